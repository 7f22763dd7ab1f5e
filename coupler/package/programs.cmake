# Included by the root. cmake --install BUILD --prefix DIR --component programs: the programs, the scenes and the licences.
# cpack --config BUILD/CPackConfig.cmake: the same as a Debian package.
include(GNUInstallDirs)
if(RICOCHET_NATIVE)
  install(CODE "message(FATAL_ERROR \"these programs run on processors like this machine's only (RICOCHET_NATIVE); \
what is to be installed is configured with -DRICOCHET_NATIVE=OFF\")" COMPONENT programs)
endif()
install(TARGETS ricochet explicit_solver implicit_solver reduced_solver COMPONENT programs)
install(DIRECTORY coupler/python/ricochet DESTINATION lib/python3/dist-packages COMPONENT programs FILES_MATCHING PATTERN "*.py"
  PATTERN __pycache__ EXCLUDE)
install(DIRECTORY configs DESTINATION ${CMAKE_INSTALL_DATADIR}/ricochet COMPONENT programs)

# Licences: ours, and those of the libraries that consist of headers, whose code is within the programs.
install(FILES coupler/package/copyright LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT programs)
foreach(package cppzmq-dev libcli11-dev libeigen3-dev libmsgpack-cxx-dev libtoml11-dev nlohmann-json3-dev)
  install(FILES /usr/share/doc/${package}/copyright DESTINATION ${CMAKE_INSTALL_DOCDIR}/licences RENAME ${package}
    COMPONENT programs)
endforeach()
foreach(library vega vega-lite vega-embed)
  install(FILES ${report_node_modules}/${library}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR}/licences RENAME ${library}
    COMPONENT programs)
endforeach()

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_CONTACT "The ricochet authors")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "co-simulation of impacts by finite elements")
set(CPACK_PACKAGE_DESCRIPTION "Two elastic bodies collide, with friction. Elements near the contact are integrated\n\
implicitly, the others explicitly, by two solvers in processes of their own; the\n\
command ricochet couples them, measures what that gains and draws reports.")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL programs)
set(CPACK_COMPONENTS_GROUPING ALL_COMPONENTS_IN_ONE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS libopenblas0-serial)  # factors of solids take a quarter of the time
# Pictures of `ricochet report`; `import ricochet`, its arrays and frames. Everything else does without.
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "nodejs, python3, python3-numpy, python3-pandas")
include(CPack)

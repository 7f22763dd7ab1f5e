# Included by the root. cmake --install BUILD --prefix DIR --component sdk: the SDK as a package for find_package(ricochet),
# for C and Fortran if libricochet.so has been built, and for Python, where `pip install DIR/share/ricochet/python` makes it
# a package of that, too.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/ricochet)
foreach(room base wire participant)
  set_target_properties(ricochet_${room} PROPERTIES EXPORT_NAME ${room})
  target_include_directories(ricochet_${room} INTERFACE $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/ricochet>)
endforeach()
install(TARGETS ricochet_base ricochet_wire ricochet_participant EXPORT ricochet COMPONENT sdk)
install(EXPORT ricochet NAMESPACE ricochet:: DESTINATION ${package_folder} FILE ricochet-targets.cmake COMPONENT sdk)

# The headers keep their path in the tree: #include "common/participant/participant.hpp"
foreach(header common/base/error.hpp common/base/vocabulary.hpp common/base/window_clock.hpp common/participant/own_loop.hpp common/participant/participant.hpp)
  cmake_path(GET header PARENT_PATH folder)
  install(FILES ${header} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/ricochet/${folder} COMPONENT sdk)
endforeach()

configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/ricochet-config.cmake.in ${CMAKE_BINARY_DIR}/ricochet-config.cmake
  INSTALL_DESTINATION ${package_folder})
write_basic_package_version_file(${CMAKE_BINARY_DIR}/ricochet-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/ricochet-config.cmake ${CMAKE_BINARY_DIR}/ricochet-config-version.cmake
  DESTINATION ${package_folder} COMPONENT sdk)
install(DIRECTORY common/participant/python/ DESTINATION ${CMAKE_INSTALL_DATADIR}/ricochet/python COMPONENT sdk
  USE_SOURCE_PERMISSIONS FILES_MATCHING PATTERN "*.py" PATTERN pyproject.toml PATTERN __pycache__ EXCLUDE
  PATTERN build EXCLUDE)
install(TARGETS ricochet_c COMPONENT sdk OPTIONAL)
install(FILES common/participant/c/ricochet.h common/participant/c/ricochet.f90
  DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/ricochet COMPONENT sdk)

# Included by the root: gets the chart libraries with npm and turns them and the page's files into one C++ source.
# Sets report_assets (that source) and report_node_modules (where the tests find the driver of the browser).
find_program(NPM npm)
if(NOT NPM)
  message(FATAL_ERROR "npm is missing: report.html draws with Vega-Lite, which is installed from npm at build time. "
    "Install the Debian packages nodejs and npm")
endif()

set(report_source ${CMAKE_CURRENT_LIST_DIR})
set(report_charts ${CMAKE_BINARY_DIR}/report_charts)
set(report_node_modules ${report_charts}/node_modules)
set(report_assets ${CMAKE_BINARY_DIR}/report_assets.cpp)
set(omit_tests OFF)
if(DEFINED BUILD_TESTING AND NOT BUILD_TESTING)
  set(omit_tests ON)
endif()

add_custom_command(
  OUTPUT ${report_charts}/installed
  COMMAND ${CMAKE_COMMAND} -DNPM=${NPM} -DFROM=${report_source} -DINTO=${report_charts} -DOMIT_TESTS=${omit_tests}
    -P ${report_source}/install_charts.cmake
  DEPENDS ${report_source}/package.json ${report_source}/package-lock.json ${report_source}/three_parts.mjs
    ${report_source}/install_charts.cmake
  COMMENT "Installing the chart libraries with npm"
  VERBATIM)

file(GLOB report_files CONFIGURE_DEPENDS ${report_source}/*.html ${report_source}/*.css ${report_source}/*.js
  ${report_source}/charts/*.json)
add_custom_command(
  OUTPUT ${report_assets}
  COMMAND ${CMAKE_COMMAND} "-DFILES=${report_files}" -DMODULES=${report_node_modules} -DOUTPUT=${report_assets}
    -P ${report_source}/embed.cmake
  DEPENDS ${report_files} ${report_charts}/installed ${report_source}/embed.cmake
  COMMENT "Embedding the report page and its chart libraries"
  VERBATIM)
# By itself, so that it waits for no room of its users.
add_custom_target(report_assets DEPENDS ${report_assets})

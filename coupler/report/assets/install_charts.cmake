# cmake -DNPM= -DFROM= -DINTO= -DOMIT_TESTS= -P install_charts.cmake: `npm ci` of FROM/package-lock.json in INTO.
file(MAKE_DIRECTORY ${INTO})
file(COPY ${FROM}/package.json ${FROM}/package-lock.json DESTINATION ${INTO})
set(arguments ci --ignore-scripts --no-audit --no-fund --loglevel=error)
if(OMIT_TESTS)
  list(APPEND arguments --omit=dev)
endif()
execute_process(COMMAND ${NPM} ${arguments} WORKING_DIRECTORY ${INTO}
  RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
if(NOT result EQUAL 0)
  message(FATAL_ERROR "npm could not install the chart libraries of report.html (vega, vega-lite, vega-embed): "
    "the first build needs the npm registry. `${NPM} ci` in ${INTO} said:\n${output}")
endif()
file(TOUCH ${INTO}/installed)

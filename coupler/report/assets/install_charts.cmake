# cmake -DNPM= -DFROM= -DINTO= -DOMIT_TESTS= -P install_charts.cmake: `npm ci` of FROM/package-lock.json in INTO,
# then esbuild makes INTO/three_bundle.js of what FROM/three_parts.mjs takes of three.js.
file(MAKE_DIRECTORY ${INTO})
file(COPY ${FROM}/package.json ${FROM}/package-lock.json DESTINATION ${INTO})
set(arguments ci --ignore-scripts --no-audit --no-fund --loglevel=error)
if(OMIT_TESTS)
  list(APPEND arguments --omit=dev)
endif()
execute_process(COMMAND ${NPM} ${arguments} WORKING_DIRECTORY ${INTO}
  RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
if(NOT result EQUAL 0)
  message(FATAL_ERROR "npm could not install the chart libraries of report.html (vega, three and what they need): "
    "the first build needs the npm registry. `${NPM} ci` in ${INTO} said:\n${output}")
endif()
file(COPY ${FROM}/three_parts.mjs DESTINATION ${INTO})
execute_process(COMMAND ${INTO}/node_modules/.bin/esbuild three_parts.mjs --bundle --minify --format=iife
  --global-name=three --legal-comments=none --outfile=three_bundle.js WORKING_DIRECTORY ${INTO}
  RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
if(NOT result EQUAL 0)
  message(FATAL_ERROR "esbuild could not bundle three.js in ${INTO}:\n${output}")
endif()
file(TOUCH ${INTO}/installed)

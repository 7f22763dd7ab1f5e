# cmake -DFILES= -DMODULES= -DOUTPUT= -P embed.cmake: a C++ source that holds the files as raw string literals.
set(delimiter ricochet_asset)

function(embed name file)
  file(READ ${file} text)
  string(FIND "${text}" ")${delimiter}\"" end)
  if(NOT end EQUAL -1)
    message(FATAL_ERROR "${file} contains )${delimiter}\" and cannot be embedded as a raw string")
  endif()
  file(APPEND ${OUTPUT}.part "    {\"${name}\", R\"${delimiter}(")
  file(APPEND ${OUTPUT}.part "${text}")
  file(APPEND ${OUTPUT}.part ")${delimiter}\"},\n")
endfunction()

file(WRITE ${OUTPUT}.part "#include \"coupler/report/assets/assets.hpp\"\n
#include <stdexcept>
#include <string>
#include <utility>\n
namespace ricochet::report {
namespace {\n
constexpr std::pair<const char*, const char*> assets[] = {\n")
foreach(file ${FILES})
  get_filename_component(name ${file} NAME)
  embed(${name} ${file})
endforeach()
foreach(library vega vega-lite vega-embed)
  embed(${library}.js ${MODULES}/${library}/build/${library}.min.js)
  embed(${library}.license ${MODULES}/${library}/LICENSE)
endforeach()
embed(three.js ${MODULES}/../three_bundle.js)
embed(three.license ${MODULES}/three/LICENSE)
file(APPEND ${OUTPUT}.part "};\n
}  // namespace\n
std::string_view asset(std::string_view name) {
  for (const auto& [known, text] : assets) {
    if (known == name) return text;
  }
  throw std::logic_error(\"no embedded file \" + std::string(name));
}\n
}  // namespace ricochet::report\n")
file(RENAME ${OUTPUT}.part ${OUTPUT})

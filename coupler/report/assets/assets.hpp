#pragma once

#include <string_view>

namespace ricochet::report {

/// Text of a file that was embedded at build time (assets.cmake): the page's own files by their names in this folder,
/// the libraries as "vega.js", "vega-lite.js", "vega-embed.js", "three.js" (what three_parts.mjs takes of it), their
/// licences as "vega.license" and so on. Throws std::logic_error if there is none of that name.
[[nodiscard]] std::string_view asset(std::string_view name);

}  // namespace ricochet::report

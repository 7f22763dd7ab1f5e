#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace ricochet {

/// The entry of `allowed` that someone who typed `name` most likely meant: smallest edit distance (insert, delete,
/// replace, swap of neighbours each cost one, upper and lower case are the same), the first of equals. If none is
/// nearer than two edits or a third of the longer name's length, whichever is more, the first that has `name` as one of
/// its words between underscores; else empty.
[[nodiscard]] std::string nearest(std::string_view name, const std::vector<std::string>& allowed);

/// "; did you mean \"...\"?" for the end of an error text, or nothing if no entry of `allowed` is near.
[[nodiscard]] std::string did_you_mean(std::string_view name, const std::vector<std::string>& allowed);

}  // namespace ricochet

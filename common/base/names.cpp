#include "common/base/names.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <numeric>

namespace ricochet {
namespace {

std::string lower(std::string_view text) {
  std::string result(text);
  std::transform(result.begin(), result.end(), result.begin(), [](unsigned char c) { return std::tolower(c); });
  return result;
}

/// Optimal string alignment distance, three rows at a time.
std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> before(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
  std::iota(last.begin(), last.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (swapped) row[j] = std::min(row[j], before[j - 2] + 1);
    }
    std::swap(before, last);
    std::swap(last, row);
  }
  return last[b.size()];
}

}  // namespace

std::string nearest(std::string_view name, const std::vector<std::string>& allowed) {
  const std::string typed = lower(name);
  std::string best;
  std::size_t smallest = std::string::npos;
  for (const std::string& candidate : allowed) {
    const std::size_t distance = edit_distance(typed, lower(candidate));
    const std::size_t near = std::max<std::size_t>(2, std::max(typed.size(), candidate.size()) / 3);
    // A name that shares no letter is no suggestion, however short both are.
    if (distance > near || distance >= std::max(typed.size(), candidate.size())) continue;
    if (distance < smallest) {
      smallest = distance;
      best = candidate;
    }
  }
  if (!best.empty()) return best;
  const auto has_it_as_a_word = [word = fmt::format("_{}_", typed)](const std::string& candidate) {
    return fmt::format("_{}_", lower(candidate)).find(word) != std::string::npos;
  };
  const auto found = std::find_if(allowed.begin(), allowed.end(), has_it_as_a_word);
  return typed.empty() || found == allowed.end() ? "" : *found;
}

std::string did_you_mean(std::string_view name, const std::vector<std::string>& allowed) {
  const std::string near = nearest(name, allowed);
  return near.empty() ? "" : "; did you mean \"" + near + "\"?";
}

}  // namespace ricochet

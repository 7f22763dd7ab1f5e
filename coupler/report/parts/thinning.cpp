#include "coupler/report/parts/thinning.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace ricochet::report {
namespace {

void keep_extrema(const std::vector<double>& values, std::size_t begin, std::size_t end,
                  std::vector<std::size_t>& kept) {
  std::size_t lowest = end, highest = end, broken = end;
  for (std::size_t i = begin; i < end; ++i) {
    if (!std::isfinite(values[i])) {
      if (broken == end) broken = i;
      continue;
    }
    if (lowest == end || values[i] < values[lowest]) lowest = i;
    if (highest == end || values[i] > values[highest]) highest = i;
  }
  for (const std::size_t row : {lowest, highest, broken}) {
    if (row != end) kept.push_back(row);
  }
}

}  // namespace

std::vector<std::size_t> thin(const std::vector<double>& time, const std::vector<const std::vector<double>*>& series,
                              std::size_t pixels) {
  std::vector<std::size_t> kept;
  if (time.size() <= 2 * pixels) {
    kept.resize(time.size());
    std::iota(kept.begin(), kept.end(), std::size_t{0});
    return kept;
  }
  const double scale = static_cast<double>(pixels) / (time.back() - time.front());
  const auto pixel_of = [&](std::size_t row) { return std::floor(scale * (time[row] - time.front())); };
  for (std::size_t begin = 0; begin < time.size();) {
    std::size_t end = begin + 1;
    while (end < time.size() && pixel_of(end) == pixel_of(begin)) ++end;
    const auto first = kept.size();
    kept.push_back(begin);
    kept.push_back(end - 1);
    for (const auto* values : series) keep_extrema(*values, begin, end, kept);
    std::sort(kept.begin() + static_cast<std::ptrdiff_t>(first), kept.end());
    kept.erase(std::unique(kept.begin() + static_cast<std::ptrdiff_t>(first), kept.end()), kept.end());
    begin = end;
  }
  return kept;
}

}  // namespace ricochet::report

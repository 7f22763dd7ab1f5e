#include "coupler/report/parts/quantity.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

namespace ricochet::report {

DisplayUnit display_unit(double largest, const std::string& si_unit) {
  static constexpr std::pair<double, const char*> prefixes[] = {{1e6, "M"},  {1e3, "k"},  {1.0, ""},
                                                                {1e-3, "m"}, {1e-6, "µ"}, {1e-9, "n"}};
  const bool never_larger = !si_unit.empty() && (si_unit[0] == 's' || si_unit[0] == 'm');
  largest = std::abs(largest);
  if (si_unit.empty() || largest == 0.0 || !std::isfinite(largest)) return {1.0, si_unit};
  for (const auto& [size, prefix] : prefixes) {
    if (size > 1.0 && never_larger) continue;
    if (largest >= size * (1 - 1e-12) || size == 1e-9) return {1.0 / size, prefix + si_unit};
  }
  return {1.0, si_unit};
}

std::string quantity(double value, const std::string& si_unit, int digits) {
  const auto unit = display_unit(value, si_unit);
  const auto number = fmt::format("{:.{}g}", value * unit.factor, digits);
  return unit.name.empty() ? number : number + " " + unit.name;
}

}  // namespace ricochet::report

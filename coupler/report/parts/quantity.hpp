#pragma once

#include <string>

namespace ricochet::report {

/// A unit to read numbers in: value_in_si * factor [name].
struct DisplayUnit {
  double factor = 1.0;
  std::string name;
};

/// The SI prefix that brings `largest` (in SI units, any sign) between 1 and 1000: "Pa" and 8.5e8 give MPa. From nano
/// to mega; seconds, metres and metres per second are never made larger (no "km/s"). A unit "" stays without prefix.
[[nodiscard]] DisplayUnit display_unit(double largest, const std::string& si_unit);

/// "31.158 µs": value in its own display unit with `digits` significant digits.
[[nodiscard]] std::string quantity(double value, const std::string& si_unit, int digits = 5);

}  // namespace ricochet::report

#pragma once

#include <string>
#include <variant>
#include <vector>

namespace ricochet::coupler {

using AxisValue = std::variant<double, std::string>;

/// The values that one key takes in a sweep.
struct Axis {
  std::string key;  ///< of the scene, or "courant"
  std::vector<AxisValue> values;
  bool logarithmic = false;
};

/// "KEY=LOW:HIGH:COUNT" (evenly spaced, both ends), "KEY=LOW:HIGH:COUNT:log" (by a constant factor) or
/// "KEY=VALUE,VALUE,..." (numbers, or words where not all are numbers). ConfigError naming `option`, what was found and
/// what is allowed.
[[nodiscard]] Axis parse_axis(const std::string& option, const std::string& text);

/// The same for the step: the key is "courant" or "time.step_s", the values are numbers > 0 that rise.
[[nodiscard]] Axis parse_step_axis(const std::string& option, const std::string& text);

/// A value as text, numbers with 6 digits.
[[nodiscard]] std::string text_of(const AxisValue& value);

}  // namespace ricochet::coupler

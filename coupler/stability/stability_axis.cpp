#include "coupler/stability/stability_axis.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <sstream>

#include "common/base/error.hpp"

namespace ricochet::coupler {
namespace {

constexpr int most_values = 1000;

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> words;
  std::istringstream stream(text);
  for (std::string word; std::getline(stream, word, separator);) words.push_back(word);
  return words;
}

std::optional<double> number_of(const std::string& text) {
  double value = 0.0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stop != end || !std::isfinite(value)) return {};
  return value;
}

[[noreturn]] void refuse(const std::string& option, const std::string& text, const std::string& why) {
  throw ConfigError(
      fmt::format("{}: found \"{}\"{}, allowed: KEY=LOW:HIGH:COUNT, KEY=LOW:HIGH:COUNT:log or "
                  "KEY=VALUE,VALUE,...",
                  option, text, why.empty() ? "" : " (" + why + ")"));
}

void fill_range(const std::string& option, const std::string& text, const std::vector<std::string>& words, Axis& axis) {
  axis.logarithmic = words.size() == 4;
  if (axis.logarithmic && words[3] != "log") refuse(option, text, "\"" + words[3] + "\" is not log");
  const auto low = number_of(words[0]), high = number_of(words[1]), count = number_of(words[2]);
  if (!low || !high || !count) refuse(option, text, "LOW, HIGH and COUNT are numbers");
  if (!(*low < *high)) refuse(option, text, "LOW is less than HIGH");
  if (axis.logarithmic && !(*low > 0.0)) refuse(option, text, "LOW is more than 0 for log");
  if (*count != std::round(*count) || *count < 2 || *count > most_values) {
    refuse(option, text, fmt::format("COUNT is an integer from 2 to {}", most_values));
  }
  for (int i = 0; i < static_cast<int>(*count); ++i) {
    const double share = i / (*count - 1.0);
    axis.values.emplace_back(axis.logarithmic ? *low * std::pow(*high / *low, share) : *low + share * (*high - *low));
  }
}

void fill_list(const std::string& option, const std::string& text, const std::vector<std::string>& words, Axis& axis) {
  const bool numbers = std::all_of(words.begin(), words.end(), [](const auto& word) { return number_of(word); });
  for (const auto& word : words) {
    if (word.empty()) refuse(option, text, "an empty value");
    const AxisValue value = numbers ? AxisValue(*number_of(word)) : AxisValue(word);
    const bool again = std::find(axis.values.begin(), axis.values.end(), value) != axis.values.end();
    if (again) refuse(option, text, word + " a second time");
    axis.values.push_back(value);
  }
}

}  // namespace

Axis parse_axis(const std::string& option, const std::string& text) {
  const auto equals = text.find('=');
  if (equals == std::string::npos || equals == 0 || equals + 1 == text.size()) refuse(option, text, "");
  Axis axis{text.substr(0, equals), {}, false};
  const std::string values = text.substr(equals + 1);
  const auto range = split(values, ':');
  if (range.size() == 3 || range.size() == 4) {
    fill_range(option, text, range, axis);
  } else if (range.size() == 1) {
    fill_list(option, text, split(values, ','), axis);
  } else {
    refuse(option, text, "");
  }
  return axis;
}

Axis parse_step_axis(const std::string& option, const std::string& text) {
  const Axis axis = parse_axis(option, text);
  if (axis.key != "courant" && axis.key != "time.step_s") {
    throw ConfigError(
        fmt::format("{}: found the key \"{}\", allowed: courant (share of the critical time step of what "
                    "is explicit) or time.step_s",
                    option, axis.key));
  }
  double last = 0.0;
  for (const auto& value : axis.values) {
    const auto* number = std::get_if<double>(&value);
    if (!number || !(*number > last)) refuse(option, text, "steps are numbers > 0 that rise");
    last = *number;
  }
  return axis;
}

std::string text_of(const AxisValue& value) {
  const auto* number = std::get_if<double>(&value);
  return number ? fmt::format("{:.6g}", *number) : std::get<std::string>(value);
}

}  // namespace ricochet::coupler

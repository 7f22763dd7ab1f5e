#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <string_view>
#include <system_error>

#include "common/base/error.hpp"
#include "common/base/names.hpp"
#include "common/participant/participant.hpp"

namespace ricochet::participant {
namespace {

double seconds_of(const std::string& option, const std::string& text) {
  double value = 0.0;
  const char* const end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || rest != end || !(value >= 0.0) || !std::isfinite(value))
    throw ConfigError(fmt::format("{}: found \"{}\", allowed is a number of seconds, 0 or more", option, text));
  return value;
}

}  // namespace

Arguments parse_arguments(int argc, const char* const* argv) {
  Arguments arguments;
  std::string critical_step;
  for (int i = 1; i < argc; ++i) {
    const std::string option = argv[i];
    if (option == "--watch-stdin") {
      arguments.options.watch_stdin = true;
      continue;
    }
    std::string* value = option == "--scene"           ? &arguments.scene
                         : option == "--name"          ? &arguments.name
                         : option == "--connect"       ? &arguments.options.endpoint
                         : option == "--key"           ? &arguments.options.key
                         : option == "--critical-step" ? &critical_step
                                                       : nullptr;
    if (!value) {
      const std::vector<std::string> known{"--scene", "--name",          "--connect",
                                           "--key",   "--critical-step", "--watch-stdin"};
      throw ConfigError(fmt::format("unexpected argument \"{}\", allowed are {}{}", option, fmt::join(known, ", "),
                                    did_you_mean(option, known)));
    }
    if (i + 1 == argc) throw ConfigError(fmt::format("{} needs a value", option));
    *value = argv[++i];
    if (value == &critical_step) arguments.critical_time_step_s = seconds_of(option, critical_step);
  }
  for (const auto& [option, value] : {std::pair{"--name", arguments.name}, {"--connect", arguments.options.endpoint}}) {
    if (value.empty()) throw ConfigError(fmt::format("{} is missing", option));
  }
  return arguments;
}

}  // namespace ricochet::participant

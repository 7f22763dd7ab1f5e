#include <fmt/format.h>

#include <string_view>

#include "common/base/error.hpp"
#include "common/base/names.hpp"
#include "common/participant/participant.hpp"

namespace ricochet::participant {

Arguments parse_arguments(int argc, const char* const* argv) {
  Arguments arguments;
  for (int i = 1; i < argc; ++i) {
    const std::string option = argv[i];
    if (option == "--watch-stdin") {
      arguments.options.watch_stdin = true;
      continue;
    }
    std::string* value = option == "--scene"     ? &arguments.scene
                         : option == "--name"    ? &arguments.name
                         : option == "--connect" ? &arguments.options.endpoint
                         : option == "--key"     ? &arguments.options.key
                                                 : nullptr;
    if (!value) {
      const std::vector<std::string> known{"--scene", "--name", "--connect", "--key", "--watch-stdin"};
      throw ConfigError(fmt::format("unexpected argument \"{}\", allowed are {}{}", option, fmt::join(known, ", "),
                                    did_you_mean(option, known)));
    }
    if (i + 1 == argc) throw ConfigError(fmt::format("{} needs a value", option));
    *value = argv[++i];
  }
  for (const auto& [option, value] : {std::pair{"--name", arguments.name}, {"--connect", arguments.options.endpoint}}) {
    if (value.empty()) throw ConfigError(fmt::format("{} is missing", option));
  }
  return arguments;
}

}  // namespace ricochet::participant

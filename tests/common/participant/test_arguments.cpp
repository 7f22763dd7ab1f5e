// The command line that participants are started with.
#include <gmock/gmock.h>

#include <string>
#include <vector>

#include "common/base/error.hpp"
#include "common/participant/participant.hpp"

namespace ricochet::participant {
namespace {

using testing::HasSubstr;

Arguments parsed(std::vector<const char*> words) {
  words.insert(words.begin(), {"solver", "--name", "outside", "--connect", "ipc://@nowhere"});
  return parse_arguments(static_cast<int>(words.size()), words.data());
}

std::string error_of(const std::vector<const char*>& words) {
  try {
    static_cast<void>(parsed(words));
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "no error";
}

TEST(Arguments, SayWhoConnectsWhere) {
  const Arguments arguments = parsed({"--scene", "bars.toml", "--key", "/dev/fd/3", "--watch-stdin"});
  EXPECT_EQ(arguments.name, "outside");
  EXPECT_EQ(arguments.options.endpoint, "ipc://@nowhere");
  EXPECT_EQ(arguments.scene, "bars.toml");
  EXPECT_EQ(arguments.options.key, "/dev/fd/3");
  EXPECT_TRUE(arguments.options.watch_stdin);
  EXPECT_FALSE(arguments.critical_time_step_s.has_value()) << "nobody told";
}

TEST(Arguments, TellTheCriticalStepToTheLastBit) {
  EXPECT_EQ(parsed({"--critical-step", "6.0123456789012345e-08"}).critical_time_step_s, 6.0123456789012345e-08);
  EXPECT_EQ(parsed({"--critical-step", "0"}).critical_time_step_s, 0.0);
}

TEST(Arguments, ACriticalStepIsANumberOfSeconds) {
  for (const char* text : {"soon", "1e-8s", "-1e-8", "nan", "inf", ""}) {
    EXPECT_THAT(error_of({"--critical-step", text}),
                HasSubstr("--critical-step: found \"" + std::string(text) + "\", allowed is a number of seconds"));
  }
  EXPECT_THAT(error_of({"--critical-step"}), HasSubstr("--critical-step needs a value"));
}

}  // namespace
}  // namespace ricochet::participant

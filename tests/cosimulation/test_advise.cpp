// `ricochet advise`: the run that it names has the error that was asked, where the answer is known exactly.
#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <sstream>

#include "tests/support/page.hpp"
#include "tests/support/two_bars.hpp"

namespace ricochet::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;

Outcome advise(const std::string& scene, const TemporaryFolder& folder, const std::string& quantity,
               const std::string& error, const std::vector<std::string>& more = {}) {
  std::vector<std::string> command{ricochet_binary(),
                                   "advise",
                                   scene,
                                   "--quantity",
                                   quantity,
                                   "--error",
                                   error,
                                   "--out",
                                   folder.path().string() + "/advice"};
  command.insert(command.end(), more.begin(), more.end());
  return run_command(command, folder.path().string(), 120.0);
}

/// "KEY=VALUE" of the command behind "least time:" or "next:".
std::vector<std::string> settings_in(const std::string& out, const std::string& label) {
  std::istringstream words(out.substr(out.find("\n" + label) + 1));
  std::vector<std::string> settings;
  std::string line;
  std::getline(words, line);
  std::istringstream parts(line);
  for (std::string word, before; parts >> word; before = word)
    if (before == "--set") settings.push_back(word);
  return settings;
}

nlohmann::json run_with(const std::string& scene, const TemporaryFolder& folder,
                        const std::vector<std::string>& settings) {
  const std::string out = folder.path().string() + "/run";
  std::vector<std::string> command{ricochet_binary(), "run", scene, "--out", out};
  for (const auto& setting : settings) command.insert(command.end(), {"--set", setting});
  const auto outcome = run_command(command, folder.path().string(), 120.0);
  EXPECT_EQ(outcome.code, 0) << outcome.error;
  return nlohmann::json::parse(file_text(out + "/summary.json"));
}

struct KnownImpulse {
  std::string text;
  double exact_n_s;
};

/// Either the run that is named has at most the error that was asked, or the message says what can be had.
TEST(Advice, IsKeptWhereTheImpulseIsKnownExactly) {
  const double of_bars = bars_force_n * bars_contact_s;
  int answered = 0, refused = 0;
  for (const auto& [text, exact] : {KnownImpulse{bars_of(1), of_bars},
                                    {bars_of(2), of_bars},
                                    {bars_of(4), of_bars},
                                    {bars_of(8), of_bars},
                                    {replaced(config_text("rod_on_stop"), "end_s = 12.0", "end_s = 2.5"), 0.5}}) {
    for (const char* asked : {"0.1", "0.03", "0.01"}) {
      const TemporaryFolder folder;
      const std::string scene = folder.write(text);
      const auto outcome = advise(scene, folder, "contact_impulse_n_s", asked);
      if (outcome.code != 0) {
        EXPECT_EQ(outcome.code, 2) << outcome.error;
        EXPECT_THAT(outcome.error, HasSubstr("times shorter"));
        ++refused;
        continue;
      }
      ++answered;
      const auto summary = run_with(scene, folder, settings_in(outcome.out, "least time:"));
      const double error = std::abs(summary.at("contact_impulse_n_s").get<double>() / exact - 1.0);
      EXPECT_LE(error, std::stod(asked)) << outcome.out;
    }
  }
  EXPECT_GE(answered, 9);
  EXPECT_GE(refused, 1);
}

/// The published impact: all_implicit takes less time in longer windows than the hybrid, and the two agree.
TEST(Advice, NamesABaselineWhereThatIsCheaper) {
  const TemporaryFolder folder;
  const std::string scene = std::string(RICOCHET_SOURCE) + "/configs/kim_impact.toml";
  const auto outcome = advise(scene, folder, "contact_impulse_n_s", "0.03");
  ASSERT_EQ(outcome.code, 0) << outcome.error;
  const auto best = settings_in(outcome.out, "least time:"), next = settings_in(outcome.out, "next:");
  EXPECT_THAT(best, testing::Contains("coupling.protocol=all_implicit"));
  EXPECT_THAT(next, testing::Not(testing::Contains("coupling.protocol=all_implicit")));
  const auto impulse = [&](const std::vector<std::string>& settings) {
    const TemporaryFolder other;
    return run_with(scene, other, settings).at("contact_impulse_n_s").get<double>();
  };
  EXPECT_NEAR(impulse(best) / impulse(next), 1.0, 0.06);
  const std::string table = file_text(folder.path() / "advice" / "advice.csv");
  EXPECT_THAT(table, HasSubstr("protocol,step_s,predicted_s,expected_error,order,refused\nall_implicit,8.64e-07,"));
}

TEST(Advice, IsOfTheSceneThatSetMakes) {
  const TemporaryFolder folder;
  const auto outcome = advise(folder.write(bars_of(2)), folder, "contact_impulse_n_s", "0.1",
                              {"--set", "time.end_s=3e-4", "--set", "coupling.protocol=kim"});
  ASSERT_EQ(outcome.code, 0) << outcome.error;
  EXPECT_THAT(outcome.out, HasSubstr("--set time.end_s=3e-4 --set coupling.protocol=kim --set coupling.protocol="));
}

TEST(Advice, RefusesByName) {
  const TemporaryFolder folder;
  const std::string bars = folder.write(bars_of(1)), configs = std::string(RICOCHET_SOURCE) + "/configs/";
  const auto expect = [&](const Outcome& outcome, const std::string& said, const std::string& too) {
    EXPECT_EQ(outcome.code, 2);
    EXPECT_THAT(outcome.error, AllOf(HasSubstr(said), HasSubstr(too)));
  };
  expect(advise(bars, folder, "contact_impuls_n_s", "0.1"),
         "--quantity: found \"contact_impuls_n_s\", allowed: ", "did you mean \"contact_impulse_n_s\"");
  expect(advise(bars, folder, "peak_contact_force_n", "0.1"), "peak_contact_force_n\" of a flat impact",
         "allowed: contact_impulse_n_s");
  expect(advise(bars, folder, "contact_impulse_n_s", "3"), "--error: found 3", "between 0 and 1");
  expect(advise(bars, folder, "contact_impulse_n_s", "1e-5"), "within 0.001 % on this mesh", "times shorter");
  expect(advise(configs + "two_balls.toml", folder, "peak_contact_force_n", "0.1"), "found a mesh of a file",
         "meshes by elements");
  expect(advise(configs + "slipping_plates.toml", folder, "contact_impulse_n_s", "0.1"),
         "no protocol and step can be tried on coarser meshes", "3 or more across a periodic mesh");
  expect(advise(folder.write(replaced(bars_of(1), "[time]", "[time]\nchanges = [{ from_s = 80e-6, step_s = 1e-6 }]"),
                             "changes.toml"),
                folder, "contact_impulse_n_s", "0.1"),
         "advise: found time.changes", "one step for the whole run");
}

}  // namespace
}  // namespace ricochet::test

// `ricochet advise`: the run that it names has the error that was asked, where the answer is known exactly.
#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include "tests/support/page.hpp"
#include "tests/support/places.hpp"
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
  const std::string scene = source_folder() + "/configs/kim_impact.toml";
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
  EXPECT_THAT(table, HasSubstr("protocol,step_s,elements_times,predicted_s,expected_error/contact_impulse_n_s,"
                               "order/contact_impulse_n_s,refused\nall_implicit,8.64e-07,1,"));
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
  const std::string bars = folder.write(bars_of(1)), configs = source_folder() + "/configs/";
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
  const auto bare = [&](const std::vector<std::string>& options) {
    std::vector<std::string> command{ricochet_binary(), "advise", bars};
    command.insert(command.end(), options.begin(), options.end());
    return run_command(command, folder.path().string(), 120.0);
  };
  expect(bare({}), "found no table [accuracy]", "or --quantity NAME --error SHARE");
  expect(bare({"--error", "0.1"}), "--quantity and --error: found one of them", "allowed: both, or none");
}

/// The bars without what a scene with [accuracy] may leave open, asking for these errors.
std::string asking(const std::string& text, const std::string& errors) {
  return replaced(text, "[time]\n", "[accuracy]\nrelative_error = { " + errors + " }\n[time]\n");
}
std::string without_step(const std::string& text) {
  const auto at = text.find("step_s = ");
  return text.substr(0, at) + text.substr(text.find('\n', at) + 1);
}

TEST(Accuracy, OfTheRunIsWhatTheSceneAsksForAndTheChosenSceneComputesItAgain) {
  const TemporaryFolder folder;
  const std::string out = folder.path().string() + "/run";
  const std::string errors = "contact_impulse_n_s = 0.03, rebound_velocity_right_m_s = 0.06";
  const auto scene = folder.write(asking(without_step(bars_of(4)), errors));
  const auto run = run_command({ricochet_binary(), "run", scene, "--out", out}, folder.path().string(), 120.0);
  ASSERT_EQ(run.code, 0) << run.error;
  EXPECT_THAT(run.out, HasSubstr("  best\n"));
  const auto summary = nlohmann::json::parse(file_text(out + "/summary.json"));
  EXPECT_NEAR(summary.at("contact_impulse_n_s").get<double>(), bars_force_n * bars_contact_s,
              0.03 * bars_force_n * bars_contact_s);
  const auto& entry = summary.at("error_bar").at("quantities").at("rebound_velocity_right_m_s");
  EXPECT_NEAR(entry.at("value").get<double>(), 5.13588, 0.06 * 5.13588);
  EXPECT_EQ(entry.at("asked"), 0.06);
  const bool reached = entry.at("total") <= 0.06 * entry.at("value").get<double>();
  EXPECT_EQ(entry.at("reached"), reached);
  const std::string verdict = reached ? "reached" : "not reached";
  EXPECT_THAT(run.out, HasSubstr("asked: rebound_velocity_right_m_s within 6 %: " + verdict + ", its bar is "));
  EXPECT_THAT(file_text(out + "/report.html"), HasSubstr("; asked 6 %: " + verdict));
  // The pilots of the method that was chosen are companions of its run.
  std::ptrdiff_t computed = 0;
  for (const auto& entry_of : std::filesystem::directory_iterator(out + "/accuracy"))
    computed += std::filesystem::exists(entry_of.path() / "1" / "summary.json") ? 1 : 0;
  const auto pilots = std::stol(run.out.substr(run.out.find(", from ") + 7));
  const auto companions = static_cast<long>(summary.at("error_bar").at("companions").size());
  EXPECT_LE(computed, pilots + companions - 2);
  const auto again =
      run_command({ricochet_binary(), "run", out + "/scene/scene.toml", "--out", folder.path().string() + "/again"},
                  folder.path().string(), 120.0);
  ASSERT_EQ(again.code, 0) << again.error;
  EXPECT_THAT(again.out, AllOf(testing::Not(HasSubstr("pilot runs")), HasSubstr("within 6 %: " + verdict)));
  EXPECT_EQ(file_text(folder.path() / "again" / "history.csv"), file_text(out + "/history.csv"));
}

TEST(Accuracy, LeavesWhatTheSceneFixes) {
  const TemporaryFolder folder;
  const auto candidates = [&](const std::string& text) {
    const auto outcome =
        run_command({ricochet_binary(), "advise", folder.write(text), "--out", folder.path().string() + "/advice"},
                    folder.path().string(), 120.0);
    EXPECT_EQ(outcome.code, 0) << outcome.error;
    std::istringstream table(file_text(folder.path() / "advice" / "advice.csv"));
    std::set<std::string> protocols, steps;
    std::string line;
    std::getline(table, line);
    while (std::getline(table, line)) {
      protocols.insert(line.substr(0, line.find(',')));
      steps.insert(line.substr(line.find(',') + 1, line.find(',', line.find(',') + 1) - line.find(',') - 1));
    }
    return std::pair(protocols, steps);
  };
  const std::string impulse = "contact_impulse_n_s = 0.1";
  const auto [protocols, one_step] = candidates(asking(bars_of(2), impulse));
  EXPECT_THAT(protocols, testing::IsSupersetOf({"all_explicit", "all_implicit", "hughes_liu"}));
  EXPECT_THAT(one_step, testing::ElementsAre("1.113e-06"));
  const auto [kim, steps] = candidates(asking(with_protocol(without_step(bars_of(2)), "kim"), impulse));
  EXPECT_THAT(kim, testing::ElementsAre("kim"));
  EXPECT_EQ(steps.size(), 6U);
  auto largest = asking(with_protocol(replaced(bars_of(2), "step_s", "largest_step_s"), "kim"), impulse);
  largest = replaced(largest, "implicit_length_m = { left = 0.0635, right = 0.0635 }", "rule = \"auto\"");
  for (const auto& step : candidates(largest).second) EXPECT_LE(std::stod(step), 1.114e-6);
}

/// The bars with 20 elements cannot have the impulse within half a percent, and one with eight times as many can.
TEST(Accuracy, TakesAFinerMeshThatTheSceneAllowsAndNoFinerThanItNeeds) {
  const TemporaryFolder folder;
  const std::string out = folder.path().string() + "/run";
  const auto with_meshes = [&](const std::string& times, const char* error) {
    const auto text = asking(without_step(bars_of(1)), std::string("contact_impulse_n_s = ") + error);
    return folder.write(replaced(text, "[accuracy]\n", "[accuracy]\nelements_times = [" + times + "]\n"));
  };
  const auto compute = [&](const std::string& scene) {
    return run_command({ricochet_binary(), "run", scene, "--out", out}, folder.path().string(), 120.0);
  };
  const auto exact = compute(with_meshes("16, 1, 2, 4, 8, 1", "0.005"));
  ASSERT_EQ(exact.code, 0) << exact.error;
  EXPECT_THAT(exact.out, testing::ContainsRegex(" x (4|8|16) .*best\n"));
  const auto summary = nlohmann::json::parse(file_text(out + "/summary.json"));
  EXPECT_NEAR(summary.at("contact_impulse_n_s").get<double>(), bars_force_n * bars_contact_s,
              0.005 * bars_force_n * bars_contact_s);
  const auto again = compute(out + "/scene/scene.toml");
  EXPECT_EQ(again.code, 0) << again.error;
  EXPECT_THAT(again.out, AllOf(testing::Not(HasSubstr("pilot runs")), HasSubstr("contact_impulse_n_s within 0.5 %")));
  const auto rough = compute(with_meshes("1, 2, 4, 8, 16", "0.2"));
  EXPECT_EQ(rough.code, 0) << rough.error;
  EXPECT_THAT(rough.out, HasSubstr("   x 1 "));
  EXPECT_THAT(file_text(out + "/scene/scene.toml"), HasSubstr("elements=20"));
  const auto refused = compute(with_meshes("1, 2", "0.001"));
  EXPECT_EQ(refused.code, 2);
  EXPECT_THAT(refused.error, AllOf(HasSubstr("within 0.1 % on these meshes"), HasSubstr("on elements times 2"),
                                   HasSubstr("accuracy.elements_times = [")));
  const auto too_fine = compute(with_meshes("1", "1e-6"));
  EXPECT_THAT(too_fine.error, AllOf(HasSubstr("within 0.0001 %"), HasSubstr("times shorter")));
  EXPECT_THAT(too_fine.error, testing::Not(HasSubstr("elements_times"))) << "more than the key allows";
  const auto none = compute(with_meshes("0, 1", "0.1"));
  EXPECT_EQ(none.code, 2);
  EXPECT_THAT(none.error, AllOf(HasSubstr("accuracy.elements_times"), HasSubstr("0.015625")));
}

/// The command that is printed has the mesh, in words of which each is an argument.
TEST(Advice, NamesTheMesh) {
  const TemporaryFolder folder;
  const std::string text = asking(without_step(bars_of(1)), "contact_impulse_n_s = 0.005");
  const auto scene = folder.write(replaced(text, "[accuracy]\n", "[accuracy]\nelements_times = [4, 8, 16]\n"));
  const auto outcome = run_command({ricochet_binary(), "advise", scene, "--out", folder.path().string() + "/advice"},
                                   folder.path().string(), 120.0);
  ASSERT_EQ(outcome.code, 0) << outcome.error;
  const auto settings = settings_in(outcome.out, "least time:");
  EXPECT_THAT(settings, testing::Contains(testing::StartsWith("body.left.mesh.elements=")));
  const auto summary = run_with(scene, folder, settings);
  EXPECT_NEAR(summary.at("contact_impulse_n_s").get<double>(), bars_force_n * bars_contact_s,
              0.005 * bars_force_n * bars_contact_s);
}

/// A step above the critical one, which no explicit side bears.
TEST(Accuracy, TakesAProtocolThatBearsTheStepOfTheScene) {
  const TemporaryFolder folder;
  const std::string out = folder.path().string() + "/run";
  const auto scene =
      folder.write(asking(with_key(bars_of(4), "time", "step_s", "1.5e-6"), "contact_impulse_n_s = 0.1"));
  const auto run = run_command({ricochet_binary(), "run", scene, "--out", out}, folder.path().string(), 120.0);
  ASSERT_EQ(run.code, 0) << run.error;
  EXPECT_THAT(file_text(out + "/scene/scene.toml"), HasSubstr("protocol = \"all_implicit\""));
  EXPECT_THAT(run.out, HasSubstr("asked: contact_impulse_n_s within 10 %: reached"));
}

TEST(Accuracy, IsRefusedByNameBeforeAnythingRuns) {
  const TemporaryFolder folder;
  const auto expect = [&](const char* command, const std::string& text, const std::string& said,
                          const std::string& too) {
    const auto scene = folder.write(text);
    const auto outcome = run_command({ricochet_binary(), command, scene, "--out", folder.path().string() + "/run"},
                                     folder.path().string(), 120.0);
    EXPECT_EQ(outcome.code, 2) << command;
    EXPECT_THAT(outcome.error, AllOf(HasSubstr(said), HasSubstr(too))) << command;
    EXPECT_FALSE(std::filesystem::exists(folder.path() / "run" / "history.csv"));
  };
  expect("run", asking(bars_of(1), "contact_impuls_n_s = 0.1"), "accuracy.relative_error: found \"contact_impuls_n_s\"",
         "did you mean \"contact_impulse_n_s\"");
  expect("run", asking(bars_of(1), "contact_impulse_n_s = 1.5"), "accuracy.relative_error", "1.5");
  const std::string apart = R"([[body]]
name = "apart"
material = { youngs_modulus_pa = 2e11, density_kg_m3 = 8000.0 }
mesh = { start_m = -9.0, length_m = 1.0, elements = 9 }
[[body]]
name = "left")";
  expect("run", asking(replaced(bars_of(1), "[[body]]\nname = \"left\"", apart), "restitution = 0.1"),
         "accuracy.relative_error: found \"restitution\"", "\"rebound_velocity_apart_m_s\"");
  expect("run", asking(bars_of(1), "peak_contact_force_n = 0.1"),
         "accuracy: found \"peak_contact_force_n\" of a flat impact", "allowed: contact_impulse_n_s");
  expect("run", asking(without_step(bars_of(1)), "contact_impulse_n_s = 1e-4"), "within 0.01 % on this mesh",
         "Type relative_error = { \"contact_impulse_n_s\" = 0.0");
  const auto balls =
      folder.write(asking(with_absolute_meshes(config_text("two_balls")), "peak_contact_force_n = 0.1"), "balls.toml");
  const auto checked = run_command({ricochet_binary(), "check", balls}, folder.path().string(), 120.0);
  EXPECT_EQ(checked.code, 2);
  EXPECT_THAT(checked.error, HasSubstr("accuracy: found a mesh of a file; allowed: meshes by elements"));
}

TEST(Accuracy, OfARunThatIsGoneOnWithIsFoundAgain) {
  const TemporaryFolder folder;
  const std::string out = folder.path().string() + "/run";
  const auto scene = folder.write(asking(without_step(bars_of(2)), "contact_impulse_n_s = 0.05") +
                                  "[checkpoint]\nevery_windows = 50\nevery_s = 0\n");
  const auto run = run_command({ricochet_binary(), "run", scene, "--out", out}, folder.path().string(), 120.0);
  ASSERT_EQ(run.code, 0) << run.error;
  const auto bars = [&] {
    return nlohmann::json::parse(file_text(out + "/summary.json")).value("error_bar", nlohmann::json{});
  };
  const auto before = bars().at("quantities");
  const auto again = run_command({ricochet_binary(), "resume", out}, folder.path().string(), 120.0);
  ASSERT_EQ(again.code, 0) << again.error;
  EXPECT_THAT(again.out, HasSubstr("asked: contact_impulse_n_s within 5 %: reached"));
  EXPECT_EQ(bars().at("quantities"), before);
  const auto longer = run_command({ricochet_binary(), "resume", out, "--until", "3e-4"}, folder.path().string(), 120.0);
  ASSERT_EQ(longer.code, 0) << longer.error;
  EXPECT_TRUE(bars().empty());
}

TEST(Accuracy, ThatIsNotReachedIsSaid) {
  const TemporaryFolder folder;
  const auto scene = folder.write(asking(with_protocol(bars_of(1), "kim"), "contact_impulse_n_s = 0.001"));
  const auto checked = run_command({ricochet_binary(), "check", scene}, folder.path().string(), 120.0);
  EXPECT_THAT(checked.out,
              HasSubstr("asked: contact_impulse_n_s within 0.1 %; `ricochet run` says whether that was reached"));
  const auto run = run_command({ricochet_binary(), "run", scene, "--out", folder.path().string() + "/run"},
                               folder.path().string(), 120.0);
  EXPECT_EQ(run.code, 0) << run.error;
  EXPECT_THAT(run.out, HasSubstr("asked: contact_impulse_n_s within 0.1 %: not reached, its bar is "));
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "run" / "advice.csv"));
}

/// A bar on a driven one, of pieces whose meshes differ: the coarse pilots agree too well. The mesh alone is
/// open, so that the cheapest is the same on any machine.
std::string bars_of_pieces(const std::string& error) {
  return R"(model = "axisymmetric"
[[body]]
name = "low"
material = { youngs_modulus_pa = 70e9, poisson_ratio = 0.0, density_kg_m3 = 2700.0 }
mesh = { length_m = 0.01, radius_m = 0.004, elements = [2, 18] }
[[body.prescribed]]
surface = "start"
component = "z"
displacement_m = 1e-6
amplitude = { time_s = [0.0, 4e-6, 2e-5], factor = [0.0, 1.0, 0.5] }
[[body]]
name = "high"
material = { youngs_modulus_pa = 200e9, poisson_ratio = 0.0, density_kg_m3 = 2700.0 }
initial_velocity_m_s = [0.0, -2.0]
[[body.mesh.piece]]
name = "a"
start_m = 0.010005
length_m = 0.005
radius_m = 0.004
elements = [2, 4]
[[body.mesh.piece]]
name = "b"
start_m = 0.015005
length_m = 0.005
radius_m = 0.004
elements = [3, 9]
[[body.mesh.tie]]
surfaces = ["a.end", "b.start"]
[contact]
surfaces = ["low.end", "high.a.start"]
[coupling]
protocol = "all_implicit"
[time]
step_s = 1.166e-7
end_s = 24e-6
[accuracy]
relative_error = { contact_impulse_n_s = )" +
         error + R"( }
elements_times = [0.5, 1, 2]
)";
}

/// Bodies, contact and an end are enough.
TEST(Accuracy, IsAskedOfASceneThatSaysNothingOfPartitionAndStep) {
  const TemporaryFolder folder;
  std::string text = without_step(bars_of(4));
  const auto partition = text.find("[partition]"), next = text.find("\n[", partition);
  text.erase(partition, next + 1 - partition);
  const auto run = run_text(asking(text, "contact_impulse_n_s = 0.05"), folder);
  const double exact_n_s = bars_force_n * bars_contact_s;
  EXPECT_NEAR(run.summary.at("contact_impulse_n_s").get<double>(), exact_n_s, 0.05 * exact_n_s);
}

TEST(Accuracy, ThatTheChoiceHasNotReachedIsReachedByWhatItSaysToType) {
  const TemporaryFolder folder;
  const auto run = [&](const std::string& error) {
    const auto outcome = run_command(
        {ricochet_binary(), "run", folder.write(bars_of_pieces(error)), "--out", folder.path().string() + "/run"},
        folder.path().string(), 120.0);
    EXPECT_EQ(outcome.code, 0) << outcome.error;
    return outcome.out;
  };
  const auto first = run("0.05");
  ASSERT_THAT(first, HasSubstr("asked: contact_impulse_n_s within 5 %: not reached, its bar is "));
  ASSERT_THAT(first, HasSubstr("% were expected: with relative_error = { \"contact_impulse_n_s\" = "));
  const auto from = first.find("\"contact_impulse_n_s\" = ") + 24;
  const auto second = run(first.substr(from, first.find(' ', from) - from));
  const auto bar = second.find(", its bar is ");
  ASSERT_NE(bar, std::string::npos);
  EXPECT_LE(std::stod(second.substr(bar + 13)), 5.0) << second;
}

}  // namespace
}  // namespace ricochet::test

// Each explicit participant with its own number of substeps: a striker of short elements takes several in a window, the
// long bar behind the contact one. Exact: Acceptance A4, the force falls in steps of r = (Z1 - Z2)/(Z1 + Z2).
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>

#include "tests/support/run.hpp"
#include "tests/support/same_results.hpp"

namespace ricochet::test {
namespace {

using testing::HasSubstr;

constexpr double area_m2 = 1e-4;
const double z_steel = area_m2 * std::sqrt(207e9 * 7860), z_aluminium = area_m2 * std::sqrt(70e9 * 2700);
const double interval_s = 2 * 0.1 / std::sqrt(207e9 / 7860);

/// unequal_bars with the striker's elements four times shorter, an explicit participant for each body.
std::string bars(const std::string& of_striker, const std::string& of_bar, const std::string& of_coupling = "") {
  std::string text =
      replaced(config_text("unequal_bars"), "length_m = 0.1, elements = 100", "length_m = 0.1, elements = 400");
  text += "[coupling]\nprotocol = \"prakash_hjelmstad\"\n" + of_coupling;
  for (const auto& [name, substeps] : {std::pair{"striker", of_striker}, {"bar", of_bar}})
    text += fmt::format("[[participant]]\nname = \"of_{}\"\nrole = \"explicit\"\nbodies = [\"{}\"]\n{}", name, name,
                        substeps);
  return text + "[[participant]]\nname = \"contact\"\nrole = \"implicit\"\n";
}

void expect_steps_of_force(const RunResult& run) {
  const double first = 10.0 * z_steel * z_aluminium / (z_steel + z_aluminium),
               r = (z_steel - z_aluminium) / (z_steel + z_aluminium);
  for (int n = 0; n < 3; ++n) {
    const double mean = run.mean("contact_force_n", (n + 0.2) * interval_s, (n + 0.8) * interval_s);
    EXPECT_NEAR(mean, first * std::pow(r, n), 0.003 * first) << "interval " << n;
  }
  EXPECT_LT(run.summary.at("momentum_error_max").get<double>(), 1e-11);
}

TEST(OwnSubsteps, GiveTheForceOfEqualOnesInAFourthOfTheWindows) {
  const TemporaryFolder folder;
  const auto own = run_text(bars("substeps = 4\n", ""), folder, "own"), one = run_text(bars("", ""), folder, "one");
  expect_steps_of_force(own);
  expect_steps_of_force(one);
  EXPECT_NEAR(one.summary.at("windows").get<double>() / own.summary.at("windows").get<double>(), 4.0, 0.05);
  EXPECT_LT(own.largest("energy_error"), 2e-3);
  EXPECT_LT(own.summary.at("interface_energy_max").get<double>(), 2e-3);
}

TEST(OwnSubsteps, ThatAreEqualAreThoseOfTheCoupling) {
  const TemporaryFolder folder;
  const auto own = run_text(bars("substeps = 3\n", "substeps = 3\n"), folder, "own"),
             common = run_text(bars("", "", "substeps = 3\n"), folder, "common");
  for (const char* column : {"time_s", "contact_force_n", "energy_kinetic_j", "velocity_mean_bar_m_s"})
    EXPECT_EQ(own.column(column), common.column(column)) << column;
}

/// The fewest substeps of each that are within safety_factor of its critical step: 4 h/c = 0.779 us / 0.9 for the
/// aluminium bar's own elements, four times fewer for the striker's.
TEST(OwnSubsteps, AreFoundWhereFewestAreAsked) {
  const TemporaryFolder folder;
  const std::string text = replaced(bars("", "", "substeps = \"fewest\"\n"), "safety_factor = 0.9", "step_s = 0.17e-6");
  const std::string scene = folder.write(text);
  const auto checked = run_command({ricochet_binary(), "check", scene}, folder.path().string());
  EXPECT_EQ(checked.code, 0) << checked.error;
  EXPECT_THAT(checked.out, HasSubstr("participant \"of_striker\" takes 4 substeps of 4.25e-08 s in a window"));
  EXPECT_THAT(checked.out, testing::Not(HasSubstr("\"of_bar\" takes")));
  expect_steps_of_force(run_text(text, folder, "run"));
}

/// An unstable number of its own is refused with the number to type.
TEST(OwnSubsteps, OfTooLongASubstepAreRefused) {
  const TemporaryFolder folder;
  const std::string text = replaced(bars("substeps = 2\n", ""), "safety_factor = 0.9", "step_s = 0.17e-6");
  const auto run = run_file(folder.write(text), folder);
  EXPECT_EQ(run.outcome.code, 2);
  EXPECT_THAT(run.outcome.error, HasSubstr("substeps = 4 of that participant"));
}

/// The shortest of m times the critical step of each; of 40 elements each that is the striker's.
TEST(OwnSubsteps, AreStableUpToTheStepOfEach) {
  const TemporaryFolder folder;
  std::string text = replaced(bars("substeps = 4\n", ""), "elements = 400", "elements = 40");
  text = replaced(text, "length_m = 0.4, elements = 400", "length_m = 0.4, elements = 40");
  const auto swept = run_command({ricochet_binary(), "stability", folder.write(text), "--sweep", "courant=0.98,1.02",
                                  "--out", (folder.path() / "out").string()},
                                 folder.path().string());
  EXPECT_EQ(swept.code, 0) << swept.error;
  EXPECT_THAT(swept.out, testing::ContainsRegex("1.90964e-06 +0.98000 open +[^ ]+ +[^ ]+ stable"));
  EXPECT_THAT(swept.out, testing::ContainsRegex("1.98759e-06 +1.02000 open +[^ ]+ +[^ ]+ unstable"));
}

TEST(OwnSubsteps, GoOnFromACheckpointToTheSameBytes) {
  const TemporaryFolder folder;
  const std::string text = with_key(bars("substeps = 4\n", ""), "checkpoint", "every_windows", "150");
  const RunResult whole = run_text(text, folder);
  (void)expect_the_same_from_the_earlier_checkpoint(whole, folder);
}

}  // namespace
}  // namespace ricochet::test

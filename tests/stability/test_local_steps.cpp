#include <gmock/gmock.h>

#include <regex>

#include "tests/stability/edges.hpp"

// `ricochet stability` of `local_explicit`: stable as long as the coarse elements bear the window.

namespace ricochet::test {
namespace {

using testing::HasSubstr;

/// A body whose elements get finer along its axis.
struct GradedBody {
  const char *name, *model, *mesh, *velocity;

  [[nodiscard]] std::string text(const std::string& protocol, double step_s) const {
    return "model = \"" + std::string(model) +
           "\"\n[[body]]\nname = \"body\"\n"
           "material = { youngs_modulus_pa = 1e9, poisson_ratio = 0.3, density_kg_m3 = 1000.0 }\nmesh = " +
           mesh + "\ninitial_velocity_m_s = " + velocity + "\n[time]\nstep_s = " + number(step_s) +
           "\nend_s = 0.1\n[coupling]\nprotocol = \"" + protocol + "\"\n";
  }
};

class StabilityOfLocalSteps : public testing::TestWithParam<GradedBody> {};
INSTANTIATE_TEST_SUITE_P(
    Bodies, StabilityOfLocalSteps,
    testing::Values(GradedBody{"sheet", "plane_strain",
                               "{ length_m = 1.0, height_m = 1.0, elements = [8, 24], grading = [1.0, 8.0] }",
                               "[0.0, -0.01]"},
                    GradedBody{"block", "solid",
                               "{ length_m = 1.0, height_m = 1.0, width_m = 1.0, elements = [3, 3, 16], grading = "
                               "[1.0, 1.0, 16.0] }",
                               "[0.0, 0.0, -0.01]"}),
    [](const auto& tested) { return tested.param.name; });

/// The longest window that the coarsest node bears as one step, of which `check` grants 0.9 to who asks for more.
double longest_window_s(const GradedBody& body, const TemporaryFolder& folder) {
  const Outcome refusal = check_text(body.text("local_explicit", 1e-2), folder);
  EXPECT_EQ(refusal.code, 2);
  std::smatch found;
  EXPECT_TRUE(std::regex_search(refusal.error, found, std::regex("\"local_explicit\": ([-+.e0-9]+) or less")))
      << refusal.error;
  return found.empty() ? 0.0 : std::stod(found[1]) / 0.9;
}

int rows_with(const std::string& verdict, const GradedBody& body, const std::string& protocol, double longest_s,
              const TemporaryFolder& folder) {
  const std::string scene = folder.write(body.text(protocol, 5e-6), "stability.toml"),
                    out = (folder.path() / protocol).string(),
                    sweep = "time.step_s=" + number(0.5 * longest_s) + "," + number(0.99 * longest_s);
  const Outcome outcome = run_command({ricochet_binary(), "stability", scene, "--out", out, "--sweep", sweep},
                                      folder.path().string(), 300.0);
  EXPECT_EQ(outcome.code, 0) << outcome.error;
  const std::string rows = file_text(out + "/stability.csv");
  const std::regex word("," + verdict + ",");
  return static_cast<int>(std::distance(std::sregex_iterator(rows.begin(), rows.end(), word), std::sregex_iterator()));
}

TEST_P(StabilityOfLocalSteps, ReachesTheStepOfTheCoarseElements) {
  const TemporaryFolder folder;
  const GradedBody& body = GetParam();
  const double longest_s = longest_window_s(body, folder);
  EXPECT_GT(longest_s, 7e-5) << "seven times or more the critical step of all elements";
  EXPECT_THAT(check_text(body.text("all_explicit", longest_s), folder).error,
              HasSubstr("times the critical time step"));
  EXPECT_EQ(rows_with("stable", body, "local_explicit", longest_s, folder), 2);
  EXPECT_EQ(rows_with("unstable", body, "all_explicit", longest_s, folder), 2) << "the measurement can tell";
}

}  // namespace
}  // namespace ricochet::test

// Facts at the end of a run that a reader takes: the peak of a flat impact, when bodies meet and part, what never met.
#include <gmock/gmock.h>

#include <algorithm>

#include "tests/support/run.hpp"

namespace ricochet::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

/// The scene of `ricochet init`: two cylinders meet end to end, 604.4 MPa by impedance theory on pi (5 mm)^2.
constexpr double theory_n = 604.37e6 * 7.854e-5;

std::string first_scene(const TemporaryFolder& folder, double safety_factor, const std::string& protocol) {
  const auto path = folder.path() / "first";
  run_command({ricochet_binary(), "init", path.string()}, folder.path().string());
  std::string text = with_protocol(file_text(path.string() + ".toml"), protocol);
  std::filesystem::remove(path.string() + ".toml");
  return replaced(text, "safety_factor = 0.9 ", "safety_factor = " + std::to_string(safety_factor) + " ");
}

class FlatImpact : public testing::TestWithParam<std::string> {};

/// The mass of the contact nodes stops in one window: the force there goes with 1/step, that after 2h/c does not.
TEST_P(FlatImpact, HasAPeakThatDoesNotGoWithTheStep) {
  const TemporaryFolder folder;
  const auto coarse = run_text(first_scene(folder, 0.9, GetParam()), folder, "coarse");
  const auto fine = run_text(first_scene(folder, 0.2, GetParam()), folder, "fine");
  const auto of = [](const RunResult& run, const char* key) { return run.summary.at(key).get<double>(); };
  for (const auto* key : {"peak_contact_force_n", "gauge_peak_force_n"}) {
    EXPECT_NEAR(of(fine, key) / of(coarse, key), 1.0, 0.05) << key;
    EXPECT_NEAR(of(fine, key) / theory_n, 1.16, 0.08) << key << ": a cylinder's front is that of a plate at first";
  }
  EXPECT_GT(of(fine, "first_window_force_n"), 1.3 * of(coarse, "first_window_force_n"));
  const double rise_s = of(fine, "rise_time_s");
  EXPECT_NEAR(rise_s, 2e-3 / 5955.0, 0.01 * rise_s) << "2h/c of elements of 1 mm";
  EXPECT_GT(of(fine, "peak_contact_force_s"), rise_s);
  EXPECT_THAT(fine.outcome.out, AllOf(HasSubstr("after the first 2h/c = 0.33"), HasSubstr("N in the first window;")));
  EXPECT_THAT(file_text(fine.folder + "/report.html"), HasSubstr("force in the first window"));
}

TEST_P(FlatImpact, IsToldTheSameWhateverRowsAreKept) {
  const TemporaryFolder folder;
  const std::string text = first_scene(folder, 0.3, GetParam());
  const auto all = run_text(text, folder, "all");
  const auto few = run_text(with_key(text, "output", "history_every", "7"), folder, "few");
  for (const auto* key : {"first_contact_s", "separation_time_s", "peak_contact_force_n", "peak_contact_force_s",
                          "first_window_force_n", "gauge_peak_force_n", "contact_level_n"})
    EXPECT_EQ(all.summary.at(key), few.summary.at(key)) << key;
  EXPECT_NEAR(all.summary.at("first_window_force_n").get<double>(), all.column("contact_force_n")[1], 1e-6 * theory_n);
}

INSTANTIATE_TEST_SUITE_P(Headline, FlatImpact,
                         testing::Values("hughes_liu", "all_explicit", "all_implicit", "belytschko_mullen"),
                         [](const auto& test) { return test.param; });

/// A striker meets the first of two bars that touch each other: c = 1000 m/s, 0.5 m each.
std::string chain(const std::string& protocol) {
  const auto bar = [](const std::string& name, const std::string& start, const std::string& velocity) {
    return "[[body]]\nname = \"" + name +
           "\"\nmaterial = { youngs_modulus_pa = 1e9, poisson_ratio = 0.25, density_kg_m3 = 1000.0 }\nmesh = { start_m "
           "= " +
           start + ", length_m = 0.5, elements = 50 }\ninitial_velocity_m_s = [" + velocity + "]\n";
  };
  return "model = \"bar\"\n" + bar("striker", "-0.5", "1.0") + bar("middle", "0.0", "0.0") + bar("last", "0.5", "0.0") +
         "[[contact]]\nname = \"hit\"\nsurfaces = [\"striker.end\", \"middle.start\"]\n"
         "[[contact]]\nname = \"touching\"\nsurfaces = [\"middle.end\", \"last.start\"]\n" +
         (protocol.rfind("all_", 0) == 0
              ? ""
              : "[partition]\nimplicit_length_m = { striker = 0.1, middle = 0.1, last = 0.1 }\n") +
         "[time]\nsafety_factor = 0.7\nend_s = 2.5e-3\n[coupling]\nprotocol = \"" + protocol + "\"\n";
}

class TouchingBodies : public testing::TestWithParam<std::string> {};

TEST_P(TouchingBodies, MeetWhenTheWaveArrives) {
  const TemporaryFolder folder;
  const auto run = run_text(chain(GetParam()), folder);
  const auto& touching = run.summary.at("contacts").at("touching");
  constexpr double arrival_s = 5e-4;
  EXPECT_NEAR(touching.at("first_contact_s").get<double>(), arrival_s, 0.16 * arrival_s)
      << "what it shows before is the foot of the discrete wave";
  EXPECT_NEAR(touching.at("separation_time_s").get<double>(), 3.0 * arrival_s, 0.15 * arrival_s);
  EXPECT_NEAR(touching.at("contact_level_n").get<double>(), 1e-3 * run.largest("contact_force_n/touching"), 1e-3);
  EXPECT_THAT(run.outcome.out, HasSubstr("0.001 of the largest"));
}

INSTANTIATE_TEST_SUITE_P(Headline, TouchingBodies, testing::Values("hughes_liu", "all_explicit", "all_implicit"),
                         [](const auto& test) { return test.param; });

std::string flight(const std::string& gap_m, const std::string& more = "") {
  const auto bar = [](const std::string& name, const std::string& start, const std::string& velocity) {
    return "[[body]]\nname = \"" + name +
           "\"\nmaterial = { youngs_modulus_pa = 1e9, poisson_ratio = 0.25, density_kg_m3 = 1000.0 }\nmesh = { start_m "
           "= " +
           start + ", length_m = 0.5, elements = 50 }\ninitial_velocity_m_s = [" + velocity + "]\n";
  };
  return "model = \"bar\"\n" + bar("one", "-0.5", "1.0") + bar("other", "0.0", "0.0") +
         "[contact]\nsurfaces = [\"one.end\", \"other.start\"]\ninitial_gap_m = " + gap_m +
         "\n[partition]\nimplicit_length_m = { one = 0.1, other = 0.1 }\n[time]\nsafety_factor = 0.9\nend_s = 2e-3\n" +
         more;
}

TEST(BodiesThatNeverMeet, AreSaid) {
  const TemporaryFolder folder;
  const auto run = run_text(flight("0.01"), folder);
  EXPECT_THAT(run.outcome.out, AllOf(HasSubstr("none in this run: the bodies never met; smallest gap 0.00799"),
                                     Not(HasSubstr("peak contact"))));
  EXPECT_TRUE(run.summary.at("first_contact_s").is_null());
  EXPECT_TRUE(run.summary.at("separation_time_s").is_null());
  EXPECT_THAT(file_text(run.folder + "/report.html"), HasSubstr("the bodies never met"));
}

TEST(SceneWithoutContact, IsSaidAndHasNoTheory) {
  const TemporaryFolder folder;
  std::string text = flight("0.0");
  text.erase(text.find("[contact]"), text.find("[time]") - text.find("[contact]"));
  text += "[coupling]\nprotocol = \"all_explicit\"\n";
  const auto run = run_text(replaced(text, "[1.0]", "[0.0]"), folder);
  EXPECT_THAT(run.outcome.out, HasSubstr("none in this scene"));
  EXPECT_FALSE(run.summary.contains("theory"));
  EXPECT_THAT(file_text(run.folder + "/report.html"), Not(HasSubstr("<th>theory</th>")));
}

TEST(Windows, OfTheSummaryAreWhatWasComputed) {
  const TemporaryFolder folder;
  const auto run = run_text(flight("0.0", "until_separated_plus_s = 1e-5\n"), folder);
  const auto rows = static_cast<int>(run.column("time_s").size());
  EXPECT_EQ(run.summary.at("windows"), rows - 1);
  EXPECT_GT(run.summary.at("windows_planned").get<int>(), rows + 20);
  EXPECT_TRUE(run.summary.contains("theory"));
}

/// The force of the last window may end within it: its pairs are open at its end, and the run counts from there.
TEST(Headline, OfARunThatEndsAsSoonAsBodiesAreApartHasTheSeparation) {
  const TemporaryFolder folder;
  for (const char* const step_s : {"7e-7", "6e-7", "5.85131e-7", "5e-7", "4e-7", "3e-7"}) {
    const auto run = run_text(std::string(R"(model = "axisymmetric"
[[body]]
name = "ball"
material = { youngs_modulus_pa = 200e9, poisson_ratio = 0.32, density_kg_m3 = 7850.0 }
initial_velocity_m_s = [0.0, -0.05]
mesh = { length_m = 0.01, radius_m = 0.005, elements = [10, 20] }
[[body]]
name = "plate"
material = { youngs_modulus_pa = 68.9e9, poisson_ratio = 0.35, density_kg_m3 = 2710.0 }
mesh = { start_m = -0.02, length_m = 0.02, radius_m = 0.02, elements = [30, 30] }
[contact]
surfaces = ["ball.start", "plate.end"]
nose_radius_m = 0.02
[coupling]
protocol = "all_implicit"
[time]
end_s = 2e-4
until_separated_plus_s = 0.0
step_s = )") + step_s + "\n",
                              folder);
    EXPECT_LT(run.summary.at("windows"), run.summary.at("windows_planned"));
    EXPECT_FALSE(run.summary.at("separation_time_s").is_null()) << step_s;
  }
}

}  // namespace
}  // namespace ricochet::test

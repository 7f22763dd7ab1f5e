// material.yield_stress_pa and strength_pa: where, when and by how much stress first passes them, against exact waves,
// uniform stress and Hertz' theory.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

#include "tests/support/run.hpp"

namespace ricochet::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

const nlohmann::json* passed(const RunResult& run, const std::string& kind) {
  for (const auto& entry : run.summary.at("outside_model"))
    if (entry.at("kind") == kind) return &entry;
  return nullptr;
}

std::string limits_checked(const std::string& text, const TemporaryFolder& folder) {
  const auto outcome =
      run_command({ricochet_binary(), "check", folder.write(text, "check.toml")}, folder.path().string());
  EXPECT_EQ(outcome.code, 0) << outcome.error;
  return outcome.out;
}

/// Half a cosine from 0 to 1, of which so slow a pull makes vibrations of 0.4 % at most.
constexpr double pull_s = 3.2e-3;
std::string slowly() {
  std::string times, factors;
  for (int i = 0; i <= 64; ++i) {
    times += fmt::format("{}{:.9f}", i == 0 ? "" : ", ", pull_s * i / 64.0);
    factors += fmt::format("{}{:.9f}", i == 0 ? "" : ", ", 0.5 - 0.5 * std::cos(std::numbers::pi * i / 64.0));
  }
  return "{ time_s = [" + times + "], factor = [" + factors + "] }";
}

/// A block of 1 GPa, 0.25 and 1000 kg/m^3 that is pulled along its axis, over eight periods of its longest wave. Its
/// flanks are free.
std::string pulled_block(const std::string& model, const std::string& protocol, double pull_pa,
                         const std::string& limit) {
  const std::string axis = model == "bar" ? "x" : model == "axisymmetric" || model == "solid" ? "z" : "y";
  const std::string zeros = model == "bar" ? "" : model == "solid" ? "0.0, 0.0, " : "0.0, ";
  const std::string across = model == "bar"            ? "elements = 10"
                             : model == "solid"        ? "height_m = 0.02, width_m = 0.02, elements = [2, 2, 10]"
                             : model == "axisymmetric" ? "radius_m = 0.02, elements = [2, 10]"
                                                       : "height_m = 0.02, elements = [2, 10]";
  return fmt::format(
      "model = \"{}\"\n[[body]]\nname = \"block\"\nmaterial = {{ youngs_modulus_pa = 1e9, poisson_ratio = 0.25, "
      "density_kg_m3 = 1000.0, {} }}\nmesh = {{ length_m = 0.1, {} }}\n"
      "support = [{{ surface = \"start\", fixed = [\"{}\"] }}]\n"
      "traction = [{{ surface = \"end\", traction_pa = [{}{}], amplitude = {} }}]\n[time]\n{}\nend_s = "
      "3.4e-3\n[coupling]\nprotocol = \"{}\"\n",
      model, limit, across, axis, zeros, pull_pa, slowly(),
      protocol == "all_explicit" ? "safety_factor = 0.9" : "step_s = 1e-5", protocol);
}

struct Pull {
  std::string model, protocol;
};

class Pulled : public testing::TestWithParam<Pull> {};

/// In plane strain the stress across the plane, nu sigma, makes von Mises' smaller, sqrt(1 - nu + nu^2) sigma.
TEST_P(Pulled, PassesItsLimitsWhereUniformStressDoes) {
  const auto& [model, protocol] = GetParam();
  const double share = model == "plane_strain" ? std::sqrt(1.0 - 0.25 + 0.0625) : 1.0;
  const std::string yield = fmt::format("yield_stress_pa = {:.6f}", share * 5e6), strength = "strength_pa = 5e6";
  const TemporaryFolder folder;
  for (const double sign : {1.0, -1.0}) {
    const auto below = run_text(pulled_block(model, protocol, sign * 4.95e6, yield + ", " + strength), folder, "below");
    EXPECT_EQ(below.summary.at("status"), "done") << below.summary.at("outside_model");
    const auto run = run_text(pulled_block(model, protocol, sign * 5.05e6, yield + ", " + strength), folder, "above");
    EXPECT_EQ(run.summary.at("status"), "left_model");
    EXPECT_EQ(run.summary.at("limits").at(0).at("strength_pa"), 5e6);
    const auto* tension = passed(run, "tension");
    EXPECT_EQ(tension != nullptr, sign > 0.0) << "compression breaks nothing";
    if (tension) {
      EXPECT_NEAR(tension->at("size").get<double>(), 5.05e6, 0.03e6);
    }
    const auto* flows = passed(run, "yield");
    ASSERT_TRUE(flows);
    EXPECT_NEAR(flows->at("size").get<double>(), share * 5.05e6, 0.03e6);
    EXPECT_FALSE(flows->at("results_wrong").get<bool>());
    const double first_s = flows->at("first_s"), step_s = run.summary.at("window_size_s");
    EXPECT_NEAR(first_s, pull_s * std::acos(1.0 - 2.0 / 1.01) / std::numbers::pi, 0.1e-3)
        << "when the pull has grown to the limit";
    const double looks = protocol == "all_implicit" || model == "bar" ? 1.0 : 8.0;
    EXPECT_NEAR(first_s - flows->at("last_without_s").get<double>(), looks * step_s, 1e-9);
    EXPECT_GT(flows->at("first_size").get<double>(), share * 5e6);
    EXPECT_LE(flows->at("first_size").get<double>(), flows->at("size").get<double>());
    EXPECT_THAT(run.outcome.error, HasSubstr(fmt::format("times its yield stress of {:.4g} MPa", share * 5.0)));
    EXPECT_THAT(file_text(run.folder + "/report.html"), HasSubstr("yield stress passed in block"));
  }
}

INSTANTIATE_TEST_SUITE_P(Blocks, Pulled,
                         testing::Values(Pull{"bar", "all_explicit"}, Pull{"bar", "all_implicit"},
                                         Pull{"plane_strain", "all_explicit"}, Pull{"plane_strain", "all_implicit"},
                                         Pull{"axisymmetric", "all_explicit"}, Pull{"axisymmetric", "all_implicit"},
                                         Pull{"solid", "all_explicit"}, Pull{"solid", "all_implicit"}),
                         [](const auto& test) { return test.param.model + "_" + test.param.protocol; });

/// Bars of 1 GPa and 4 GPa, 1000 kg/m^3, that meet at x = 0: the stress is two thirds of rho c v of the first,
/// 0.667 MPa for each m/s. Its yield stress of 10 MPa is reached at 15 m/s.
std::string limited_bars(double speed_m_s, const std::string& protocol) {
  const std::string material = "material = { density_kg_m3 = 1000.0, youngs_modulus_pa = ";
  return fmt::format(
      "model = \"bar\"\n[[body]]\nname = \"left\"\n{}1e9, yield_stress_pa = 10e6 }}\nmesh = {{ start_m = -1.0, "
      "length_m = 1.0, elements = 50 }}\ninitial_velocity_m_s = [{}]\n"
      "[[body]]\nname = \"right\"\n{}4e9 }}\nmesh = {{ length_m = 2.0, elements = 50 }}\n"
      "[contact]\nsurfaces = [\"left.end\", \"right.start\"]\n"
      "[partition]\nimplicit_length_m = {{ left = 0.1, right = 0.2 }}\n"
      "[time]\n{}\nend_s = 1.5e-3\n[coupling]\nprotocol = \"{}\"\n",
      material, speed_m_s, material, protocol == "all_explicit" ? "safety_factor = 1.0" : "step_s = 1.8e-5", protocol);
}

/// Where each wave crosses an element in a step, central difference has the exact waves, without overshoot.
TEST(BarAtItsYieldVelocity, PassesTheYieldStressOnePercentAboveItAndNotOnePercentBelow) {
  const TemporaryFolder folder;
  const auto below = run_text(limited_bars(0.99 * 15.0, "all_explicit"), folder, "below");
  EXPECT_EQ(below.summary.at("status"), "done") << below.summary.at("outside_model");
  const auto run = run_text(limited_bars(1.01 * 15.0, "all_explicit"), folder, "above");
  EXPECT_EQ(run.summary.at("status"), "left_model");
  EXPECT_EQ(run.summary.at("exit_code"), 0);
  const auto* yield = passed(run, "yield");
  ASSERT_TRUE(yield) << run.summary.at("outside_model");
  EXPECT_EQ(yield->at("body"), "left") << "the other body has no limit";
  EXPECT_NEAR(yield->at("size").get<double>(), 10.1e6, 10.0);
  EXPECT_NEAR(yield->at("first_size").get<double>(), 10.1e6, 10.0);
  EXPECT_NEAR(yield->at("first_place_m").at(0).get<double>(), -0.01, 1e-9) << "the element at the contact";
  EXPECT_LE(yield->at("first_s").get<double>(), 2.1 * 2e-5);
  EXPECT_THAT(run.outcome.error, AllOf(HasSubstr("warning: von Mises stress of 10.1 MPa in body 'left'"),
                                       HasSubstr("1.01 times its yield stress of 10 MPa; first passed between t = "),
                                       HasSubstr("a metal flows")));
  EXPECT_THAT(run.outcome.out, HasSubstr("1.01 times its yield stress"));
  EXPECT_THAT(file_text(run.folder + "/report.html"),
              AllOf(HasSubstr("1.01 times its yield stress"), HasSubstr("yield stress of left"),
                    HasSubstr("yield stress passed in left")));
}

TEST(BarAtItsYieldVelocity, IsWarnedOfBeforeTheRun) {
  const TemporaryFolder folder;
  EXPECT_THAT(limits_checked(limited_bars(0.99 * 15.0, "all_explicit"), folder), Not(HasSubstr("yield stress")));
  EXPECT_THAT(limits_checked(limited_bars(1.01 * 15.0, "all_explicit"), folder),
              HasSubstr("warning: an impact at 15.15 m/s makes, by impedance theory, a von Mises stress of 10.1 MPa in "
                        "body \"left\", 1.01 times its yield stress of 10 MPa: linear elastic elements are right up to "
                        "15 m/s"));
  const auto run = run_text(limited_bars(1.01 * 15.0, "all_explicit"), folder);
  EXPECT_THAT(run.outcome.error, HasSubstr("makes, by impedance theory, a von Mises stress of 10.1 MPa"));
}

class BarOfBothSolvers : public testing::TestWithParam<const char*> {};

/// Steps shorter than the critical one, and the trapezoidal rule, overshoot behind a front that is a jump, by less than
/// half of it.
TEST_P(BarOfBothSolvers, IsLookedAtInBoth) {
  const TemporaryFolder folder;
  EXPECT_TRUE(run_text(limited_bars(0.6 * 15.0, GetParam()), folder, "below").summary.at("outside_model").empty());
  const auto run = run_text(limited_bars(1.2 * 15.0, GetParam()), folder, "above");
  const auto* yield = passed(run, "yield");
  ASSERT_TRUE(yield);
  EXPECT_NEAR(yield->at("first_place_m").at(0).get<double>(), -0.01, 0.021);
  EXPECT_LE(yield->at("first_s").get<double>(), 5.0 * 1.8e-5);
}

INSTANTIATE_TEST_SUITE_P(Bars, BarOfBothSolvers,
                         testing::Values("hughes_liu", "all_implicit", "belytschko_mullen", "kim"),
                         [](const auto& test) { return std::string(test.param); });

/// A striker of 0.2 m sends a pulse of 0.4 m and 10 MPa into a bar of 1 m and equal impedance. Its free end sends it
/// back as tension, which the rest of the pulse balances until its tail has passed: the first tension stands 0.2 m from
/// the free end, (1 + 0.2) m / c after the impact, and has the whole 10 MPa at once.
std::string spalling(const std::string& protocol) {
  const std::string material = "material = { density_kg_m3 = 1000.0, youngs_modulus_pa = 1e9, strength_pa = 5e6 }\n";
  return "model = \"bar\"\n[[body]]\nname = \"striker\"\n" + material +
         "mesh = { start_m = -0.2, length_m = 0.2, elements = 20 }\ninitial_velocity_m_s = [20.0]\n"
         "[[body]]\nname = \"bar\"\n" +
         material +
         "mesh = { length_m = 1.0, elements = 100 }\n[contact]\nsurfaces = [\"striker.end\", \"bar.start\"]\n"
         "[partition]\nimplicit_length_m = { striker = 0.05, bar = 0.05 }\n[time]\n" +
         (protocol == "all_explicit" ? "safety_factor = 1.0" : "step_s = 9e-6") +
         "\nend_s = 1.4e-3\n[coupling]\nprotocol = \"" + protocol + "\"\n";
}

class Spall : public testing::TestWithParam<const char*> {};

TEST_P(Spall, BeginsWhereAndWhenTheExactWavesFirstPull) {
  const bool exact = GetParam() == std::string("all_explicit");
  const TemporaryFolder folder;
  const auto run = run_text(spalling(GetParam()), folder);
  const auto* tension = passed(run, "tension");
  ASSERT_TRUE(tension) << run.summary.at("outside_model");
  EXPECT_EQ(tension->at("body"), "bar");
  EXPECT_NEAR(tension->at("first_place_m").at(0).get<double>(), 0.8, exact ? 0.0051 : 0.02);
  EXPECT_NEAR(tension->at("first_s").get<double>(), 1.2e-3, exact ? 1.01e-5 : 4e-5);
  EXPECT_NEAR(tension->at("size").get<double>(), 10e6, exact ? 10.0 : 5.5e6);
  EXPECT_THAT(run.outcome.error, HasSubstr("a brittle body breaks there"));
}

INSTANTIATE_TEST_SUITE_P(Bars, Spall, testing::Values("all_explicit", "hughes_liu", "all_implicit"),
                         [](const auto& test) { return std::string(test.param); });

TEST(Spall, IsWarnedOfBeforeTheRun) {
  const TemporaryFolder folder;
  EXPECT_THAT(limits_checked(spalling("hughes_liu"), folder),
              HasSubstr("sends, by impedance theory, a wave that a free end turns into a tension of 10 MPa in body "
                        "\"bar\", 2 times its strength of 5 MPa"));
  EXPECT_THAT(limits_checked(replaced(spalling("hughes_liu"), "[20.0]", "[9.9]"), folder), Not(HasSubstr("strength")));
}

/// configs/two_balls.toml, R' = 5 mm, E' = 25 GPa, with limits for the lower ball.
std::string limited_balls(double speed_m_s, const std::string& limits, const std::string& protocol) {
  std::string text = with_absolute_meshes(with_protocol(config_text("two_balls"), protocol));
  text = replaced(text, "density_kg_m3 = 2800.0", "density_kg_m3 = 2800.0, " + limits);
  text = replaced(text, "[0.0, 10.0]", fmt::format("[0.0, {}]", speed_m_s));
  text = replaced(text, "[0.0, -10.0]", fmt::format("[0.0, -{}]", speed_m_s));
  return protocol == "all_explicit" ? replaced(text, "step_s = 5e-8", "safety_factor = 0.9") : text;
}

/// On the axis below a Hertz patch, in shares of the largest pressure: sigma_z = -1/(1 + s^2), s = z/a, and sigma_r =
/// -(1 + nu)(1 - s atan(1/s)) + 1/(2 (1 + s^2)). Von Mises' stress is their difference; its largest is 0.6 or so.
double largest_von_mises_share(double nu) {
  double largest = 0.0;
  for (double s = 0.01; s < 2.0; s += 0.001) {
    const double z = -1.0 / (1.0 + s * s), r = -(1.0 + nu) * (1.0 - s * std::atan(1.0 / s)) + 0.5 / (1.0 + s * s);
    largest = std::max(largest, std::abs(z - r));
  }
  return largest;
}

class YieldingBall : public testing::TestWithParam<const char*> {};

TEST_P(YieldingBall, PassesWhatHertzHasBelowThePatch) {
  const TemporaryFolder folder;
  const auto run = run_text(limited_balls(10.0, "yield_stress_pa = 500e6", GetParam()), folder);
  const auto* yield = passed(run, "yield");
  ASSERT_TRUE(yield);
  constexpr double modulus = 25e9, radius = 5e-3;
  const double force = run.summary.at("peak_contact_force_n");
  const double patch = std::cbrt(0.75 * force * radius / modulus),
               pressure = 1.5 * force / (std::numbers::pi * patch * patch);
  EXPECT_NEAR(yield->at("size").get<double>() / (largest_von_mises_share(0.2) * pressure), 1.0, 0.05);
  EXPECT_LT(yield->at("place_m").at(0).get<double>(), 0.3 * patch);
  EXPECT_EQ(yield->at("body"), "lower");
}

INSTANTIATE_TEST_SUITE_P(Balls, YieldingBall, testing::Values("all_explicit", "hughes_liu", "all_implicit"),
                         [](const auto& test) { return std::string(test.param); });

/// p_max = 1.6 times the yield stress at the yield velocity, which for a given yield stress is what it goes by.
TEST(YieldingBall, IsWarnedOfBeforeTheRunFromItsYieldVelocityOn) {
  const TemporaryFolder folder;
  const double modulus = 25e9, radius = 5e-3, mass = 0.5 * 2800.0 * 4.0 / 3.0 * std::numbers::pi * 1e-6;
  const auto pressure = [&](double closing) {
    const double approach = std::pow(15.0 * mass * closing * closing / (16.0 * std::sqrt(radius) * modulus), 0.4);
    return 2.0 * modulus / std::numbers::pi * std::sqrt(approach / radius);
  };
  const std::string limits = fmt::format("yield_stress_pa = {:.6g}", pressure(20.0) / 1.6);
  EXPECT_THAT(limits_checked(limited_balls(8.5, limits, "hughes_liu"), folder), Not(HasSubstr("yield stress")));
  EXPECT_THAT(limits_checked(limited_balls(11.5, limits, "hughes_liu"), folder),
              AllOf(HasSubstr("makes, by Hertz' theory, a von Mises stress of "), HasSubstr("in body \"lower\""),
                    Not(HasSubstr("in body \"upper\""))));
  EXPECT_THAT(limits_checked(limited_balls(10.0, "strength_pa = 100e6", "hughes_liu"), folder),
              HasSubstr("makes, by Hertz' theory, a tension of "));
}

}  // namespace
}  // namespace ricochet::test

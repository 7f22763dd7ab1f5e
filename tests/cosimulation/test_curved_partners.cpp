// Curved surfaces whose facets do not match, either named first: a core in a bore, a ball on a plate, an edge, a disc
// that rolls and a slider that wanders.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <tuple>
#include <utility>

#include "tests/support/dome_mesh.hpp"
#include "tests/support/plane_grid.hpp"
#include "tests/support/run.hpp"

namespace ricochet::test {
namespace {

std::string body_of(const std::string& name, const std::string& rest, const std::string& modulus = "48e9",
                    const std::string& ratio = "0.2", const std::string& density = "2800.0") {
  return fmt::format(
      "[[body]]\nname = \"{0}\"\nmaterial = {{ youngs_modulus_pa = {1}, poisson_ratio = {2}, density_kg_m3 = {3} }}\n"
      "mesh = {{ gmsh = \"{0}.msh\" }}\n{4}\n",
      name, modulus, ratio, density, rest);
}

std::string contact_of(const std::string& one, const std::string& other, bool other_first, double friction = 0.0) {
  return fmt::format("[contact]\nsurfaces = [\"{}\", \"{}\"]\nfriction_coefficient = {}\n", other_first ? other : one,
                     other_first ? one : other, friction);
}

std::string time_and_protocol(double step_s, double end_s, const std::string& protocol) {
  return fmt::format(
      "[time]\nstep_s = {}\nend_s = {:.17g}\n[output]\nhistory_every = 1\n[coupling]\nprotocol = \"{}\"\n", step_s,
      end_s, protocol);
}

struct Facets {
  int core, bore;
};

class CoreInBore : public testing::TestWithParam<std::tuple<Facets, bool>> {};

/// A quarter of a round core in a block's bore that it fills, pressed slowly from outside by p: exactly, -p I
/// everywhere. Both surfaces are one circle, of which the facets differ.
TEST_P(CoreInBore, CarriesThePressure) {
  constexpr double radius_m = 0.01, side_m = 0.02, pressure_pa = 24e6, ramp_s = 2e-4;
  const auto [facets, bore_first] = GetParam();
  const TemporaryFolder folder;
  const PlaneGrid core(facets.core / 2, facets.core / 2, [&](double a, double b) {
    const auto [x, y] = on_rays(a, b, 0.75);
    return PlaneGrid::Place(radius_m * (a > 0.0 ? x : 0.0), radius_m * (b > 0.0 ? y : 0.0));
  });
  (void)folder.write(core.msh("core", {{"round", core.right() + core.high()}, {"y0", core.low()}, {"x0", core.left()}}),
                     "core.msh");
  const PlaneGrid block(6, facets.bore, [&](double a, double b) {
    const double angle = 0.5 * std::numbers::pi * b, x = b < 1.0 ? std::cos(angle) : 0.0, y = std::sin(angle),
                 r = radius_m + (side_m / std::max(x, y) - radius_m) * a;
    return PlaneGrid::Place(r * x, r * y);
  });
  PlaneGrid::Edges right = block.right(), top(right.begin() + facets.bore / 2, right.end());
  right.resize(static_cast<std::size_t>(facets.bore / 2));
  (void)folder.write(
      block.msh("block",
                {{"hole", block.left()}, {"right", right}, {"top", top}, {"y0", block.low()}, {"x0", block.high()}}),
      "block.msh");
  const std::string supports =
      "[[body.support]]\nsurface = \"x0\"\nfixed = [\"x\"]\n[[body.support]]\nsurface = \"y0\"\nfixed = [\"y\"]\n";
  std::string loads;
  for (const auto& [surface, traction] : {std::pair{"right", "[-24e6, 0.0]"}, {"top", "[0.0, -24e6]"}})
    loads += fmt::format(
        "[[body.traction]]\nsurface = \"{}\"\ntraction_pa = {}\namplitude = {{ time_s = [0.0, {}], factor = [0.0, 1.0] "
        "}}\n",
        surface, traction, ramp_s);
  const RunResult run = run_text(
      "model = \"plane_strain\"\n" + body_of("core", supports) + body_of("block", supports + loads) +
          contact_of("core.round", "block.hole", bore_first) + time_and_protocol(2e-6, 1.5 * ramp_s, "all_implicit"),
      folder);
  const auto of = [&](const char* column) { return run.mean(column, 1.05 * ramp_s, 1.5 * ramp_s); };
  // Facets of 15 degrees carry it, too, and are a third of a fine edge off the circle without being taken for bodies
  // that overlap.
  const double times = facets.bore < 16 ? 6.0 : 1.0;
  // The force of a quarter circle acts along its mean normal.
  EXPECT_NEAR(of("contact_force_n") / (std::sqrt(2.0) * pressure_pa * radius_m), 1.0, times * 3e-3);
  EXPECT_NEAR(of("contact_pressure_mean_pa") / pressure_pa, 1.0, times * 2e-3);
  EXPECT_NEAR(of("contact_pressure_max_pa") / pressure_pa, 1.0, times * 0.03);
  EXPECT_EQ(of("pairs_open"), 0.0);
}

INSTANTIATE_TEST_SUITE_P(Facets, CoreInBore,
                         testing::Combine(testing::Values(Facets{16, 16}, Facets{16, 24}, Facets{24, 16},
                                                          Facets{16, 40}, Facets{40, 16}, Facets{64, 6}),
                                          testing::Bool()),
                         [](const auto& test) {
                           const Facets facets = std::get<0>(test.param);
                           return fmt::format("{}_in_{}_{}_first", facets.core, facets.bore,
                                              std::get<1>(test.param) ? "bore" : "core");
                         });

/// A striker with a round end hits a plate, axisymmetric, from 0.05 mm: no force before it is there, and one peak,
/// whichever is named first and finer.
TEST(RoundOnFlat, HasOneForceInEitherOrderOfTheNames) {
  constexpr double speed_m_s = 5.0, apart_m = 5e-5, step_s = 2e-8;
  const TemporaryFolder folder;
  for (const int cells : {16, 40}) {
    double one = 0.0;
    for (const bool plate_first : {false, true}) {
      const PlaneGrid striker = rectangle(0.0, 0.006, apart_m, 0.008, 24, 16, 0.05, true),
                      plate = rectangle(0.0, 0.008, -0.006, 0.0, cells, 16);
      (void)folder.write(striker.msh("striker", {{"tip", striker.low()}}), "striker.msh");
      (void)folder.write(plate.msh("plate", {{"top", plate.high()}}), "plate.msh");
      const RunResult run =
          run_text("model = \"axisymmetric\"\n" +
                       body_of("striker", fmt::format("initial_velocity_m_s = [0.0, -{:.1f}]", speed_m_s)) +
                       body_of("plate", "") + contact_of("striker.tip", "plate.top", plate_first) +
                       time_and_protocol(step_s, 30e-6, "all_explicit"),
                   folder, "scene");
      const auto &force = run.column("contact_force_n"), &time = run.column("time_s");
      for (std::size_t i = 0; time[i] < apart_m / speed_m_s - step_s; ++i) ASSERT_EQ(force[i], 0.0) << time[i];
      const double peak = run.summary.at("peak_contact_force_n").get<double>();
      if (one == 0.0) one = peak;
      EXPECT_NEAR(peak / one, 1.0, 1e-9) << cells << plate_first;
    }
  }
}

/// Both surfaces go around a right angle: each piece has normals of its own, and the impact stays one-dimensional.
TEST(AroundAnEdge, AnImpactStaysOneDimensional) {
  for (const char* protocol : {"hughes_liu", "all_implicit", "all_explicit"}) {
    const TemporaryFolder folder;
    const PlaneGrid lower = rectangle(0.0, 0.01, -0.02, 0.0, 4, 8), upper = rectangle(0.0, 0.01, 0.0, 0.02, 3, 8);
    (void)folder.write(lower.msh("lower", {{"cap", lower.high() + lower.right()}}), "lower.msh");
    (void)folder.write(upper.msh("upper", {{"cap", upper.low() + upper.right()}}), "upper.msh");
    const std::string partition = "[partition]\nimplicit_length_m = { lower = 0.006, upper = 0.006 }\n";
    const RunResult run = run_text(
        "model = \"plane_strain\"\n" + body_of("lower", "initial_velocity_m_s = [0.0, 5.0]", "48e9", "0.0") +
            body_of("upper", "initial_velocity_m_s = [0.0, -5.0]", "48e9", "0.0") +
            contact_of("lower.cap", "upper.cap", false) + "normal = [0.0, 1.0]\n" +
            time_and_protocol(1e-7, 12e-6, protocol) + (std::string(protocol) == "hughes_liu" ? partition : ""),
        folder);
    const double impedance = std::sqrt(48e9 * 2800.0) * 0.01;
    EXPECT_NEAR(run.mean("contact_force_n", 2e-6, 8e-6) / (impedance * 5.0), 1.0, 0.01) << protocol;
    for (const char* column : {"normal_force_t_n", "friction_force_n"})
      EXPECT_LT(std::max(run.largest(column), -run.smallest(column)), 1e-12 * impedance * 5.0) << protocol;
    EXPECT_LT(run.largest("momentum_t_kg_m_s"), 1e-12 * impedance * 5.0 * 8e-6) << protocol;
  }
}

/// A disc that gravity presses on a plate slips at first and then rolls: its velocity is 2/3 of that at the start,
/// whatever the pressure was on the way, and friction has taken a third of its energy.
TEST(Rolling, ADiscKeepsTwoThirdsOfItsVelocity) {
  for (const bool base_first : {false, true}) {
    const TemporaryFolder folder;
    const PlaneGrid base = rectangle(-0.02, 0.02, -0.006, 0.0, 40, 6);
    (void)folder.write(disc_msh("disc", 0.0, 0.01, 0.01, 16, false), "disc.msh");
    (void)folder.write(base.msh("base", {{"bottom", base.low()}, {"top", base.high()}}), "base.msh");
    const RunResult run = run_text(
        "model = \"plane_strain\"\n" +
            body_of("disc", "initial_velocity_m_s = [1.0, 0.0]\ngravity_m_s2 = [0.0, -2e4]") +
            body_of("base", "[[body.support]]\nsurface = \"bottom\"\nfixed = [\"x\", \"y\"]") +
            contact_of("disc.cap", "base.top", base_first, 0.5) + time_and_protocol(1e-7, 150e-6, "all_explicit"),
        folder);
    const double momentum = std::abs(run.column("momentum_t_kg_m_s").front());
    // It rolls on with elastic vibrations of the friction force.
    EXPECT_NEAR(run.mean("friction_impulse_n_s", 75e-6, 150e-6) / momentum, 1.0 / 3.0, 0.01) << base_first;
    EXPECT_NEAR(run.last("energy_friction_j") / (0.5 * momentum * 1.0), 1.0 / 3.0, 0.003) << base_first;
    EXPECT_LT(run.summary.at("energy_error_max").get<double>(), 1e-5) << base_first;
  }
}

/// A slider with a round end, pressed down by a weight, goes 12 elements of its base along without friction and back.
TEST(Wandering, ASliderCarriesItsWeightAllTheWay) {
  constexpr double ramp_s = 1e-4, period_s = 2e-3, weight_n = 2e6 * 0.004;
  constexpr int knots = 80;
  std::string times, factors;
  for (int k = 0; k <= knots; ++k) {
    times += fmt::format("{:.9g}, ", ramp_s + period_s * k / knots);
    factors += fmt::format("{:.9f}, ", 0.5 - 0.5 * std::cos(2.0 * std::numbers::pi * k / knots));
  }
  for (const bool base_first : {false, true}) {
    const TemporaryFolder folder;
    const PlaneGrid slider = rectangle(-0.002, 0.002, 0.0, 0.003, 10, 6, 0.02),
                    base = rectangle(-0.006, 0.012, -0.004, 0.0, 36, 8);
    (void)folder.write(slider.msh("slider", {{"bottom", slider.low()}, {"top", slider.high()}}), "slider.msh");
    (void)folder.write(base.msh("base", {{"bottom", base.low()}, {"top", base.high()}}), "base.msh");
    const std::string drive = fmt::format(
        "[[body.traction]]\nsurface = \"top\"\ntraction_pa = [0.0, -2e6]\namplitude = {{ time_s = [0.0, {}], factor = "
        "[0.0, 1.0] }}\n[[body.prescribed]]\nsurface = \"top\"\ncomponent = \"x\"\ndisplacement_m = 0.006\namplitude = "
        "{{ time_s = [{}], factor = [{}] }}",
        ramp_s, times, factors);
    const RunResult run = run_text(
        "model = \"plane_strain\"\n" + body_of("slider", drive, "1e9", "0.25", "1000.0") +
            body_of("base", "[[body.support]]\nsurface = \"bottom\"\nfixed = [\"x\", \"y\"]", "1e9", "0.25", "1000.0") +
            contact_of("slider.bottom", "base.top", base_first) +
            time_and_protocol(1e-6, ramp_s + period_s, "all_implicit"),
        folder);
    const double middle_s = ramp_s + 0.5 * period_s;
    EXPECT_NEAR(run.mean("contact_force_n", ramp_s + 2e-4, middle_s) / weight_n, 1.0, 2e-3) << base_first;
    EXPECT_NEAR(run.mean("contact_force_n", middle_s, ramp_s + period_s) / weight_n, 1.0, 2e-3) << base_first;
    EXPECT_LT(std::abs(run.last("normal_impulse_t_n_s")), 1e-4 * weight_n * period_s) << base_first;
    EXPECT_LT(run.summary.at("energy_error_max").get<double>(), 0.01) << base_first;
  }
}

/// `check` names a curved surface whose facets stand off it by more than a tenth of the approach: h^2/(4 R) in the
/// middle of a square one, 1.6 um of 15.5 um by Hertz; in the plane h^2/(8 R).
TEST(CoarseFacets, AreSaidWithTheApproachOfTheImpact) {
  const TemporaryFolder folder;
  const auto check = [&](const std::string& text) {
    const Outcome outcome =
        run_command({ricochet_binary(), "check", folder.write(text, "scene.toml")}, folder.path().string());
    EXPECT_EQ(outcome.code, 0) << outcome.error;
    return outcome.out;
  };
  for (const int across : {5, 8}) {
    std::string bodies;
    for (const bool lower : {true, false}) {
      const std::string name = lower ? "lower" : "upper";
      (void)folder.write(dome_msh(name, {.radius_m = 0.1,
                                         .start_m = lower ? -0.004 : 0.0,
                                         .up = lower,
                                         .half_x = false,
                                         .half_y = false,
                                         .across = lower ? 6 : across,
                                         .along = 6}),
                         name + ".msh");
      bodies += body_of(name, fmt::format("initial_velocity_m_s = [0.0, 0.0, {}]", lower ? "2.0" : "-2.0"));
    }
    const std::string said = check("model = \"solid\"\n" + bodies + contact_of("lower.cap", "upper.cap", false) +
                                   time_and_protocol(1e-7, 1e-6, "all_explicit"));
    EXPECT_THAT(said, testing::Not(testing::HasSubstr("surface \"lower.cap\"")));
    if (across == 8) {
      EXPECT_THAT(said, testing::Not(testing::HasSubstr("facets")));
    }
    if (across == 5) {
      EXPECT_THAT(said, testing::HasSubstr("surface \"upper.cap\": its facets, 0.0008 m long where the bodies meet, "
                                           "stand off the round surface by 1.6e-06 m, and the bodies approach by about "
                                           "1.55e-05 m in the impact, by Hertz' theory"));
    }
  }
  (void)folder.write(disc_msh("disc", 0.0, 0.01, 0.01, 16, false), "disc.msh");
  const PlaneGrid base = rectangle(-0.02, 0.02, -0.006, 0.0, 40, 6);
  (void)folder.write(base.msh("base", {{"top", base.high()}}), "base.msh");
  EXPECT_THAT(
      check("model = \"plane_strain\"\n" + body_of("disc", "initial_velocity_m_s = [0.0, -1.0]") + body_of("base", "") +
            contact_of("base.top", "disc.cap", false) + time_and_protocol(1e-7, 1e-6, "all_explicit")),
      testing::AllOf(testing::HasSubstr("surface \"disc.cap\": its facets, 0.000981 m long"),
                     testing::HasSubstr("by the time of waves"),
                     testing::Not(testing::HasSubstr("surface \"base.top\""))));
}

double processor_time_s() {
  rusage usage{};
  getrusage(RUSAGE_CHILDREN, &usage);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

/// Two domes that slide by a third of an edge while they touch: rows are written anew some dozens of times, not in
/// every window. Measured 1.1 times all-explicit, 1.6 times hybrid.
TEST(ObliqueImpact, CostsLittleMoreThanAStraightOne) {
  for (const auto& [protocol, most] : {std::pair{"all_explicit", 1.8}, {"hughes_liu", 2.5}}) {
    std::array<double, 2> cost{};
    for (std::size_t oblique = 0; oblique < 2; ++oblique) {
      const TemporaryFolder folder;
      std::string bodies;
      for (const bool lower : {true, false}) {
        const std::string name = lower ? "lower" : "upper";
        (void)folder.write(dome_msh(name, {.radius_m = 0.1,
                                           .start_m = lower ? -0.004 : 0.0,
                                           .up = lower,
                                           .half_x = false,
                                           .half_y = false,
                                           .across = lower ? 6 : 5,
                                           .along = 6}),
                           name + ".msh");
        bodies += body_of(name, fmt::format("initial_velocity_m_s = [{}, 0.0, {}]",
                                            oblique == 0 ? "0.0" : (lower ? "1.0" : "-1.0"), lower ? "2.0" : "-2.0"));
      }
      const double before_s = processor_time_s();
      (void)run_text("model = \"solid\"\n" + bodies + contact_of("lower.cap", "upper.cap", false, 0.3) +
                         "normal = [0.0, 0.0, 1.0]\n" + time_and_protocol(1e-7, 60e-6, protocol) +
                         (std::string(protocol) == "hughes_liu"
                              ? "[partition]\nimplicit_length_m = { lower = 0.0014, upper = 0.0014 }\n"
                              : ""),
                     folder);
      cost[oblique] = processor_time_s() - before_s;
    }
    EXPECT_LT(cost[1], most * cost[0]) << protocol;
  }
}

}  // namespace
}  // namespace ricochet::test

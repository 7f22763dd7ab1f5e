#include "tests/support/run.hpp"

// Acceptance A3: two plates under pressure and shear, on both sides of the stick limit v_t / v_n = mu c_L / c_S (here
// 0.52).

namespace ricochet::test {
namespace {

constexpr double area_m2 = 0.0075;  // height 7.5 mm, thickness 1 m
constexpr double pressure_pa = 1.09545e7;
const double c_l = std::sqrt(1e9 * 0.75 / (1000 * 1.25 * 0.5)), c_s = std::sqrt(1e9 / (2 * 1000 * 1.25));

class Plates : public testing::TestWithParam<const char*> {
 protected:
  RunResult run(const std::string& scene) { return run_text(with_protocol(config_text(scene), GetParam()), folder_); }
  TemporaryFolder folder_;
};

TEST_P(Plates, StickBelowTheLimit) {
  const RunResult r = run("sticking_plates");
  EXPECT_NEAR(r.mean("contact_pressure_mean_pa", 50e-6, 400e-6), pressure_pa, 0.005 * pressure_pa);
  const double shear = 1000 * c_s * 3.0;
  EXPECT_NEAR(std::abs(r.mean("friction_force_n", 50e-6, 400e-6)) / area_m2, shear, 0.01 * shear);
  EXPECT_GT(r.mean("pairs_stick", 50e-6, 400e-6), 0.9 * r.mean("pairs_slip", 50e-6, 400e-6) + 1.0);
  EXPECT_LT(r.last("energy_friction_j") / r.column("energy_kinetic_j").front(), 2e-3) << "sticking dissipates nothing";
  // Mohr's circle: -p, nu / (1 - nu) of that across the plate, and the shear.
  const double across = pressure_pa / 3.0, radius = std::hypot(0.5 * (pressure_pa - across), shear);
  const double principal = 0.5 * (pressure_pa + across) + radius;
  EXPECT_NEAR(principal, 1.14180e7, 1e2);
  EXPECT_NEAR(r.mean("principal_stress_mean_pa", 50e-6, 400e-6), principal, 0.005 * principal);
}

/// The pairs slide from the start on, two elements from the shared nodes: what the implicit side answers to probes with
/// this contact is not linear, so it is measured with the contact open.
TEST(SlippingPlates, HaveTheTractionOfTheoryByGravouilCombescureBesideTheInterface) {
  for (const char* substeps : {"1", "2"}) {
    const TemporaryFolder folder;
    std::string text = with_key(with_protocol(config_text("slipping_plates"), "gravouil_combescure"), "coupling",
                                "substeps", substeps);
    text = replaced(text, "{ lower = 0.025, upper = 0.025 }", "{ lower = 0.005, upper = 0.005 }");
    const RunResult r = run_text(text, folder);
    EXPECT_NEAR(r.mean("contact_pressure_mean_pa", 50e-6, 400e-6), pressure_pa, 1e-3 * pressure_pa) << substeps;
    EXPECT_NEAR(std::abs(r.mean("friction_force_n", 50e-6, 400e-6)) / area_m2, 0.3 * pressure_pa, 3e-4 * pressure_pa)
        << substeps;
    EXPECT_LT(r.summary.at("momentum_error_max").get<double>(), 1e-10) << substeps;
    EXPECT_EQ(r.mean("pairs_slip", 50e-6, 400e-6), 3.0) << "the contact is that of the scene again";
  }
}

TEST_P(Plates, SlipAboveTheLimit) {
  const RunResult r = run("slipping_plates");
  EXPECT_NEAR(r.mean("contact_pressure_mean_pa", 50e-6, 400e-6), pressure_pa, 0.005 * pressure_pa);
  const double traction = 0.3 * pressure_pa;
  EXPECT_NEAR(std::abs(r.mean("friction_force_n", 50e-6, 400e-6)) / area_m2, traction, 0.005 * traction);
  EXPECT_EQ(r.mean("pairs_stick", 50e-6, 400e-6), 0.0);
  // Each side slips at v_t - mu c_L v_n / c_S = 14.8038 m/s: the power of friction says so.
  const auto& time = r.column("time_s");
  const auto& dissipated = r.column("energy_friction_j");
  const auto at = [&](double t) {
    return static_cast<std::size_t>(std::lower_bound(time.begin(), time.end(), t) - time.begin());
  };
  const std::size_t i = at(50e-6), j = at(400e-6);
  const double slip_rate = (dissipated[j] - dissipated[i]) / (time[j] - time[i]) / (traction * area_m2);
  EXPECT_NEAR(slip_rate / 2.0, 20.0 - 0.3 * c_l * 10.0 / c_s, 0.01 * 14.8038);
  EXPECT_NEAR(20.0 - 0.3 * c_l * 10.0 / c_s, 14.8038, 1e-3);
}

TEST_P(Plates, KeepMomentumInBothDirections) {
  EXPECT_LT(run("slipping_plates").summary.at("momentum_error_max").get<double>(), 1e-10);
}

// With a penalty of a quarter of an element's stiffness. A pair that sticks remembers its traction, tau = tau_n - alpha
// w slip: what acts on the plateau is the sum of all its slips.
TEST_P(Plates, StickAndSlipWithAPenaltyToo) {
  const auto with_penalty = [&](const std::string& scene) {
    const std::string text =
        with_key(with_protocol(config_text(scene), GetParam()), "contact", "penalty_pa_m", "1.2e11");
    return run_text(with_key(text, "contact", "enforcement", "\"penalty\""), folder_, scene);
  };
  const double shear = 1000 * c_s * 3.0, limit = 0.3 * pressure_pa;
  for (const auto& [scene, traction] : {std::pair{"sticking_plates", shear}, std::pair{"slipping_plates", limit}}) {
    const RunResult r = with_penalty(scene);
    EXPECT_NEAR(r.mean("contact_pressure_mean_pa", 50e-6, 400e-6), pressure_pa, 0.005 * pressure_pa) << scene;
    EXPECT_NEAR(std::abs(r.mean("friction_force_n", 50e-6, 400e-6)) / area_m2, traction, 0.01 * traction) << scene;
    EXPECT_LT(r.summary.at("momentum_error_max").get<double>(), 1e-10) << scene;
  }
}

INSTANTIATE_TEST_SUITE_P(Protocols, Plates, testing::Values("hughes_liu", "all_implicit", "all_explicit"),
                         [](const auto& test) { return std::string(test.param); });

/// `count` pairs across, of elements as large as those of the scene, on plates a tenth as thick.
RunResult run_wide(const std::string& scene, int count, const char* protocol, const TemporaryFolder& folder) {
  auto text = with_protocol(config_text(scene), protocol);
  text = replaced(text, "start_m = -0.25, length_m = 0.25", "start_m = -0.025, length_m = 0.025");
  text = replaced(text, "mesh = { length_m = 0.25", "mesh = { length_m = 0.025");
  for (int body = 0; body < 2; ++body) {
    text =
        replaced(text, "height_m = 0.0075, elements = [3, 100]",
                 "height_m = " + std::to_string(0.0025 * count) + ", elements = [" + std::to_string(count) + ", 10]");
  }
  text = replaced(text, "{ lower = 0.025, upper = 0.025 }", "{ lower = 0.01, upper = 0.01 }");
  text = replaced(text, "safety_factor = 0.9", "step_s = 1.5e-6");
  return run_text(replaced(text, "end_s = 600e-6", "end_s = 60e-6"), folder);  // they have parted by then
}

/// The plates are periodic: however many pairs of them are looked at, each has the same force. With 300 pairs the
/// contact problem is too large for a dense inverse.
TEST(WidePlates, HaveTheForcesOfNarrowOnesPerArea) {
  for (const char* scene : {"sticking_plates", "slipping_plates"}) {
    for (const char* protocol : {"hughes_liu", "all_implicit"}) {
      const TemporaryFolder narrow_folder, wide_folder;
      const RunResult narrow = run_wide(scene, 3, protocol, narrow_folder);
      const RunResult wide = run_wide(scene, 300, protocol, wide_folder);
      for (const char* column : {"contact_force_n", "friction_force_n"}) {
        const auto &few = narrow.column(column), &many = wide.column(column);
        ASSERT_EQ(few.size(), many.size());
        const double peak =
            *std::max_element(narrow.column("contact_force_n").begin(), narrow.column("contact_force_n").end());
        EXPECT_GT(peak, 0.5 * pressure_pa * 0.0075);
        EXPECT_EQ(few.back(), 0.0) << "they have parted";
        for (std::size_t i = 0; i < few.size(); ++i) EXPECT_NEAR(few[i], many[i] / 100.0, 1e-9 * peak) << column << i;
      }
      EXPECT_LT(wide.summary.at("momentum_error_max").get<double>(), 1e-10);
    }
  }
}

/// The lower plate four elements across, the upper one six: no node but every other lies opposite one.
std::string with_other_meshes(const std::string& scene, const char* protocol) {
  const std::string text = with_protocol(config_text(scene), protocol);
  const auto second = text.find("name = \"upper\"");
  return replaced(text.substr(0, second), "elements = [3, 100]", "elements = [4, 100]") +
         replaced(text.substr(second), "elements = [3, 100]", "elements = [6, 100]");
}

class MeshesThatDiffer : public testing::TestWithParam<const char*> {};

TEST_P(MeshesThatDiffer, HaveTheExactTractionStickingAndSlipping) {
  const double shear = 1000 * c_s * 3.0, limit = 0.3 * pressure_pa;
  for (const auto& [scene, traction] : {std::pair{"sticking_plates", shear}, std::pair{"slipping_plates", limit}}) {
    const TemporaryFolder folder;
    const RunResult r = run_text(with_other_meshes(scene, GetParam()), folder);
    EXPECT_NEAR(r.mean("contact_pressure_mean_pa", 50e-6, 400e-6), pressure_pa, 1e-3 * pressure_pa) << scene;
    EXPECT_NEAR(std::abs(r.mean("friction_force_n", 50e-6, 400e-6)) / area_m2, traction, 1e-3 * traction) << scene;
    EXPECT_EQ(r.mean(traction == shear ? "pairs_stick" : "pairs_slip", 50e-6, 400e-6), 6.0)
        << scene << ": one a node of the finer surface";
    EXPECT_LT(r.summary.at("momentum_error_max").get<double>(), 1e-10) << scene;
    EXPECT_LT(r.summary.at("contact").at("residual_max").get<double>(), 1e-10) << scene;
    const auto &normal = r.column("contact_force_n"), &tangential = r.column("friction_force_n");
    for (std::size_t i = 0; i < normal.size(); ++i)
      EXPECT_LE(std::abs(tangential[i]), 0.3 * normal[i] + 1e-9 * pressure_pa * area_m2) << scene << ", row " << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Protocols, MeshesThatDiffer,
                         testing::Values("hughes_liu", "prakash_hjelmstad", "all_implicit", "all_explicit"),
                         [](const auto& test) { return std::string(test.param); });

/// A block of three elements across on a wider one of seven, without friction; one end of the upper
/// surface lies within an element of the lower one.
TEST_P(MeshesThatDiffer, KeepMomentumAndAngularMomentumOfABlockOnAWiderOne) {
  const std::string text = R"(model = "plane_strain"
[[body]]
name = "anvil"
material = { youngs_modulus_pa = 1e9, poisson_ratio = 0.25, density_kg_m3 = 1000.0 }
mesh = { start_m = -0.02, length_m = 0.02, height_m = 0.07, elements = [7, 4] }
[[body]]
name = "block"
material = { youngs_modulus_pa = 1e9, poisson_ratio = 0.25, density_kg_m3 = 1000.0 }
mesh = { length_m = 0.04, height_m = 0.036, elements = [3, 5] }
initial_velocity_m_s = [0.0, -1.0]
[contact]
surfaces = ["block.start", "anvil.end"]
[partition]
implicit_length_m = { anvil = 0.01, block = 0.01 }
[time]
step_s = 1e-6
end_s = 1.2e-4
[coupling]
protocol = ")" + std::string(GetParam()) +
                           "\"\n";
  const TemporaryFolder folder;
  const RunResult r = run_text(text, folder);
  // One-dimensional theory for the two thicknesses: rho c_L v / 2 over the width of the block.
  const double plateau = 0.5 * 1000 * c_l * 1.0 * 0.036;
  EXPECT_NEAR(r.mean("contact_force_n", 5e-6, 25e-6), plateau, 0.1 * plateau);
  EXPECT_LT(r.summary.at("momentum_error_max").get<double>(), 1e-10);
  EXPECT_LT(r.summary.at("angular_momentum_error_max").get<double>(), 1e-4) << "strains are";
}

/// A law of the multiplier and a protocol.
using Method = std::pair<const char*, const char*>;

std::string name_of(const testing::TestParamInfo<Method>& info) {
  return std::string(info.param.first) + "_" + info.param.second;
}

std::string with_law(const std::string& text, const Method& method) {
  const std::string law = method.first;
  const auto with_it =
      law == "trapezoidal_reset" ? text : with_key(text, "contact", "multiplier_update", "\"" + law + "\"");
  return with_protocol(with_it, method.second);
}

class StickingPlates : public testing::TestWithParam<Method> {};

TEST_P(StickingPlates, KeepTheExactTractionInEveryWindow) {
  const TemporaryFolder folder;
  const RunResult r = run_text(with_law(config_text("sticking_plates"), GetParam()), folder);
  const double exact_n = 1000 * c_s * 3.0 * area_m2;
  EXPECT_NEAR(std::abs(r.mean("friction_force_n", 50e-6, 400e-6)), exact_n, 1e-2 * exact_n);
  EXPECT_LT(r.deviation("friction_force_n", 50e-6, 400e-6), 2e-2 * exact_n);
  EXPECT_EQ(r.mean("pairs_stick", 50e-6, 400e-6), 3.0);
}

struct Edge {
  double poisson_ratio, friction_coefficient;
};

/// Plates at 0.99 and 1.01 of the stick limit; the edge is as sharp as the ripple of the pressure, hence 400 elements.
TEST_P(StickingPlates, StandOnTheRightSideOfTheStickLimit) {
  for (const Edge edge : {Edge{0.25, 0.3}, Edge{0.1, 0.05}}) {
    const double nu = edge.poisson_ratio, mu = edge.friction_coefficient;
    const double speed_l = std::sqrt(1e9 * (1 - nu) / (1000 * (1 + nu) * (1 - 2 * nu))),
                 speed_s = std::sqrt(1e9 / (2 * 1000 * (1 + nu)));
    for (const double share : {0.99, 1.01}) {
      const double v_t = share * mu * speed_l / speed_s * 10.0, height_m = 0.0075 / 4, period_s = 0.5 / speed_l;
      auto text = with_law(
          with_key(config_text("sticking_plates"), "contact", "friction_coefficient", std::to_string(mu)), GetParam());
      for (const auto& sign : {std::string(), std::string("-")}) {
        text = replaced(text, "poisson_ratio = 0.25", "poisson_ratio = " + std::to_string(nu));
        text = replaced(text, "[" + sign + "3.0, " + sign + "10.0]",
                        "[" + sign + std::to_string(v_t) + ", " + sign + "10.0]");
        text = replaced(text, "height_m = 0.0075, elements = [3, 100]",
                        "height_m = " + std::to_string(height_m) + ", elements = [3, 400]");
      }
      const TemporaryFolder folder;
      const RunResult r = run_text(text, folder);
      const double exact_pa = std::min(1000 * speed_s * v_t, mu * 1000 * speed_l * 10.0);
      const double traction_pa = std::abs(r.mean("friction_force_n", 0.1 * period_s, 0.9 * period_s)) / height_m;
      EXPECT_NEAR(traction_pa, exact_pa, 1e-3 * exact_pa) << "nu " << nu << ", " << share << " of the limit";
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Methods, StickingPlates,
                         testing::Values(Method{"trapezoidal_reset", "hughes_liu"}, Method{"massless", "hughes_liu"},
                                         Method{"massless", "all_implicit"}, Method{"massless", "all_explicit"}),
                         name_of);

}  // namespace
}  // namespace ricochet::test

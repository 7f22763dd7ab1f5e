#include "tests/support/run.hpp"

// Acceptance A3: two plates under pressure and shear, on both sides of the stick limit v_t / v_n = mu c_L / c_S (here 0.52).

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

TEST_P(Plates, SlipAboveTheLimit) {
  const RunResult r = run("slipping_plates");
  EXPECT_NEAR(r.mean("contact_pressure_mean_pa", 50e-6, 400e-6), pressure_pa, 0.005 * pressure_pa);
  const double traction = 0.3 * pressure_pa;
  EXPECT_NEAR(std::abs(r.mean("friction_force_n", 50e-6, 400e-6)) / area_m2, traction, 0.005 * traction);
  EXPECT_EQ(r.mean("pairs_stick", 50e-6, 400e-6), 0.0);
  // Each side slips at v_t - mu c_L v_n / c_S = 14.8038 m/s: the power of friction says so.
  const auto& time = r.column("time_s");
  const auto& dissipated = r.column("energy_friction_j");
  const auto at = [&](double t) { return static_cast<std::size_t>(std::lower_bound(time.begin(), time.end(), t) - time.begin()); };
  const std::size_t i = at(50e-6), j = at(400e-6);
  const double slip_rate = (dissipated[j] - dissipated[i]) / (time[j] - time[i]) / (traction * area_m2);
  EXPECT_NEAR(slip_rate / 2.0, 20.0 - 0.3 * c_l * 10.0 / c_s, 0.01 * 14.8038);
  EXPECT_NEAR(20.0 - 0.3 * c_l * 10.0 / c_s, 14.8038, 1e-3);
}

TEST_P(Plates, KeepMomentumInBothDirections) {
  EXPECT_LT(run("slipping_plates").summary.at("momentum_error_max").get<double>(), 1e-10);
}

// With a penalty of a quarter of an element's stiffness. A pair that sticks remembers its traction, tau = tau_n - alpha w slip: what acts on the
// plateau is the sum of all its slips.
TEST_P(Plates, StickAndSlipWithAPenaltyToo) {
  const auto with_penalty = [&](const std::string& scene) {
    const std::string text = with_key(with_protocol(config_text(scene), GetParam()), "contact", "penalty_pa_m", "1.2e11");
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

}  // namespace
}  // namespace ricochet::test

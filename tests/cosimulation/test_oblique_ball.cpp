// configs/oblique_ball.toml: an elastic ball strikes a plane obliquely, against the theory of Maw, Barber and Fawcett.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "tests/support/places.hpp"
#include "tests/support/run.hpp"
#include "tests/support/vtu.hpp"

namespace ricochet::test {
namespace {

constexpr double ball_friction = 0.092, ball_radius_m = 0.01;

RunResult oblique_impact(const std::string& protocol, double degrees, const TemporaryFolder& folder) {
  std::string text = with_protocol_of_two_steps(config_text("oblique_ball"), protocol);
  text = replaced(text, "oblique_ball.msh", source_folder() + "/configs/oblique_ball.msh");
  text = replaced(text, "[0.8391, 0.0, -1.0]", fmt::format("[{:.17g}, 0.0, -1.0]", std::tan(degrees * M_PI / 180.0)));
  if (protocol == "all_explicit") text = replaced(text, "step_s = 1.8e-7", "safety_factor = 0.9");
  return run_text(with_key(text, "output", "fields_every", "1000000"), folder);  // the last window always
}

/// Velocity along the plane of the place of contact of a rigid ball that moves as this one does after the impact: the
/// line v_x(z) through all nodes by least squares, at z = 0.
double surface_velocity_m_s(const RunResult& run) {
  double n = 0.0, z = 0.0, zz = 0.0, v = 0.0, zv = 0.0;
  std::string last;
  for (const auto& file : std::filesystem::directory_iterator(run.folder + "/fields")) {
    const std::string name = file.path().filename();
    if (name.ends_with(".vtu")) last = std::max(last, name.substr(name.rfind('_')));
  }
  for (const auto& file : std::filesystem::directory_iterator(run.folder + "/fields")) {
    if (!file.path().string().ends_with(last)) continue;
    const auto places = vtu_array(file.path(), "Points"), velocity = vtu_array(file.path(), "velocity");
    for (std::size_t i = 0; i < places.size(); i += 3) {
      n += 1.0;
      z += places[i + 2];
      zz += places[i + 2] * places[i + 2];
      v += velocity[i];
      zv += places[i + 2] * velocity[i];
    }
  }
  return (zz * v - z * zv) / (n * zz - z * z);
}

class ObliqueBall : public testing::TestWithParam<const char*> {};

/// It slips all the time: friction is mu times the force in every window but the last few, where the ball rolls off.
/// beta is -v_s/v_t after against before. Its deficit is the mesh's, whose lumped masses turn less easily than a
/// ball: 2.3, 1.8 and 1.1 % of 1 + beta with tetrahedra of 2.5, 1.5 (these) and 0.8 mm inside the ball.
TEST_P(ObliqueBall, ThatSlipsLeavesWithTheVelocityOfTheory) {
  const TemporaryFolder folder;
  const double v_t = std::tan(40.0 * M_PI / 180.0);
  const RunResult r = oblique_impact(GetParam(), 40.0, folder);
  const auto &normal = r.column("momentum_n_kg_m_s"), &force = r.column("contact_force_n"),
             &friction = r.column("friction_force_n");
  const double e = -normal.back() / normal.front();
  EXPECT_NEAR(e, 1.0, 2e-3);
  const double beta = -surface_velocity_m_s(r) / v_t, exact = -1.0 + 3.5 * ball_friction * (1.0 + e) / v_t;
  EXPECT_NEAR(1.0 + beta, 1.0 + exact, 0.025 * (1.0 + exact));
  const double impulse = std::abs(r.last("friction_impulse_n_s"));
  EXPECT_NEAR(impulse, ball_friction * r.last("contact_impulse_n_s"), 4e-3 * impulse);
  for (std::size_t i = 0; i < force.size(); ++i)
    ASSERT_LE(std::abs(friction[i]), ball_friction * force[i] + 1e-9 * 380.0) << i;
  EXPECT_LT(r.summary.at("momentum_error_max").get<double>(), 1e-10);
}

/// At 10 degrees it sticks in part: the elastic surface springs back, friction changes its sign before the ball leaves
/// and its surface moves on backwards, which no rigid ball does.
TEST_P(ObliqueBall, ThatSticksIsThrownBack) {
  const TemporaryFolder folder;
  const RunResult r = oblique_impact(GetParam(), 10.0, folder);
  const auto& friction = r.column("friction_force_n");
  const double most = *std::max_element(friction.begin(), friction.end()),
               least = *std::min_element(friction.begin(), friction.end());
  EXPECT_GT(most, 20.0);
  EXPECT_LT(least, -3.5);
  EXPECT_NEAR(r.last("friction_impulse_n_s") / r.last("contact_impulse_n_s"), 0.0378, 1e-3);
  EXPECT_LT(-surface_velocity_m_s(r) / std::tan(10.0 * M_PI / 180.0), 0.5);
  EXPECT_GT(-surface_velocity_m_s(r) / std::tan(10.0 * M_PI / 180.0), 0.4);
}

INSTANTIATE_TEST_SUITE_P(Protocols, ObliqueBall,
                         testing::Values("hughes_liu", "prakash_hjelmstad", "all_implicit", "all_explicit"),
                         [](const auto& test) { return std::string(test.param); });

}  // namespace
}  // namespace ricochet::test

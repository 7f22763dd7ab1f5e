#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>
#include <string>

#include "common/body/linear_elements.hpp"
#include "common/body/turning_elements.hpp"
#include "tests/support/rods.hpp"

// Elements in a frame that turns with their part: no force of a turn, forces that are the gradient of their energy.

namespace ricochet::solver {
namespace {

std::string turning_block(const std::string& model) {
  return fmt::format(R"(model = "{}"
[[body]]
name = "block"
material = {{ youngs_modulus_pa = 2e11, poisson_ratio = 0.3, density_kg_m3 = 8000.0 }}
mesh = {{ length_m = 0.5, height_m = 0.3, {} }}
large_rotation = true
[time]
step_s = 1e-7
end_s = 1e-5
[coupling]
protocol = "all_explicit"
)",
                     model, model == "solid" ? "width_m = 0.2, elements = [3, 2, 5]" : "elements = [3, 10]");
}

class TurningElementsOf : public testing::TestWithParam<const char*> {
 protected:
  TurningElementsOf() : scene(turning_block(GetParam())), elements(body(), linear_elements(body())) {
    force.setZero(body().part.dofs());
  }
  [[nodiscard]] BodyState& body() { return scene.states.at(0); }
  [[nodiscard]] int components() { return fem::components(body().part.mesh.model); }
  [[nodiscard]] Eigen::Matrix3d some_turn() {
    const Eigen::Vector3d axis =
        components() == 2 ? Eigen::Vector3d(0, 0, 1) : Eigen::Vector3d(1, -2, 0.5).normalized();
    return Eigen::AngleAxisd(2.5, axis).toRotationMatrix();
  }
  /// Places X go to R (X + strained) + (1, 2, 3); in a plane the third coordinate stays.
  void move(const Eigen::Matrix3d& turn, const Eigen::VectorXd& strained) {
    for (int node = 0; node < body().part.nodes(); ++node) {
      const Eigen::Vector3d& place = body().part.mesh.position[fem::at(node)];
      Eigen::Vector3d at = place;
      for (int c = 0; c < components(); ++c) at[c] += strained[node * components() + c];
      const Eigen::Vector3d moved = turn * at + Eigen::Vector3d(1.0, 2.0, 3.0) - place;
      for (int c = 0; c < components(); ++c) body().u[node * components() + c] = moved[c];
    }
  }
  [[nodiscard]] Eigen::VectorXd noise(double size_m) {
    std::normal_distribution<double> normal(0.0, size_m);
    Eigen::VectorXd values(body().part.dofs());
    for (double& value : values) value = normal(chance);
    return values;
  }
  [[nodiscard]] double stored() {
    elements.evaluate(0.0, body().u, force);
    return elements.stored(body().u, force, 0.5 * body().u.dot(force));
  }

  test::SceneStates scene;
  TurningElements elements;
  Eigen::VectorXd force;
  std::mt19937 chance{7};
};

TEST_P(TurningElementsOf, HaveNoForceWhereTheirPartHasTurnedAsAWhole) {
  move(some_turn(), Eigen::VectorXd::Zero(body().part.dofs()));
  EXPECT_LT(stored(), 1e-15 * 2e11 * 0.03);
  EXPECT_LT(force.lpNorm<Eigen::Infinity>(), 1e-14 * 2e11);
  Eigen::VectorXd in_frame;
  EXPECT_LT(body().straining(in_frame).lpNorm<Eigen::Infinity>(), 1e-14);
  EXPECT_LT((body().rotation() - some_turn()).norm(), 1e-13);
}

/// A turn of the part turns its forces, and neither its energy nor their sums know of the turn.
TEST_P(TurningElementsOf, TurnTheForcesWithThePart) {
  const Eigen::VectorXd strained = noise(1e-4);
  move(Eigen::Matrix3d::Identity(), strained);
  const double energy_j = stored();
  const Eigen::VectorXd upright = force;
  const Eigen::Matrix3d turn = some_turn();
  move(turn, strained);
  EXPECT_NEAR(stored() / energy_j, 1.0, 1e-9);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero(), moment = sum;
  const double largest = upright.lpNorm<Eigen::Infinity>();
  for (int node = 0; node < body().part.nodes(); ++node) {
    Eigen::Vector3d was = Eigen::Vector3d::Zero(), is = was, place = body().part.mesh.position[fem::at(node)];
    for (int c = 0; c < components(); ++c) {
      was[c] = upright[node * components() + c];
      is[c] = force[node * components() + c];
      place[c] += body().u[node * components() + c];
    }
    ASSERT_LT((is - turn * was).norm(), 1e-9 * largest) << node;
    sum += is;
    moment += place.cross(is);
  }
  EXPECT_LT(sum.norm(), 1e-10 * largest);
  EXPECT_LT(moment.norm(), 1e-9 * largest);
}

TEST_P(TurningElementsOf, PushAsTheGradientOfTheirEnergy) {
  move(some_turn(), noise(2e-3));  // strains of per cents: the turn of the frame with u counts
  (void)stored();
  const Eigen::VectorXd pushed = force, from = body().u, direction = noise(1.0);
  constexpr double step = 1e-6;
  body().u = from + step * direction;
  const double above = stored();
  body().u = from - step * direction;
  const double below = stored();
  EXPECT_NEAR((above - below) / (2.0 * step) / pushed.dot(direction), 1.0, 1e-7);
}

/// Without strain the tangent is exact, but for what turns the frame against the part, of which there is none.
TEST_P(TurningElementsOf, HaveTheTurnedStiffnessForATangent) {
  move(some_turn(), Eigen::VectorXd::Zero(body().part.dofs()));
  const Eigen::VectorXd from = body().u, direction = noise(1.0);
  const Eigen::VectorXd expected = elements.tangent(from) * direction;
  constexpr double step = 1e-7;
  (void)stored();
  const Eigen::VectorXd before = force;
  body().u = from + step * direction;
  (void)stored();
  EXPECT_LT(((force - before) / step - expected).norm(), 1e-5 * expected.norm());
}

INSTANTIATE_TEST_SUITE_P(Models, TurningElementsOf, testing::Values("plane_strain", "solid"),
                         [](const auto& info) { return std::string(info.param); });

}  // namespace
}  // namespace ricochet::solver

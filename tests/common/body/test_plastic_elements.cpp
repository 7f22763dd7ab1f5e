#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <random>
#include <string>

#include "common/body/plastic_elements.hpp"
#include "common/body/plastic_state.hpp"
#include "tests/support/rods.hpp"

// Elements that yield, of each model, moved at random: the work of their forces, and steps that are undone.

namespace ricochet::solver {
namespace {

std::string block(const std::string& model) {
  const std::string mesh = model == "bar"            ? "elements = 70"
                           : model == "plane_strain" ? "height_m = 0.3, elements = [3, 40]"
                           : model == "axisymmetric" ? "radius_m = 0.3, elements = [3, 40]"
                                                     : "height_m = 0.3, width_m = 0.2, elements = [3, 2, 12]";
  return fmt::format(R"(model = "{0}"
[[body]]
name = "block"
material = {{ youngs_modulus_pa = 2e11, poisson_ratio = 0.3, density_kg_m3 = 8000.0, plasticity = {{ yield_stress_pa = 4e8, hardening_pa = 2e10 }} }}
mesh = {{ length_m = 1.0, {1} }}
{2}[time]
step_s = 1e-7
end_s = 1e-5
[coupling]
protocol = "all_explicit"
)",
                     model, mesh, model == "bar" ? "area_m2 = 1e-4\n" : "");
}

/// A body that yields, and a path of it: a flight with vibrations, which yield here and there.
struct Moved {
  explicit Moved(const std::string& model) : scene(block(model)), elements(std::make_unique<PlasticElements>(body())) {
    force.setZero(body().part.dofs());
  }

  [[nodiscard]] BodyState& body() { return scene.states.at(0); }
  void move() {
    const double far_m = 1e-5 * std::pow(where(chance), 12.0);  // most steps move little, and some far
    const bool round = body().part.section.model == fem::Model::axisymmetric;
    for (Eigen::Index dof = 0; dof < body().u.size(); ++dof)
      body().u[dof] += (round && dof % 2 == 0 ? 0.0 : 1e-3) + far_m * normal(chance);
  }
  void evaluate() { elements->evaluate(body().u, force); }
  void step() {
    evaluate();
    elements->follow(force);
  }
  [[nodiscard]] double stored() const {
    return elements->stored(scene.states[0].u, force, 0.5 * scene.states[0].u.dot(force));
  }

  test::SceneStates scene;
  std::unique_ptr<PlasticElements> elements;
  Eigen::VectorXd force;
  std::mt19937 chance{7};
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> where{0.0, 1.2};
};

class PlasticElementsOf : public testing::TestWithParam<const char*> {};

/// Elements are looked at when that is due. A part that begins at the same state looks at all of them.
TEST_P(PlasticElementsOf, GiveTheForceOfAllElements) {
  Moved path(GetParam());
  std::size_t steps_with_flow = 0;
  double before = 0.0;
  for (int n = 0; n < 200; ++n) {
    path.move();
    PlasticElements all(path.body());
    Eigen::VectorXd expected = path.force;
    all.evaluate(path.body().u, expected);
    path.step();
    path.elements->settle();
    ASSERT_EQ(path.force, expected) << "step " << n;
    const double work_j = path.body().plastic->work_j;
    if (work_j > before) ++steps_with_flow;
    before = work_j;
  }
  EXPECT_GT(steps_with_flow, 20U);
  EXPECT_LT(steps_with_flow, 195U);
}

/// (P_n + P_{n+1})/2 . du = what is stored + plastic work.
TEST_P(PlasticElementsOf, BookTheWorkOfTheirForces) {
  Moved path(GetParam());
  double work_j = 0.0, largest_j = 0.0;
  Eigen::VectorXd u_before = path.body().u, force_before = path.force;
  for (int n = 0; n < 100; ++n) {
    path.move();
    path.step();
    path.elements->settle();
    work_j += 0.5 * (force_before + path.force).dot(path.body().u - u_before);
    u_before = path.body().u;
    force_before = path.force;
    const PlasticState& plastic = *path.body().plastic;
    largest_j = std::max(largest_j, work_j);
    ASSERT_NEAR(path.stored() + plastic.work_j, work_j, 1e-10 * largest_j + 1e-12) << "step " << n;
    ASSERT_GE(path.stored(), 0.0);
  }
  EXPECT_GT(path.body().plastic->work_j, 0.2 * largest_j);
}

TEST_P(PlasticElementsOf, ForgetStepsThatAreUndone) {
  Moved path(GetParam()), straight(GetParam());
  for (Moved* moved : {&path, &straight}) {
    for (int n = 0; n < 20; ++n) {
      moved->move();
      moved->step();
    }
    moved->elements->settle();
  }
  const Eigen::VectorXd settled = path.body().u;
  for (int n = 0; n < 20; ++n) {  // other steps, and evaluations that no step follows
    for (double& u : path.body().u) u += 1e-4 * std::sin(1e6 * u + n);
    n % 3 == 0 ? path.evaluate() : path.step();
  }
  path.elements->go_back();
  path.body().u = settled;
  for (int n = 0; n < 20; ++n) {
    for (Moved* moved : {&path, &straight}) {
      moved->move();
      moved->step();
      moved->elements->settle();
    }
    ASSERT_EQ(path.force, straight.force) << "step " << n;
    ASSERT_EQ(path.body().plastic->work_j, straight.body().plastic->work_j);
  }
}

/// No tangent is larger than K: a step by K never goes too far.
TEST_P(PlasticElementsOf, AreNowhereStifferThanTheirOperator) {
  Moved path(GetParam());
  for (int n = 0; n < 60; ++n) {
    path.move();
    path.evaluate();
    const Eigen::VectorXd at = path.force;
    Eigen::VectorXd u = path.body().u, further = at, step(u.size());
    for (double& value : step) value = 1e-6 * path.normal(path.chance);
    u += step;
    path.elements->evaluate(u, further);
    const double own = step.dot(further - at), largest = step.dot(path.body().part.stiffness * step);
    ASSERT_LE(own, largest * (1.0 + 1e-9));
    ASSERT_GE(own, -1e-9 * largest);
    path.step();
    path.elements->settle();
  }
}

INSTANTIATE_TEST_SUITE_P(Models, PlasticElementsOf, testing::Values("bar", "plane_strain", "axisymmetric", "solid"),
                         [](const auto& info) { return std::string(info.param); });

}  // namespace
}  // namespace ricochet::solver

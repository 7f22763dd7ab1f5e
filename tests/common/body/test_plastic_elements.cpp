#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <random>
#include <string>
#include <tuple>
#include <utility>

#include "common/body/plastic_elements.hpp"
#include "common/body/plastic_state.hpp"
#include "tests/support/rods.hpp"

// Elements that yield, of each model, moved at random: the work of their forces, and steps that are undone.

namespace ricochet::solver {
namespace {

constexpr const char *linear_law = "hardening_pa = 2e10",
                     *johnson_cook =
                         "hardening_pa = 1e9, hardening_exponent = 0.3, rate_factor = 0.02, "
                         "reference_rate_per_s = 100.0, heat = { specific_heat_j_kg_k = 50.0, melting_k = 400.0 }";
constexpr double step_s = 1e-7;

std::string block(const std::string& model, const std::string& law) {
  const std::string mesh = model == "bar"            ? "elements = 70"
                           : model == "plane_strain" ? "height_m = 0.3, elements = [3, 40]"
                           : model == "axisymmetric" ? "radius_m = 0.3, elements = [3, 40]"
                                                     : "height_m = 0.3, width_m = 0.2, elements = [4, 4, 12]";
  return fmt::format(R"(model = "{0}"
[[body]]
name = "block"
material = {{ youngs_modulus_pa = 2e11, poisson_ratio = 0.3, density_kg_m3 = 8000.0, plasticity = {{ yield_stress_pa = 4e8, {3} }} }}
mesh = {{ length_m = 1.0, {1} }}
{2}[time]
step_s = 1e-7
end_s = 1e-5
[coupling]
protocol = "all_explicit"
)",
                     model, mesh, model == "bar" ? "area_m2 = 1e-4\n" : "", law);
}

/// A body that yields, and a path of it: a flight with vibrations, which yield here and there.
struct Moved {
  Moved(const std::string& model, const std::string& law)
      : scene(block(model, law)), elements(std::make_unique<PlasticElements>(body())) {
    force.setZero(body().part.dofs());
  }

  [[nodiscard]] BodyState& body() { return scene.states.at(0); }
  void move() {
    const double far_m = 1e-5 * std::pow(where(chance), 12.0);  // most steps move little, and some far
    const bool round = body().part.section.model == fem::Model::axisymmetric;
    for (Eigen::Index dof = 0; dof < body().u.size(); ++dof)
      body().u[dof] += (round && dof % 2 == 0 ? 0.0 : 1e-3) + far_m * normal(chance);
  }
  void evaluate() { elements->evaluate(step_s, body().u, force); }
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

/// By how much a point is above its yield stress y of `linear_law`, over it. It would flow further by (q - y)/(m c^2 +
/// hardening).
double largest_beyond_yield(const BodyState& state) {
  BodyState copy = state;
  copy.plastic = std::make_shared<PlasticState>(*state.plastic);
  PlasticElements elements(copy);
  Eigen::VectorXd u = state.u, force = u;
  elements.evaluate(step_s, u, force);
  elements.follow(force);
  elements.settle();
  const double factor_squared = state.part.section.model == fem::Model::bar ? 1.0 : 1.5;
  const Eigen::ArrayXd grown = copy.plastic->equivalent - state.plastic->equivalent;
  return (grown * (factor_squared * state.plastic->modulus_pa(0) + 2e10) /
          (4e8 + 2e10 * state.plastic->equivalent.array()))
      .maxCoeff();
}

class PlasticElementsOf : public testing::TestWithParam<std::tuple<const char*, const char*>> {
 protected:
  [[nodiscard]] static Moved moved() { return {std::get<0>(GetParam()), std::get<1>(GetParam())}; }
};

/// Elements are looked at when that is due. A part that begins at the same state looks at all of them.
TEST_P(PlasticElementsOf, GiveTheForceOfAllElements) {
  Moved path = moved();
  std::size_t steps_with_flow = 0;
  double before = 0.0;
  for (int n = 0; n < 200; ++n) {
    path.move();
    PlasticElements all(path.body());
    Eigen::VectorXd expected = path.force;
    all.evaluate(step_s, path.body().u, expected);
    path.step();
    path.elements->settle();
    ASSERT_EQ(path.force, expected) << "step " << n;
    const double work_j = path.body().plastic->work_j.sum();
    if (work_j > before) ++steps_with_flow;
    before = work_j;
  }
  EXPECT_GT(steps_with_flow, 20U);
  EXPECT_LT(steps_with_flow, 200U);
}

/// (P_n + P_{n+1})/2 . du = what is stored + plastic work.
TEST_P(PlasticElementsOf, BookTheWorkOfTheirForces) {
  Moved path = moved();
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
    ASSERT_NEAR(path.stored() + plastic.work_j.sum(), work_j, 1e-10 * largest_j + 1e-12) << "step " << n;
    ASSERT_GE(path.stored(), 0.0);
  }
  EXPECT_GT(path.body().plastic->work_j.sum(), 0.2 * largest_j);
}

TEST_P(PlasticElementsOf, ForgetStepsThatAreUndone) {
  Moved path = moved(), straight = moved();
  for (Moved* own : {&path, &straight}) {
    for (int n = 0; n < 20; ++n) {
      own->move();
      own->step();
    }
    own->elements->settle();
  }
  const Eigen::VectorXd settled = path.body().u;
  for (int n = 0; n < 20; ++n) {  // other steps, and evaluations that no step follows
    for (double& u : path.body().u) u += 1e-4 * std::sin(1e6 * u + n);
    n % 3 == 0 ? path.evaluate() : path.step();
  }
  path.elements->go_back();
  path.body().u = settled;
  for (int n = 0; n < 20; ++n) {
    for (Moved* own : {&path, &straight}) {
      own->move();
      own->step();
      own->elements->settle();
    }
    ASSERT_EQ(path.force, straight.force) << "step " << n;
    ASSERT_EQ(path.body().plastic->work_j.sum(), straight.body().plastic->work_j.sum());
  }
}

/// Elements hold the flow of one place on the way to another: P is linear there, and the work of a step is booked to
/// rounding. Where they call that enough, little would flow further.
TEST_P(PlasticElementsOf, HoldWhatFlows) {
  Moved path = moved();
  const double factor_squared = path.body().part.section.model == fem::Model::bar ? 1.0 : 1.5;
  const bool linear = std::get<1>(GetParam()) == linear_law;
  double work_j = 0.0, largest_j = 0.0;
  int enough = 0;
  Eigen::VectorXd u_before = path.body().u, force_before = path.force, change = u_before;
  for (int n = 0; n < 100; ++n) {
    path.move();
    Eigen::VectorXd near = path.body().u, at_near = path.force, kept = path.force;
    for (double& u : near) u += (n % 2 == 0 ? 1e-7 : 1e-10) * path.normal(path.chance);
    path.elements->evaluate(step_s, near, at_near);
    path.elements->hold(step_s, near, change);
    path.elements->evaluate_at_rest(near, kept);
    ASSERT_LE((kept - change - at_near).norm(), 1e-12 * kept.norm()) << "step " << n;
    ASSERT_TRUE(path.elements->hold_enough(near));
    const bool is_enough = path.elements->hold_enough(path.body().u);
    const Eigen::ArrayXd equivalent = path.body().plastic->equivalent;
    path.step();
    const auto& stiffness = path.body().part.stiffness;
    ASSERT_LE((path.force - at_near - stiffness * (path.body().u - near)).norm(), 1e-9 * at_near.norm());
    path.elements->settle();
    const PlasticState& plastic = *path.body().plastic;
    work_j += 0.5 * (force_before + path.force).dot(path.body().u - u_before);
    u_before = path.body().u;
    force_before = path.force;
    largest_j = std::max(largest_j, work_j);
    ASSERT_NEAR(path.stored() + plastic.work_j.sum(), work_j, 1e-10 * largest_j + 1e-12) << "step " << n;
    if (!is_enough || !linear) continue;
    ++enough;
    const double flowed = (plastic.equivalent.array() - equivalent).maxCoeff() * factor_squared * plastic.modulus_pa(0);
    ASSERT_LE(largest_beyond_yield(path.body()), std::min(1.1e-3 + 0.033 * flowed / 4e8, 0.033)) << "step " << n;
  }
  EXPECT_GT(path.body().plastic->work_j.sum(), 0.2 * largest_j);
  if (linear) {
    EXPECT_GE(enough, 40);
    EXPECT_LT(enough, 100);
  }
}

/// No tangent is larger than K: a step by K never goes too far.
TEST_P(PlasticElementsOf, AreNowhereStifferThanTheirOperator) {
  Moved path = moved();
  for (int n = 0; n < 60; ++n) {
    path.move();
    path.evaluate();
    const Eigen::VectorXd at = path.force;
    Eigen::VectorXd u = path.body().u, further = at, step(u.size());
    for (double& value : step) value = 1e-6 * path.normal(path.chance);
    u += step;
    path.elements->evaluate(step_s, u, further);
    const double own = step.dot(further - at), largest = step.dot(path.body().part.stiffness * step);
    ASSERT_LE(own, largest * (1.0 + 1e-9));
    ASSERT_GE(own, -1e-9 * largest);
    path.step();
    path.elements->settle();
  }
}

constexpr const char* models[] = {"bar", "plane_strain", "axisymmetric", "solid"};

INSTANTIATE_TEST_SUITE_P(Models, PlasticElementsOf,
                         testing::Combine(testing::ValuesIn(models), testing::Values(linear_law, johnson_cook)),
                         [](const auto& info) {
                           const bool linear = std::get<1>(info.param) == linear_law;
                           return fmt::format("{}_{}", std::get<0>(info.param), linear ? "linear" : "johnson_cook");
                         });

/// Stretched along the axis and nowhere else, every point's deviator keeps its direction, and the law is one equation
/// of p for each step: q = 3 G (e - p) = y(p, p', T), with e = 2/3 of the strain; of a bar q = E (strain - p). Solved
/// here by halving.
class StretchedBlock : public testing::TestWithParam<const char*> {};

TEST_P(StretchedBlock, FollowsTheLawOfJohnsonAndCook) {
  Moved path(GetParam(), johnson_cook);
  const bool bar = path.body().part.section.model == fem::Model::bar;
  const double modulus_pa = bar ? 2e11 : 3.0 * 2e11 / 2.6;
  const int width = fem::components(path.body().part.section.model);
  const auto& position = path.body().part.mesh.position;
  double p = 0.0, temperature_k = 293.15, q = 0.0;
  for (int n = 1; n <= 60; ++n) {
    // Faster and faster, from below the reference rate on, and held between.
    const double strain = n > 40 && n < 50 ? 0.016 : 0.01 * std::pow(n / 30.0, 2.0);
    const double shear = bar ? strain : 2.0 / 3.0 * strain, step = 3e-5;
    for (std::size_t i = 0; i < position.size(); ++i)
      path.body().u[static_cast<Eigen::Index>(i) * width + width - 1] = strain * position[i][width - 1];
    path.elements->evaluate(step, path.body().u, path.force);
    path.elements->follow(path.force);
    path.elements->settle();
    const auto yield_pa = [&](double grown) {
      const double melted = std::pow(std::max(temperature_k - 293.15, 0.0) / (400.0 - 293.15), 1.0);
      return (4e8 + 1e9 * std::pow(p + grown, 0.3)) * (1.0 + 0.02 * std::log(std::max(1.0, grown / step / 100.0))) *
             (1.0 - std::min(1.0, melted));
    };
    double low = 0.0, high = std::max(0.0, shear - p);
    for (int i = 0; i < 200; ++i) {
      const double middle = 0.5 * (low + high);
      (modulus_pa * (shear - p - middle) > yield_pa(middle) ? low : high) = middle;
    }
    const double grown = 0.5 * (low + high), before_pa = std::exchange(q, modulus_pa * (shear - p - grown));
    temperature_k += 0.9 * 0.5 * (before_pa + q) * grown / (8000.0 * 50.0);
    p += grown;
    const PlasticState& plastic = *path.body().plastic;
    ASSERT_NEAR(plastic.largest, p, 1e-12) << "step " << n;
    ASSERT_NEAR(plastic.equivalent.minCoeff(), p, 1e-12);
    ASSERT_NEAR(plastic.hottest_k, temperature_k, 1e-9 * temperature_k);
    ASSERT_NEAR(plastic.temperature_of(0), temperature_k, 1e-9 * temperature_k);
  }
  EXPECT_GT(p, 0.01);
  EXPECT_GT(temperature_k, 300.0);
}

INSTANTIATE_TEST_SUITE_P(Models, StretchedBlock, testing::ValuesIn(models),
                         [](const auto& info) { return std::string(info.param); });

/// Enough points flow for threads to share them.
TEST(StretchedBlock, HasTheSameBitsFromAnyNumberOfThreads) {
  Moved one("solid", johnson_cook), three("solid", johnson_cook);
  three.body().parallel = std::make_shared<Parallel>(3);
  for (int n = 1; n <= 20; ++n) {
    for (Moved* path : {&one, &three}) {
      path->move();
      const auto& position = path->body().part.mesh.position;
      for (std::size_t i = 0; i < position.size(); ++i)
        path->body().u[static_cast<Eigen::Index>(i) * 3 + 2] += 1e-3 * position[i][2];
      path->step();
      path->elements->settle();
    }
    ASSERT_EQ(one.force, three.force) << "step " << n;
  }
  const auto& yielded = one.body().plastic->equivalent.array();
  EXPECT_GT((yielded > 0.0).count(), 1400);
}

/// An instant has no rate: nothing flows in it, though the point is beyond the stress at which it would yield slowly.
TEST(StretchedBlock, StaysAsItIsWhileNoTimePasses) {
  Moved path("bar", johnson_cook);
  const auto& position = path.body().part.mesh.position;
  for (std::size_t i = 0; i < position.size(); ++i) path.body().u[static_cast<Eigen::Index>(i)] = 5e-3 * position[i][0];
  path.step();
  path.elements->settle();
  const Eigen::VectorXd held = path.force;
  path.elements->evaluate(0.0, path.body().u, path.force);
  EXPECT_EQ(path.force, held);
  path.evaluate();  // a step in which time passes lets the stress fall
  EXPECT_LT(path.force.lpNorm<Eigen::Infinity>(), 0.999 * held.lpNorm<Eigen::Infinity>());
}

}  // namespace
}  // namespace ricochet::solver

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "common/fem/stiffness_product.hpp"
#include "common/problem/critical_step.hpp"
#include "tests/common/scene/scene_text.hpp"

namespace ricochet::scene {
namespace {

/// A uniform bar of 1 m.
BodyProblem bar_of(int elements) {
  return build_problem(load_text("model = \"bar\"\n[[body]]\nname = \"rod\"\narea_m2 = 1e-4\n"
                                 "material = { youngs_modulus_pa = 2e11, density_kg_m3 = 8000.0 }\n"
                                 "mesh = { length_m = 1.0, elements = " +
                                 std::to_string(elements) +
                                 " }\n"
                                 "[coupling]\nprotocol = \"all_implicit\"\n[time]\nstep_s = 1e-6\nend_s = 1e-4\n"))
      .bodies[0];
}

/// A body so large that its critical step, h/c of a uniform bar with lumped mass, is found to 5e-5 only; but whatever
/// the step, what is found falls on the side on which h/c does.
TEST(CriticalStep, OfALargeBodyIsFoundAsExactlyAsTheStepAsksFor) {
  constexpr int elements = 3000;
  const BodyProblem body = bar_of(elements);
  const std::vector<bool> all(body.mesh.elements.size(), true);
  const double exact_s = 1.0 / elements / std::sqrt(2e11 / 8000.0);
  for (const double ratio : {0.5, 0.9, 0.997, 1.003, 1.1}) {
    const double found_s = critical_time_step(body, all, false, ratio * exact_s);
    EXPECT_EQ(found_s<ratio * exact_s, ratio> 1.0) << "step over limit " << ratio;
    EXPECT_NEAR(found_s, exact_s, 5e-4 * exact_s);
  }
  EXPECT_NEAR(critical_time_step(body, all, false, 0.9999 * exact_s), exact_s, 1e-8 * exact_s);
}

/// It is exact for a small one, for it is printed.
TEST(CriticalStep, OfASmallBodyIsExact) {
  const BodyProblem body = bar_of(200);
  const std::vector<bool> all(body.mesh.elements.size(), true);
  const double exact_s = 1.0 / 200 / std::sqrt(2e11 / 8000.0);
  EXPECT_NEAR(critical_time_step(body, all, false, 0.5 * exact_s), exact_s, 1e-9 * exact_s);
}

TEST(CriticalStep, TellsAStableStepFromOneThatIsNotHoweverCloseTheyAre) {
  for (const int elements : {200, 3000}) {
    const BodyProblem body = bar_of(elements);
    const std::vector<bool> all(body.mesh.elements.size(), true);
    const double exact_s = 1.0 / elements / std::sqrt(2e11 / 8000.0);
    for (const double ratio : {0.5, 0.9, 0.9985, 0.9999}) EXPECT_TRUE(is_stable_step(body, all, ratio * exact_s));
    for (const double ratio : {1.0001, 1.0015, 1.1}) EXPECT_FALSE(is_stable_step(body, all, ratio * exact_s)) << ratio;
  }
}

/// With the mass of the whole body and with that of its own half, whose last node then has half of it.
TEST(CriticalStep, HasABoundAboveByAFewProducts) {
  const BodyProblem body = bar_of(1000);
  std::vector<bool> half(body.mesh.elements.size(), false);
  std::vector<int> elements;
  for (int e = 0; e < 500; ++e) {
    half[static_cast<std::size_t>(e)] = true;
    elements.push_back(e);
  }
  const fem::Part part = fem::extract_part(body.mesh, body.name, body.section, body.material, elements);
  const fem::StiffnessProduct product(part.stiffness, 1);
  for (const bool own_mass : {false, true}) {
    const double critical_s = critical_time_step(body, part, own_mass, 1.0);
    EXPECT_GE(largest_critical_time_step(body, part, product, own_mass), critical_s * (1.0 - 1e-9));
    EXPECT_LE(largest_critical_time_step(body, part, product, own_mass), 1.1 * critical_s);
  }
  const fem::Part nothing = fem::extract_part(body.mesh, body.name, body.section, body.material, {}, {0});
  EXPECT_TRUE(
      std::isinf(largest_critical_time_step(body, nothing, fem::StiffnessProduct(nothing.stiffness, 1), false)));
}

}  // namespace
}  // namespace ricochet::scene

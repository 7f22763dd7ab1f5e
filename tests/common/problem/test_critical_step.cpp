#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

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
  constexpr int elements = 10000;
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

/// Of a small one it is exact, for it is printed.
TEST(CriticalStep, OfASmallBodyIsExact) {
  const BodyProblem body = bar_of(200);
  const std::vector<bool> all(body.mesh.elements.size(), true);
  const double exact_s = 1.0 / 200 / std::sqrt(2e11 / 8000.0);
  EXPECT_NEAR(critical_time_step(body, all, false, 0.5 * exact_s), exact_s, 1e-9 * exact_s);
}

}  // namespace
}  // namespace ricochet::scene

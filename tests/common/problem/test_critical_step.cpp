#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "common/problem/critical_step.hpp"
#include "tests/common/scene/scene_text.hpp"

namespace ricochet::scene {
namespace {

/// One bar of `text` as a problem.
BodyProblem bar_of(int elements, double grading) {
  std::string mesh = "elements = " + std::to_string(elements);
  if (grading != 1.0) mesh += ", grading = " + std::to_string(grading);
  return build_problem(load_text("model = \"bar\"\n[[body]]\nname = \"rod\"\narea_m2 = 1e-4\n"
                                 "material = { youngs_modulus_pa = 2e11, density_kg_m3 = 8000.0 }\n"
                                 "mesh = { length_m = 1.0, " +
                                 mesh +
                                 " }\n"
                                 "[coupling]\nprotocol = \"all_implicit\"\n[time]\nstep_s = 1e-6\nend_s = 1e-4\n"))
      .bodies[0];
}

// Whatever the step, the rough answer must fall on the side on which the exact one does; below the step it is the exact
// one.
TEST(CriticalStep, RoughlyIsOnTheRightSideOfTheStep) {
  for (const double grading : {1.0, 0.999, 0.9, 0.1}) {
    const BodyProblem body = bar_of(2000, grading);
    const std::vector<bool> all(body.mesh.elements.size(), true);
    const double exact_s = critical_time_step(body, all);
    for (const double ratio : {0.1, 0.9, 0.99, 0.9985, 0.99999, 1.00001, 1.0015, 1.01, 1.1, 10.0}) {
      const double step_s = ratio * exact_s, rough_s = critical_time_step_beyond(body, all, step_s);
      EXPECT_EQ(rough_s < step_s, exact_s < step_s) << "grading " << grading << ", step over limit " << ratio;
      EXPECT_NEAR(rough_s, exact_s, 1e-3 * exact_s);
      if (ratio > 1.0) {
        EXPECT_EQ(rough_s, exact_s) << "it is printed";
      }
    }
  }
}

}  // namespace
}  // namespace ricochet::scene

#pragma once

#include <utility>
#include <vector>

#include "common/contact/root_problem.hpp"

namespace ricochet::test {

/// A root problem whose pairs all have the friction of the law.
struct UniformRoot : solver::RootProblem {
  UniformRoot(const scene::Contact& law, solver::Compliance compliance, const std::vector<double>& area_m2, double dt)
      : RootProblem(law, std::move(compliance), pairs_of(law, area_m2), dt) {}

 private:
  static std::vector<PairLaw> pairs_of(const scene::Contact& law, const std::vector<double>& area_m2) {
    std::vector<PairLaw> pairs;
    for (const double area : area_m2) pairs.push_back({area, law.friction_coefficient});
    return pairs;
  }
};

}  // namespace ricochet::test

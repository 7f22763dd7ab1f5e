#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "common/contact/compliance.hpp"
#include "common/contact/contact_rows.hpp"

namespace ricochet::solver {

struct Swept {
  int sweeps = 0;
  double residual = 0.0;  ///< largest last change over the largest force
};

/// Projected Gauss-Seidel: goes through the pairs one after the other, again and again, until no force changes by more
/// than `settled_share` of the largest, `most` times. `project(pair, set)` sets forces of a pair, set(unknown, value),
/// to what they are if all others are right; `motion` = D x and what else moves the pairs follows each of them. Where D
/// is known by products only, it follows once a sweep (projected Jacobi).
template <class Project>
Swept sweep(const Compliance& d, int pairs, int most, Eigen::VectorXd& x, Eigen::VectorXd& motion,
            const Project& project) {
  double change = 0.0;
  const auto set = [&](Eigen::Index unknown, double value) {
    const double more = value - x[unknown];
    if (more == 0.0) return;
    x[unknown] = value;
    change = std::max(change, std::abs(more));
    if (d.has_columns()) d.add_column(unknown, more, motion);
  };
  Swept swept;
  for (bool settled = false; !settled && swept.sweeps < most; ++swept.sweeps) {
    change = 0.0;
    for (int pair = 0; pair < pairs; ++pair) project(pair, set);
    if (!d.has_columns()) d.times(x, motion);
    const double largest = x.cwiseAbs().maxCoeff();
    settled = change <= settled_share * largest;
    swept.residual = largest > 0.0 ? change / largest : 0.0;
  }
  return swept;
}

}  // namespace ricochet::solver

#pragma once

#include <Eigen/Core>
#include <cstddef>

#include "common/base/archive.hpp"

namespace ricochet::solver {

/// The bars of a part remember how they have yielded, a number per element, and the work that took.
struct PlasticState {
  explicit PlasticState(std::size_t elements = 0)
      : strain(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(elements))), equivalent(strain), stress_pa(strain) {}

  Eigen::VectorXd strain;      ///< plastic strain
  Eigen::VectorXd equivalent;  ///< equivalent plastic strain, the sum of all magnitudes of its changes
  Eigen::VectorXd stress_pa;
  double work_j = 0.0;  ///< plastic work so far, of all elements

  void archive(Archive& a) {
    a.same_size(strain, equivalent, stress_pa);
    a(work_j);
  }
};

}  // namespace ricochet::solver

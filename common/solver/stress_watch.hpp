#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "common/body/body_state.hpp"
#include "common/solver/element_motion.hpp"

namespace ricochet::solver {

/// The worst of one kind in one look.
struct Worst {
  double share = 0.0;  ///< of the limit: where materials differ the largest stress need not be the worst
  double size = 0.0;
  Eigen::Vector3d place{0.0, 0.0, 0.0};
  void take(double other, const Eigen::Vector3d& at) { take(other, other, at); }
  void take(double other_share, double other, const Eigen::Vector3d& at) {
    if (other_share > share) *this = {other_share, other, at};
  }
};

/// Compares the stress in the middle of each element, fem::element_stress at its centre, with the limits of its
/// material: sqrt(3/2 s:s) of the deviator s with yield_stress_pa, the largest principal stress with strength_pa. Looks
/// at parts whose material has one of them; others cost nothing.
class StressWatch {
 public:
  StressWatch() = default;
  explicit StressWatch(const std::vector<BodyState>& states);

  [[nodiscard]] bool watches() const { return watches_; }
  /// The von Mises stress and the tension that are farthest above their limits, in the middles of their elements [Pa];
  /// size 0 where none is.
  struct Passed {
    Worst yield, tension;
  };
  [[nodiscard]] Passed look(std::size_t part, const BodyState& state) const;

 private:
  template <int dimension>
  void look(std::size_t part, const BodyState& state, Passed& passed) const;

  bool watches_ = false;
  /// Per part and element the inverse of middle_differences of its places; of a bar 1/length first. Empty where no
  /// limit is.
  std::vector<std::vector<Eigen::Matrix3d>> inverse_;
};

}  // namespace ricochet::solver

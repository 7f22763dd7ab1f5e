#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <vector>

namespace ricochet::surface {

/// Boxes in halves of halves, so that those which a question reaches are found among n of them in about log n steps.
class BoxTree {
 public:
  explicit BoxTree(std::vector<Eigen::AlignedBox3d> boxes);

  /// visit(i) for every box i that `reaches` holds of; it must hold of a box that holds another for which it does.
  template <class Reaches, class Visit>
  void visit(const Reaches& reaches, const Visit& visit) const {
    if (!halves_.empty()) descend(0, reaches, visit);
  }

 private:
  struct Half {
    Eigen::AlignedBox3d box;
    std::size_t begin, end;  ///< of order_
    std::size_t below = 0;   ///< index of the first of its two halves, 0: none
  };
  void divide(std::size_t half);
  template <class Reaches, class Visit>
  void descend(std::size_t at, const Reaches& reaches, const Visit& visit) const {
    const Half& half = halves_[at];
    if (!reaches(half.box)) return;
    if (half.below > 0) {
      descend(half.below, reaches, visit);
      descend(half.below + 1, reaches, visit);
      return;
    }
    for (std::size_t i = half.begin; i < half.end; ++i)
      if (reaches(boxes_[order_[i]])) visit(order_[i]);
  }

  std::vector<Eigen::AlignedBox3d> boxes_;
  std::vector<std::size_t> order_;
  std::vector<Half> halves_;
};

}  // namespace ricochet::surface

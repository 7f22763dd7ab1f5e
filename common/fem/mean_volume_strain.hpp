#pragma once

#include <Eigen/Core>

/// The strain operator of an element that may yield: plastic flow keeps the volume, which the points of a quadrilateral
/// or a hexahedron would each demand by themselves, and that locks the element. All of them take the element's mean
/// volume strain instead (Hughes 1980; Nagtegaal, Parks, Rice 1974),
///   B-bar = B + 1/3 m (mean of m^T B - m^T B),   m = 1 for the direct strains, which come first, else 0.
/// Deviators stay what they are.
namespace ricochet::fem {

/// m^T B.
template <class StrainOperator>
[[nodiscard]] auto volume_strain(const StrainOperator& b) {
  return (b.row(0) + b.row(1) + b.row(2)).eval();
}

/// B to B-bar.
template <class StrainOperator, class Row>
void take_volume_strain(const Row& mean, StrainOperator& b) {
  const Row more = (mean - volume_strain(b)) / 3.0;
  for (int direct = 0; direct < 3; ++direct) b.row(direct) += more;
}

}  // namespace ricochet::fem

#pragma once

#include <functional>
#include <vector>

#include "common/solver/compliance.hpp"
#include "common/solver/contact_rows.hpp"

namespace ricochet::solver {

/// Along normal, tangent and binormal.
[[nodiscard]] inline const ContactRow& row_of(const Pair& pair, Eigen::Index direction) {
  return direction == 0 ? pair.normal : direction == 1 ? pair.tangent : pair.binormal;
}

/// G: the rows of all pairs, all normals first, then all along the tangent and, of three `directions`, the binormal;
/// over columns that `column` numbers (-1: left out).
[[nodiscard]] Compliance::Sparse matrix_of_rows(const std::vector<Pair>& pairs, Eigen::Index directions,
                                                Eigen::Index columns,
                                                const std::function<int(const RowEntry&)>& column);

/// G M^-1 G^T [1/kg]: what impulses on pairs do to their relative velocities, and forces to accelerations.
[[nodiscard]] Compliance inverse_mass_of(const std::vector<Pair>& pairs, const std::vector<BodyState>& states,
                                         Eigen::Index directions);

}  // namespace ricochet::solver

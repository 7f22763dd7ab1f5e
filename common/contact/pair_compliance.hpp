#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "common/body/internal_force.hpp"
#include "common/contact/compliance.hpp"
#include "common/contact/contact_rows.hpp"

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

/// Accelerations of some degrees of freedom by forces on them that are held over a window where elements step locally:
/// M^-1 S, one column a unit force [1/kg]. Not symmetric where one of two neighbours takes more steps than the other.
/// Those of a part that turns are in its frame.
struct UnitResponses {
  std::vector<std::pair<int, int>> dofs;  ///< part and number, ascending
  Eigen::MatrixXd matrix;
};
[[nodiscard]] UnitResponses unit_responses(std::vector<std::pair<int, int>> dofs,
                                           const std::vector<InternalForce*>& of_part,
                                           const std::vector<BodyState>& states);
/// G R M^-1 S R^T G^T with R = `turns` of the frame of each part (none: of no part); every degree of freedom of a row,
/// and then of its node, is one of the responses'.
[[nodiscard]] Compliance compliance_of(const std::vector<Pair>& pairs, const UnitResponses& responses,
                                       const std::vector<Eigen::Matrix3d>& turns, Eigen::Index components,
                                       Eigen::Index directions);

}  // namespace ricochet::solver

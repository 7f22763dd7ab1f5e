#pragma once

#include <Eigen/Core>

namespace ricochet::solver {

/// Solves the linear complementarity problem w = M z + q, w >= 0, z >= 0, w . z = 0 by Lemke's method of complementary
/// pivots (Cottle, Pang, Stone: The Linear Complementarity Problem, 1992, 4.4), on a dense tableau: about n pivots of
/// n^2 operations. For the copositive M of Coulomb friction in two dimensions it ends in a solution. Returns the number
/// of pivots; `z` is empty if it ends on a ray.
int solve_lemke(const Eigen::MatrixXd& m, const Eigen::VectorXd& q, Eigen::VectorXd& z);

}  // namespace ricochet::solver

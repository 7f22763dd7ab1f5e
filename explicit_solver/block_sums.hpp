#pragma once

#include <Eigen/Core>
#include <array>

#include "common/body/blocks.hpp"
#include "common/body/body_state.hpp"
#include "common/body/internal_force.hpp"

namespace ricochet::explicit_solver {

using solver::block_nodes, solver::blocks_of;

/// Sums over the degrees of freedom of one block of nodes, or of several, of a part.
struct BlockSums {
  double momentum_kg_m_s[3] = {0.0, 0.0, 0.0};  ///< m v, by component
  double angular_kg_m2_s[3] = {0.0, 0.0, 0.0};  ///< (x + u) x m v
  double velocity_j = 0.0;                      ///< v m v
  double acceleration_j_s2 = 0.0;               ///< a m a
  double strain_j = 0.0;                        ///< u . P(u)
  double beyond_j = 0.0;                        ///< PlasticState::stored_beyond_j; of a part that yields, told by ranks
  double plastic_work_j = 0.0;                  ///< the same

  static constexpr int numbers = 11;
  [[nodiscard]] std::array<double, numbers> as_numbers() const;
  [[nodiscard]] static BlockSums from_numbers(const double* numbers);
  void add(const BlockSums& other);
};

/// Sums over block `block` of a part; `internal`: P(u) [N].
[[nodiscard]] BlockSums block_sums(const solver::BodyState& state, const Eigen::VectorXd& internal, int block);

/// Over all blocks.
[[nodiscard]] BlockSums part_sums(const solver::BodyState& state, const Eigen::VectorXd& internal);

/// Momentum, kinetic energy in the staggered metric 1/2 (v^T M v - dt^2/4 a^T M a) and u . P(u)/2, the strain energy of
/// linear elements, of a part, from the sums over all its blocks, into its totals.
void set_totals(const BlockSums& sums, double dt, solver::BodyState& state);

}  // namespace ricochet::explicit_solver

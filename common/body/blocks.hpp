#pragma once

#include <Eigen/Core>
#include <algorithm>

namespace ricochet::solver {

struct BodyState;

/// Nodes of a part whose sums are made together: sums over a part are those over its blocks, one after another, so that
/// they are the same bits whoever makes the sums of a block. Whole slices of the product K u.
constexpr int block_nodes = 16;

[[nodiscard]] inline int blocks_of(int nodes) { return (nodes + block_nodes - 1) / block_nodes; }

/// By component: mass times displacement, and mass. A part that turns has block_turn about its centre of mass, too.
struct Moments {
  Eigen::Vector3d moved_kg_m{0.0, 0.0, 0.0}, mass_kg{0.0, 0.0, 0.0};
  Eigen::Matrix3d turned_kg_m2 = Eigen::Matrix3d::Zero();

  void add(const Moments& other) {
    moved_kg_m += other.moved_kg_m;
    mass_kg += other.mass_kg;
    turned_kg_m2 += other.turned_kg_m2;
  }
  static constexpr int numbers = 15;
  void write(double* to) const {
    to = std::copy_n(moved_kg_m.data(), 3, to);
    to = std::copy_n(mass_kg.data(), 3, to);
    std::copy_n(turned_kg_m2.data(), 9, to);
  }
  static Moments from(const double* given) {
    return {Eigen::Vector3d(given), Eigen::Vector3d(given + 3), Eigen::Matrix3d(given + 6)};
  }
};

/// The moments of block `block`, with the displacement u + ahead_s v.
[[nodiscard]] Moments block_moments(const BodyState& state, double ahead_s, int block);

/// sum m (Y + u + ahead_s v) Y^T of a block, Y from `centre_m` [kg m^2].
[[nodiscard]] Eigen::Matrix3d block_turn(const BodyState& state, const Eigen::Vector3d& centre_m, double ahead_s,
                                         int block);

}  // namespace ricochet::solver

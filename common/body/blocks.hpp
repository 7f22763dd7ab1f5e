#pragma once

#include <Eigen/Core>

#include "common/body/body_state.hpp"

namespace ricochet::solver {

/// Nodes of a part whose sums are made together: sums over a part are those over its blocks, one after another, so that
/// they are the same bits whoever makes the sums of a block. Whole slices of the product K u.
constexpr int block_nodes = 16;

[[nodiscard]] inline int blocks_of(int nodes) { return (nodes + block_nodes - 1) / block_nodes; }

/// By component: mass times displacement, and mass.
struct Moments {
  Eigen::Vector3d moved_kg_m{0.0, 0.0, 0.0}, mass_kg{0.0, 0.0, 0.0};

  void add(const Moments& other) {
    moved_kg_m += other.moved_kg_m;
    mass_kg += other.mass_kg;
  }
};

/// Of block `block`, with the displacement u + ahead_s v.
[[nodiscard]] Moments block_moments(const BodyState& state, double ahead_s, int block);

}  // namespace ricochet::solver

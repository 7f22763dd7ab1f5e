#include "explicit_solver/block_sums.hpp"

#include <algorithm>

namespace ricochet::explicit_solver {

using solver::BodyState;

namespace {

/// All components side by side, since a stride would take twice the time of K u's rows: `lanes` is a multiple of the
/// components, so that one keeps its lanes.
template <int lanes>
struct Lanes {
  using Array = Eigen::Array<double, lanes, 1>;
  Array momentum = Array::Zero(), velocity = Array::Zero(), acceleration = Array::Zero(), strain = Array::Zero();

  template <class Vector>
  void add(const BodyState& state, const Eigen::VectorXd& internal, const Vector& at) {
    const auto m = at(state.mass), v = at(state.v), a = at(state.a);
    const Array p = m * v;
    momentum += p;
    velocity += p * v;
    acceleration += m * a * a;
    strain += at(state.u) * at(internal);
  }
  [[nodiscard]] BlockSums sums(int components) const {
    BlockSums sums;
    for (int lane = 0; lane < lanes; ++lane) sums.momentum_kg_m_s[lane % components] += momentum[lane];
    for (int lane = 0; lane < lanes; ++lane) sums.velocity_j += velocity[lane];
    for (int lane = 0; lane < lanes; ++lane) sums.acceleration_j_s2 += acceleration[lane];
    for (int lane = 0; lane < lanes; ++lane) sums.strain_j += strain[lane];
    return sums;
  }
};

template <int lanes>
BlockSums sums_by_lanes(const BodyState& state, const Eigen::VectorXd& internal, int first, int last, int components) {
  Lanes<lanes> lane;
  int dof = first;
  for (; dof + lanes <= last; dof += lanes) {
    lane.add(state, internal, [dof](const Eigen::VectorXd& x) { return x.segment<lanes>(dof).array(); });
  }
  if (dof < last) {  // the end of the part
    lane.add(state, internal, [dof, last](const Eigen::VectorXd& x) {
      Eigen::Array<double, lanes, 1> end = Eigen::Array<double, lanes, 1>::Zero();
      end.head(last - dof) = x.segment(dof, last - dof).array();
      return end;
    });
  }
  return lane.sums(components);
}

}  // namespace

std::array<double, BlockSums::numbers> BlockSums::as_numbers() const {
  return {momentum_kg_m_s[0], momentum_kg_m_s[1], momentum_kg_m_s[2], angular_kg_m2_s[0],
          angular_kg_m2_s[1], angular_kg_m2_s[2], velocity_j,         acceleration_j_s2,
          strain_j,           beyond_j,           plastic_work_j};
}

BlockSums BlockSums::from_numbers(const double* given) {
  return {{given[0], given[1], given[2]},
          {given[3], given[4], given[5]},
          given[6],
          given[7],
          given[8],
          given[9],
          given[10]};
}

void BlockSums::add(const BlockSums& other) {
  for (int c = 0; c < 3; ++c) momentum_kg_m_s[c] += other.momentum_kg_m_s[c];
  for (int c = 0; c < 3; ++c) angular_kg_m2_s[c] += other.angular_kg_m2_s[c];
  velocity_j += other.velocity_j;
  acceleration_j_s2 += other.acceleration_j_s2;
  strain_j += other.strain_j;
  beyond_j += other.beyond_j;
  plastic_work_j += other.plastic_work_j;
}

BlockSums block_sums(const BodyState& state, const Eigen::VectorXd& internal, int block) {
  const int components = fem::components(state.part.mesh.model), rows = block_nodes * components;
  const int first = block * rows, last = std::min(first + rows, state.part.dofs());
  BlockSums sums = components == 3 ? sums_by_lanes<24>(state, internal, first, last, components)
                                   : sums_by_lanes<8>(state, internal, first, last, components);
  const Eigen::Vector3d angular = state.angular_momentum_of(first / components, last / components);
  std::copy_n(angular.data(), 3, sums.angular_kg_m2_s);
  return sums;
}

BlockSums part_sums(const BodyState& state, const Eigen::VectorXd& internal) {
  BlockSums sums;
  for (int block = 0; block < blocks_of(state.part.nodes()); ++block) sums.add(block_sums(state, internal, block));
  return sums;
}

void set_totals(const BlockSums& sums, double dt, BodyState& state) {
  const Eigen::Vector3d momentum(sums.momentum_kg_m_s);
  auto& totals = state.totals;
  totals.momentum_n_kg_m_s = state.normal.dot(momentum);
  totals.momentum_t_kg_m_s = state.tangent.dot(momentum);
  totals.momentum_b_kg_m_s = state.binormal.dot(momentum);
  state.set_angular_momentum(Eigen::Vector3d(sums.angular_kg_m2_s));
  totals.energy_kinetic_j = 0.5 * (sums.velocity_j - 0.25 * dt * dt * sums.acceleration_j_s2);
  totals.energy_strain_j = 0.5 * sums.strain_j;
}

}  // namespace ricochet::explicit_solver

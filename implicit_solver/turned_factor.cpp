#include "implicit_solver/turned_factor.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <utility>

#include "common/contact/compliance.hpp"

namespace ricochet::implicit_solver {
namespace {

/// Vectors of a part's nodes, one after another, turned by R.
template <int components>
void turn_nodes(const Eigen::Matrix3d& by, int nodes, double* x) {
  using OfNode = Eigen::Matrix<double, components, 1>;
  const Eigen::Matrix<double, components, components> turn = by.topLeftCorner<components, components>();
  for (int node = 0; node < nodes; ++node) {
    Eigen::Map<OfNode> at(x + node * components);
    const OfNode given = at;
    at = turn.lazyProduct(given);
  }
}

}  // namespace

TurnedFactor::TurnedFactor(const CombinedParts& parts, std::vector<Eigen::Matrix3d> directions, fem::SparseMatrix a,
                           const std::vector<bool>& active, const std::vector<int>& root, participant::Heartbeat* heart)
    : parts_(parts),
      factored_(std::move(directions)),
      directions_(factored_),
      factor_(std::move(a), active, root, parts.states.empty() ? nullptr : parts.states.front().parallel, heart) {
  for (std::size_t i = 0; i < active.size(); ++i)
    if (!active[i]) inactive_.push_back(static_cast<int>(i));
  axis_.assign(parts.size(), -1);
  for (std::size_t p = 0; p < parts.size(); ++p) {
    const auto& state = parts.states[p];
    if (!state.frame) continue;
    components_ = fem::components(state.part.mesh.model);
    may_turn_ = may_turn_ && state.dashpots.empty() && find_axis(p, active);
    for (int dof = 0; dof < state.part.dofs(); ++dof)
      may_turn_ = may_turn_ && state.mass[dof] == state.mass[dof - dof % components_];
  }
  may_turn_ = may_turn_ && collect_root(root, active);
}

/// Returns whether there is no more than one.
bool TurnedFactor::find_axis(std::size_t part, const std::vector<bool>& active) {
  bool one = true;
  for (int node = 0; node < parts_.states[part].part.nodes(); ++node) {
    int held = 0, component = -1;
    for (int c = 0; c < components_; ++c) {
      if (active[static_cast<std::size_t>(parts_.offsets[part] + node * components_ + c)]) continue;
      ++held;
      component = c;
    }
    if (held == 0 || held == components_) continue;
    one = one && components_ == 3 && held == 1 && (axis_[part] < 0 || axis_[part] == component);
    axis_[part] = component;
  }
  return one;
}

/// Returns whether all unknowns of a node of a part with a frame are in the root, or none.
bool TurnedFactor::collect_root(const std::vector<int>& root, const std::vector<bool>& active) {
  std::map<Eigen::Index, RootNode> nodes;  // by the first degree of freedom
  for (std::size_t i = 0; i < root.size(); ++i) {
    const std::size_t part = parts_.part_of(root[i]);
    if (!parts_.states[part].frame) continue;
    const auto component = (root[i] - parts_.offsets[part]) % components_;
    const auto found = nodes.try_emplace(root[i] - component, RootNode{part, {-1, -1, -1}}).first;
    found->second.places[static_cast<std::size_t>(component)] = static_cast<int>(i);
  }
  bool whole = true;
  for (const auto& [dof, node] : nodes) {
    for (int c = 0; c < components_; ++c)
      whole = whole && (node.places[static_cast<std::size_t>(c)] >= 0 || !active[static_cast<std::size_t>(dof + c)]);
    root_nodes_.push_back(node);
  }
  return whole;
}

void TurnedFactor::turn(const std::vector<Eigen::Matrix3d>& directions) {
  directions_ = directions;
  by_.resize(directions.size());
  for (std::size_t p = 0; p < by_.size(); ++p) {
    by_[p] = Eigen::Matrix3d::Identity();
    if (parts_.states[p].frame) by_[p] = directions[p] * factored_[p].transpose();
    if (axis_[p] < 0) continue;
    Eigen::Matrix3d& turn = by_[p];
    const int i = (axis_[p] + 1) % 3, j = (axis_[p] + 2) % 3;
    const double angle = std::atan2(turn(j, i) - turn(i, j), turn(i, i) + turn(j, j));
    turn = Eigen::AngleAxisd(angle, Eigen::Vector3d::Unit(axis_[p])).toRotationMatrix();
  }
}

void TurnedFactor::turn_all(bool back, Eigen::VectorXd& x) const {
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    const auto& state = parts_.states[p];
    if (!state.frame) continue;
    const Eigen::Matrix3d turn = back ? Eigen::Matrix3d(by_[p].transpose()) : by_[p];
    double* const first = x.data() + parts_.offsets[p];
    components_ == 3 ? turn_nodes<3>(turn, state.part.nodes(), first) : turn_nodes<2>(turn, state.part.nodes(), first);
  }
}

void TurnedFactor::turn_root(bool back, Eigen::VectorXd& x) const {
  for (const RootNode& node : root_nodes_) {
    Eigen::Vector3d given = Eigen::Vector3d::Zero();
    for (int c = 0; c < components_; ++c)
      if (const int place = node.places[static_cast<std::size_t>(c)]; place >= 0) given[c] = x[place];
    const Eigen::Vector3d turned = (back ? Eigen::Matrix3d(by_[node.part].transpose()) : by_[node.part]) * given;
    for (int c = 0; c < components_; ++c)
      if (const int place = node.places[static_cast<std::size_t>(c)]; place >= 0) x[place] = turned[c];
  }
}

void TurnedFactor::forward(const Eigen::VectorXd& b) {
  if (!turned()) {
    factor_.forward(b);
    return;
  }
  all_ = b;
  turn_all(true, all_);
  factor_.forward(all_);
  root_rhs_ = factor_.root_rhs();
  turn_root(false, root_rhs_);
}

void TurnedFactor::solve_root(const Eigen::VectorXd& rhs, Eigen::VectorXd& x) {
  if (!turned()) {
    x.noalias() = factor_.root_inverse() * rhs;
    return;
  }
  root_forces_ = rhs;
  turn_root(true, root_forces_);
  x.noalias() = factor_.root_inverse() * root_forces_;
  turn_root(false, x);
}

void TurnedFactor::add_root_motion(const Eigen::VectorXd& forces, Eigen::VectorXd& x) {
  if (!turned()) {
    solver::add_product(factor_.root_inverse(), forces, x);
    return;
  }
  root_forces_.setZero(x.size());
  root_forces_.head(forces.size()) = forces;
  turn_root(true, root_forces_);
  root_motion_.setZero(x.size());
  solver::add_product(factor_.root_inverse(), root_forces_, root_motion_);
  turn_root(false, root_motion_);
  x += root_motion_;
}

void TurnedFactor::backward(const Eigen::VectorXd& x_root, Eigen::VectorXd& x) {
  if (!turned()) {
    factor_.backward(x_root, x);
    return;
  }
  root_forces_ = x_root;
  turn_root(true, root_forces_);
  all_.resize(x.size());
  factor_.backward(root_forces_, all_);
  for (const int dof : inactive_) all_[dof] = 0.0;
  turn_all(false, all_);
  for (const int dof : inactive_) all_[dof] = x[dof];
  x.swap(all_);
}

}  // namespace ricochet::implicit_solver

// Contact forces that act inside the small steps of parts that step locally.
#include <algorithm>
#include <utility>

#include "explicit_solver/explicit_contact.hpp"

namespace ricochet::explicit_solver {

using solver::BodyState;
using solver::ContactRow;

namespace {

/// By how much the entries of a part's rotation may change before the contact's compliance is made anew.
constexpr double turns_at_once = 1e-2;

}  // namespace

/// The degrees of freedom of the rows and, of surfaces that slide or turn, of all nodes of theirs.
void ExplicitContact::act_through(const std::vector<std::unique_ptr<solver::InternalForce>>& forces,
                                  const std::vector<BodyState>& states) {
  const bool turns =
      std::any_of(forces.begin(), forces.end(), [](const auto& force) { return force->turn() != nullptr; });
  std::vector<std::pair<int, int>> dofs;
  const auto add_node = [&](int part, int node) {
    for (int c = 0; c < surface_.components; ++c) dofs.emplace_back(part, node * surface_.components + c);
  };
  for (const auto& pair : surface_.pairs)
    for (const auto* row : {&pair.normal, &pair.tangent, &pair.binormal})
      for (const auto& e : row->entries) {
        if (sliding_ || turns) add_node(e.part, e.dof / surface_.components);
        if (row == &pair.normal || pair.friction_coefficient > 0.0) dofs.emplace_back(e.part, e.dof);
      }
  for (const auto& idle : surface_.idle) add_node(idle.part, idle.node);
  const auto spreads = [&](const auto& dof) {
    return forces[static_cast<std::size_t>(dof.first)]->spreads(dof.second);
  };
  if (std::none_of(dofs.begin(), dofs.end(), spreads)) return;
  for (const auto& force : forces) through_.push_back(force.get());
  for (const auto& state : states) {
    spread_.emplace_back(Eigen::VectorXd::Zero(state.part.dofs()));
    held_.emplace_back(static_cast<std::size_t>(state.part.dofs()), false);
    for (const auto& c : state.constrained) held_.back()[static_cast<std::size_t>(c.dof)] = true;
  }
  old_spread_ = spread_;
  if (turns) state_.turns.resize(forces.size());
  note_turns();
  responses_ = solver::unit_responses(std::move(dofs), through_, states);
}

/// S N^T r of all pairs, without what acts on a support at once. The rest at supports pulls them inside the steps.
void ExplicitContact::spread_forces() {
  for (auto& force : spread_) force.setZero();
  const auto add = [&](const ContactRow& row, double force) {
    for (const auto& e : row.entries)
      if (!held_[static_cast<std::size_t>(e.part)][static_cast<std::size_t>(e.dof)])
        spread_[static_cast<std::size_t>(e.part)][e.dof] += force * e.coefficient;
  };
  for (std::size_t i = 0; i < pairs(); ++i) {
    const auto& pair = surface_.pairs[i];
    const auto& force = state_.forces[i];
    add(pair.normal, force.normal);
    add(pair.tangent, force.tangential[0]);
    add(pair.binormal, force.tangential[1]);
  }
  for (std::size_t b = 0; b < spread_.size(); ++b)
    if (!spread_[b].isZero(0.0)) through_[b]->spread(spread_[b]);
}

double ExplicitContact::unspread_j(const std::vector<BodyState>& states) {
  strained_.resize(states.size());
  for (std::size_t b = 0; b < states.size(); ++b) {
    if (!states[b].frame) continue;
    const fem::RigidMotion motion = states[b].frame->fit(states[b].u).motion;
    states[b].frame->straining(states[b].u, motion, strained_[b]);
    solver::turn_nodes(motion.rotation, surface_.components, strained_[b]);
  }
  const auto by = [&](int part) -> const Eigen::VectorXd& {
    const auto b = static_cast<std::size_t>(part);
    return states[b].frame ? strained_[b] : states[b].u;
  };
  double work_j = 0.0;
  for (std::size_t i = 0; i < pairs(); ++i) {
    const auto& pair = surface_.pairs[i];
    const Force& force = state_.forces[i];
    work_j += force.normal * pair.normal.times(by) + force.tangential[0] * pair.tangent.times(by) +
              force.tangential[1] * pair.binormal.times(by);
  }
  for (std::size_t b = 0; b < states.size(); ++b) {
    const auto& moved = by(static_cast<int>(b));
    for (Eigen::Index dof = 0; dof < moved.size(); ++dof)
      if (spread_[b][dof] != 0.0) work_j -= spread_[b][dof] * moved[dof];
  }
  return 0.5 * work_j;
}

void ExplicitContact::add_reactions(std::size_t part, const BodyState& state, Eigen::VectorXd& external) const {
  if (!inside_small_steps()) return;
  for (const auto& c : state.constrained) external[c.dof] -= spread_[part][c.dof];
}

void ExplicitContact::note_turns() {
  for (std::size_t b = 0; b < state_.turns.size(); ++b) {
    const Eigen::Matrix3d* const turn = through_[b]->turn();
    state_.turns[b] = turn != nullptr ? *turn : Eigen::Matrix3d::Identity();
  }
}

/// The compliance of parts that step locally turns with them.
bool ExplicitContact::turned() const {
  for (std::size_t b = 0; b < state_.turns.size(); ++b) {
    const Eigen::Matrix3d* const turn = through_[b]->turn();
    if (turn != nullptr && (*turn - state_.turns[b]).cwiseAbs().maxCoeff() > turns_at_once) return true;
  }
  return false;
}

/// Effect of the forces of the window before, beyond what the compliance says: a normal force that pushes along a
/// direction which has turned would be answered by friction.
void ExplicitContact::add_turn(const std::vector<BodyState>& states, double acting_time) {
  const auto last = last_forces(acting_time);
  Eigen::VectorXd told(last.force.size());
  root_->compliance().times(last.force, told);
  const auto does = [&](const ContactRow& row) {
    double rate = 0.0;
    for (const auto& e : row.entries) {
      const auto part = static_cast<std::size_t>(e.part);
      rate += e.coefficient * states[part].inverse_mass[e.dof] * spread_[part][e.dof];
    }
    return dt() * acting_time * rate;
  };
  const auto n = static_cast<Eigen::Index>(pairs());
  for (Eigen::Index k = 0; k < n; ++k) {
    const auto& pair = surface_.pairs[static_cast<std::size_t>(k)];
    gap_free_[k] += does(pair.normal) - told[k];
    if (told.size() > n) slip_free_[k] += does(pair.tangent) - told[n + k];
    if (told.size() > 2 * n) slip_free_[n + k] += does(pair.binormal) - told[2 * n + k];
  }
}

}  // namespace ricochet::explicit_solver

#include "explicit_solver/force_driven.hpp"

namespace ricochet::explicit_solver {
namespace {

/// This part's entries of a link vector, whose parts follow one another; moves `next` on.
Eigen::Map<const Eigen::VectorXd> part_of(const std::vector<double>& link, const solver::BodyState& state,
                                          std::size_t& next) {
  const double* begin = link.data() + next;
  next += state.shared_dofs.size();
  return {begin, static_cast<Eigen::Index>(state.shared_dofs.size())};
}

}  // namespace

ForceDriven::ForceDriven(std::vector<solver::BodyState>& states, const participant::Setup& setup,
                         const MakeForce& make_force)
    : states_(states), clock_(setup.clock), substeps_(setup.substeps) {
  for (const auto& state : states_) {
    parts_.emplace_back(state, substeps_, step_s(), make_force);
  }
}

void ForceDriven::answer(participant::LinkOutput& output) const {
  for (auto* values : {&output.value, &output.velocity_m_s, &output.acceleration_m_s2}) values->clear();
  for (std::size_t b = 0; b < states_.size(); ++b) {
    for (std::size_t i = 0; i < states_[b].shared_dofs.size(); ++i) {
      const auto motion = parts_[b].shared_motion(states_[b], i);
      output.value.push_back(motion.displacement);
      output.velocity_m_s.push_back(motion.velocity);
      output.acceleration_m_s2.push_back(motion.acceleration);
    }
  }
}

void ForceDriven::synchronise(std::int64_t window, const std::vector<double>& force) {
  std::size_t next = 0;
  for (std::size_t b = 0; b < states_.size(); ++b) {
    parts_[b].start(states_[b], begin_s(window + 1), part_of(force, states_[b], next));
  }
}

void ForceDriven::run(double begin_s, int steps, const std::vector<double>& force) {
  std::size_t next = 0;
  for (std::size_t b = 0; b < states_.size(); ++b) {
    part_force_ = part_of(force, states_[b], next);
    parts_[b].advance(states_[b], begin_s, steps, part_force_);
  }
}

void ForceDriven::reconfigure() {
  substep_ = 0;
  for (auto& part : parts_) part.set_step(step_s());
}

void ForceDriven::advance(std::int64_t window, const std::vector<double>& force) {
  substep_ = 0;
  run(begin_s(window), substeps_, force);
}

void ForceDriven::advance_substep(std::int64_t window, int substep, const std::vector<double>& force) {
  substep_ = substep;
  run(begin_s(window) + (substep - 1) * step_s(), 1, force);
}

void ForceDriven::work_ahead(std::int64_t window) {
  if (substep_ > 0) return;
  for (std::size_t b = 0; b < states_.size(); ++b) parts_[b].advance_held(states_[b], begin_s(window), substeps_);
}

bool ForceDriven::accept(std::int64_t) {
  for (std::size_t b = 0; b < states_.size(); ++b) parts_[b].accept(states_[b]);
  return substep_ == 0 || substep_ == substeps_;
}

ForceDriven::State ForceDriven::state() const {
  State state;
  for (const auto& part : parts_) state.parts.push_back(part.state());
  return state;
}

void ForceDriven::restore(const State& state) {
  substep_ = 0;
  for (std::size_t b = 0; b < parts_.size(); ++b) parts_[b].restore(state.parts[b]);
}

void ForceDriven::freeze(participant::FrozenContact) {
  restore(state());
  for (auto& part : parts_) part.elements().reach_all();  // the motion may be any
}

}  // namespace ricochet::explicit_solver

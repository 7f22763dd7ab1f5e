#include "explicit_solver/reduced/reduced_solver.hpp"

#include <cmath>
#include <utility>

#include "common/participant/heartbeat.hpp"
#include "common/solver/describe.hpp"

namespace ricochet::explicit_solver {

namespace {

/// Windows between looks at what leaves the model: displacements of all nodes take a solve.
constexpr std::int64_t looks_apart = 8 * solver::ModelWatch::every;

}  // namespace

using participant::Capability;
using participant::LinkOutput;

ReducedSolver::ReducedSolver(scene::Problem problem, const std::string& name, std::optional<double>)
    : problem_(std::move(problem)), spec_(&problem_.scene.participant(name)) {
  states_ = solver::initial_states(problem_, *spec_, false);
}

participant::Description ReducedSolver::describe() {
  auto description = solver::describe(problem_, *spec_, states_, false);
  description.solver = "ricochet reduced_solver";
  description.interface_mass_kg.assign(description.interface_mass_kg.size(), 0.0);  // it is in the modes
  reporting_.describe(problem_, states_, description);
  description.capabilities = {Capability::repeat_window, Capability::reconfigure, Capability::save_state,
                              Capability::load_state};
  return description;
}

void ReducedSolver::initialize(const participant::Setup& setup, LinkOutput& output) {
  setup_ = setup;
  participant::Heartbeat heart(setup_.progress);
  heart.begin("finding modes");
  for (std::size_t b = 0; b < states_.size(); ++b)
    parts_.emplace_back(states_[b], problem_.scene.partition.reduced_modes.at(states_[b].name),
                        reporting_.probed_dofs(b, problem_.scene.components()));
  set_step();
  reporting_.begin(problem_, states_, setup_, spec_->name, {}, true);
  answer(false, output);
}

void ReducedSolver::set_step() {
  for (auto& part : parts_) part.set_step(setup_.clock.size_s());
}

void ReducedSolver::reconfigure(const participant::Setup& setup) {
  setup_.clock = setup.clock;
  set_step();
}

/// take(part, u_b)
template <class Take>
void ReducedSolver::share_out(const std::vector<double>& link_input, const Take& take) {
  std::size_t next = 0;
  for (std::size_t b = 0; b < parts_.size(); ++b) {
    const auto size = states_[b].shared_dofs.size();
    moved_ = Eigen::Map<const Eigen::VectorXd>(link_input.data() + next, static_cast<Eigen::Index>(size));
    next += size;
    take(parts_[b], moved_);
  }
}

void ReducedSolver::answer(bool of_trial, LinkOutput& output) const {
  output.value.clear();
  for (const auto& part : parts_) {
    const auto& force = part.answer(of_trial);
    output.value.insert(output.value.end(), force.begin(), force.end());
  }
}

void ReducedSolver::synchronise(participant::Integration, const std::vector<double>& link_input, LinkOutput& output) {
  share_out(link_input, [](ReducedPart& part, const Eigen::VectorXd& u_b) { part.synchronise(u_b); });
  answer(false, output);
  reported_ = -1;
  if (window_ == 0) {
    reported();
    reporting_.note_start();
  }
}

void ReducedSolver::advance(std::int64_t, const std::vector<double>& link_input, LinkOutput& output) {
  share_out(link_input, [](ReducedPart& part, const Eigen::VectorXd& u_b) { part.advance(u_b); });
  answer(true, output);
}

void ReducedSolver::accept() {
  ++window_;
  for (std::size_t b = 0; b < parts_.size(); ++b) parts_[b].accept(states_[b].totals);
  if (!reporting_.picture_due(window_) && window_ % looks_apart != 0) return;
  reported();
  reporting_.note(window_, states_, states_);
}

const std::vector<solver::BodyState>& ReducedSolver::reported() {
  if (reported_ != window_)
    for (std::size_t b = 0; b < parts_.size(); ++b) parts_[b].write_motion(states_[b]);
  reported_ = window_;
  return states_;
}

void ReducedSolver::record(std::vector<double>& row) {
  for (std::size_t b = 0; b < parts_.size(); ++b) {
    BodyTotals& totals = states_[b].totals;
    parts_[b].set_totals(totals);
    if (!std::isfinite(totals.energy_kinetic_j + totals.energy_strain_j)) {
      reported_ = -1;
      solver::require_finite(reported()[b], states_[b].u, window_);
    }
    append_quantities(totals, row);
    for (const auto& [name, member] : reduced_quantities) row.push_back(totals.*member);
  }
}

void ReducedSolver::probes(std::vector<double>& row) {
  if (reported_ != window_)
    for (std::size_t b = 0; b < parts_.size(); ++b) parts_[b].write_probed(states_[b]);
  reporting_.append_probes(states_, window_, row);
}

void ReducedSolver::write_fields(std::int64_t window) {
  solver::write_fields(setup_.output_directory, spec_->name, window, reported(), {}, true);
}

void ReducedSolver::finish() { reporting_.finish(window_, reported(), states_); }

void ReducedSolver::load_state(const std::vector<double>& state, participant::FrozenContact) {
  const double* next = state.data();
  const auto taken = [&next](Eigen::Index size) {
    const Eigen::Map<const Eigen::VectorXd> values(next, size);
    next += size;
    return Eigen::VectorXd(values);
  };
  for (auto& part : parts_) {
    const Eigen::VectorXd q = taken(part.modes()), rate = taken(part.modes());
    part.load(q, rate);
  }
}

void ReducedSolver::read_state(std::vector<double>& state, std::vector<double>& scale) {
  for (const auto& part : parts_) {
    for (const auto& [values, time_s] :
         {std::pair{&part.motion().q, setup_.clock.size_s()}, std::pair{&part.motion().rate, 1.0}}) {
      state.insert(state.end(), values->begin(), values->end());
      scale.insert(scale.end(), static_cast<std::size_t>(values->size()), 1.0 / time_s);
    }
  }
}

ReducedSolver::State ReducedSolver::state() const {
  State state{.window = window_, .motions = {}, .totals = {}};
  for (const auto& part : parts_) state.motions.push_back(part.motion());
  for (const auto& body : states_) state.totals.push_back(body.totals);
  return state;
}

std::string ReducedSolver::save_state() {
  Archive out;
  State state = this->state();
  out.same_size(state, reporting_);
  return out.take();
}

void ReducedSolver::restore_state(std::string_view bytes) {
  Archive in(bytes, "the state of participant '" + spec_->name + "'");
  State state = this->state();
  in.same_size(state, reporting_);
  in.end();
  window_ = state.window;
  for (std::size_t b = 0; b < parts_.size(); ++b) {
    parts_[b].restore(state.motions[b]);
    states_[b].totals = state.totals[b];
  }
  reported_ = -1;
}

}  // namespace ricochet::explicit_solver

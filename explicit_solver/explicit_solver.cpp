#include "explicit_solver/explicit_solver.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "common/base/error.hpp"
#include "common/body/free_motion.hpp"
#include "common/body/small_steps.hpp"
#include "common/participant/heartbeat.hpp"
#include "common/solver/describe.hpp"
#include "explicit_solver/block_sums.hpp"
#include "explicit_solver/local_force.hpp"

namespace ricochet::explicit_solver {

using participant::Capability;
using participant::LinkOutput;

ExplicitSolver::ExplicitSolver(scene::Problem problem, const std::string& name,
                               std::optional<double> told_critical_step_s, Ranks* ranks, MakeForce make_force)
    : problem_(std::move(problem)),
      spec_(&problem_.scene.participant(name)),
      told_critical_step_s_(told_critical_step_s),
      ranks_(ranks),
      make_force_(std::move(make_force)) {
  if (spec_->role != scene::Role::explicit_solver) {
    throw ConfigError(
        fmt::format("{}: participant '{}' has role \"implicit\"; start implicit_solver for it, or set its role "
                    "to \"explicit\"",
                    problem_.scene.path, name));
  }
  states_ = solver::initial_states(problem_, *spec_, false);
}

participant::Description ExplicitSolver::describe() {
  auto description = solver::describe(problem_, *spec_, states_, has_contact(), told_critical_step_s_);
  description.solver = "ricochet explicit_solver";
  reporting_.describe(problem_, states_, description);
  description.capabilities = {Capability::repeat_window, Capability::driven_by_force, Capability::single_substep,
                              Capability::save_state};
  if (!any_small_steps()) description.capabilities.push_back(Capability::reconfigure);  // they are of one window size
  // The motion of a massless node is no state; that of nodes of other ranks is nothing this process could be given.
  // A loaded state is to be continued linearly.
  const bool linear = std::all_of(states_.begin(), states_.end(), [](const auto& state) { return state.linear(); });
  if (ranks_ == nullptr && linear && (!alone() || !problem_.scene.massless_contact()))
    description.capabilities.push_back(Capability::load_state);
  return description;
}

bool ExplicitSolver::any_small_steps() const {
  return std::any_of(states_.begin(), states_.end(),
                     [this](const auto& state) { return solver::takes_small_steps(problem_, state); });
}

std::unique_ptr<solver::InternalForce> ExplicitSolver::make_force(const solver::BodyState& state,
                                                                  const std::vector<int>& driven) const {
  if (!solver::takes_small_steps(problem_, state)) return make_force_(state, driven);
  auto steps = ranks_ ? ranks_->local_steps(static_cast<std::size_t>(&state - stepped().data()))
                      : solver::local_steps(problem_, state, setup_.clock.size_s());
  return local_force(state, driven, std::move(steps));
}

std::optional<ExplicitContact> ExplicitSolver::make_contact() const {
  if (!has_contact()) return std::nullopt;
  return ExplicitContact(problem_.scene.contact_law(), solver::ContactSurface(problem_, stepped()), setup_.clock,
                         solver::SlidingRows(problem_, stepped()));
}

void ExplicitSolver::initialize(const participant::Setup& setup, LinkOutput& output) {
  setup_ = setup;
  if (setup_.driven_by == participant::Drive::force) {
    // The shared nodes become this participant's own: with the mass of its own elements, held by their supports.
    states_.clear();
    states_ = solver::initial_states(problem_, *spec_, true);
    solver::take_interface_mass(setup_.interface_mass_kg, states_);
  }
  std::optional<participant::Heartbeat> heart;  // the set-up of others is short
  if (any_small_steps())
    heart.emplace(setup_.progress).begin("finding local steps and what contact forces move in them");
  if (ranks_) share_ = &ranks_->begin(problem_, *spec_, setup_, states_);
  stepping_.emplace(stepped(), setup_, make_contact(),
                    [this](const auto& state, const std::vector<int>& driven) { return make_force(state, driven); });
  stepping_->answer(output);
  solver::PressedSurface pressing;
  if (contact()) pressing = contact()->pressed(stepped());
  reporting_.begin(problem_, states_, setup_, spec_->name, pressing, true);
}

void ExplicitSolver::tell(Order order, std::int64_t window, int substep) {
  if (ranks_) ranks_->tell(order, window, substep);
}

void ExplicitSolver::synchronise(participant::Integration, const std::vector<double>& link_input, LinkOutput& output) {
  tell(Order::synchronise, window_);
  stepping_->synchronise(window_, link_input);
  for (auto& state : stepped()) state.move_hanging();
  stepping_->answer(output);
  gathered_ = -1;
  update_status();
  if (window_ == 0) {
    reported();
    reporting_.note_start();
  }
}

void ExplicitSolver::reconfigure(const participant::Setup& setup) {
  setup_.clock = setup.clock;
  if (ranks_) ranks_->reconfigure(setup_.clock);
  stepping_->reconfigure();
}

void ExplicitSolver::advance(std::int64_t window, const std::vector<double>& link_input, LinkOutput& output) {
  tell(Order::advance, window);
  stepping_->advance(window, link_input);
  stepping_->answer(output);
}

void ExplicitSolver::advance_substep(std::int64_t window, int substep, const std::vector<double>& link_input,
                                     LinkOutput& output) {
  tell(Order::advance_substep, window, substep);
  stepping_->advance_substep(window, substep, link_input);
  stepping_->answer(output);
}

void ExplicitSolver::work_ahead() {
  if (window_ >= setup_.last_window || contact()) return;
  tell(Order::work_ahead, window_ + 1);
  stepping_->work_ahead(window_ + 1);
}

void ExplicitSolver::accept() {
  tell(Order::accept, window_ + 1);
  if (!stepping_->accept(window_ + 1)) return;
  ++window_;
  for (auto& state : stepped()) state.move_hanging();
  update_status();
  if (reporting_.due(window_)) reported();
  reporting_.note(window_, states_, stepped());
}

const std::vector<solver::BodyState>& ExplicitSolver::reported() {
  if (ranks_ && gathered_ != window_) {
    ranks_->take_motion(states_);
    for (auto& state : states_) state.move_hanging();
    gathered_ = window_;
  }
  return states_;
}

void ExplicitSolver::update_status() {
  if (const auto* c = contact()) reporting_.note_contact(window_, stepped(), c->pairs_closed());
}

/// Sums over the nodes, and that they are numbers.
void ExplicitSolver::take_totals() {
  const double dt = setup_.clock.size_s() / setup_.substeps;
  if (ranks_) {
    ranks_->take_totals(*stepping_, dt, states_);
    const auto finite = [](const solver::BodyState& state) {
      return std::isfinite(state.totals.energy_kinetic_j + state.totals.energy_strain_j);
    };
    if (!std::all_of(states_.begin(), states_.end(), finite)) reported();
  }
  unspread_work_j_ = 0.0;
  for (std::size_t b = 0; b < states_.size(); ++b) {
    auto& state = states_[b];
    if (!ranks_ || gathered_ == window_) solver::require_finite(state, state.u, window_);
    const auto& internal = stepping_->internal(b);
    double& strain_j = state.totals.energy_strain_j;
    if (!ranks_) {
      set_totals(part_sums(state, internal), dt, state);
      strain_j = stepping_->force(b).stored(state.u, internal, strain_j);
    }
    const auto unspread = stepping_->force(b).unspread(stepped()[b].u, internal);
    strain_j += unspread.half_work_j;
    unspread_work_j_ += unspread.work_j;
  }
}

/// Where contact alone acts inside small steps all that they leave out of the work is its own, else what its forces
/// leave out [J].
double ExplicitSolver::unspread_of_contact_j() {
  auto* const c = contact();
  if (!c->inside_small_steps()) return 0.0;
  const auto driven = [](const solver::BodyState& state) {
    return !state.external.zero() || std::any_of(state.constrained.begin(), state.constrained.end(),
                                                 [](const auto& given) { return given.motion.moves(); });
  };
  return std::any_of(states_.begin(), states_.end(), driven) ? c->unspread_j(stepped()) : unspread_work_j_;
}

void ExplicitSolver::record(std::vector<double>& row) {
  take_totals();
  solver::record_bodies(states_, row);
  if (auto* c = contact()) append_quantities(c->report(stepped(), unspread_of_contact_j()), row);
}

ExplicitSolver::State ExplicitSolver::state() const {
  return {.window = window_, .stepping = stepping_->state(), .separation = reporting_.separation()};
}

void ExplicitSolver::restore(const State& state) {
  window_ = state.window;
  reporting_.restore(state.separation);
  stepping_->restore(state.stepping);
  gathered_ = -1;
}

void ExplicitSolver::load_state(const std::vector<double>& state, participant::FrozenContact contact) {
  solver::load_motion(state, states_);
  stepping_->freeze(contact);
}

void ExplicitSolver::read_state(std::vector<double>& state, std::vector<double>& scale) {
  solver::read_motion(states_, setup_.clock.size_s(), state, scale);
}

void ExplicitSolver::archive(State& state, Archive& a) { a.same_size(state, reporting_); }

std::string ExplicitSolver::save_state() {
  Archive out;
  State state = this->state();
  archive(state, out);
  if (ranks_) {
    auto others = ranks_->save();
    out(others);
  }
  return out.take();
}

void ExplicitSolver::restore_state(std::string_view bytes) {
  Archive in(bytes, "the state of participant '" + spec_->name + "'");
  State state = this->state();
  archive(state, in);
  std::vector<std::string> others;
  if (ranks_) in(others);
  in.end();
  if (ranks_) ranks_->restore(others);  // first, since what turns asks them
  restore(state);
}

void ExplicitSolver::finish() {
  reporting_.finish(window_, reported(), stepped());
  tell(Order::end);
}

void ExplicitSolver::write_fields(std::int64_t window) {
  const auto& states = reported();
  std::vector<fem::ContactFields> fields;
  if (const auto* c = contact()) fields = c->fields(stepped());
  if (ranks_ && !fields.empty()) fields = solver::of_whole_parts(fields, stepped(), states);
  solver::write_fields(setup_.output_directory, spec_->name, window, states, fields,
                       setup_.driven_by == participant::Drive::displacement);
}

}  // namespace ricochet::explicit_solver

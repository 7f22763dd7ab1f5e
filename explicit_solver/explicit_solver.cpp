#include "explicit_solver/explicit_solver.hpp"

#include <fmt/format.h>

#include <utility>

#include "common/base/error.hpp"
#include "common/solver/describe.hpp"
#include "common/solver/free_motion.hpp"

namespace ricochet::explicit_solver {

using participant::Capability;
using participant::LinkOutput;

ExplicitSolver::ExplicitSolver(scene::Problem problem, const std::string& name)
    : problem_(std::move(problem)), spec_(&problem_.scene.participant(name)) {
  if (spec_->role != scene::Role::explicit_solver) {
    throw ConfigError(
        fmt::format("{}: participant '{}' has role \"implicit\"; start implicit_solver for it, or set its role "
                    "to \"explicit\"",
                    problem_.scene.path, name));
  }
  states_ = solver::initial_states(problem_, *spec_, false);
}

participant::Description ExplicitSolver::describe() {
  auto description = solver::describe(problem_, *spec_, states_, has_contact());
  description.solver = "ricochet explicit_solver";
  axial_stress_ = solver::AxialStressShares(problem_, states_);
  description.axial_stress_columns = axial_stress_.columns();
  description.capabilities = {Capability::repeat_window, Capability::driven_by_force, Capability::single_substep,
                              Capability::save_state};
  if (!alone() || !problem_.scene.massless_contact())
    description.capabilities.push_back(Capability::load_state);  // the motion of a massless node is no state
  return description;
}

std::optional<ExplicitContact> ExplicitSolver::make_contact() const {
  if (!has_contact()) return std::nullopt;
  return ExplicitContact(problem_.scene.contact_law(),
                         solver::ContactSurface(problem_, scene::participant_parts(problem_, *spec_)),
                         setup_.window_size_s, solver::SlidingRows(problem_, states_));
}

ExplicitContact* ExplicitSolver::contact() {
  return std::visit([](auto& drive) { return drive.contact(); }, *drive_);
}

void ExplicitSolver::initialize(const participant::Setup& setup, LinkOutput& output) {
  setup_ = setup;
  separation_ = SeparationWatch(setup.separation_windows);
  if (setup_.driven_by == participant::Drive::force) {
    // The shared nodes become this participant's own: with the mass of its own elements, held by their supports.
    states_ = solver::initial_states(problem_, *spec_, true);
    solver::take_interface_mass(setup_.interface_mass_kg, states_);
    drive_.emplace(std::in_place_type<ForceDriven>, states_, setup_);
  } else {
    drive_.emplace(std::in_place_type<MotionDriven>, states_, make_contact(), setup_.window_size_s);
  }
  std::visit([&](const auto& drive) { drive.answer(output); }, *drive_);
  model_watch_ = solver::ModelWatch(problem_, states_, contact() ? &contact()->surface() : nullptr);
  outline_ = solver::WatchedOutline(problem_, states_);
  shapes_.emplace(problem_, states_, setup_, spec_->name);
}

void ExplicitSolver::synchronise(participant::Integration, const std::vector<double>& link_input, LinkOutput& output) {
  std::visit(
      [&](auto& drive) {
        drive.synchronise(window_, link_input);
        drive.answer(output);
      },
      *drive_);
  update_status();
  if (window_ == 0) shapes_->note(window_);
}

void ExplicitSolver::advance(std::int64_t window, const std::vector<double>& link_input, LinkOutput& output) {
  std::visit(
      [&](auto& drive) {
        drive.advance(window, link_input);
        drive.answer(output);
      },
      *drive_);
}

void ExplicitSolver::advance_substep(std::int64_t window, int substep, const std::vector<double>& link_input,
                                     LinkOutput& output) {
  auto& drive = std::get<ForceDriven>(*drive_);
  drive.advance_substep(window, substep, link_input);
  drive.answer(output);
}

void ExplicitSolver::work_ahead() {
  if (window_ < setup_.last_window) std::visit([&](auto& drive) { drive.work_ahead(window_ + 1); }, *drive_);
}

void ExplicitSolver::accept() {
  if (!std::visit([&](auto& drive) { return drive.accept(window_ + 1); }, *drive_)) return;
  ++window_;
  update_status();
  model_watch_.look(window_, states_);
  shapes_->note(window_);
}

void ExplicitSolver::update_status() {
  if (const auto* c = contact())
    status_ = solver::contact_status(c->surface(), states_, c->pairs_closed(), window_, setup_, separation_);
}

void ExplicitSolver::record(std::vector<double>& row) {
  const double dt = setup_.window_size_s / setup_.substeps;
  for (std::size_t b = 0; b < states_.size(); ++b) {
    auto& state = states_[b];
    solver::require_finite(state, state.u, window_);
    state.update_momentum();
    const double kinetic = (state.mass.array() * state.v.array().square()).sum();
    const double staggered = 0.25 * dt * dt * (state.mass.array() * state.a.array().square()).sum();
    state.totals.energy_kinetic_j = 0.5 * (kinetic - staggered);
    const auto& internal =
        std::visit([&](const auto& drive) -> const Eigen::VectorXd& { return drive.internal(b); }, *drive_);
    state.totals.energy_strain_j = 0.5 * state.u.dot(internal);
  }
  solver::record_bodies(states_, row);
  if (auto* c = contact()) append_quantities(c->report(states_), row);
}

ExplicitSolver::State ExplicitSolver::state() const {
  return {.window = window_,
          .bodies = solver::motions_of(states_),
          .drive = std::visit([](const auto& drive) -> decltype(State::drive) { return drive.state(); }, *drive_),
          .separation = separation_};
}

void ExplicitSolver::restore(const State& state) {
  window_ = state.window;
  separation_ = state.separation;
  solver::restore_motions(state.bodies, states_);
  if (auto* motion = std::get_if<MotionDriven>(&*drive_)) {
    motion->restore(std::get<MotionDriven::State>(state.drive));
  } else {
    std::get<ForceDriven>(*drive_).restore(std::get<ForceDriven::State>(state.drive));
  }
}

void ExplicitSolver::load_state(const std::vector<double>& state, participant::FrozenContact contact) {
  solver::load_motion(state, states_);
  std::visit([&](auto& drive) { drive.freeze(contact); }, *drive_);
}

void ExplicitSolver::read_state(std::vector<double>& state, std::vector<double>& scale) {
  solver::read_motion(states_, setup_.window_size_s, state, scale);
}

std::string ExplicitSolver::save_state() {
  Archive out;
  State state = this->state();
  archive(state, out);
  return out.take();
}

void ExplicitSolver::restore_state(std::string_view bytes) {
  Archive in(bytes, "the state of participant '" + spec_->name + "'");
  State state = this->state();
  archive(state, in);
  in.end();
  restore(state);
}

void ExplicitSolver::finish() {
  model_watch_.look(window_, states_, true);
  shapes_->finish(window_);
}

void ExplicitSolver::write_fields(std::int64_t window) {
  solver::write_fields(setup_.output_directory, spec_->name, window, states_);
}

}  // namespace ricochet::explicit_solver

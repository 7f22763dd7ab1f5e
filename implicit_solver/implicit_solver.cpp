#include "implicit_solver/implicit_solver.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/base/error.hpp"
#include "common/body/free_motion.hpp"
#include "common/participant/heartbeat.hpp"
#include "common/solver/describe.hpp"

namespace ricochet::implicit_solver {

using participant::Capability;
using participant::Integration;
using participant::LinkOutput;

namespace {

/// Refuses a participant that is to be another solver's.
std::vector<solver::BodyState> states_of(const scene::Problem& problem, const scene::ParticipantSpec& spec) {
  if (spec.role != scene::Role::implicit_solver) {
    throw ConfigError(
        fmt::format("{}: participant '{}' has role \"explicit\"; start explicit_solver for it, or set its role "
                    "to \"implicit\"",
                    problem.scene.path, spec.name));
  }
  return solver::initial_states(problem, spec, true);
}

}  // namespace

ImplicitSolver::ImplicitSolver(scene::Problem problem, const std::string& name,
                               std::optional<double> told_critical_step_s, const MakeForce& make_force)
    : problem_(std::move(problem)),
      spec_(&problem_.scene.participant(name)),
      told_critical_step_s_(told_critical_step_s),
      states_(states_of(problem_, *spec_)),
      parts_(states_, make_force) {}

participant::Description ImplicitSolver::describe() {
  auto description = solver::describe(problem_, *spec_, states_, !problem_.contacts.empty(), told_critical_step_s_);
  description.solver = "ricochet implicit_solver";
  reporting_.describe(problem_, states_, description);
  description.capabilities = {Capability::repeat_window, Capability::interface_stiffness};
  description.capabilities.push_back(Capability::switch_integration);
  description.capabilities.push_back(Capability::reconfigure);
  description.capabilities.push_back(Capability::save_state);
  // The motion of a massless node is no state, and what is loaded is to be continued linearly.
  if (!problem_.scene.massless_contact() && parts_.linear()) description.capabilities.push_back(Capability::load_state);
  return description;
}

/// They are in balance at any time by a K that is factored once.
void ImplicitSolver::refuse_massless_nodes() const {
  if (parts_.linear() || !problem_.scene.massless_contact()) return;
  throw ConfigError(fmt::format(
      "{}: contact.multiplier_update = \"massless\" balances the contact nodes of participant '{}' by the stiffness of "
      "the start, and its elements are not linear; use \"trapezoidal_reset\" or \"fully_implicit\"",
      problem_.scene.path, spec_->name));
}

void ImplicitSolver::initialize(const participant::Setup& setup, LinkOutput& output) {
  refuse_massless_nodes();
  setup_ = setup;
  solver::take_interface_mass(setup.interface_mass_kg, states_);
  for (auto* vector : {&forces_.residual, &forces_.external, &forces_.link, &trial_.increment, &trial_.velocity,
                       &trial_.acceleration, &trial_.end.residual, &trial_.end.external, &trial_.end.link}) {
    vector->setZero(parts_.dofs());
  }
  if (!problem_.contacts.empty()) {
    const solver::ContactSurface surface(problem_, states_);
    contact_.emplace(problem_, surface, states_);
    contact_->move_masses(states_);
  }
  ImplicitContact* const contact = contact_ ? &*contact_ : nullptr;
  flight_.emplace(parts_, contact, setup_.clock);
  parts_.external_force(0.0, forces_.external);
  flight_->settle_at_start(forces_.external);
  for (const auto& state : states_) internal_.push_back(state.u);
  interface_work_j_.assign(states_.size(), 0.0);
  first_staggered_j_ = interface_work_j_;
  {
    participant::Heartbeat heart(setup_.progress);
    heart.begin("assembling");
    set_up_windows(&heart);
  }
  reporting_.begin(problem_, states_, setup_, spec_->name,
                   contact_ ? contact_->pressed(states_) : solver::PressedSurface{}, false);
  put_output(output);
}

void ImplicitSolver::set_up_windows(participant::Heartbeat* heart) {
  const auto shared = static_cast<Eigen::Index>(setup_.interface_stiffness.empty() ? 0 : parts_.shared_dofs.size());
  newmark_.emplace(parts_, contact_ ? &*contact_ : nullptr,
                   Eigen::Map<const Eigen::MatrixXd>(setup_.interface_stiffness.data(), shared, shared), setup_.clock,
                   heart);
}

/// The operator is another one; motion and forces are what they were.
void ImplicitSolver::reconfigure(const participant::Setup& setup) {
  setup_.clock = setup.clock;
  setup_.interface_stiffness = setup.interface_stiffness;
  newmark_->forget();
  const auto forces = contact_ ? std::optional(contact_->state()) : std::nullopt;
  set_up_windows(nullptr);
  if (contact_) contact_->restore(*forces, states_);
}

void ImplicitSolver::take_link(const std::vector<double>& link_input, Eigen::VectorXd& link) const {
  for (std::size_t i = 0; i < parts_.shared_dofs.size(); ++i) link[parts_.shared_dofs[i]] = link_input[i];
}

/// Motion of the shared nodes at the end of a trial_.
void ImplicitSolver::put_output(LinkOutput& output) const {
  output.value.clear();
  output.velocity_m_s.clear();
  output.acceleration_m_s2.clear();
  for (std::size_t b = 0; b < states_.size(); ++b) {
    for (const int dof : states_[b].shared_dofs) {
      output.value.push_back(states_[b].u[dof] + trial_.increment[parts_.offsets[b] + dof]);
      output.velocity_m_s.push_back(trial_.velocity[parts_.offsets[b] + dof]);
      output.acceleration_m_s2.push_back(trial_.acceleration[parts_.offsets[b] + dof]);
    }
  }
}

void ImplicitSolver::synchronise(Integration integration, const std::vector<double>& link_input, LinkOutput& output) {
  const double time_s = setup_.clock.time_s(window_);
  integration_ = integration;
  newmark_->forget();
  take_link(link_input, forces_.link);
  parts_.external_force(time_s, forces_.external);
  trial_.increment.setZero();
  if (integration == Integration::implicit_newmark) newmark_->add_interface_force(forces_.link);
  for (std::size_t b = 0; b < states_.size(); ++b) {
    auto& state = states_[b];
    auto q = parts_.segment(forces_.residual, b);
    parts_.forces[b]->evaluate(0.0, state.u, internal_[b]);
    parts_.forces[b]->follow(internal_[b]);
    parts_.forces[b]->settle();
    for (const auto& d : state.dashpots) {
      forces_.external[parts_.offsets[b] + d.dof] =
          parts_.load_on(b, d.dof, forces_.external) + d.force(state.v[d.dof]);
    }
    q = parts_.segment(forces_.external, b) - internal_[b] - parts_.segment(forces_.link, b);
    state.a = state.inverse_mass.cwiseProduct(q);
    state.constrain_acceleration(time_s, setup_.clock.size_s(), state.a);
    state.constrain_velocity(time_s, setup_.clock.size_s(), state.v);
    for (const auto& c : state.constrained) {  // reactions join f, so that q = M a there too
      const double inertia = state.mass[c.dof] * state.a[c.dof];
      forces_.external[parts_.offsets[b] + c.dof] += inertia - q[c.dof];
      q[c.dof] = inertia;
    }
    parts_.segment(trial_.velocity, b) = state.v;
    parts_.segment(trial_.acceleration, b) = state.a;
  }
  if (contact_) contact_->open();
  if (contact_ && contact_->held()) {
    contact_->hold_rates(states_, trial_.velocity, trial_.acceleration);
    for (std::size_t b = 0; b < states_.size(); ++b) {
      states_[b].v = parts_.segment(trial_.velocity, b);
      states_[b].a = parts_.segment(trial_.acceleration, b);
    }
  }
  put_output(output);
  update_status();
  if (window_ == 0) reporting_.note_start();
}

void ImplicitSolver::advance(std::int64_t window, const std::vector<double>& link_input, LinkOutput& output) {
  take_link(link_input, trial_.end.link);
  if (integration_ == Integration::implicit_newmark) {
    newmark_->advance(window, forces_, trial_);
    tried_ = true;
  } else {
    flight_->advance(window, forces_, trial_);
  }
  put_output(output);
}

void ImplicitSolver::work_ahead() {
  const bool due = !tried_ && integration_ == Integration::implicit_newmark && window_ < setup_.last_window &&
                   !parts_.shared_dofs.empty();
  if (due) newmark_->prepare(window_ + 1, forces_, trial_);
}

void ImplicitSolver::accept() {
  ++window_;
  tried_ = false;
  account();
  for (std::size_t b = 0; b < states_.size(); ++b) {
    auto& state = states_[b];
    state.u += parts_.segment(trial_.increment, b);
    state.v = parts_.segment(trial_.velocity, b);
    state.a = parts_.segment(trial_.acceleration, b);
    state.move_hanging();
  }
  std::swap(forces_, trial_.end);
  parts_.settle(setup_.clock.size_s());
  if (contact_) contact_->accept();
  const int every = problem_.scene.coupling.resynchronise_every;
  if (every > 0 && window_ % every == 0) resynchronise_residual();
  update_status();
  reporting_.note(window_, states_, states_);
}

/// Replaces the residual that the increments have carried along by q = f - P(u) - L itself; round-off would otherwise
/// add up like window^(3/2) in the momentum.
void ImplicitSolver::resynchronise_residual() {
  for (std::size_t b = 0; b < states_.size(); ++b) {
    auto& state = states_[b];
    parts_.forces[b]->evaluate_at_rest(state.u, internal_[b]);
    for (int i = 0; i < state.part.dofs(); ++i) {
      const auto dof = parts_.offsets[b] + i;
      if (!state.free[static_cast<std::size_t>(i)]) continue;
      forces_.residual[dof] = forces_.external[dof] - internal_[b][i] - forces_.link[dof];
    }
  }
}

void ImplicitSolver::account() {
  const double dt = setup_.clock.size_s();
  for (std::size_t b = 0; b < states_.size(); ++b) {
    const auto at = parts_.offsets[b];
    states_[b].account_external(
        dt, [&](int dof) { return 0.5 * (forces_.external[at + dof] + trial_.end.external[at + dof]); },
        [&](int dof) { return trial_.increment[at + dof]; },
        [&](int dof) { return states_[b].u[dof] + 0.5 * trial_.increment[at + dof]; });
    for (const int dof : states_[b].shared_dofs) {
      interface_work_j_[b] -= 0.5 * (forces_.link[at + dof] + trial_.end.link[at + dof]) * trial_.increment[at + dof];
    }
  }
  if (integration_ == Integration::implicit_newmark) newmark_->account(trial_);
}

void ImplicitSolver::update_status() {
  if (contact_) reporting_.note_contact(window_, states_, contact_->pairs_closed());
}

/// The explicit elements' share in the staggered metric of the shared nodes. Central difference takes dt^2/8 a^T M a
/// off 1/2 v^T M v; where only L of the force M a is explicit, that is -dt^2/8 a . (-L). Without it the energy of the
/// sum flickers at the interface by that amount.
double ImplicitSolver::shared_staggered_energy(std::size_t part) const {
  if (integration_ == Integration::explicit_central || newmark_->has_interface_stiffness()) return 0.0;
  const auto& state = states_[part];
  double sum = 0.0;
  for (const int dof : state.shared_dofs) sum += state.a[dof] * forces_.link[parts_.offsets[part] + dof];
  const double dt = setup_.clock.size_s();
  return 0.125 * dt * dt * sum;
}

void ImplicitSolver::record(std::vector<double>& row) {
  const double dt = setup_.clock.size_s();
  for (std::size_t b = 0; b < states_.size(); ++b) {
    auto& state = states_[b];
    solver::require_finite(state, state.u, window_);
    state.update_momentum();
    double kinetic = (state.mass.array() * state.v.array().square()).sum();
    if (integration_ == Integration::explicit_central) {
      kinetic -= 0.25 * dt * dt * (state.mass.array() * state.a.array().square()).sum();
    }
    const double shared = shared_staggered_energy(b);
    state.totals.energy_kinetic_j = 0.5 * kinetic + shared;
    if (window_ == 0) first_staggered_j_[b] = shared;
    state.totals.energy_interface_j = interface_work_j_[b] + shared - first_staggered_j_[b];
    Eigen::VectorXd& internal = internal_[b];
    internal =
        parts_.segment(forces_.external, b) - parts_.segment(forces_.residual, b) - parts_.segment(forces_.link, b);
    state.totals.energy_strain_j = parts_.forces[b]->stored(state.u, internal, 0.5 * state.u.dot(internal));
  }
  solver::record_bodies(states_, row);
  if (contact_) append_quantities(contact_->report(states_), row);
}

ImplicitSolver::State ImplicitSolver::state() const {
  std::vector<std::string> elements;
  for (const auto& force : parts_.forces) elements.push_back(kept_by(*force));
  return {.window = window_,
          .bodies = solver::motions_of(states_),
          .integration = integration_,
          .forces = forces_,
          .interface_work_j = interface_work_j_,
          .first_staggered_j = first_staggered_j_,
          .elements = std::move(elements),
          .linearised_at = newmark_->linearised_at(),
          .last_increment = newmark_->last_increment(),
          .directions = newmark_->directions(),
          .contact = contact_ ? std::optional(contact_->state()) : std::nullopt,
          .separation = reporting_.separation()};
}

void ImplicitSolver::restore(const State& state) {
  window_ = state.window;
  solver::restore_motions(state.bodies, states_);
  integration_ = state.integration;
  forces_ = state.forces;
  interface_work_j_ = state.interface_work_j;
  first_staggered_j_ = state.first_staggered_j;
  if (contact_) contact_->restore(*state.contact, states_);
  reporting_.restore(state.separation);
  for (std::size_t b = 0; b < states_.size(); ++b) put_back(state.elements[b], *parts_.forces[b]);
  newmark_->begin_with(state.linearised_at, state.directions);
  newmark_->set_last_increment(state.last_increment);
  trial_.end.external = forces_.external;
  tried_ = false;
}

void ImplicitSolver::load_state(const std::vector<double>& state, participant::FrozenContact contact) {
  if (surroundings_.empty()) surroundings_ = solver::surroundings_of(states_);
  solver::load_motion(state, states_);
  if (contact_) contact_->freeze(contact);
  State homogeneous = this->state();
  homogeneous.forces.external.setZero();
  restore(homogeneous);
}

void ImplicitSolver::read_state(std::vector<double>& state, std::vector<double>& scale) {
  solver::read_motion(states_, setup_.clock.size_s(), state, scale);
}

std::string ImplicitSolver::save_state() {
  Archive out;
  State state = this->state();
  archive(state, out);
  return out.take();
}

void ImplicitSolver::restore_state(std::string_view bytes) {
  Archive in(bytes, "the state of participant '" + spec_->name + "'");
  if (!surroundings_.empty()) {
    solver::give_back(std::exchange(surroundings_, {}), states_);
    if (contact_) contact_->freeze(std::nullopt);
  }
  State state = this->state();
  archive(state, in);
  in.end();
  restore(state);
}

void ImplicitSolver::finish() { reporting_.finish(window_, states_, states_); }

void ImplicitSolver::write_fields(std::int64_t window) {
  solver::write_fields(setup_.output_directory, spec_->name, window, states_,
                       contact_ ? contact_->fields(states_) : std::vector<fem::ContactFields>(), false);
}

}  // namespace ricochet::implicit_solver

#include "explicit_solver/explicit_solver.hpp"

#include <fmt/format.h>

#include <utility>

#include "common/base/error.hpp"
#include "common/fem/newmark.hpp"
#include "common/solver/describe.hpp"
#include "common/solver/free_motion.hpp"

namespace ricochet::explicit_solver {

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
  windows_.resize(states_.size());
  for (const auto& window : windows_) u_before_.push_back(&window.u);
}

participant::Description ExplicitSolver::describe() {
  const auto& contact = problem_.scene.contact;
  auto description = solver::describe(problem_, *spec_, states_, alone() && !problem_.contact.pairs.empty());
  description.solver = "ricochet explicit_solver";
  axial_stress_ = solver::AxialStressShares(problem_, states_);
  description.axial_stress_columns = axial_stress_.columns();
  description.capabilities = {Capability::repeat_window, Capability::driven_by_force, Capability::single_substep};
  const bool massless = alone() && contact && contact->multiplier_update == scene::MultiplierUpdate::massless;
  if (!massless)
    description.capabilities.push_back(Capability::load_state);  // the motion of a massless node is no state
  return description;
}

void ExplicitSolver::initialize(const participant::Setup& setup, LinkOutput& output) {
  setup_ = setup;
  separation_ = solver::SeparationWatch(setup.separation_windows, setup.window_size_s);
  if (driven_by_force()) {
    initialize_subcycling();
    shared_motion(output);
  } else {
    initialize_internal_forces();
    interface_force(output);
  }
  model_watch_ = solver::ModelWatch(problem_, states_, contact_ ? &contact_->surface() : nullptr);
  outline_ = solver::WatchedOutline(problem_, states_);
}

void ExplicitSolver::initialize_internal_forces() {
  for (std::size_t b = 0; b < states_.size(); ++b) {
    auto& window = windows_[b];
    window.u = states_[b].u;
    window.internal.resize(states_[b].part.dofs());
    states_[b].stiffness.multiply(states_[b].u, window.internal);
    window.internal_old = window.internal;
    window.external.setZero(states_[b].part.dofs());
    states_[b].external.at(0.0, window.external);
    window.external_old = window.external;
    set_shared_columns(b);
  }
  if (alone() && !problem_.contact.pairs.empty()) {
    contact_.emplace(problem_, scene::participant_parts(problem_, *spec_), setup_.window_size_s);
    settle_at_start();
  }
  for (std::size_t b = 0; b < states_.size(); ++b) {
    windows_[b].front = WaveFront(states_[b], driven_nodes(b));
    if (all_rows_) windows_[b].front.reach_all();
  }
}

/// Massless contact nodes begin in balance with the others.
void ExplicitSolver::settle_at_start() {
  contact_->move_masses(states_);
  for (auto& window : windows_) {
    trial_u_.push_back(&window.u);
    trial_external_.push_back(&window.external);
  }
  contact_->settle(states_, trial_external_, trial_u_);
  for (std::size_t b = 0; b < states_.size(); ++b) {
    states_[b].u = windows_[b].u;
    states_[b].stiffness.multiply(states_[b].u, windows_[b].internal);
    windows_[b].internal_old = windows_[b].internal;
  }
}

/// Shared and contact nodes.
std::vector<int> ExplicitSolver::driven_nodes(std::size_t b) const {
  std::vector<int> nodes = states_[b].shared_nodes;
  if (!contact_) return nodes;
  for (const auto& pair : contact_->surface().pairs) {
    for (const auto& side : {pair.a, pair.b}) {
      if (side.part == static_cast<int>(b)) nodes.push_back(side.node);
    }
  }
  return nodes;
}

int ExplicitSolver::rows_computed() const {
  int sum = 0;
  if (driven_by_force()) {
    for (const auto& window : subcycled_) sum += window.rows_computed();
  } else {
    for (const auto& window : windows_) sum += window.front.rows_computed();
  }
  return sum;
}

void ExplicitSolver::take_link(const solver::BodyState& state, const std::vector<double>& link_input, std::size_t& next,
                               Eigen::VectorXd& u) const {
  for (const int dof : state.shared_dofs) u[dof] = link_input[next++];
}

void ExplicitSolver::interface_force(LinkOutput& output) const {
  output.value.clear();
  for (std::size_t b = 0; b < states_.size(); ++b) {
    for (const int dof : states_[b].shared_dofs)
      output.value.push_back(windows_[b].internal[dof] - windows_[b].external[dof]);
  }
}

/// Work the link does on the explicit elements while it moves their shared nodes: 1/2 (P_old + P_new) . du.
void ExplicitSolver::account_interface(std::size_t b, const Eigen::VectorXd& u_old, const Eigen::VectorXd& u_new) {
  const auto& w = windows_[b];
  auto& totals = states_[b].totals;
  for (const int dof : states_[b].shared_dofs) {
    const double force = (w.internal_old[dof] - w.external_old[dof]) + (w.internal[dof] - w.external[dof]);
    totals.energy_interface_j += 0.5 * force * (u_new[dof] - u_old[dof]);
  }
}

void ExplicitSolver::synchronise(participant::Integration, const std::vector<double>& link_input, LinkOutput& output) {
  if (driven_by_force()) {
    synchronise_subcycling(link_input, output);
    return;
  }
  std::size_t next = 0;
  const double time_s = static_cast<double>(window_) * setup_.window_size_s;
  for (std::size_t b = 0; b < states_.size(); ++b) {
    auto& window = windows_[b];
    window.u = states_[b].u;
    take_link(states_[b], link_input, next, states_[b].u);
    if (!trial_) {
      window.internal_old.swap(window.internal);
      window.external_old = window.external;
    }
    window.front.multiply(states_[b].stiffness, states_[b].u, window.internal);
    states_[b].external.at(time_s, window.external);
    account_interface(b, window.u, states_[b].u);
  }
  trial_ = false;
  find_accelerations(time_s, Velocity::now);
  for (auto& state : states_) state.constrain_velocity(time_s, setup_.window_size_s, state.v);
  interface_force(output);
  update_status();
}

void ExplicitSolver::advance(std::int64_t window, const std::vector<double>& link_input, LinkOutput& output) {
  const double dt = setup_.window_size_s;
  if (driven_by_force()) {
    substep_ = 0;
    advance_subcycling(static_cast<double>(window - 1) * dt, setup_.substeps, link_input, output);
    return;
  }
  if (!trial_) predict(window);
  std::size_t next = 0;
  for (std::size_t b = 0; b < states_.size(); ++b) move_shared(b, link_input, next);
  interface_force(output);
}

/// Everything of the window that does not need the link: u of the own nodes, K u with the shared ones where they were,
/// f.
void ExplicitSolver::predict(std::int64_t window) {
  const double dt = setup_.window_size_s, time_s = static_cast<double>(window) * dt;
  if (contact_ && !contact_started_) contact_->start(states_);
  contact_started_ = true;
  for (std::size_t b = 0; b < states_.size(); ++b) {
    const auto& state = states_[b];
    auto& w = windows_[b];
    w.internal.swap(w.internal_old);
    w.external.swap(w.external_old);
    w.u = fem::predicted_displacement(state.u, state.v, state.a, dt, fem::beta_explicit);
    state.constrain_displacement(time_s, w.u);
    for (const int dof : state.shared_dofs) w.u[dof] = state.u[dof];
    if (!state.external.zero()) state.external.at(time_s, w.external);
  }
  if (contact_) contact_->settle(states_, trial_external_, trial_u_);
  for (std::size_t b = 0; b < states_.size(); ++b) {
    const auto& state = states_[b];
    auto& w = windows_[b];
    w.front.multiply(state.stiffness, w.u, w.internal);
    for (std::size_t i = 0; i < w.near_rows.size(); ++i) {
      w.near_internal[static_cast<Eigen::Index>(i)] = w.internal[w.near_rows[i]];
    }
  }
  trial_ = true;
}

/// u_Gamma of the link, and what it changes of K u.
void ExplicitSolver::move_shared(std::size_t b, const std::vector<double>& link_input, std::size_t& next) {
  const auto& state = states_[b];
  auto& w = windows_[b];
  for (std::size_t i = 0; i < state.shared_dofs.size(); ++i) {
    const int dof = state.shared_dofs[i];
    w.u[dof] = link_input[next++];
    w.shared_moved[static_cast<Eigen::Index>(i)] = w.u[dof] - state.u[dof];
  }
  for (std::size_t i = 0; i < w.near_rows.size(); ++i) {
    const auto row = static_cast<int>(i);
    double sum = w.near_internal[row];
    for (fem::SparseMatrix::InnerIterator it(w.shared_columns, row); it; ++it)
      sum += it.value() * w.shared_moved[it.col()];
    w.internal[w.near_rows[i]] = sum;
  }
}

void ExplicitSolver::set_shared_columns(std::size_t b) {
  const auto& state = states_[b];
  auto& w = windows_[b];
  std::vector<int> column(static_cast<std::size_t>(state.part.dofs()), -1);
  for (std::size_t i = 0; i < state.shared_dofs.size(); ++i)
    column[static_cast<std::size_t>(state.shared_dofs[i])] = static_cast<int>(i);
  std::vector<Eigen::Triplet<double>> entries;
  for (int row = 0; row < state.part.dofs(); ++row) {
    const auto before = entries.size();
    for (fem::SparseMatrix::InnerIterator it(state.part.stiffness, row); it; ++it) {
      const int shared = column[static_cast<std::size_t>(it.col())];
      if (shared >= 0) entries.emplace_back(static_cast<int>(w.near_rows.size()), shared, it.value());
    }
    if (entries.size() > before) w.near_rows.push_back(row);
  }
  const auto rows = static_cast<Eigen::Index>(w.near_rows.size()),
             columns = static_cast<Eigen::Index>(state.shared_dofs.size());
  w.shared_columns.resize(rows, columns);
  w.shared_columns.setFromTriplets(entries.begin(), entries.end());
  w.near_internal.setZero(rows);
  w.shared_moved.setZero(columns);
}

void ExplicitSolver::work_ahead() {
  if (window_ >= setup_.last_window) return;
  if (driven_by_force()) {
    if (substep_ > 0) return;  // who asks for single substeps holds no multiplier over the window
    for (std::size_t b = 0; b < states_.size(); ++b) {
      subcycled_[b].advance_held(states_[b], static_cast<double>(window_) * setup_.window_size_s, setup_.substeps);
    }
    return;
  }
  if (!trial_ && !contact_) predict(window_ + 1);
}

void ExplicitSolver::accept() {
  if (driven_by_force()) {
    accept_subcycling();
    return;
  }
  const double dt = setup_.window_size_s;
  ++window_;
  trial_ = false;
  for (std::size_t b = 0; b < states_.size(); ++b) {
    half_a_step(b);
    states_[b].u.swap(windows_[b].u);
    set_shared_velocity(b);
  }
  const double time_s = static_cast<double>(window_) * dt;
  find_accelerations(time_s, Velocity::half_a_step_before);
  if (contact_) contact_->apply(states_, u_before_);
  for (std::size_t b = 0; b < states_.size(); ++b) {
    half_a_step(b);
    states_[b].constrain_velocity(time_s, dt, states_[b].v);
  }
  if (contact_) contact_->finish(states_, u_before_);
  account();
  update_status();
  model_watch_.look(window_, states_);
}

/// The link says where shared nodes are, not how fast: their mean velocity over the window, for the fields. Nothing
/// else reads it.
void ExplicitSolver::set_shared_velocity(std::size_t b) {
  auto& state = states_[b];
  for (const int dof : state.shared_dofs) state.v[dof] = (state.u[dof] - windows_[b].u[dof]) / setup_.window_size_s;
}

/// v += dt/2 a, where there is an acceleration.
void ExplicitSolver::half_a_step(std::size_t b) {
  auto& state = states_[b];
  for (const auto& [first, last] : windows_[b].front.rows()) {
    const auto count = last - first;
    state.v.segment(first, count) += (0.5 * setup_.window_size_s) * state.a.segment(first, count);
  }
}

/// The forces of dashpots join f.
void ExplicitSolver::set_dashpot_forces(solver::BodyState& state, Window& w, Velocity velocity) const {
  for (const auto& d : state.dashpots) {
    if (state.external.zero()) w.external[d.dof] = 0.0;  // what it was a window ago
    const double others = w.external[d.dof] - w.internal[d.dof], v = state.v[d.dof];
    w.external[d.dof] +=
        velocity == Velocity::now ? d.force(v) : d.force_after_step(v, others, state.mass[d.dof], setup_.window_size_s);
  }
}

/// a = M^-1 (f - K u), the given motion at constrained dofs; the reactions there, R = M a + K u - f, join f.
void ExplicitSolver::find_accelerations(double time_s, Velocity velocity) {
  for (std::size_t b = 0; b < states_.size(); ++b) {
    auto& state = states_[b];
    auto& w = windows_[b];
    w.front.grow(w.internal);
    set_dashpot_forces(state, w, velocity);
    for (const auto& [first, last] : w.front.rows()) {
      const auto count = last - first;
      state.a.segment(first, count) =
          state.inverse_mass.segment(first, count)
              .cwiseProduct(w.external.segment(first, count) - w.internal.segment(first, count));
    }
    state.constrain_acceleration(time_s, setup_.window_size_s, state.a);
    for (const auto& c : state.constrained) w.external[c.dof] = state.mass[c.dof] * state.a[c.dof] + w.internal[c.dof];
  }
}

void ExplicitSolver::account() {
  for (std::size_t b = 0; b < states_.size(); ++b) {
    const auto& w = windows_[b];
    const auto& u = states_[b].u;
    states_[b].account_external(
        setup_.window_size_s, [&](int dof) { return 0.5 * (w.external_old[dof] + w.external[dof]); },
        [&](int dof) { return u[dof] - w.u[dof]; });
    account_interface(b, w.u, states_[b].u);
  }
}

void ExplicitSolver::update_status() {
  if (!contact_) return;
  status_ =
      solver::contact_status(contact_->surface(), states_, contact_->pairs_closed(), window_, setup_, separation_);
}

void ExplicitSolver::record(std::vector<double>& row) {
  const double dt = step_s();
  for (std::size_t b = 0; b < states_.size(); ++b) {
    auto& state = states_[b];
    solver::require_finite(state, state.u, window_);
    state.update_momentum();
    const double kinetic = (state.mass.array() * state.v.array().square()).sum();
    const double staggered = 0.25 * dt * dt * (state.mass.array() * state.a.array().square()).sum();
    state.totals.energy_kinetic_j = 0.5 * (kinetic - staggered);
    state.totals.energy_strain_j =
        0.5 * state.u.dot(driven_by_force() ? subcycled_[b].internal() : windows_[b].internal);
  }
  solver::record_bodies(states_, row);
  if (contact_) solver::append(contact_->report(states_), row);
}

void ExplicitSolver::load_state(const std::vector<double>& state, participant::FrozenContact contact) {
  solver::load_motion(state, states_);
  for (auto& window : windows_) {
    window.external.setZero();
    window.external_old = window.external;
    if (!driven_by_force()) window.front.reach_all();
  }
  for (auto& window : subcycled_) window.reach_all();
  if (contact_) contact_->freeze(contact);
  contact_started_ = false;  // a_n contains the contact force that closes the gap at n + 1
}

void ExplicitSolver::read_state(std::vector<double>& state, std::vector<double>& scale) {
  solver::read_motion(states_, setup_.window_size_s, state, scale);
}

void ExplicitSolver::write_fields(std::int64_t window) {
  solver::write_fields(setup_.output_directory, spec_->name, window, states_);
}

/// The shared nodes become this participant's own: integrated with the mass of its own elements, held by their
/// supports.
void ExplicitSolver::initialize_subcycling() {
  states_ = solver::initial_states(problem_, *spec_, true);
  solver::take_interface_mass(setup_.interface_mass_kg, states_);
  for (const auto& state : states_) {
    subcycled_.emplace_back(state, setup_.substeps, step_s());
    if (all_rows_) subcycled_.back().reach_all();
  }
}

void ExplicitSolver::shared_motion(LinkOutput& output) const {
  for (auto* values : {&output.value, &output.velocity_m_s, &output.acceleration_m_s2}) values->clear();
  for (std::size_t b = 0; b < states_.size(); ++b) {
    for (std::size_t i = 0; i < states_[b].shared_dofs.size(); ++i) {
      const auto motion = subcycled_[b].shared_motion(states_[b], i);
      output.value.push_back(motion.displacement);
      output.velocity_m_s.push_back(motion.velocity);
      output.acceleration_m_s2.push_back(motion.acceleration);
    }
  }
}

/// This part's entries of a link vector, whose parts follow one another; moves `next` on.
Eigen::Map<const Eigen::VectorXd> part_of(const std::vector<double>& link, const solver::BodyState& state,
                                          std::size_t& next) {
  const double* begin = link.data() + next;
  next += state.shared_dofs.size();
  return {begin, static_cast<Eigen::Index>(state.shared_dofs.size())};
}

void ExplicitSolver::synchronise_subcycling(const std::vector<double>& force, LinkOutput& output) {
  std::size_t next = 0;
  const double time_s = static_cast<double>(window_) * setup_.window_size_s;
  for (std::size_t b = 0; b < states_.size(); ++b) {
    subcycled_[b].start(states_[b], time_s, part_of(force, states_[b], next));
  }
  shared_motion(output);
}

void ExplicitSolver::advance_subcycling(double begin_s, int steps, const std::vector<double>& force,
                                        LinkOutput& output) {
  std::size_t next = 0;
  for (std::size_t b = 0; b < states_.size(); ++b) {
    part_force_ = part_of(force, states_[b], next);
    subcycled_[b].advance(states_[b], begin_s, steps, part_force_);
  }
  shared_motion(output);
}

void ExplicitSolver::advance_substep(std::int64_t window, int substep, const std::vector<double>& link_input,
                                     LinkOutput& output) {
  substep_ = substep;
  advance_subcycling(static_cast<double>(window - 1) * setup_.window_size_s + (substep - 1) * step_s(), 1, link_input,
                     output);
}

void ExplicitSolver::accept_subcycling() {
  for (std::size_t b = 0; b < states_.size(); ++b) subcycled_[b].accept(states_[b]);
  if (substep_ != 0 && substep_ != setup_.substeps) return;
  ++window_;
  model_watch_.look(window_, states_);
}

}  // namespace ricochet::explicit_solver

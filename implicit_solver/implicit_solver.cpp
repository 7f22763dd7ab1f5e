#include "implicit_solver/implicit_solver.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/base/error.hpp"
#include "common/fem/newmark.hpp"
#include "common/solver/describe.hpp"
#include "common/solver/free_motion.hpp"

namespace ricochet::implicit_solver {

namespace {
/// With the shared nodes in the root most of a solve is done before the link's force is there, but every window
/// multiplies by the dense inverse of the root. That pays while it has at most so many entries per entry of the
/// operator. Measured on the rounded striker: 312 root unknowns (the limit there) break even, with 998 the implicit
/// side takes four times as long.
constexpr std::size_t root_entries_per_entry = 2;
}  // namespace

using participant::Integration;
using participant::LinkOutput;

namespace {

fem::SparseMatrix block_diagonal(const std::vector<solver::BodyState>& states,
                                 const std::vector<Eigen::Index>& offsets) {
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::Index size = 0;
  for (std::size_t b = 0; b < states.size(); ++b) {
    const auto& k = states[b].part.stiffness;
    for (int row = 0; row < k.outerSize(); ++row) {
      for (fem::SparseMatrix::InnerIterator it(k, row); it; ++it) {
        entries.emplace_back(static_cast<int>(offsets[b]) + row, static_cast<int>(offsets[b] + it.col()), it.value());
      }
    }
    size += k.rows();
  }
  fem::SparseMatrix all(size, size);
  all.setFromTriplets(entries.begin(), entries.end());
  return all;
}

}  // namespace

ImplicitSolver::ImplicitSolver(scene::Problem problem, const std::string& name)
    : problem_(std::move(problem)), spec_(&problem_.scene.participant(name)) {
  if (spec_->role != scene::Role::implicit_solver) {
    throw ConfigError(
        fmt::format("{}: participant '{}' has role \"explicit\"; start explicit_solver for it, or set its role "
                    "to \"implicit\"",
                    problem_.scene.path, name));
  }
  states_ = solver::initial_states(problem_, *spec_, true);
  Eigen::Index offset = 0;
  for (const auto& state : states_) {
    offsets_.push_back(offset);
    for (const int dof : state.shared_dofs) shared_dofs_.push_back(static_cast<int>(offset) + dof);
    offset += state.part.dofs();
  }
  stiffness_ = block_diagonal(states_, offsets_);
}

participant::Description ImplicitSolver::describe() {
  auto description = solver::describe(problem_, *spec_, states_, !problem_.contact.pairs.empty());
  description.solver = "ricochet implicit_solver";
  axial_stress_ = solver::AxialStressShares(problem_, states_);
  description.axial_stress_columns = axial_stress_.columns();
  description.capabilities = {Capability::repeat_window, Capability::interface_stiffness};
  description.capabilities.push_back(Capability::switch_integration);
  const auto& contact = problem_.scene.contact;
  const bool massless = contact && contact->multiplier_update == scene::MultiplierUpdate::massless;
  if (!massless)
    description.capabilities.push_back(Capability::load_state);  // the motion of a massless node is no state
  return description;
}

void ImplicitSolver::initialize(const participant::Setup& setup, LinkOutput& output) {
  setup_ = setup;
  separation_ = solver::SeparationWatch(setup.separation_windows, setup.window_size_s);
  solver::take_interface_mass(setup.interface_mass_kg, states_);
  const auto shared = static_cast<Eigen::Index>(setup.interface_stiffness.empty() ? 0 : shared_dofs_.size());
  shared_x_.setZero(shared);
  shared_force_.setZero(shared);
  interface_stiffness_ = Eigen::Map<const Eigen::MatrixXd>(setup.interface_stiffness.data(), shared, shared);
  const auto size = stiffness_.rows();
  for (auto* vector :
       {&residual_, &external_, &link_, &rhs_, &trial_.increment, &trial_.velocity, &trial_.acceleration,
        &trial_.residual, &trial_.external, &trial_.link, &trial_.bracket, &trial_.jump, &trial_.mean_velocity}) {
    vector->setZero(size);
  }
  if (!problem_.contact.pairs.empty()) {
    contact_.emplace(problem_, scene::participant_parts(problem_, *spec_), states_);
  }
  settle_at_start();
  for (const auto& state : states_) {
    internal_.push_back(state.u);
    dashpot_load_.emplace_back(state.dashpots.size(), 0.0);
  }
  interface_work_j_.assign(states_.size(), 0.0);
  first_staggered_j_ = interface_work_j_;
  factorise();
  model_watch_ = solver::ModelWatch(problem_, states_, contact_ ? &contact_->surface() : nullptr);
  outline_ = solver::WatchedOutline(problem_, states_);
  put_output(trial_, output);
}

/// Massless contact nodes begin in balance with the others.
void ImplicitSolver::settle_at_start() {
  if (contact_) contact_->move_masses(states_);
  for (auto& state : states_) moved_.push_back(state.u);
  external_force(0.0, external_);
  settle_massless(external_);
  for (std::size_t b = 0; b < states_.size(); ++b) states_[b].u = moved_[b];
}

/// The massless nodes' displacement in `moved_`, from that of the others there.
void ImplicitSolver::settle_massless(const Eigen::VectorXd& external) {
  if (!contact_ || !contact_->massless()) return;
  part_external_.resize(states_.size());
  for (std::size_t b = 0; b < states_.size(); ++b) part_external_[b] = segment(external, b);
  contact_->settle(states_, part_external_, moved_);
}

/// Adds scale S to the shared dofs of a matrix.
void ImplicitSolver::add_interface_stiffness(double scale, fem::SparseMatrix& a) const {
  std::vector<Eigen::Triplet<double>> entries;
  for (Eigen::Index i = 0; i < interface_stiffness_.rows(); ++i) {
    for (Eigen::Index j = 0; j < interface_stiffness_.cols(); ++j) {
      const auto row = static_cast<std::size_t>(i), column = static_cast<std::size_t>(j);
      if (interface_stiffness_(i, j) != 0.0) {
        entries.emplace_back(shared_dofs_[row], shared_dofs_[column], scale * interface_stiffness_(i, j));
      }
    }
  }
  fem::SparseMatrix s(a.rows(), a.cols());
  s.setFromTriplets(entries.begin(), entries.end());
  a += s;
}

/// A = M + dt/2 C + dt^2/4 (K + S) on the dofs that are free.
void ImplicitSolver::factorise() {
  const double dt = setup_.window_size_s;
  fem::SparseMatrix a = (0.25 * dt * dt) * stiffness_;
  std::vector<bool> active(static_cast<std::size_t>(a.rows()));
  Eigen::VectorXd mass(a.rows());
  for (std::size_t b = 0; b < states_.size(); ++b) {
    segment(mass, b) = states_[b].mass;
    for (const auto& d : states_[b].dashpots) mass[offsets_[b] + d.dof] += 0.5 * dt * d.coefficient_kg_s;
    for (int dof = 0; dof < states_[b].part.dofs(); ++dof) {
      active[static_cast<std::size_t>(offsets_[b] + dof)] = states_[b].free[static_cast<std::size_t>(dof)];
    }
  }
  a += fem::SparseMatrix(mass.asDiagonal());
  if (interface_stiffness_.size() > 0) add_interface_stiffness(0.25 * dt * dt, a);
  std::vector<int> root = contact_ ? contact_->root_dofs() : std::vector<int>{};
  const std::size_t roots = root.size() + shared_dofs_.size();
  link_in_root_ = roots * roots <= root_entries_per_entry * static_cast<std::size_t>(a.nonZeros());
  for (const int dof : link_in_root_ ? shared_dofs_ : std::vector<int>{}) {
    const auto found = std::find(root.begin(), root.end(), dof);
    if (!active[static_cast<std::size_t>(dof)]) continue;
    shared_roots_.emplace_back(dof, found - root.begin());
    if (found == root.end()) root.push_back(dof);
  }
  factor_.emplace(a, active, root);
  if (!contact_) return;
  const auto size = static_cast<Eigen::Index>(contact_->root_dofs().size());
  contact_->prepare(factor_->root_inverse().topLeftCorner(size, size), dt);
  for (const int dof : contact_->root_dofs()) {
    std::size_t part = states_.size() - 1;
    while (dof < offsets_[part]) --part;
    roots_.push_back({dof, part, dof - static_cast<int>(offsets_[part])});
  }
}

void ImplicitSolver::external_force(double time_s, Eigen::VectorXd& external) {
  for (std::size_t b = 0; b < states_.size(); ++b) {
    if (states_[b].external.zero()) continue;
    Eigen::VectorXd force(states_[b].part.dofs());
    states_[b].external.at(time_s, force);
    segment(external, b) = force;
  }
}

void ImplicitSolver::take_link(const std::vector<double>& link_input, Eigen::VectorXd& link) const {
  for (std::size_t i = 0; i < shared_dofs_.size(); ++i) link[shared_dofs_[i]] = link_input[i];
}

/// link += S x, x the accepted displacement of the shared nodes or its increment in the trial.
void ImplicitSolver::add_stiffness_force(bool of_increment, Eigen::VectorXd& link) {
  if (interface_stiffness_.size() == 0) return;
  Eigen::Index i = 0;
  for (std::size_t b = 0; b < states_.size(); ++b) {
    for (const int dof : states_[b].shared_dofs) {
      shared_x_[i++] = of_increment ? trial_.increment[offsets_[b] + dof] : states_[b].u[dof];
    }
  }
  shared_force_.noalias() = interface_stiffness_ * shared_x_;
  for (std::size_t k = 0; k < shared_dofs_.size(); ++k)
    link[shared_dofs_[k]] += shared_force_[static_cast<Eigen::Index>(k)];
}

/// Motion of the shared nodes at the end of a window.
void ImplicitSolver::put_output(const Window& window, LinkOutput& output) const {
  output.value.clear();
  output.velocity_m_s.clear();
  output.acceleration_m_s2.clear();
  for (std::size_t b = 0; b < states_.size(); ++b) {
    for (const int dof : states_[b].shared_dofs) {
      output.value.push_back(states_[b].u[dof] + window.increment[offsets_[b] + dof]);
      output.velocity_m_s.push_back(window.velocity[offsets_[b] + dof]);
      output.acceleration_m_s2.push_back(window.acceleration[offsets_[b] + dof]);
    }
  }
}

void ImplicitSolver::synchronise(Integration integration, const std::vector<double>& link_input, LinkOutput& output) {
  const double time_s = static_cast<double>(window_) * setup_.window_size_s;
  integration_ = integration;
  prepared_ = -1;
  take_link(link_input, link_);
  external_force(time_s, external_);
  trial_.increment.setZero();
  if (integration == Integration::implicit_newmark) add_stiffness_force(false, link_);
  for (std::size_t b = 0; b < states_.size(); ++b) {
    auto& state = states_[b];
    auto q = segment(residual_, b);
    state.stiffness.multiply(state.u, internal_[b]);
    for (const auto& d : state.dashpots) {
      external_[offsets_[b] + d.dof] = load_on(b, d.dof, external_) + d.force(state.v[d.dof]);
    }
    q = segment(external_, b) - internal_[b] - segment(link_, b);
    state.a = state.inverse_mass.cwiseProduct(q);
    state.constrain_acceleration(time_s, setup_.window_size_s, state.a);
    state.constrain_velocity(time_s, setup_.window_size_s, state.v);
    for (const auto& c : state.constrained) {  // reactions join f, so that q = M a there too
      const double inertia = state.mass[c.dof] * state.a[c.dof];
      external_[offsets_[b] + c.dof] += inertia - q[c.dof];
      q[c.dof] = inertia;
    }
    segment(trial_.velocity, b) = state.v;
    segment(trial_.acceleration, b) = state.a;
  }
  if (contact_) contact_->open();
  if (contact_ && contact_->held()) {
    contact_->hold_rates(states_, trial_.velocity, trial_.acceleration);
    for (std::size_t b = 0; b < states_.size(); ++b) {
      states_[b].v = segment(trial_.velocity, b);
      states_[b].a = segment(trial_.acceleration, b);
    }
  }
  put_output(trial_, output);
  update_status();
}

void ImplicitSolver::advance(std::int64_t window, const std::vector<double>& link_input, LinkOutput& output) {
  const double time_s = static_cast<double>(window) * setup_.window_size_s;
  take_link(link_input, trial_.link);
  if (integration_ == Integration::implicit_newmark) {
    if (prepared_ != window) prepare(window);
    advance_implicit(time_s);
  } else {
    external_force(time_s, trial_.external);
    advance_explicit(time_s);
  }
  put_output(trial_, output);
}

/// The right-hand side of the class comment without the link's change, and as much of the solve as does not need that.
void ImplicitSolver::prepare(std::int64_t window) {
  const double dt = setup_.window_size_s, quarter = 0.25 * dt * dt, time_s = static_cast<double>(window) * dt;
  external_force(time_s, trial_.external);
  for (std::size_t b = 0; b < states_.size(); ++b) {
    const auto& state = states_[b];
    segment(rhs_, b) = state.mass.cwiseProduct(dt * state.v + quarter * state.a) + quarter * segment(residual_, b);
    if (!state.external.zero()) segment(rhs_, b) += quarter * (segment(trial_.external, b) - segment(external_, b));
  }
  damp_rhs();
  constrain_increment(time_s);
  if (link_in_root_) factor_->forward(rhs_);
  prepared_ = window;
}

void ImplicitSolver::work_ahead() {
  const bool due =
      integration_ == Integration::implicit_newmark && window_ < setup_.last_window && !shared_dofs_.empty();
  if (due && prepared_ != window_ + 1) prepare(window_ + 1);
}

void ImplicitSolver::advance_implicit(double time_s) {
  const double quarter = 0.25 * setup_.window_size_s * setup_.window_size_s;
  add_stiffness_force(false, trial_.link);  // S du is in the operator
  if (link_in_root_) {
    root_rhs_ = factor_->root_rhs();
    for (const auto& [dof, root] : shared_roots_) root_rhs_[root] -= quarter * (trial_.link[dof] - link_[dof]);
  } else {
    rhs_with_link_ = rhs_;
    for (const int dof : shared_dofs_) rhs_with_link_[dof] -= quarter * (trial_.link[dof] - link_[dof]);
    factor_->forward(rhs_with_link_);
    root_rhs_ = factor_->root_rhs();
  }
  solve_increment();
  add_stiffness_force(true, trial_.link);
  find_rates();
  constrain_rates(time_s);
}

/// Given increments of the constrained dofs, and what they push on the free ones: b_f -= dt^2/4 K_fc du_c.
void ImplicitSolver::constrain_increment(double time_s) {
  const double quarter = 0.25 * setup_.window_size_s * setup_.window_size_s;
  for (std::size_t b = 0; b < states_.size(); ++b) {
    for (const auto& c : states_[b].constrained) {
      const double du = c.at(time_s) - states_[b].u[c.dof];
      const auto row = static_cast<int>(offsets_[b]) + c.dof;
      trial_.increment[row] = du;
      if (du == 0.0) continue;
      for (fem::SparseMatrix::InnerIterator it(stiffness_, row); it; ++it) rhs_[it.col()] -= quarter * it.value() * du;
    }
  }
}

void ImplicitSolver::solve_increment() {
  root_increment_.noalias() = factor_->root_inverse() * root_rhs_;
  if (contact_) {
    const auto& root = contact_->root_dofs();
    for (std::size_t i = 0; i < root.size(); ++i)
      trial_.increment[root[i]] = root_increment_[static_cast<Eigen::Index>(i)];
    contact_->solve(states_, trial_.increment);
    const double scale = contact_->kappa() * 0.25 * setup_.window_size_s * setup_.window_size_s;
    const auto size = static_cast<Eigen::Index>(root.size());
    root_increment_.noalias() += scale * (factor_->root_inverse().leftCols(size) * contact_->root_force());
  }
  factor_->backward(root_increment_, trial_.increment);
}

/// a*, v* and q of the class comment; the velocity and acceleration of closed pairs; the bracket of the contact work.
void ImplicitSolver::find_rates() {
  const double dt = setup_.window_size_s;
  for (std::size_t b = 0; b < states_.size(); ++b) {
    const auto& state = states_[b];
    auto a = segment(trial_.acceleration, b);
    a = (4.0 / (dt * dt)) * (segment(trial_.increment, b) - dt * state.v) - state.a;
    segment(trial_.velocity, b) = fem::corrected_velocity(state.v, state.a, a, dt);
    segment(trial_.residual, b) = state.mass.cwiseProduct(a);
  }
  if (contact_) find_contact_rates();
  set_dashpot_forces();
}

/// Takes the contact forces out of q (and, where the law does not remember them, out of a), then applies Eq. 25.
void ImplicitSolver::find_contact_rates() {
  const Eigen::VectorXd& force = contact_->root_force();
  for (std::size_t i = 0; i < roots_.size(); ++i) {
    const auto& [dof, part, local] = roots_[i];
    const auto& state = states_[part];
    const double applied = contact_->kappa() * force[static_cast<Eigen::Index>(i)];
    trial_.bracket[dof] = state.mass[local] * state.a[local] - residual_[dof] + applied;
    trial_.residual[dof] -= applied;
    if (state.mass[local] == 0.0) {  // massless: it has no rates of its own
      trial_.velocity[dof] = trial_.increment[dof] / setup_.window_size_s;
      trial_.acceleration[dof] = 0.0;
    }
    trial_.mean_velocity[dof] = trial_.velocity[dof];
    if (!contact_->remembered()) trial_.acceleration[dof] = trial_.residual[dof] * state.inverse_mass[local];
  }
  contact_->update_rates(states_, trial_.bracket, trial_.increment, trial_.velocity, trial_.acceleration);
  for (const auto& [dof, part, local] : roots_) {
    const double before = trial_.mean_velocity[dof];
    trial_.jump[dof] = states_[part].mass[local] * (trial_.velocity[dof] - before);
    trial_.mean_velocity[dof] = 0.5 * (before + trial_.velocity[dof]);
  }
}

/// Motion of the constrained dofs at the window's end, and the reactions R = M a + K u + L - f there, which join f.
void ImplicitSolver::constrain_rates(double time_s) {
  const double dt = setup_.window_size_s;
  for (std::size_t b = 0; b < states_.size(); ++b) {
    const auto& state = states_[b];
    for (const auto& c : state.constrained) {
      const auto dof = static_cast<int>(offsets_[b]) + c.dof;
      double internal = external_[dof] - residual_[dof] - link_[dof];
      for (fem::SparseMatrix::InnerIterator it(stiffness_, dof); it; ++it)
        internal += it.value() * trial_.increment[it.col()];
      trial_.velocity[dof] = c.velocity(time_s, dt);
      trial_.acceleration[dof] = c.acceleration(time_s, dt);
      trial_.residual[dof] = state.mass[c.dof] * trial_.acceleration[dof];
      trial_.external[dof] = trial_.residual[dof] + internal + trial_.link[dof];
    }
  }
}

/// Central difference step with the same lumped masses, without contact.
void ImplicitSolver::advance_explicit(double time_s) {
  const double dt = setup_.window_size_s;
  for (std::size_t b = 0; b < states_.size(); ++b) {
    const auto& state = states_[b];
    segment(trial_.increment, b) = dt * state.v + (0.5 * dt * dt) * state.a;
    for (const auto& c : state.constrained) trial_.increment[offsets_[b] + c.dof] = c.at(time_s) - state.u[c.dof];
    moved_[b] = state.u + segment(trial_.increment, b);
  }
  settle_massless(trial_.external);
  for (std::size_t b = 0; b < states_.size(); ++b) {
    const auto& state = states_[b];
    state.stiffness.multiply(moved_[b], internal_[b]);
    for (const auto& d : state.dashpots) {
      const auto dof = offsets_[b] + d.dof;
      const double load = load_on(b, d.dof, trial_.external), others = load - trial_.link[dof] - internal_[b][d.dof];
      const double half_velocity = state.v[d.dof] + 0.5 * dt * state.a[d.dof];
      trial_.external[dof] = load + d.force_after_step(half_velocity, others, state.mass[d.dof], dt);
    }
    segment(trial_.residual, b) = segment(trial_.external, b) - segment(trial_.link, b) - internal_[b];
    segment(trial_.acceleration, b) = state.inverse_mass.cwiseProduct(segment(trial_.residual, b));
    segment(trial_.velocity, b) = fem::corrected_velocity(state.v, state.a, segment(trial_.acceleration, b), dt);
  }
  if (contact_ && contact_->massless()) {
    for (std::size_t b = 0; b < states_.size(); ++b) segment(trial_.increment, b) = moved_[b] - states_[b].u;
    contact_->set_massless_velocity(trial_.increment, trial_.velocity);
  }
  constrain_rates(time_s);
}

void ImplicitSolver::accept() {
  ++window_;
  account();
  for (std::size_t b = 0; b < states_.size(); ++b) {
    auto& state = states_[b];
    state.u += segment(trial_.increment, b);
    state.v = segment(trial_.velocity, b);
    state.a = segment(trial_.acceleration, b);
  }
  residual_.swap(trial_.residual);
  external_.swap(trial_.external);
  link_.swap(trial_.link);
  if (contact_) contact_->accept();
  const int every = problem_.scene.coupling.resynchronise_every;
  if (every > 0 && window_ % every == 0) resynchronise_residual();
  update_status();
  model_watch_.look(window_, states_);
}

/// Replaces the residual that the increments have carried along by q = f - K u - L itself; round-off would otherwise
/// add up like window^(3/2) in the momentum.
void ImplicitSolver::resynchronise_residual() {
  double drift = 0.0, scale = 0.0;
  for (std::size_t b = 0; b < states_.size(); ++b) {
    const auto& state = states_[b];
    state.stiffness.multiply(state.u, internal_[b]);
    for (int i = 0; i < state.part.dofs(); ++i) {
      const auto dof = offsets_[b] + i;
      const double residual = external_[dof] - internal_[b][i] - link_[dof];
      scale = std::max(scale, std::abs(internal_[b][i]));
      drift = std::max(drift, std::abs(residual - residual_[dof]));
      if (state.free[static_cast<std::size_t>(i)]) residual_[dof] = residual;
    }
  }
  if (scale > 0.0) largest_drift_ = std::max(largest_drift_, drift / scale);
}

void ImplicitSolver::account() {
  const double dt = setup_.window_size_s;
  for (std::size_t b = 0; b < states_.size(); ++b) {
    const auto at = offsets_[b];
    states_[b].account_external(
        dt, [&](int dof) { return 0.5 * (external_[at + dof] + trial_.external[at + dof]); },
        [&](int dof) { return trial_.increment[at + dof]; });
    for (const int dof : states_[b].shared_dofs) {
      interface_work_j_[b] -= 0.5 * (link_[at + dof] + trial_.link[at + dof]) * trial_.increment[at + dof];
    }
  }
  if (contact_ && integration_ == Integration::implicit_newmark) {
    contact_->account(states_, trial_.bracket, trial_.increment, trial_.jump, trial_.mean_velocity);
  }
}

void ImplicitSolver::update_status() {
  if (!contact_) return;
  status_ =
      solver::contact_status(contact_->surface(), states_, contact_->pairs_closed(), window_, setup_, separation_);
}

/// The explicit elements' share in the staggered metric of the shared nodes. Central difference takes dt^2/8 a^T M a
/// off 1/2 v^T M v; where only L of the force M a is explicit, that is -dt^2/8 a . (-L). Without it the energy of the
/// sum flickers at the interface by that amount.
double ImplicitSolver::shared_staggered_energy(std::size_t part) const {
  if (integration_ == Integration::explicit_central || interface_stiffness_.size() > 0) return 0.0;
  const auto& state = states_[part];
  double sum = 0.0;
  for (const int dof : state.shared_dofs) sum += state.a[dof] * link_[offsets_[part] + dof];
  return 0.125 * setup_.window_size_s * setup_.window_size_s * sum;
}

void ImplicitSolver::record(std::vector<double>& row) {
  const double dt = setup_.window_size_s;
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
    state.totals.energy_strain_j = 0.5 * state.u.dot(segment(external_, b) - segment(residual_, b) - segment(link_, b));
  }
  solver::record_bodies(states_, row);
  if (contact_) solver::append(contact_->report(states_), row);
}

void ImplicitSolver::load_state(const std::vector<double>& state, participant::FrozenContact contact) {
  solver::load_motion(state, states_);
  external_.setZero();
  trial_.external.setZero();
  if (contact_) contact_->freeze(contact);
}

void ImplicitSolver::read_state(std::vector<double>& state, std::vector<double>& scale) {
  solver::read_motion(states_, setup_.window_size_s, state, scale);
}

void ImplicitSolver::write_fields(std::int64_t window) {
  solver::write_fields(setup_.output_directory, spec_->name, window, states_);
}

}  // namespace ricochet::implicit_solver

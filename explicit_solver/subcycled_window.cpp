#include "explicit_solver/subcycled_window.hpp"

#include <algorithm>

#include "common/body/central_difference.hpp"

namespace ricochet::explicit_solver {

using solver::BodyState;

namespace {

/// Nodes within `layers` layers of elements of the shared ones, ascending.
std::vector<bool> within_reach(const BodyState& state, int components, int layers) {
  std::vector<bool> reached(static_cast<std::size_t>(state.part.nodes()), false);
  std::vector<int> front = state.shared_nodes;
  for (const int node : front) reached[static_cast<std::size_t>(node)] = true;
  for (int layer = 0; layer < layers && !front.empty(); ++layer) {
    std::vector<int> next;
    for (const int node : front) {
      for (fem::SparseMatrix::InnerIterator it(state.part.stiffness, node * components); it; ++it) {
        const auto neighbour = static_cast<std::size_t>(it.col() / components);
        if (reached[neighbour]) continue;
        reached[neighbour] = true;
        next.push_back(static_cast<int>(neighbour));
      }
    }
    front.swap(next);
  }
  return reached;
}

fem::SparseMatrix submatrix(const fem::SparseMatrix& k, const std::vector<int>& dofs) {
  std::vector<int> index(static_cast<std::size_t>(k.rows()), -1);
  for (std::size_t i = 0; i < dofs.size(); ++i) index[static_cast<std::size_t>(dofs[i])] = static_cast<int>(i);
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t i = 0; i < dofs.size(); ++i) {
    for (fem::SparseMatrix::InnerIterator it(k, dofs[i]); it; ++it) {
      const int column = index[static_cast<std::size_t>(it.col())];
      if (column >= 0) entries.emplace_back(static_cast<int>(i), column, it.value());
    }
  }
  const auto size = static_cast<Eigen::Index>(dofs.size());
  fem::SparseMatrix result(size, size);
  result.setFromTriplets(entries.begin(), entries.end());
  return result;
}

}  // namespace

SubcycledWindow::SubcycledWindow(const BodyState& state, int substeps, double dt, const MakeForce& make_force)
    : dt_(dt) {
  const int components = fem::components(state.part.mesh.model);
  const auto reached = within_reach(state, components, substeps - 1);
  std::vector<int> index(static_cast<std::size_t>(state.part.dofs()), -1);
  for (int dof = 0; dof < state.part.dofs(); ++dof) {
    if (!reached[static_cast<std::size_t>(dof / components)]) continue;
    index[static_cast<std::size_t>(dof)] = static_cast<int>(near_.size());
    near_.push_back(dof);
  }
  std::vector<int> near_nodes;  // whatever the multiplier moves is among them
  for (int node = 0; node < state.part.nodes(); ++node) {
    if (reached[static_cast<std::size_t>(node)]) near_nodes.push_back(node);
  }
  elements_ = make_force(state, near_nodes);
  for (const auto& d : state.dashpots) near_dashpots_ = near_dashpots_ || index[static_cast<std::size_t>(d.dof)] >= 0;
  if (state.others != nullptr) anything_given_ = state.others->anywhere(near_dashpots_ || !state.external.zero());
  for (const int dof : state.shared_dofs) near_of_shared_.push_back(index[static_cast<std::size_t>(dof)]);
  for (const auto& c : state.constrained) {
    const int at = index[static_cast<std::size_t>(c.dof)];
    if (at >= 0) near_constrained_.emplace_back(at, &c);
  }
  near_stiffness_ = fem::StiffnessProduct(submatrix(state.part.stiffness, near_), components);
  const auto size = static_cast<Eigen::Index>(near_.size());
  const auto shared = static_cast<Eigen::Index>(state.shared_dofs.size());
  near_inverse_mass_.resize(size);
  for (Eigen::Index i = 0; i < size; ++i)
    near_inverse_mass_[i] = state.inverse_mass[near_[static_cast<std::size_t>(i)]];
  for (auto* vector : {&du_, &dv_, &da_, &da_new_, &d_internal_, &d_internal_old_}) vector->setZero(size);
  for (auto* vector : {&accepted_.internal, &accepted_.external, &u_, &v_, &a_, &trial_internal_, &trial_external_,
                       &external_old_, &a_new_}) {
    vector->setZero(state.part.dofs());
  }
  for (auto* vector : {&accepted_.force, &trial_force_, &d_force_}) vector->setZero(shared);
  shared_path_.setZero(shared, substeps + 1);
  d_shared_path_ = shared_path_;
}

void SubcycledWindow::start(BodyState& state, double time_s, const Eigen::VectorXd& force) {
  tried_ = false;
  accepted_.force = force;
  elements_->evaluate(0.0, state.u, accepted_.internal);
  elements_->follow(accepted_.internal);
  elements_->settle();
  state.external.at(time_s, accepted_.external);
  for (const auto& d : state.dashpots) accepted_.external[d.dof] += d.force(state.v[d.dof]);
  state.a = state.inverse_mass.cwiseProduct(accepted_.external - accepted_.internal);
  for (std::size_t i = 0; i < state.shared_dofs.size(); ++i) {
    const int dof = state.shared_dofs[i];
    state.a[dof] += state.inverse_mass[dof] * force[static_cast<Eigen::Index>(i)];
  }
  state.constrain_acceleration(time_s, dt_, state.a);
  state.constrain_velocity(time_s, dt_, state.v);
  solver::set_reactions(state, time_s, dt_, accepted_.internal, accepted_.external);
}

void SubcycledWindow::set_step(double dt) {
  dt_ = dt;
  tried_ = false;
}

void SubcycledWindow::advance(const BodyState& state, double begin_s, int steps, const Eigen::VectorXd& force) {
  const bool given = state.others != nullptr ? anything_given_ : near_dashpots_ || !state.external.zero();
  if (tried_ && steps == steps_ && !given && elements_->linear()) {
    correct(state, begin_s, force);
  } else {
    run(state, begin_s, steps, force);
  }
}

void SubcycledWindow::advance_held(const BodyState& state, double begin_s, int steps) {
  if (!tried_) run(state, begin_s, steps, accepted_.force);
}

void SubcycledWindow::run(const BodyState& state, double begin_s, int steps, const Eigen::VectorXd& force) {
  tried_ = true;
  steps_ = steps;
  elements_->go_back();
  trial_force_ = force;
  given_ = {};
  clear_correction();
  u_ = state.u;
  v_ = state.v;
  a_ = state.a;
  trial_external_ = accepted_.external;
  for (std::size_t i = 0; i < state.shared_dofs.size(); ++i) {
    shared_path_(static_cast<Eigen::Index>(i), 0) = u_[state.shared_dofs[i]];
  }
  for (int j = 1; j <= steps; ++j) {
    const double time_s = begin_s + j * dt_, share = static_cast<double>(j) / steps;
    a_new_ = u_;  // u_n, until the new acceleration is known
    solver::step_displacement(state, time_s, dt_, u_, v_, a_, u_);
    Eigen::VectorXd& u_old = a_new_;
    external_old_ = trial_external_;
    elements_->evaluate(dt_, u_, trial_internal_);
    elements_->follow(trial_internal_);
    if (!state.external.zero()) state.external.at(time_s, trial_external_);
    solver::add_dashpot_forces(
        state, dt_, [this](int dof) { return v_[dof] + 0.5 * dt_ * a_[dof]; },
        [this](int dof, double load) { return load - trial_internal_[dof]; }, trial_external_);
    solver::set_reactions(state, time_s, dt_, trial_internal_, trial_external_);
    state.book([&](int dof) { return 0.5 * (external_old_[dof] + trial_external_[dof]); },
               [&](int dof) { return u_[dof] - u_old[dof]; }, [&](int dof) { return 0.5 * (u_[dof] + u_old[dof]); },
               [&](double mean_force, double moved, int component, const Eigen::Vector3d& place) {
                 given_.add(dt_, mean_force, moved, component, place);
               });
    a_new_ = state.inverse_mass.cwiseProduct(trial_external_ - trial_internal_);
    for (std::size_t i = 0; i < state.shared_dofs.size(); ++i) {
      const int dof = state.shared_dofs[i];
      const auto k = static_cast<Eigen::Index>(i);
      a_new_[dof] += state.inverse_mass[dof] * (accepted_.force[k] + share * (force[k] - accepted_.force[k]));
      shared_path_(k, j) = u_[dof];
    }
    state.constrain_acceleration(time_s, dt_, a_new_);
    v_ = fem::corrected_velocity(v_, a_, a_new_, dt_);
    state.constrain_velocity(time_s, dt_, v_);
    a_.swap(a_new_);
  }
}

void SubcycledWindow::clear_correction() {
  for (auto* vector : {&du_, &dv_, &da_, &d_internal_, &d_force_}) vector->setZero();
  d_shared_path_.setZero();
  d_given_ = {};
}

void SubcycledWindow::correct(const BodyState& state, double begin_s, const Eigen::VectorXd& force) {
  const int components = fem::components(state.part.mesh.model);
  clear_correction();
  d_force_ = force - trial_force_;
  for (int j = 1; j <= steps_; ++j) {
    const double share = static_cast<double>(j) / steps_;
    du_ += fem::predicted_increment(dv_, da_, dt_, fem::beta_explicit);
    d_internal_old_ = d_internal_;
    if (j > 1) near_stiffness_.multiply(du_, d_internal_);  // until then nothing has moved
    da_new_ = -near_inverse_mass_.cwiseProduct(d_internal_);
    for (std::size_t i = 0; i < near_of_shared_.size(); ++i) {
      const int at = near_of_shared_[i];
      const auto k = static_cast<Eigen::Index>(i);
      da_new_[at] += near_inverse_mass_[at] * share * d_force_[k];
      d_shared_path_(k, j) = du_[at];
    }
    for (const auto& [at, c] : near_constrained_) {
      const double end_s = begin_s + j * dt_;
      d_given_.add(dt_, 0.5 * (d_internal_old_[at] + d_internal_[at]), c->at(end_s) - c->at(end_s - dt_),
                   c->dof % components,
                   state.place_of(c->dof, [&](int dof) { return 0.5 * (state.u[dof] + u_[dof]); }));
    }
    dv_ = fem::corrected_velocity(dv_, da_, da_new_, dt_);
    da_.swap(da_new_);
  }
}

SubcycledWindow::State SubcycledWindow::state() const {
  State state = accepted_;
  state.elements = kept_by(*elements_);
  return state;
}

void SubcycledWindow::restore(const State& state) {
  accepted_ = state;
  put_back(state.elements, *elements_);
  trial_internal_ = accepted_.internal;  // rows beyond the front are never written
  tried_ = false;
}

SubcycledWindow::Motion SubcycledWindow::shared_motion(const BodyState& state, std::size_t i) const {
  const int dof = state.shared_dofs[i], at = near_of_shared_[i];
  if (!tried_) return {state.u[dof], state.v[dof], state.a[dof]};
  return {u_[dof] + du_[at], v_[dof] + dv_[at], a_[dof] + da_[at]};
}

/// sum_j 1/2 (lambda_{j-1} + lambda_j) . (u_j - u_{j-1}), what the link does on the part.
double SubcycledWindow::interface_work() const {
  double work = 0.0;
  for (int j = 1; j <= steps_; ++j) {
    const double middle = (j - 0.5) / steps_;
    for (Eigen::Index i = 0; i < accepted_.force.size(); ++i) {
      const double moved =
          shared_path_(i, j) - shared_path_(i, j - 1) + d_shared_path_(i, j) - d_shared_path_(i, j - 1);
      const double end = trial_force_[i] + d_force_[i];
      work += (accepted_.force[i] + middle * (end - accepted_.force[i])) * moved;
    }
  }
  return work;
}

void SubcycledWindow::accept(BodyState& state) {
  elements_->settle();
  state.totals.energy_interface_j += interface_work();
  state.take(given_);
  state.take(d_given_);
  for (std::size_t i = 0; i < near_.size(); ++i) {
    const int dof = near_[i];
    const auto k = static_cast<Eigen::Index>(i);
    u_[dof] += du_[k];
    v_[dof] += dv_[k];
    a_[dof] += da_[k];
    trial_internal_[dof] += d_internal_[k];
  }
  for (const auto& [at, c] : near_constrained_) trial_external_[c->dof] += d_internal_[at];
  state.u.swap(u_);
  state.v.swap(v_);
  state.a.swap(a_);
  accepted_.internal.swap(trial_internal_);
  accepted_.external.swap(trial_external_);
  accepted_.force = trial_force_ + d_force_;
  tried_ = false;
}

}  // namespace ricochet::explicit_solver

#include "implicit_solver/newmark_window.hpp"

#include <algorithm>
#include <utility>

#include "common/fem/newmark.hpp"
#include "common/solver/compliance.hpp"

namespace ricochet::implicit_solver {

namespace {
/// With the shared nodes in the root most of a solve is done before the link's force is there, but every window
/// multiplies by the dense inverse of the root. That pays while it has at most so many entries per entry of the
/// operator. Measured on the rounded striker: 312 root unknowns (the limit there) break even, with 998 the implicit
/// side takes four times as long.
constexpr std::size_t root_entries_per_entry = 2;
/// Up to so many contact dofs are in the root, whose dense inverse costs their cube to find and their square to keep
/// and to use. More of them are eliminated with all others; then what contact forces add to the motion is another solve
/// of the whole operator. Measured on flat cylinders: with 600 a hybrid window costs the same either way, finding the
/// inverse three times the rest of the set-up with 800.
constexpr std::size_t most_contact_dofs_in_root = 800;
}  // namespace

NewmarkWindow::NewmarkWindow(const CombinedParts& parts, ImplicitContact* contact, Eigen::MatrixXd interface_stiffness,
                             const WindowClock& clock, participant::Heartbeat* heart)
    : parts_(parts),
      contact_(contact),
      clock_(clock),
      dt_(clock.size_s()),
      interface_stiffness_(std::move(interface_stiffness)) {
  for (auto* vector : {&rhs_, &mean_velocity_}) vector->setZero(parts_.dofs());
  for (auto* vector : {&shared_x_, &shared_force_}) vector->setZero(interface_stiffness_.rows());
  for (const auto& state : parts_.states) dashpot_load_.emplace_back(state.dashpots.size(), 0.0);
  factorise(heart);
}

/// Adds scale S to the shared dofs of a matrix.
void NewmarkWindow::add_interface_stiffness(double scale, fem::SparseMatrix& a) const {
  std::vector<Eigen::Triplet<double>> entries;
  for (Eigen::Index i = 0; i < interface_stiffness_.rows(); ++i) {
    for (Eigen::Index j = 0; j < interface_stiffness_.cols(); ++j) {
      const auto row = static_cast<std::size_t>(i), column = static_cast<std::size_t>(j);
      if (interface_stiffness_(i, j) != 0.0) {
        entries.emplace_back(parts_.shared_dofs[row], parts_.shared_dofs[column], scale * interface_stiffness_(i, j));
      }
    }
  }
  fem::SparseMatrix s(a.rows(), a.cols());
  s.setFromTriplets(entries.begin(), entries.end());
  a += s;
}

/// A = M + dt/2 C + dt^2/4 (K + S) on the dofs that are free.
void NewmarkWindow::factorise(participant::Heartbeat* heart) {
  const double dt = dt_;
  fem::SparseMatrix a = parts_.stiffness();
  a *= 0.25 * dt * dt;
  std::vector<bool> active(static_cast<std::size_t>(a.rows()));
  Eigen::VectorXd mass(a.rows());
  for (std::size_t b = 0; b < parts_.states.size(); ++b) {
    parts_.segment(mass, b) = parts_.states[b].mass;
    for (const auto& d : parts_.states[b].dashpots) mass[parts_.offsets[b] + d.dof] += 0.5 * dt * d.coefficient_kg_s;
    for (int dof = 0; dof < parts_.states[b].part.dofs(); ++dof) {
      active[static_cast<std::size_t>(parts_.offsets[b] + dof)] = parts_.states[b].free[static_cast<std::size_t>(dof)];
    }
  }
  a += fem::SparseMatrix(mass.asDiagonal());
  if (interface_stiffness_.size() > 0) add_interface_stiffness(0.25 * dt * dt, a);
  std::vector<int> root = contact_ ? contact_->root_dofs() : std::vector<int>{};
  contact_in_root_ = root.size() <= most_contact_dofs_in_root || contact_->massless();
  if (!contact_in_root_) root.clear();
  const std::size_t roots = root.size() + parts_.shared_dofs.size();
  link_in_root_ = contact_in_root_ && roots * roots <= root_entries_per_entry * static_cast<std::size_t>(a.nonZeros());
  for (const int dof : link_in_root_ ? parts_.shared_dofs : std::vector<int>{}) {
    const auto found = std::find(root.begin(), root.end(), dof);
    if (!active[static_cast<std::size_t>(dof)]) continue;
    shared_roots_.emplace_back(dof, found - root.begin());
    if (found == root.end()) root.push_back(dof);
  }
  factor_.emplace(std::move(a), active, root, parts_.states.empty() ? nullptr : parts_.states.front().parallel, heart);
  if (!contact_) return;
  if (heart) heart->begin("preparing the contact");
  const auto size = static_cast<Eigen::Index>(contact_->root_dofs().size());
  if (contact_in_root_) {
    contact_->prepare(factor_->root_inverse().topLeftCorner(size, size), dt);
  } else {
    contact_force_.setZero(parts_.dofs());
    contact_increment_.setZero(parts_.dofs());
    const auto solve = [this](const Eigen::VectorXd& forces, Eigen::VectorXd& motion) {
      move_by(forces);
      motion.resize(forces.size());
      for (Eigen::Index i = 0; i < forces.size(); ++i)
        motion[i] = contact_increment_[contact_->root_dofs()[static_cast<std::size_t>(i)]];
    };
    contact_->prepare(parts_.states, solve, dt);
  }
  for (const int dof : contact_->root_dofs()) {
    std::size_t part = parts_.states.size() - 1;
    while (dof < parts_.offsets[part]) --part;
    roots_.push_back({dof, part, dof - static_cast<int>(parts_.offsets[part])});
  }
}

/// link += S x.
template <class Displacement>
void NewmarkWindow::add_stiffness_force(const Displacement& displacement, Eigen::VectorXd& link) {
  if (interface_stiffness_.size() == 0) return;
  Eigen::Index i = 0;
  for (std::size_t b = 0; b < parts_.states.size(); ++b) {
    for (const int dof : parts_.states[b].shared_dofs) shared_x_[i++] = displacement(b, dof);
  }
  shared_force_.noalias() = interface_stiffness_ * shared_x_;
  for (std::size_t k = 0; k < parts_.shared_dofs.size(); ++k)
    link[parts_.shared_dofs[k]] += shared_force_[static_cast<Eigen::Index>(k)];
}

void NewmarkWindow::add_interface_force(Eigen::VectorXd& link) {
  add_stiffness_force([&](std::size_t b, int dof) { return parts_.states[b].u[dof]; }, link);
}

/// The right-hand side of the class comment without the link's change, and as much of the solve as does not need that.
void NewmarkWindow::prepare(std::int64_t window, const WindowState& last, WindowTrial& trial) {
  if (prepared_ == window) return;
  const double dt = dt_, quarter = 0.25 * dt * dt, time_s = clock_.time_s(window);
  parts_.external_force(time_s, trial.end.external);
  for (std::size_t b = 0; b < parts_.states.size(); ++b) {
    const auto& state = parts_.states[b];
    parts_.segment(rhs_, b) =
        state.mass.cwiseProduct(dt * state.v + quarter * state.a) + quarter * parts_.segment(last.residual, b);
    if (!state.external.zero())
      parts_.segment(rhs_, b) += quarter * (parts_.segment(trial.end.external, b) - parts_.segment(last.external, b));
  }
  damp_rhs(trial);
  constrain_increment(time_s, trial);
  if (link_in_root_) factor_->forward(rhs_);
  prepared_ = window;
}

/// Of the dashpots' forces in q and df, what does not change with du: see the class comment.
void NewmarkWindow::damp_rhs(const WindowTrial& trial) {
  const double dt = dt_;
  for (std::size_t b = 0; b < parts_.states.size(); ++b) {
    const auto& state = parts_.states[b];
    for (std::size_t i = 0; i < state.dashpots.size(); ++i) {
      const auto& d = state.dashpots[i];
      dashpot_load_[b][i] = parts_.load_on(b, d.dof, trial.end.external);
      double change = 2.0 * d.coefficient_kg_s * state.v[d.dof];
      if (!state.external.zero()) change += d.force(state.v[d.dof]);  // df was formed with it in f_n
      rhs_[parts_.offsets[b] + d.dof] += 0.25 * dt * dt * change;
    }
  }
}

void NewmarkWindow::advance(std::int64_t window, const WindowState& last, WindowTrial& trial) {
  prepare(window, last, trial);
  const double quarter = 0.25 * dt_ * dt_;
  add_interface_force(trial.end.link);  // S du is in the operator
  if (link_in_root_) {
    root_rhs_ = factor_->root_rhs();
    for (const auto& [dof, root] : shared_roots_)
      root_rhs_[root] -= quarter * (trial.end.link[dof] - last.link[dof]);  // Delta P
  } else {
    rhs_with_link_ = rhs_;
    for (const int dof : parts_.shared_dofs) rhs_with_link_[dof] -= quarter * (trial.end.link[dof] - last.link[dof]);
    factor_->forward(rhs_with_link_);
    root_rhs_ = factor_->root_rhs();
  }
  solve_increment(trial);
  add_stiffness_force([&](std::size_t b, int dof) { return trial.increment[parts_.offsets[b] + dof]; }, trial.end.link);
  find_rates(trial);
  parts_.constrain_rates(clock_.time_s(window), dt_, last, trial);
}

/// Given increments of the constrained dofs, and what they push on the free ones: b_f -= dt^2/4 K_fc du_c.
void NewmarkWindow::constrain_increment(double time_s, WindowTrial& trial) {
  const double quarter = 0.25 * dt_ * dt_;
  for (std::size_t b = 0; b < parts_.states.size(); ++b) {
    for (const auto& c : parts_.states[b].constrained) {
      const double du = c.at(time_s) - parts_.states[b].u[c.dof];
      trial.increment[parts_.offsets[b] + c.dof] = du;
      if (du == 0.0) continue;
      for (fem::SparseMatrix::InnerIterator it(parts_.states[b].part.stiffness, c.dof); it; ++it)
        rhs_[parts_.offsets[b] + it.col()] -= quarter * it.value() * du;
    }
  }
}

/// contact_increment_ = A^-1 of forces on the contact's root dofs.
void NewmarkWindow::move_by(const Eigen::VectorXd& forces) {
  for (Eigen::Index i = 0; i < forces.size(); ++i)
    contact_force_[contact_->root_dofs()[static_cast<std::size_t>(i)]] = forces[i];
  factor_->forward(contact_force_);
  factor_->backward(root_increment_, contact_increment_);
}

/// The increment without contact forces first, then what they add to it.
void NewmarkWindow::solve_contact_outside_root(WindowTrial& trial) {
  factor_->backward(root_increment_, trial.increment);
  contact_->solve(parts_.states, trial.increment);
  if (!contact_->any_force()) return;
  move_by(contact_->root_force());
  trial.increment.noalias() += (contact_->kappa() * 0.25 * dt_ * dt_) * contact_increment_;
}

void NewmarkWindow::solve_increment(WindowTrial& trial) {
  root_increment_.noalias() = factor_->root_inverse() * root_rhs_;
  if (!contact_in_root_) {
    solve_contact_outside_root(trial);
    return;
  }
  if (contact_) {
    const auto& root = contact_->root_dofs();
    for (std::size_t i = 0; i < root.size(); ++i)
      trial.increment[root[i]] = root_increment_[static_cast<Eigen::Index>(i)];
    contact_->solve(parts_.states, trial.increment);
    const double scale = contact_->kappa() * 0.25 * dt_ * dt_;
    root_force_ = scale * contact_->root_force();
    solver::add_product(factor_->root_inverse(), root_force_, root_increment_);
  }
  factor_->backward(root_increment_, trial.increment);
}

/// a*, v* and q of the class comment; the velocity and acceleration of closed pairs.
void NewmarkWindow::find_rates(WindowTrial& trial) {
  const double dt = dt_;
  for (std::size_t b = 0; b < parts_.states.size(); ++b) {
    const auto& state = parts_.states[b];
    auto a = parts_.segment(trial.acceleration, b);
    a = (4.0 / (dt * dt)) * (parts_.segment(trial.increment, b) - dt * state.v) - state.a;
    parts_.segment(trial.velocity, b) = fem::corrected_velocity(state.v, state.a, a, dt);
    parts_.segment(trial.end.residual, b) = state.mass.cwiseProduct(a);
  }
  if (contact_) find_contact_rates(trial);
  set_dashpot_forces(trial);
}

/// Takes the contact forces out of q (and, where the law does not remember them, out of a), then applies Eq. 25.
void NewmarkWindow::find_contact_rates(WindowTrial& trial) {
  const Eigen::VectorXd& force = contact_->root_force();
  for (std::size_t i = 0; i < roots_.size(); ++i) {
    const auto& [dof, part, local] = roots_[i];
    const auto& state = parts_.states[part];
    const double applied = contact_->kappa() * force[static_cast<Eigen::Index>(i)];
    trial.end.residual[dof] -= applied;
    if (state.mass[local] == 0.0) {  // massless: it has no rates of its own
      trial.velocity[dof] = trial.increment[dof] / dt_;
      trial.acceleration[dof] = 0.0;
    }
    mean_velocity_[dof] = trial.velocity[dof];
    if (!contact_->remembered()) trial.acceleration[dof] = trial.end.residual[dof] * state.inverse_mass[local];
  }
  contact_->update_rates(parts_.states, trial.increment, trial.velocity, trial.acceleration);
  for (const auto& root : roots_)
    mean_velocity_[root.dof] = 0.5 * (mean_velocity_[root.dof] + trial.velocity[root.dof]);
}

/// The dashpots' forces at n + 1 join f.
void NewmarkWindow::set_dashpot_forces(WindowTrial& trial) const {
  for (std::size_t b = 0; b < parts_.states.size(); ++b) {
    for (std::size_t i = 0; i < parts_.states[b].dashpots.size(); ++i) {
      const auto& d = parts_.states[b].dashpots[i];
      const auto dof = parts_.offsets[b] + d.dof;
      trial.end.external[dof] = dashpot_load_[b][i] + d.force(trial.velocity[dof]);
    }
  }
}

void NewmarkWindow::account(const WindowTrial& trial) {
  if (contact_) contact_->account(parts_.states, trial.increment, mean_velocity_);
}

}  // namespace ricochet::implicit_solver

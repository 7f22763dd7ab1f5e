#include "explicit_solver/reduced/reduced_part.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "common/base/error.hpp"

namespace ricochet::explicit_solver {
namespace {

/// Per degree of freedom, 0 where a support holds it or a hanging node has none.
Eigen::VectorXd mass_of(const solver::BodyState& state) {
  const int components = fem::components(state.part.mesh.model);
  Eigen::VectorXd mass(state.part.dofs());
  for (int dof = 0; dof < mass.size(); ++dof) mass[dof] = state.part.lumped_mass[dof / components];
  for (const auto& c : state.constrained) mass[c.dof] = 0.0;
  return mass;
}

/// Modes of a part: no more than leave its shared degrees of freedom a flexibility of their own. `check` says so, too.
int enough_of(const solver::BodyState& state, int modes) {
  const auto free = static_cast<int>((mass_of(state).array() > 0.0).count());
  if (modes + std::ssize(state.shared_dofs) <= free) return modes;
  throw ConfigError(fmt::format(
      "partition.reduced_modes.{}: found {}; allowed: at most {}, of {} degrees of freedom less the {} that are shared",
      state.name, modes, free - std::ssize(state.shared_dofs), free, state.shared_dofs.size()));
}

/// Columns of a solve: enough for a fast one, few enough for any memory.
constexpr Eigen::Index at_once = 64;

/// Relative errors of displacements that forces of the window to come are found from, and of those that are looked at.
constexpr double solved = 1e-12, shown = 1e-5;

/// E/rho over the square of the part's diagonal [1/s^2].
double scale_of(const fem::Part& part) {
  Eigen::Vector3d low = part.mesh.position.front(), high = low;
  for (const Eigen::Vector3d& x : part.mesh.position) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  return part.material.youngs_modulus_pa / part.material.density_kg_m3 / (high - low).squaredNorm();
}

/// Rows of K: the forces of supports.
fem::SparseMatrix rows_of(const fem::SparseMatrix& stiffness, const std::vector<solver::ConstrainedDof>& supports) {
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t i = 0; i < supports.size(); ++i)
    for (fem::SparseMatrix::InnerIterator it(stiffness, supports[i].dof); it; ++it)
      entries.emplace_back(static_cast<int>(i), it.col(), it.value());
  fem::SparseMatrix rows(static_cast<Eigen::Index>(supports.size()), stiffness.cols());
  rows.setFromTriplets(entries.begin(), entries.end());
  return rows;
}

/// Share of what is left beside the modes. Below, they are all there is of some motion of the shared nodes, and forces
/// against the rest of it would be round-off.
constexpr double least_rcond = 1e-11;

/// Forces at the interface hardly reach supports: a P = a (D V)(V^T D^-1 P) of both matrices, V with few columns, D
/// those forces that have one energy each.
struct Seen {
  Eigen::MatrixXd columns, forces;  ///< D V and D^-1 V

  Seen(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b, const Eigen::VectorXd& flexibility) {
    constexpr double least = 1e-14;  // share of the largest square
    const Eigen::VectorXd root = flexibility.cwiseSqrt();
    const auto square = [&](const Eigen::MatrixXd& m) -> Eigen::MatrixXd {
      const Eigen::MatrixXd scaled = m * root.cwiseInverse().asDiagonal();
      const Eigen::MatrixXd all = scaled.transpose() * scaled;
      return all.trace() > 0.0 ? Eigen::MatrixXd(all / all.trace()) : all;
    };
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> squares(square(a) + square(b));
    const auto& values = squares.eigenvalues();
    Eigen::Index kept = 0;
    while (kept < values.size() && values[values.size() - 1 - kept] > least * values.tail(1).value()) ++kept;
    const Eigen::MatrixXd vectors = squares.eigenvectors().rightCols(kept);
    columns = root.cwiseInverse().asDiagonal() * vectors;
    forces = root.asDiagonal() * vectors;
  }
};

/// (axis, first, second) in cyclic order: (a x b) along the axis is a_first b_second - a_second b_first.
struct Axis {
  explicit Axis(int axis) : first((axis + 1) % 3), second((axis + 2) % 3) {}
  int first, second;
};

}  // namespace

ReducedPart::ReducedPart(const solver::BodyState& state, int modes, std::vector<int> probed)
    : state_(state),
      lowest_(state.part.stiffness, mass_of(state), enough_of(state, modes), scale_of(state.part)),
      probed_(std::move(probed)) {
  const auto size = static_cast<Eigen::Index>(state.shared_dofs.size());
  const int components = fem::components(state.part.mesh.model);
  at_boundary_ = at_shared(lowest_.shapes());
  flexibility_.resize(size, size);
  const fem::SparseMatrix support_rows = rows_of(state.part.stiffness, state.constrained);
  Eigen::MatrixXd force(support_rows.rows(), modes + size), moved(components * support_rows.rows(), modes + size);
  const auto take_supports = [&](const Eigen::MatrixXd& u, Eigen::Index first) {
    force.middleCols(first, u.cols()) = support_rows * u;
    for (Eigen::Index i = 0; i < support_rows.rows(); ++i) {
      const int dof = state.constrained[static_cast<std::size_t>(i)].dof;
      moved.block(components * i, first, components, u.cols()) = u.middleRows(dof - dof % components, components);
    }
  };
  take_supports(lowest_.shapes(), 0);
  probed_of_z_.resize(static_cast<Eigen::Index>(probed_.size()), modes + size);
  probed_of_z_.leftCols(modes) = lowest_.shapes()(probed_, Eigen::all);
  for (Eigen::Index first = 0; first < size; first += at_once) {
    const Eigen::Index count = std::min(at_once, size - first);
    Eigen::MatrixXd forces = Eigen::MatrixXd::Zero(state.part.dofs(), count);
    for (Eigen::Index i = 0; i < count; ++i) forces(state.shared_dofs[static_cast<std::size_t>(first + i)], i) = 1.0;
    const Eigen::MatrixXd u = lowest_.others(forces, solved);
    flexibility_.middleCols(first, count) = at_shared(u);
    take_supports(u, modes + first);
    probed_of_z_.middleCols(modes + first, count) = u(probed_, Eigen::all);
  }
  flexibility_ = (0.5 * (flexibility_ + flexibility_.transpose())).eval();
  rest_.compute(flexibility_);
  if (rest_.info() != Eigen::Success || !(rest_.rcond() > least_rcond))
    throw SolverError(
        fmt::format("body '{}': its {} modes leave its shared nodes no flexibility of their own; ask for fewer, or "
                    "for none: it has {} unknowns",
                    state.name, modes, state.part.dofs()));
  set_momenta();
  set_supports(force, moved);
  motion_.force.setZero(size);
  motion_.u.setZero(size);
  motion_.q.setZero(modes);
  motion_.rate = lowest_.momenta().transpose() * state.v;
  trial_ = motion_;
}

Eigen::MatrixXd ReducedPart::at_shared(const Eigen::MatrixXd& u) const { return u(state_.shared_dofs, Eigen::all); }

void ReducedPart::set_momenta() {
  const int components = fem::components(state_.part.mesh.model);
  const Eigen::MatrixXd momenta = lowest_.momenta();
  momentum_.setZero(modes(), 3);
  moment_.setZero(modes(), 3);
  for (int dof = 0; dof < state_.part.dofs(); ++dof) {
    const Eigen::Vector3d along = Eigen::Vector3d::Unit(dof % components);
    momentum_ += momenta.row(dof).transpose() * along.transpose();
    const Eigen::Vector3d x = state_.place_of(dof, [](int) { return 0.0; });
    moment_ += momenta.row(dof).transpose() * x.cross(along).transpose();
    if (dof % components == 0) mass_kg_ += state_.part.lumped_mass[dof / components];
  }
  if (state_.place.size() == 0) return;  // a bar and a body of revolution have no angular momentum
  for (int axis = components == 3 ? 0 : 2; axis < 3; ++axis) {
    const auto [first, second] = Axis(axis);
    const auto along = [&](const Eigen::MatrixXd& all, int component) -> Eigen::MatrixXd {
      return all(Eigen::seq(component, Eigen::last, components), Eigen::all);
    };
    Eigen::MatrixXd product = along(lowest_.shapes(), first).transpose() * along(momenta, second);
    product -= along(lowest_.shapes(), second).transpose() * along(momenta, first);
    products_.push_back(std::move(product));
  }
}

void ReducedPart::set_supports(const Eigen::MatrixXd& force, const Eigen::MatrixXd& moved) {
  if (force.rows() == 0) return;
  const int components = fem::components(state_.part.mesh.model);
  supports_.force.setZero(force.cols(), 3);
  supports_.moment.setZero(force.cols(), 3);
  for (Eigen::Index i = 0; i < force.rows(); ++i) {
    const int dof = state_.constrained[static_cast<std::size_t>(i)].dof;
    const Eigen::Vector3d along = Eigen::Vector3d::Unit(dof % components);
    supports_.force += force.row(i).transpose() * along.transpose();
    const Eigen::Vector3d x = state_.place_of(dof, [](int) { return 0.0; });
    supports_.moment += force.row(i).transpose() * x.cross(along).transpose();
  }
  if (products_.empty()) return;
  const auto size = flexibility_.rows();
  const Seen seen(force.rightCols(size), moved.rightCols(size), flexibility_.diagonal());
  supports_.seen = seen.forces;
  const auto of_few = [&](const Eigen::MatrixXd& all) {
    Eigen::MatrixXd few(all.rows(), modes() + seen.columns.cols());
    few << all.leftCols(modes()), all.rightCols(size) * seen.columns;
    return few;
  };
  for (std::size_t p = 0; p < products_.size(); ++p) {
    const auto [first, second] = Axis(static_cast<int>(3 - products_.size() + p));
    Eigen::MatrixXd arm = Eigen::MatrixXd::Zero(force.rows(), force.cols());  // of the force of each support
    for (Eigen::Index i = 0; i < force.rows(); ++i) {
      const int component = state_.constrained[static_cast<std::size_t>(i)].dof % components;
      if (component == second) arm.row(i) = moved.row(components * i + first);
      if (component == first) arm.row(i) = -moved.row(components * i + second);
    }
    supports_.moved.emplace_back(of_few(force).transpose() * of_few(arm));
  }
}

void ReducedPart::set_step(double dt) {
  dt_ = dt;
  const double quarter = 0.25 * dt * dt;
  share_ = (quarter / (1.0 + quarter * omega_squared().array())).matrix();
  const Eigen::MatrixXd compliance = flexibility_ + at_boundary_ * share_.asDiagonal() * at_boundary_.transpose();
  stiffness_ = compliance.llt().solve(Eigen::MatrixXd::Identity(compliance.rows(), compliance.rows()));
  stiffness_ = (0.5 * (stiffness_ + stiffness_.transpose())).eval();
}

void ReducedPart::synchronise(const Eigen::VectorXd& u_b) {
  motion_.u = u_b;
  motion_.force = rest_.solve(motion_.u - at_boundary_ * motion_.q);
}

Eigen::VectorXd ReducedPart::acceleration(const Motion& motion) const {
  return at_boundary_.transpose() * motion.force - omega_squared().cwiseProduct(motion.q);
}

void ReducedPart::advance(const Eigen::VectorXd& u_b) {
  trial_.u = u_b;
  const double quarter = 0.25 * dt_ * dt_;
  const Eigen::VectorXd before = acceleration(motion_);
  // q* (1 + omega^2 dt^2/4) = q + dt q' + dt^2/4 q''
  trial_.q = (motion_.q + dt_ * motion_.rate + quarter * before).cwiseProduct(share_) / quarter;
  trial_.force.noalias() = stiffness_ * (trial_.u - at_boundary_ * trial_.q);
  trial_.q += share_.cwiseProduct(at_boundary_.transpose() * trial_.force);
  trial_.rate = motion_.rate + 0.5 * dt_ * (before + acceleration(trial_));
}

void ReducedPart::accept(BodyTotals& totals) {
  totals.energy_interface_j += 0.5 * (motion_.force + trial_.force).dot(trial_.u - motion_.u);
  if (!state_.constrained.empty()) book_supports(totals);
  std::swap(motion_, trial_);
}

/// Forces of the mean motion over the window, where that is.
void ReducedPart::book_supports(BodyTotals& totals) const {
  Eigen::VectorXd mean(motion_.q.size() + motion_.force.size());
  mean << 0.5 * (motion_.q + trial_.q), 0.5 * (motion_.force + trial_.force);
  const Eigen::Vector3d impulse = dt_ * (supports_.force.transpose() * mean);
  totals.impulse_n_kg_m_s += state_.normal.dot(impulse);
  totals.impulse_t_kg_m_s += state_.tangent.dot(impulse);
  totals.impulse_b_kg_m_s += state_.binormal.dot(impulse);
  Eigen::Vector3d angular = supports_.moment.transpose() * mean;
  if (!products_.empty()) {
    Eigen::VectorXd few(modes() + supports_.seen.cols());
    few << mean.head(modes()), supports_.seen.transpose() * mean.tail(motion_.force.size());
    for (std::size_t i = 0; i < products_.size(); ++i)
      angular[static_cast<Eigen::Index>(3 - products_.size() + i)] += few.dot(supports_.moved[i] * few);
  }
  totals.angular_impulse_x_kg_m2_s += dt_ * angular[0];
  totals.angular_impulse_y_kg_m2_s += dt_ * angular[1];
  totals.angular_impulse_z_kg_m2_s += dt_ * angular[2];
}

void ReducedPart::set_totals(BodyTotals& totals) const {
  totals.mass_kg = mass_kg_;
  const auto energy_of = [&](Eigen::Index last) {  // modes
    const auto q = motion_.q.tail(last), rate = motion_.rate.tail(last);
    return 0.5 * (rate.squaredNorm() + omega_squared().tail(last).dot(q.cwiseAbs2()));
  };
  totals.energy_highest_modes_j = energy_of((modes() + 9) / 10);
  totals.energy_kinetic_j = 0.5 * motion_.rate.squaredNorm();
  totals.energy_strain_j =
      0.5 * omega_squared().dot(motion_.q.cwiseAbs2()) + 0.5 * motion_.force.dot(motion_.u - at_boundary_ * motion_.q);
  const Eigen::Vector3d momentum = momentum_.transpose() * motion_.rate;
  totals.momentum_n_kg_m_s = state_.normal.dot(momentum);
  totals.momentum_t_kg_m_s = state_.tangent.dot(momentum);
  totals.momentum_b_kg_m_s = state_.binormal.dot(momentum);
  Eigen::Vector3d angular = moment_.transpose() * motion_.rate;
  for (std::size_t i = 0; i < products_.size(); ++i)
    angular[static_cast<Eigen::Index>(3 - products_.size() + i)] += motion_.q.dot(products_[i] * motion_.rate);
  totals.angular_momentum_x_kg_m2_s = angular[0];
  totals.angular_momentum_y_kg_m2_s = angular[1];
  totals.angular_momentum_z_kg_m2_s = angular[2];
}

void ReducedPart::write_motion(solver::BodyState& state) const {
  Eigen::VectorXd force = Eigen::VectorXd::Zero(state.part.dofs());
  for (std::size_t i = 0; i < state.shared_dofs.size(); ++i)
    force[state.shared_dofs[i]] = motion_.force[static_cast<Eigen::Index>(i)];
  state.u = lowest_.shapes() * motion_.q + lowest_.others(force, shown);
  state.v = lowest_.shapes() * motion_.rate;
  state.a = lowest_.shapes() * acceleration(motion_);
  state.move_hanging();
}

void ReducedPart::write_probed(solver::BodyState& state) const {
  if (probed_.empty()) return;
  const auto of_modes = probed_of_z_.leftCols(modes());
  state.u(probed_) = of_modes * motion_.q + probed_of_z_.rightCols(motion_.force.size()) * motion_.force;
  state.v(probed_) = of_modes * motion_.rate;
  state.a(probed_) = of_modes * acceleration(motion_);
}

void ReducedPart::load(const Eigen::VectorXd& q, const Eigen::VectorXd& rate) {
  motion_.q = q;
  motion_.rate = rate;
  motion_.force.setZero();
  motion_.u.setZero();
}

}  // namespace ricochet::explicit_solver

#include "implicit_solver/contact/implicit_contact.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "common/fem/element.hpp"
#include "common/solver/friction.hpp"

namespace ricochet::implicit_solver {

using scene::Enforcement;
using scene::ImpactUpdate;
using scene::MultiplierUpdate;
using solver::BodyState;
using solver::ContactRow;
using solver::ContactState;
using solver::Pair;
using solver::RowEntry;
using solver::Side;

namespace {
/// Solves that set-up may take, so that no window needs any for the contact problem: worth it after a tenth as many
/// windows, since a window without them takes some ten. Rows written by a mortar have many degrees of freedom each, too
/// many for the root, while the compliance of the rows themselves may be small enough for a solve each.
constexpr int most_solves = 800;
}  // namespace

ImplicitContact::ImplicitContact(const scene::Problem& problem, solver::ContactSurface surface,
                                 const std::vector<BodyState>& states)
    : problem_(&problem),
      law_(&problem.scene.contact_law()),
      friction_(problem.scene.friction()),
      surface_(std::move(surface)),
      shared_(surface_.askew || solver::share_nodes(surface_.pairs)) {
  if (solver::SlidingRows sliding(problem, states); sliding.any()) sliding_ = std::move(sliding);
  int offset = 0;
  for (const auto& state : states) {
    offsets_.push_back(offset);
    offset += state.part.dofs();
  }
  root_of_dof_.assign(static_cast<std::size_t>(offset), -1);
  for (const auto& pair : surface_.pairs) {
    std::vector<RowEntry> entries = pair.normal.entries;
    if (pair.friction_coefficient > 0.0) {
      entries.insert(entries.end(), pair.tangent.entries.begin(), pair.tangent.entries.end());
      entries.insert(entries.end(), pair.binormal.entries.begin(), pair.binormal.entries.end());
    }
    std::sort(entries.begin(), entries.end(),
              [](const RowEntry& x, const RowEntry& y) { return std::pair(x.side, x.dof) < std::pair(y.side, y.dof); });
    for (const auto& e : entries) add_root(e, states);
  }
  // Nodes that bodies slide to have a force in all directions that those of the start have one in.
  std::set<int> components;
  for (const auto& pair : surface_.pairs) {
    for (const auto* row : {&pair.normal, &pair.tangent, &pair.binormal}) {
      for (const auto& e : row->entries)
        if (row == &pair.normal || pair.friction_coefficient > 0.0) components.insert(e.dof % surface_.components);
    }
  }
  for (const auto& [part, node] : surface_.idle) {
    for (const int c : components) add_root({part, node * surface_.components + c}, states);
  }
  find_weights(states);
  impulse_.resize(surface_.pairs.size());
  state_.impulse = impulse_;
  state_.remembered = remembered_ = jump_impulse_ = impulse_;
  state_.impulses = surface_.no_impulses();
  report_ = surface_.empty_record();
}

bool ImplicitContact::is_free(const RowEntry& e, const std::vector<BodyState>& states) {
  return states[static_cast<std::size_t>(e.part)].free[static_cast<std::size_t>(e.dof)];
}

void ImplicitContact::add_root(const RowEntry& e, const std::vector<BodyState>& states) {
  int& root = root_of_dof_[static_cast<std::size_t>(combined(e))];
  if (root >= 0 || !is_free(e, states)) return;
  root = static_cast<int>(root_dofs_.size());
  root_dofs_.push_back(combined(e));
}

void ImplicitContact::find_weights(const std::vector<BodyState>& states) {
  weights_.clear();
  for (const auto& pair : surface_.pairs) {
    const auto weight = [&](const ContactRow& row, Side side) {
      double sum = 0.0;
      for (const auto& e : row.entries) {
        if (e.side == side && is_free(e, states)) sum += e.coefficient * e.coefficient;
      }
      return sum;
    };
    weights_.push_back({{{weight(pair.normal, Side::a), weight(pair.normal, Side::b)},
                         {weight(pair.tangent, Side::a), weight(pair.tangent, Side::b)},
                         {weight(pair.binormal, Side::a), weight(pair.binormal, Side::b)}}});
  }
}

double ImplicitContact::kappa() const {
  const bool fully_implicit =
      law_->enforcement == Enforcement::multiplier && law_->multiplier_update == MultiplierUpdate::fully_implicit;
  return fully_implicit ? 2.0 : 1.0;
}

bool ImplicitContact::massless() const { return law_->multiplier_update == MultiplierUpdate::massless; }

bool ImplicitContact::by_impedance() const {
  return law_->enforcement == Enforcement::penalty && law_->impact_update == ImpactUpdate::impedance;
}

/// Whether the law sets velocities and accelerations of closed pairs.
bool ImplicitContact::resets() const {
  return remembered() && !(law_->enforcement == Enforcement::penalty && law_->impact_update == ImpactUpdate::none);
}

void ImplicitContact::move_masses(std::vector<BodyState>& states) {
  if (massless()) massless_.emplace(surface_, states);
}

void ImplicitContact::settle(const std::vector<BodyState>& states, const std::vector<Eigen::VectorXd>& external,
                             std::vector<Eigen::VectorXd>& u) {
  external_of_part_.clear();
  u_of_part_.clear();
  for (std::size_t part = 0; part < u.size(); ++part) {
    external_of_part_.push_back(&external[part]);
    u_of_part_.push_back(&u[part]);
  }
  massless_->settle(states, external_of_part_, u_of_part_);
}

void ImplicitContact::set_massless_velocity(const Eigen::VectorXd& increment, Eigen::VectorXd& velocity) const {
  massless_->for_each_dof([&](std::size_t part, int dof) {
    const int at = offsets_[part] + dof;
    velocity[at] = increment[at] / dt_;
  });
}

void ImplicitContact::prepare(const Eigen::MatrixXd& root_inverse, double dt) {
  const Eigen::MatrixXd rows = gather();
  const Eigen::MatrixXd dense = (kappa() * 0.25 * dt * dt) * (rows * root_inverse * rows.transpose());
  if (sliding_) root_inverse_ = root_inverse;
  start(dense, dt);
}

/// G: the rows of all pairs, over the root dofs.
solver::Compliance::Sparse ImplicitContact::gather() const {
  const auto n = static_cast<Eigen::Index>(surface_.pairs.size());
  std::vector<Eigen::Triplet<double>> entries;
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index d = 0; d < directions(); ++d) {
      const auto& row = row_of(surface_.pairs[static_cast<std::size_t>(i)], static_cast<Direction>(d));
      for (const auto& e : row.entries) {
        const int column = root_of_dof_[static_cast<std::size_t>(combined(e))];
        if (column >= 0) entries.emplace_back(static_cast<int>(d * n + i), column, e.coefficient);
      }
    }
  }
  solver::Compliance::Sparse rows(directions() * n, static_cast<Eigen::Index>(root_dofs_.size()));
  rows.setFromTriplets(entries.begin(), entries.end());
  return rows;
}

void ImplicitContact::prepare(const std::vector<BodyState>& states, SolveFor solve, double dt) {
  dt_ = dt;
  const auto size = static_cast<int>(directions()) * static_cast<int>(surface_.pairs.size());
  const bool columns = !sliding_ && size <= most_solves;
  auto inverse = near_inverse(root_nodes(states), columns ? size : most_solves, solve);
  if (inverse) {
    near_inverse_.swap(*inverse);
    start(compliance_of_rows(), dt);
    if (!sliding_) near_inverse_ = {};
    return;
  }
  const double scale = kappa() * 0.25 * dt * dt;
  product_ = [this, scale, solve = std::move(solve), forces = Eigen::VectorXd(), motion = Eigen::VectorXd()](
                 const Eigen::VectorXd& x, Eigen::VectorXd& y) mutable {
    root_forces_of(x, forces);
    forces *= scale;
    solve(forces, motion);
    motion_of_pairs(motion, y);
  };
  if (columns) {
    start(columns_of_products(size), dt);
  } else {
    start({product_, bound_of_couplings(states)}, dt);
  }
}

/// The nodes of the root dofs.
std::vector<NearNode> ImplicitContact::root_nodes(const std::vector<BodyState>& states) const {
  std::map<std::pair<int, int>, NearNode> nodes;
  for (std::size_t i = 0; i < root_dofs_.size(); ++i) {
    int part = static_cast<int>(offsets_.size()) - 1;
    while (root_dofs_[i] < offsets_[static_cast<std::size_t>(part)]) --part;
    const int node = (root_dofs_[i] - offsets_[static_cast<std::size_t>(part)]) / surface_.components;
    const auto& positions = states[static_cast<std::size_t>(part)].part.mesh.position;
    NearNode& found =
        nodes.try_emplace({part, node}, NearNode{positions[static_cast<std::size_t>(node)], part, {}}).first->second;
    found.dofs.push_back(static_cast<int>(i));
  }
  std::vector<NearNode> listed;
  for (auto& [key, node] : nodes) listed.push_back(std::move(node));
  return listed;
}

Eigen::MatrixXd ImplicitContact::columns_of_products(Eigen::Index size) const {
  Eigen::MatrixXd columns(size, size);
  Eigen::VectorXd column(size);
  for (Eigen::Index j = 0; j < size; ++j) {
    product_(Eigen::VectorXd::Unit(size, j), column);
    columns.col(j) = column;
  }
  return 0.5 * (columns + columns.transpose());
}

/// No less than the compliance, on its diagonal.
Eigen::VectorXd ImplicitContact::bound_of_couplings(const std::vector<BodyState>& states) const {
  const auto n = static_cast<Eigen::Index>(surface_.pairs.size());
  const double scale = kappa() * 0.25 * dt_ * dt_;
  Eigen::VectorXd bound(directions() * n);
  for (Eigen::Index d = 0; d < directions(); ++d)
    bound.segment(d * n, n) = scale * sums_of_couplings(states, static_cast<Direction>(d));
  return bound;
}

/// Per pair the sum of the magnitudes in its row of N M^-1 N^T: a diagonal of these is no less than that matrix.
Eigen::VectorXd ImplicitContact::sums_of_couplings(const std::vector<BodyState>& states, Direction direction) const {
  Eigen::VectorXd of_dof = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(root_of_dof_.size()));
  for (const auto& pair : surface_.pairs) {
    for (const auto& e : row_of(pair, direction).entries) of_dof[combined(e)] += std::abs(e.coefficient);
  }
  Eigen::VectorXd sums = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(surface_.pairs.size()));
  for (std::size_t i = 0; i < surface_.pairs.size(); ++i) {
    for (const auto& e : row_of(surface_.pairs[i], direction).entries) {
      sums[static_cast<Eigen::Index>(i)] +=
          std::abs(e.coefficient) * of_dof[combined(e)] * states[static_cast<std::size_t>(e.part)].inverse_mass[e.dof];
    }
  }
  return sums;
}

void ImplicitContact::start(solver::Compliance compliance, double dt) {
  dt_ = dt;
  set_root(std::move(compliance));
  trial_ = state_.solution = root_->open();
}

void ImplicitContact::set_root(solver::Compliance compliance) {
  const auto n = static_cast<Eigen::Index>(surface_.pairs.size());
  std::vector<solver::RootProblem::PairLaw> pairs;
  for (const auto& pair : surface_.pairs) pairs.push_back({pair.area_m2, pair.friction_coefficient});
  root_.emplace(*law_, std::move(compliance), std::move(pairs), dt_);
  gap_free_.setZero(n);
  const Eigen::Index along = std::max<Eigen::Index>(1, surface_.components - 1);
  slip_free_.setZero(along * n);
  slip_velocity_.setZero(along * n);
  root_force_.setZero(static_cast<Eigen::Index>(root_dofs_.size()));
}

/// G^T x per root dof.
void ImplicitContact::root_forces_of(const Eigen::VectorXd& x, Eigen::VectorXd& forces) const {
  const auto n = static_cast<Eigen::Index>(surface_.pairs.size());
  forces.setZero(static_cast<Eigen::Index>(root_dofs_.size()));
  const auto push = [&](const ContactRow& row, double force) {
    for (const auto& e : row.entries) {
      const int root = root_of_dof_[static_cast<std::size_t>(combined(e))];
      if (root >= 0) forces[root] += e.coefficient * force;
    }
  };
  for (std::size_t i = 0; i < surface_.pairs.size(); ++i) {
    for (Eigen::Index d = 0; d < directions(); ++d)
      push(row_of(surface_.pairs[i], static_cast<Direction>(d)), x[d * n + static_cast<Eigen::Index>(i)]);
  }
}

/// G times the motion of the root dofs.
void ImplicitContact::motion_of_pairs(const Eigen::VectorXd& motion, Eigen::VectorXd& y) const {
  const auto n = static_cast<Eigen::Index>(surface_.pairs.size());
  const auto times = [&](const ContactRow& row) {
    double sum = 0.0;
    for (const auto& e : row.entries) {
      const int root = root_of_dof_[static_cast<std::size_t>(combined(e))];
      if (root >= 0) sum += e.coefficient * motion[root];
    }
    return sum;
  };
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index d = 0; d < directions(); ++d)
      y[d * n + i] = times(row_of(surface_.pairs[static_cast<std::size_t>(i)], static_cast<Direction>(d)));
  }
}

/// Relative displacements at the end of the window without contact forces, from zero, of held pairs.
void ImplicitContact::find_moved(const std::vector<BodyState>& states, const Eigen::VectorXd& increment) {
  for (std::size_t i = 0; i < surface_.pairs.size(); ++i) {
    const auto& pair = surface_.pairs[i];
    const auto moved = [&](const ContactRow& row) {
      return row.times(displacement_of(states)) + row.times(of_part(increment));
    };
    gap_free_[static_cast<Eigen::Index>(i)] = moved(pair.normal);
    slip_free_[static_cast<Eigen::Index>(i)] = moved(pair.tangent);
    if (surface_.components == 3) slip_free_[gap_free_.size() + static_cast<Eigen::Index>(i)] = moved(pair.binormal);
  }
}

/// With a penalty the force of the present gap is part of the acceleration that the law remembers; a multiplier either
/// is not remembered or cancels in the mean.
void ImplicitContact::hold_rates(const std::vector<BodyState>& states, Eigen::VectorXd& velocity,
                                 Eigen::VectorXd& acceleration) {
  find_moved(states, Eigen::VectorXd::Zero(velocity.size()));
  trial_ = root_->spring(gap_free_, slip_free_);
  root_forces_of(trial_.force, root_force_);
  for (std::size_t i = 0; i < root_dofs_.size(); ++i) {
    std::size_t part = offsets_.size() - 1;
    while (root_dofs_[i] < offsets_[part]) --part;
    acceleration[root_dofs_[i]] +=
        root_force_[static_cast<Eigen::Index>(i)] * states[part].inverse_mass[root_dofs_[i] - offsets_[part]];
  }
  hold_means(states, velocity, acceleration);
}

void ImplicitContact::solve(const std::vector<BodyState>& states, const Eigen::VectorXd& increment) {
  if (frozen_) {
    if (held()) find_moved(states, increment);
    trial_ = held() ? root_->hold(gap_free_, slip_free_) : root_->open();
    root_forces_of(trial_.force, root_force_);
    return;
  }
  follow(states);
  if (surface_.pairs.empty()) {  // the bodies have slid off each other
    trial_ = root_->open();
    root_force_.setZero();
    return;
  }
  for (std::size_t i = 0; i < surface_.pairs.size(); ++i) {
    const auto& pair = surface_.pairs[i];
    const auto k = static_cast<Eigen::Index>(i);
    gap_free_[k] = pair.gap(displacement_of(states)) + pair.normal.times(of_part(increment));
    if (!friction_) continue;
    slip_free_[k] = pair.tangent.times(of_part(increment));
    slip_velocity_[k] = pair.tangent.times(velocity_of(states));
    if (surface_.components < 3) continue;
    slip_free_[gap_free_.size() + k] = pair.binormal.times(of_part(increment));
    slip_velocity_[gap_free_.size() + k] = pair.binormal.times(velocity_of(states));
  }
  trial_ = root_->solve(gap_free_, slip_free_, slip_velocity_, state_.solution);
  solver::require_solved(trial_);
  root_forces_of(trial_.force, root_force_);
}

ImplicitContact::Mean ImplicitContact::mean_shares(const Pair& pair, const std::vector<BodyState>& states,
                                                   Direction direction) const {
  const auto& row = row_of(pair, direction);
  const double wa = row.inverse_mass_of(Side::a, states), wb = row.inverse_mass_of(Side::b, states);
  if (wa + wb == 0.0) return {0.0, 0.0};
  if (!by_impedance() || wa == 0.0 || wb == 0.0) return {wa / (wa + wb), wb / (wa + wb)};
  // Eq. 25-27: weights rho C, longitudinal along n, shear along the surface
  const auto impedance = [&](int part) {
    const auto& body = problem_->bodies[static_cast<std::size_t>(states[static_cast<std::size_t>(part)].body)];
    const double speed = direction == along_normal ? fem::longitudinal_wave_speed(problem_->scene.model, body.material)
                                                   : fem::shear_wave_speed(body.material);
    return body.material.density_kg_m3 * speed;
  };
  const double za = impedance(row.part_of(Side::a)), zb = impedance(row.part_of(Side::b));
  return {zb / (za + zb), za / (za + zb)};
}

/// Takes the relative rate away by what is an impulse on each side, M^-1 N^T times a number: A moves by its share of
/// it, B by its own the other way.
void ImplicitContact::set_mean(const Pair& pair, const std::vector<BodyState>& states, Direction direction,
                               Eigen::VectorXd& values) const {
  const auto& row = row_of(pair, direction);
  const double difference = row.times(of_part(values));
  const Mean share = mean_shares(pair, states, direction);
  const double inverse_a = row.inverse_mass_of(Side::a, states), inverse_b = row.inverse_mass_of(Side::b, states);
  for (const auto& e : row.entries) {
    const double side_share = e.side == Side::a ? share.share_a : share.share_b;
    if (side_share == 0.0) continue;
    const double inverse = states[static_cast<std::size_t>(e.part)].inverse_mass[e.dof];
    const double weight = inverse / (e.side == Side::a ? inverse_a : inverse_b);
    values[combined(e)] -= side_share * difference * e.coefficient * weight;
  }
}

/// Adds M^-1 times a force or impulse on B, and its opposite on A, to accelerations or velocities.
void ImplicitContact::push(const Pair& pair, const std::vector<BodyState>& states, Direction direction, double on_b,
                           Eigen::VectorXd& values) const {
  row_of(pair, direction).push(on_b, states, of_part(values));
}

/// The number p of forces N^T p, from those on one side's free degrees of freedom.
double ImplicitContact::force_on(Side side, std::size_t pair, Direction direction,
                                 const Eigen::VectorXd& forces) const {
  const double weight = weights_[pair][direction][side == Side::a ? 0 : 1];
  return weight > 0.0 ? row_of(surface_.pairs[pair], direction).of(side, of_part(forces)) / weight : 0.0;
}

/// What a pair's forces are on B, the mean of it and of the opposite on A: the two differ where Eq. 25 weighs by
/// impedances. A side that a support holds counts for nothing.
double ImplicitContact::mean_of_sides(std::size_t pair, Direction direction, double on_a, double on_b) const {
  const auto& [weight_a, weight_b] = weights_[pair][direction];
  return weight_a > 0.0 && weight_b > 0.0 ? 0.5 * (on_b - on_a) : on_b - on_a;
}

double ImplicitContact::on_b(std::size_t pair, Direction direction, const Eigen::VectorXd& forces) const {
  return mean_of_sides(pair, direction, force_on(Side::a, pair, direction, forces),
                       force_on(Side::b, pair, direction, forces));
}

/// `on_b` of M times rates.
double ImplicitContact::mass_times(std::size_t pair, const std::vector<BodyState>& states, Direction direction,
                                   const Eigen::VectorXd& rates) const {
  const auto& [weight_a, weight_b] = weights_[pair][direction];
  double on_a = 0.0, on_b = 0.0;
  for (const auto& e : row_of(surface_.pairs[pair], direction).entries) {
    const auto& state = states[static_cast<std::size_t>(e.part)];
    if (!state.free[static_cast<std::size_t>(e.dof)]) continue;
    const double force = e.coefficient * state.mass[e.dof] * rates[combined(e)];
    if (e.side == Side::a) {
      on_a -= force / weight_a;
    } else {
      on_b += force / weight_b;
    }
  }
  return mean_of_sides(pair, direction, on_a, on_b);
}

/// Velocities and accelerations of held pairs: linear, whatever the sign of a force. Of pairs that share nodes each
/// moves the others: once more for as long as any moves.
void ImplicitContact::hold_means(const std::vector<BodyState>& states, Eigen::VectorXd& velocity,
                                 Eigen::VectorXd& acceleration) const {
  if (!resets()) return;
  const auto sweep = [&](Eigen::VectorXd& values) {
    for (const auto& pair : surface_.pairs) {
      for (Eigen::Index d = 0; d < directions(pair); ++d) set_mean(pair, states, static_cast<Direction>(d), values);
    }
  };
  for (auto* values : {&velocity, &acceleration}) {
    sweep(*values);
    Eigen::VectorXd before;
    for (int n = 0; shared_ && n < solver::most_sweeps; ++n) {
      before = *values;
      sweep(*values);
      if ((*values - before).norm() <= solver::settled_share * values->norm()) break;
    }
  }
}

/// The forces of the trial that its acceleration remembers, before velocities are reset.
solver::PairForce ImplicitContact::trial_memory(std::size_t i) const {
  if (!remembered()) return {};
  return {.normal = trial_.force[static_cast<Eigen::Index>(i)], .tangential = along_surface(i, trial_.force)};
}

/// No relative velocity is left, and no relative acceleration unless that took a pull.
void ImplicitContact::reset_normal(std::size_t i, const std::vector<BodyState>& states, Eigen::VectorXd& velocity,
                                   Eigen::VectorXd& acceleration) {
  const auto& pair = surface_.pairs[i];
  const double before = mass_times(i, states, along_normal, velocity);
  set_mean(pair, states, along_normal, velocity);
  impulse_[i].normal += mass_times(i, states, along_normal, velocity) - before;
  const double force = trial_.force[static_cast<Eigen::Index>(i)];
  const double without = mass_times(i, states, along_normal, acceleration) - force;
  set_mean(pair, states, along_normal, acceleration);
  double& remembered = remembered_[i].normal;
  remembered = mass_times(i, states, along_normal, acceleration) - without;
  if (remembered >= 0.0 || by_impedance()) return;
  push(pair, states, along_normal, -remembered, acceleration);
  remembered = 0.0;
}

Eigen::Vector2d ImplicitContact::along_surface(std::size_t i, const Eigen::VectorXd& values) const {
  const auto n = static_cast<Eigen::Index>(surface_.pairs.size()), k = static_cast<Eigen::Index>(i);
  return {directions() > 1 ? values[n + k] : 0.0, directions() > 2 ? values[2 * n + k] : 0.0};
}

/// The impulse along the surface of a closed pair of which `impulse` is what it got so far and `rate` its relative
/// velocity then: what holds it, clipped to the cone of the normal impulse.
ImplicitContact::Friction ImplicitContact::friction_impulse(const Pair& pair, const Eigen::Matrix2d& inverse,
                                                            const solver::PairForce& impulse,
                                                            const Eigen::Vector2d& rate) const {
  Friction friction;
  friction.limit = pair.friction_coefficient * std::max(0.0, impulse.normal);
  Eigen::Vector2d free_rate;
  for (int k = 0; k < 2; ++k) free_rate[k] = rate[k] - inverse(k, k) * impulse.tangential[k];
  const Eigen::Vector2d holding = solver::holding_of_pair(inverse, free_rate);
  friction.given = solver::friction_of_pair(*law_, friction.limit, free_rate, holding, inverse);
  friction.sticks = friction.given == holding;
  return friction;
}

/// The force that the acceleration then remembers, likewise: `force` is in it, and leaves the relative acceleration
/// `rate`.
Eigen::Vector2d ImplicitContact::remembered_friction(const Pair& pair, const Friction& friction,
                                                     const Eigen::Matrix2d& inverse, double normal_n,
                                                     const Eigen::Vector2d& force, const Eigen::Vector2d& rate) {
  const double limit = pair.friction_coefficient * std::max(0.0, normal_n);
  if (friction.sticks) return solver::clip_to_cone(force + solver::holding_of_pair(inverse, rate), limit);
  if (!(friction.limit > 0.0)) return Eigen::Vector2d::Zero();
  return limit * friction.given / friction.limit;
}

/// Friction by impulses, and the remembered force. With impedances the two sides' own means, not an impulse.
void ImplicitContact::reset_tangent(std::size_t i, const std::vector<BodyState>& states, Eigen::VectorXd& velocity,
                                    Eigen::VectorXd& acceleration) {
  const auto& pair = surface_.pairs[i];
  const Eigen::Matrix2d inverse = pair.inverse_mass_along(states);
  if (inverse.isZero(0.0)) return;
  auto& impulse = impulse_[i];
  const Friction friction = friction_impulse(pair, inverse, impulse, pair.slip(of_part(velocity)));
  const auto set_means = [&](Eigen::VectorXd& values) {
    for (Eigen::Index d = 1; d < directions(); ++d) set_mean(pair, states, static_cast<Direction>(d), values);
  };
  if (friction.sticks && by_impedance()) {
    const auto momentum = [&] {
      Eigen::Vector2d sum(0.0, 0.0);
      for (Eigen::Index d = 1; d < directions(); ++d)
        sum[d - 1] = mass_times(i, states, static_cast<Direction>(d), velocity);
      return sum;
    };
    const Eigen::Vector2d before = momentum();
    set_means(velocity);
    impulse.tangential += momentum() - before;
  } else {
    pair.push_along(friction.given - impulse.tangential, states, of_part(velocity));
    impulse.tangential = friction.given;
  }
  impulse.state = friction.sticks ? ContactState::stick : ContactState::slip;
  const Eigen::Vector2d force = along_surface(i, trial_.force), rate = pair.slip(of_part(acceleration));
  const Eigen::Vector2d remembered = remembered_friction(pair, friction, inverse, remembered_[i].normal, force, rate);
  remembered_[i].tangential = remembered;
  if (friction.sticks && by_impedance() && remembered == force + solver::holding_of_pair(inverse, rate)) {
    set_means(acceleration);
  } else {
    pair.push_along(remembered - force, states, of_part(acceleration));
  }
}

/// A pair that opened in this window: what is left of its impulses stays within the cone, too.
void ImplicitContact::clip_tangent(std::size_t i, const std::vector<BodyState>& states, Eigen::VectorXd& velocity) {
  auto& impulse = impulse_[i];
  const auto& pair = surface_.pairs[i];
  const double limit = pair.friction_coefficient * std::max(0.0, impulse.normal);
  const Eigen::Vector2d given = solver::clip_to_cone(impulse.tangential, limit);
  if (given == impulse.tangential) return;
  pair.push_along(given - impulse.tangential, states, of_part(velocity));
  impulse.tangential = given;
}

void ImplicitContact::update_rates(const std::vector<BodyState>& states, const Eigen::VectorXd& bracket,
                                   const Eigen::VectorXd& increment, Eigen::VectorXd& velocity,
                                   Eigen::VectorXd& acceleration) {
  if (shared_) {
    update_shared(states, velocity, acceleration);
    return;
  }
  for (std::size_t i = 0; i < surface_.pairs.size(); ++i) {
    impulse_[i] = {.normal = 0.5 * dt_ * on_b(i, along_normal, bracket), .state = trial_.states[i]};
    for (Eigen::Index d = 1; d < directions(surface_.pairs[i]); ++d)
      impulse_[i].tangential[d - 1] = 0.5 * dt_ * on_b(i, static_cast<Direction>(d), bracket);
    remembered_[i] = trial_memory(i);
    const bool touched = trial_.states[i] != ContactState::open || state_.solution.states[i] != ContactState::open;
    if (!touched) impulse_[i] = {};  // but for the rounding of the bracket
  }
  if (frozen_) {
    if (held()) hold_means(states, velocity, acceleration);
    return;
  }
  if (massless_) give_back(states, bracket, increment, velocity);
  if (!resets()) return;
  for (std::size_t i = 0; i < surface_.pairs.size(); ++i) {
    const bool closed = trial_.states[i] != ContactState::open;
    if (closed && !massless_) reset_normal(i, states, velocity, acceleration);
    if (surface_.pairs[i].friction_coefficient == 0.0) continue;
    if (closed) {
      reset_tangent(i, states, velocity, acceleration);
    } else {
      clip_tangent(i, states, velocity);
    }
  }
}

/// The energy that closing and opening made in this window, back to the nodes that carry the mass.
void ImplicitContact::give_back(const std::vector<BodyState>& states, const Eigen::VectorXd& bracket,
                                const Eigen::VectorXd& increment, Eigen::VectorXd& velocity) {
  velocity_of_part_.clear();
  for (const int offset : offsets_) velocity_of_part_.push_back(velocity.data() + offset);
  massless_->begin_trial();
  for (std::size_t i = 0; i < surface_.pairs.size(); ++i) {
    const auto& pair = surface_.pairs[i];
    double made = 0.0;
    for (const Side side : {Side::a, Side::b}) {
      made += 0.5 * force_on(side, i, along_normal, bracket) * pair.normal.of(side, of_part(increment));
    }
    impulse_[i].normal += massless_->give_back(i, made, impulse_[i].normal, states, velocity_of_part_);
  }
}

void ImplicitContact::account(std::vector<BodyState>& states, const Eigen::VectorXd& bracket,
                              const Eigen::VectorXd& increment, const Eigen::VectorXd& jump,
                              const Eigen::VectorXd& mean_velocity) {
  if (massless_) {
    state_.work_normal_j += massless_->trial_work_j();
    massless_->accept();
  }
  if (shared_) {
    account_shared(states, increment, mean_velocity);
    return;
  }
  for (std::size_t i = 0; i < surface_.pairs.size(); ++i) {
    const auto& pair = surface_.pairs[i];
    // Of several contacts the force along the surface of a pair without friction is another's.
    const Eigen::Index own = surface_.contact_keys.size() > 1 ? directions(pair) : surface_.components;
    for (const Side side : {Side::a, Side::b}) {
      const auto work = [&](Direction direction) {
        const auto moved = [&](const Eigen::VectorXd& values) {
          return row_of(pair, direction).of(side, of_part(values));
        };
        return 0.5 * force_on(side, i, direction, bracket) * moved(increment) +
               force_on(side, i, direction, jump) * moved(mean_velocity);
      };
      state_.work_normal_j += work(along_normal);
      if (own > 1) state_.dissipated_friction_j -= work(along_tangent);
      if (own > 2) state_.dissipated_friction_j -= work(along_binormal);
    }
    book_impulse(pair, impulse_[i].normal, impulse_[i].tangential, states, state_.impulses);
  }
}

void ImplicitContact::accept() {
  state_.solution = trial_;
  old_pairs_.clear();
  state_.impulse = impulse_;
  state_.remembered = remembered_;
  state_.iterations += trial_.iterations;
  state_.largest_residual = std::max(state_.largest_residual, trial_.residual);
  state_.unconverged += trial_.residual > solver::converged_contact_residual;
}

void ImplicitContact::open() {
  state_.solution = trial_ = root_->open();
  std::fill(impulse_.begin(), impulse_.end(), solver::PairForce{});
  state_.impulse = state_.remembered = remembered_ = impulse_;
}

int ImplicitContact::pairs_closed() const {
  return static_cast<int>(state_.solution.states.size()) -
         static_cast<int>(std::count(state_.solution.states.begin(), state_.solution.states.end(), ContactState::open));
}

ImplicitContact::State ImplicitContact::state() const {
  State state = state_;
  if (massless_) state.massless = massless_->state();
  if (sliding_) state.sliding = sliding_->state();
  return state;
}

void ImplicitContact::restore(const State& state, const std::vector<BodyState>& states) {
  state_ = state;
  if (sliding_ && sliding_->restore(state.sliding, surface_.pairs)) {  // else the compliance stays, to the last bit
    old_pairs_.clear();
    take_new_pairs(states);
  }
  for (const auto count : {state.solution.states.size(), state.impulse.size(), state.remembered.size()})
    surface_.require_one_a_pair(count);
  surface_.require_one_a_pair(static_cast<std::size_t>(state.solution.force.size()),
                              static_cast<std::size_t>(directions()));
  if (massless_) massless_->restore(*state.massless);
}

const ContactRecord& ImplicitContact::report(const std::vector<BodyState>& states) {
  reported_ = state_.impulse;
  for (auto& force : reported_) {
    force.normal /= dt_;
    force.tangential /= dt_;
  }
  surface_.report(states, reported_, state_, report_);
  return report_;
}

}  // namespace ricochet::implicit_solver

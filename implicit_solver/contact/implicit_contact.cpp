#include "implicit_solver/contact/implicit_contact.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "common/fem/element.hpp"

namespace ricochet::implicit_solver {

using scene::Enforcement;
using scene::ImpactUpdate;
using scene::MultiplierUpdate;
using solver::BodyState;
using solver::Pair;
using solver::PairSide;
using solver::State;

namespace {

auto displacement_of(const std::vector<BodyState>& states) {
  return [&states](int part) -> const Eigen::VectorXd& { return states[static_cast<std::size_t>(part)].u; };
}
auto velocity_of(const std::vector<BodyState>& states) {
  return [&states](int part) -> const Eigen::VectorXd& { return states[static_cast<std::size_t>(part)].v; };
}

double inverse_mass(const PairSide& side, const std::vector<BodyState>& states, const Eigen::Vector2d& direction, int components) {
  if (side.part < 0) return 0.0;
  double sum = 0.0;
  const auto& inverse = states[static_cast<std::size_t>(side.part)].inverse_mass;
  for (int c = 0; c < components; ++c) sum += direction[c] * direction[c] * inverse[side.node * components + c];
  return sum;
}

}  // namespace

ImplicitContact::ImplicitContact(const scene::Problem& problem, const std::vector<scene::ParticipantPart>& parts,
                                 const std::vector<BodyState>& states)
    : problem_(&problem),
      law_(&*problem.scene.contact),
      normal_(problem.contact.normal),
      tangent_(-problem.contact.normal[1], problem.contact.normal[0]),
      components_(problem.scene.components()),
      pairs_(solver::local_pairs(problem, parts)),
      stress_(problem, parts) {
  int offset = 0;
  for (const auto& state : states) {
    offsets_.push_back(offset);
    offset += state.part.dofs();
  }
  for (const auto& pair : pairs_) {
    for (const auto& side : {pair.a, pair.b}) {
      if (side.part < 0) continue;
      const auto& state = states[static_cast<std::size_t>(side.part)];
      for (int c = 0; c < components_; ++c) {
        const int dof = side.node * components_ + c;
        const bool acts = normal_[c] != 0.0 || law_->friction_coefficient > 0.0;
        if (acts && state.inverse_mass[dof] > 0.0) root_dofs_.push_back(offsets_[static_cast<std::size_t>(side.part)] + dof);
      }
    }
  }
}

double ImplicitContact::kappa() const {
  const bool fully_implicit =
      law_->enforcement == Enforcement::multiplier && law_->multiplier_update == MultiplierUpdate::fully_implicit;
  return fully_implicit ? 2.0 : 1.0;
}

void ImplicitContact::prepare(const Eigen::MatrixXd& root_inverse, double dt) {
  const int n = static_cast<int>(pairs_.size());
  const bool friction = law_->friction_coefficient > 0.0;
  gather_.setZero(friction ? 2 * n : n, static_cast<Eigen::Index>(root_dofs_.size()));
  std::vector<double> area;
  for (int i = 0; i < n; ++i) {
    const auto& pair = pairs_[static_cast<std::size_t>(i)];
    area.push_back(pair.area_m2);
    for (const auto& [side, sign] : {std::pair{pair.a, -1.0}, std::pair{pair.b, 1.0}}) {
      if (side.part < 0) continue;
      for (int c = 0; c < components_; ++c) {
        const int dof = offsets_[static_cast<std::size_t>(side.part)] + side.node * components_ + c;
        const auto found = std::find(root_dofs_.begin(), root_dofs_.end(), dof);
        if (found == root_dofs_.end()) continue;
        const auto column = found - root_dofs_.begin();
        gather_(i, column) = sign * normal_[c];
        if (friction) gather_(n + i, column) = sign * tangent_[c];
      }
    }
  }
  const Eigen::MatrixXd compliance = (kappa() * 0.25 * dt * dt) * (gather_ * root_inverse * gather_.transpose());
  root_.emplace(*law_, compliance, area, dt);
  trial_ = accepted_ = root_->open();
  gap_free_.setZero(n);
  slip_free_.setZero(n);
  slip_velocity_.setZero(n);
  root_force_.setZero(static_cast<Eigen::Index>(root_dofs_.size()));
}

double ImplicitContact::combined(const Pair& pair, const Eigen::VectorXd& values, const Eigen::Vector2d& direction) const {
  return solver::relative(pair, direction, components_, [&](int part) {
    return values.data() + offsets_[static_cast<std::size_t>(part)];
  });
}

void ImplicitContact::solve(const std::vector<BodyState>& states, const Eigen::VectorXd& increment) {
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    const auto& pair = pairs_[i];
    const auto k = static_cast<Eigen::Index>(i);
    gap_free_[k] = pair.gap0_m + relative(pair, normal_, components_, displacement_of(states)) + combined(pair, increment, normal_);
    if (!root_->friction()) continue;
    slip_free_[k] = combined(pair, increment, tangent_);
    slip_velocity_[k] = relative(pair, tangent_, components_, velocity_of(states));
  }
  trial_ = root_->solve(gap_free_, slip_free_, slip_velocity_, accepted_);
  root_force_.noalias() = gather_.transpose() * trial_.force;
}

ImplicitContact::Mean ImplicitContact::mean_shares(const Pair& pair, const std::vector<BodyState>& states,
                                                   const Eigen::Vector2d& direction) const {
  const double wa = inverse_mass(pair.a, states, direction, components_);
  const double wb = inverse_mass(pair.b, states, direction, components_);
  if (wa + wb == 0.0) return {0.0, 0.0};
  const bool paper = law_->enforcement == Enforcement::penalty && law_->impact_update == ImpactUpdate::impedance;
  if (!paper || wa == 0.0 || wb == 0.0) return {wa / (wa + wb), wb / (wa + wb)};
  // Eq. 25-27: weights rho C, longitudinal along n, shear along t
  const auto impedance = [&](int part) {
    const auto& body = problem_->bodies[static_cast<std::size_t>(states[static_cast<std::size_t>(part)].body)];
    const bool along_normal = direction == normal_;
    const double speed = along_normal ? fem::longitudinal_wave_speed(problem_->scene.model, body.material)
                                      : fem::shear_wave_speed(body.material);
    return body.material.density_kg_m3 * speed;
  };
  const double za = impedance(pair.a.part), zb = impedance(pair.b.part);
  return {zb / (za + zb), za / (za + zb)};
}

void ImplicitContact::set_mean(const Pair& pair, const std::vector<BodyState>& states, const Eigen::Vector2d& direction,
                               Eigen::VectorXd& values) const {
  const double difference = combined(pair, values, direction);
  const Mean share = mean_shares(pair, states, direction);
  for (const auto& [side, amount] : {std::pair{pair.a, share.share_a * difference}, std::pair{pair.b, -share.share_b * difference}}) {
    if (side.part < 0) continue;
    for (int c = 0; c < components_; ++c) {
      values[offsets_[static_cast<std::size_t>(side.part)] + side.node * components_ + c] += amount * direction[c];
    }
  }
}

void ImplicitContact::update_rates(const std::vector<BodyState>& states, Eigen::VectorXd& velocity,
                                   Eigen::VectorXd& acceleration) {
  const bool never = law_->enforcement == Enforcement::penalty && law_->impact_update == ImpactUpdate::none;
  if (never || !remembered()) return;
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    if (trial_.states[i] == State::open) continue;
    set_mean(pairs_[i], states, normal_, velocity);
    set_mean(pairs_[i], states, normal_, acceleration);
    if (components_ == 1 || trial_.states[i] != State::stick) continue;
    set_mean(pairs_[i], states, tangent_, velocity);
    set_mean(pairs_[i], states, tangent_, acceleration);
  }
}

void ImplicitContact::account(std::vector<BodyState>& states, const Eigen::VectorXd& bracket, const Eigen::VectorXd& increment,
                              const Eigen::VectorXd& jump, const Eigen::VectorXd& mean_velocity, double dt) {
  for (const auto& pair : pairs_) {
    for (const auto& side : {pair.a, pair.b}) {
      if (side.part < 0) continue;
      const int first = offsets_[static_cast<std::size_t>(side.part)] + side.node * components_;
      const auto along = [&](const Eigen::VectorXd& values, const Eigen::Vector2d& direction) {
        double sum = 0.0;
        for (int c = 0; c < components_; ++c) sum += direction[c] * values[first + c];
        return sum;
      };
      const auto work = [&](const Eigen::Vector2d& d) {
        return 0.5 * along(bracket, d) * along(increment, d) + along(jump, d) * along(mean_velocity, d);
      };
      work_normal_j_ += work(normal_);
      dissipated_friction_j_ -= work(tangent_);
      if (pair.b.part >= 0) continue;
      auto& totals = states[static_cast<std::size_t>(side.part)].totals;
      totals.impulse_n_kg_m_s += 0.5 * dt * along(bracket, normal_) + along(jump, normal_);
      totals.impulse_t_kg_m_s += 0.5 * dt * along(bracket, tangent_) + along(jump, tangent_);
    }
  }
}

int ImplicitContact::pairs_closed() const {
  return static_cast<int>(accepted_.states.size()) -
         static_cast<int>(std::count(accepted_.states.begin(), accepted_.states.end(), State::open));
}

double ImplicitContact::gap_min(const std::vector<BodyState>& states) const {
  double smallest = std::numeric_limits<double>::max();
  for (const auto& pair : pairs_) {
    smallest = std::min(smallest, pair.gap0_m + relative(pair, normal_, components_, displacement_of(states)));
  }
  return smallest;
}

double ImplicitContact::gap_rate_min(const std::vector<BodyState>& states) const {
  double smallest = std::numeric_limits<double>::max();
  for (const auto& pair : pairs_) smallest = std::min(smallest, relative(pair, normal_, components_, velocity_of(states)));
  return smallest;
}

solver::Report ImplicitContact::report(const std::vector<BodyState>& states) const {
  solver::Report report;
  double area = 0.0;
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    report.contact_force_n += accepted_.force[static_cast<Eigen::Index>(i)];
    if (root_->friction()) report.friction_force_n += accepted_.force[static_cast<Eigen::Index>(pairs_.size() + i)];
    report.pairs_open += accepted_.states[i] == State::open;
    report.pairs_stick += accepted_.states[i] == State::stick;
    report.pairs_slip += accepted_.states[i] == State::slip;
    area += pairs_[i].area_m2;
  }
  report.gap_min_m = gap_min(states);
  report.contact_pressure_mean_pa = report.contact_force_n / area;
  report.principal_stress_mean_pa = stress_.mean(displacement_of(states));
  report.energy_contact_j = work_normal_j_;
  report.energy_friction_j = dissipated_friction_j_;
  return report;
}

}  // namespace ricochet::implicit_solver

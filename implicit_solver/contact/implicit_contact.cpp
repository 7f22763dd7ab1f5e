#include "implicit_solver/contact/implicit_contact.hpp"

#include <algorithm>
#include <array>
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

double inverse_mass(const PairSide& side, const std::vector<BodyState>& states, const Eigen::Vector2d& direction, int components) {
  if (side.part < 0) return 0.0;
  double sum = 0.0;
  const auto& inverse = states[static_cast<std::size_t>(side.part)].inverse_mass;
  for (int c = 0; c < components; ++c) sum += direction[c] * direction[c] * inverse[side.node * components + c];
  return sum;
}

/// Nodes that share an edge of an element with `node` and are not among `contact`, each once.
std::vector<int> inward_neighbours(const BodyState& state, int node, const std::vector<int>& contact) {
  const auto corners = static_cast<std::size_t>(fem::nodes_per_element(state.part.mesh.model));
  std::vector<int> found;
  for (const auto& element : state.part.mesh.elements) {
    for (std::size_t i = 0; i < corners; ++i) {
      if (element[i] != node) continue;
      for (const std::size_t next : {(i + 1) % corners, (i + corners - 1) % corners}) {
        const int other = element[next];
        const bool known = std::find(found.begin(), found.end(), other) != found.end();
        if (!known && std::find(contact.begin(), contact.end(), other) == contact.end()) found.push_back(other);
      }
    }
  }
  return found;
}

}  // namespace

ImplicitContact::ImplicitContact(const scene::Problem& problem, const std::vector<scene::ParticipantPart>& parts,
                                 const std::vector<BodyState>& states)
    : problem_(&problem),
      law_(&*problem.scene.contact),
      surface_(problem, parts) {
  int offset = 0;
  for (const auto& state : states) {
    offsets_.push_back(offset);
    offset += state.part.dofs();
  }
  for (const auto& pair : surface_.pairs) {
    for (const auto& side : {pair.a, pair.b}) {
      if (side.part < 0) continue;
      const auto& state = states[static_cast<std::size_t>(side.part)];
      for (int c = 0; c < surface_.components; ++c) {
        const int dof = side.node * surface_.components + c;
        const bool acts = surface_.normal[c] != 0.0 || law_->friction_coefficient > 0.0;
        if (acts && state.free[static_cast<std::size_t>(dof)]) root_dofs_.push_back(offsets_[static_cast<std::size_t>(side.part)] + dof);
      }
    }
  }
}

double ImplicitContact::kappa() const {
  const bool fully_implicit =
      law_->enforcement == Enforcement::multiplier && law_->multiplier_update == MultiplierUpdate::fully_implicit;
  return fully_implicit ? 2.0 : 1.0;
}

bool ImplicitContact::massless() const { return law_->multiplier_update == MultiplierUpdate::massless; }

void ImplicitContact::move_masses(std::vector<BodyState>& states) const {
  std::vector<std::vector<int>> contact(states.size());
  for (const auto& pair : surface_.pairs)
    for (const auto& side : {pair.a, pair.b})
      if (side.part >= 0) contact[static_cast<std::size_t>(side.part)].push_back(side.node);
  for (std::size_t part = 0; part < states.size(); ++part) {
    auto& state = states[part];
    for (const int node : contact[part]) {
      const auto inwards = inward_neighbours(state, node, contact[part]);
      for (int c = 0; c < surface_.components; ++c) {
        const int dof = node * surface_.components + c;
        if (surface_.normal[c] == 0.0 || !state.free[static_cast<std::size_t>(dof)] || inwards.empty()) continue;
        for (const int other : inwards) {
          const int to = other * surface_.components + c;
          state.mass[to] += state.mass[dof] / static_cast<double>(inwards.size());
          if (state.free[static_cast<std::size_t>(to)]) state.inverse_mass[to] = 1.0 / state.mass[to];
        }
        state.mass[dof] = state.inverse_mass[dof] = 0.0;
      }
    }
  }
}

void ImplicitContact::prepare(const Eigen::MatrixXd& root_inverse, double dt) {
  const int n = static_cast<int>(surface_.pairs.size());
  const bool friction = law_->friction_coefficient > 0.0;
  gather_.setZero(friction ? 2 * n : n, static_cast<Eigen::Index>(root_dofs_.size()));
  std::vector<double> area;
  for (int i = 0; i < n; ++i) {
    const auto& pair = surface_.pairs[static_cast<std::size_t>(i)];
    area.push_back(pair.area_m2);
    for (const auto& [side, sign] : {std::pair{pair.a, -1.0}, std::pair{pair.b, 1.0}}) {
      if (side.part < 0) continue;
      for (int c = 0; c < surface_.components; ++c) {
        const int dof = offsets_[static_cast<std::size_t>(side.part)] + side.node * surface_.components + c;
        const auto found = std::find(root_dofs_.begin(), root_dofs_.end(), dof);
        if (found == root_dofs_.end()) continue;
        const auto column = found - root_dofs_.begin();
        gather_(i, column) = sign * surface_.normal[c];
        if (friction) gather_(n + i, column) = sign * surface_.tangent[c];
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
  return solver::relative(pair, direction, surface_.components, [&](int part) {
    return values.data() + offsets_[static_cast<std::size_t>(part)];
  });
}

/// Relative displacements at the end of the window without contact forces, from zero, of held pairs.
void ImplicitContact::find_moved(const std::vector<BodyState>& states, const Eigen::VectorXd& increment) {
  for (std::size_t i = 0; i < surface_.pairs.size(); ++i) {
    const auto& pair = surface_.pairs[i];
    const auto moved = [&](const Eigen::Vector2d& direction) {
      return surface_.moved(pair, direction, states) + combined(pair, increment, direction);
    };
    gap_free_[static_cast<Eigen::Index>(i)] = moved(surface_.normal);
    slip_free_[static_cast<Eigen::Index>(i)] = moved(surface_.tangent);
  }
}

/// With a penalty the force of the present gap is part of the acceleration that the law remembers; a multiplier either is
/// not remembered or cancels in the mean.
void ImplicitContact::hold_rates(const std::vector<BodyState>& states, Eigen::VectorXd& velocity,
                                 Eigen::VectorXd& acceleration) {
  find_moved(states, Eigen::VectorXd::Zero(velocity.size()));
  trial_ = root_->spring(gap_free_, slip_free_);
  root_force_.noalias() = gather_.transpose() * trial_.force;
  for (std::size_t i = 0; i < root_dofs_.size(); ++i) {
    std::size_t part = offsets_.size() - 1;
    while (root_dofs_[i] < offsets_[part]) --part;
    acceleration[root_dofs_[i]] +=
        root_force_[static_cast<Eigen::Index>(i)] * states[part].inverse_mass[root_dofs_[i] - offsets_[part]];
  }
  update_rates(states, velocity, acceleration);
}

void ImplicitContact::solve(const std::vector<BodyState>& states, const Eigen::VectorXd& increment) {
  if (frozen_) {
    if (held()) find_moved(states, increment);
    trial_ = held() ? root_->hold(gap_free_, slip_free_) : root_->open();
    root_force_.noalias() = gather_.transpose() * trial_.force;
    return;
  }
  for (std::size_t i = 0; i < surface_.pairs.size(); ++i) {
    const auto& pair = surface_.pairs[i];
    const auto k = static_cast<Eigen::Index>(i);
    gap_free_[k] = surface_.gap(pair, states) + combined(pair, increment, surface_.normal);
    if (!root_->friction()) continue;
    slip_free_[k] = combined(pair, increment, surface_.tangent);
    slip_velocity_[k] = relative(pair, surface_.tangent, surface_.components, velocity_of(states));
  }
  trial_ = root_->solve(gap_free_, slip_free_, slip_velocity_, accepted_);
  root_force_.noalias() = gather_.transpose() * trial_.force;
}

ImplicitContact::Mean ImplicitContact::mean_shares(const Pair& pair, const std::vector<BodyState>& states,
                                                   const Eigen::Vector2d& direction) const {
  const double wa = inverse_mass(pair.a, states, direction, surface_.components);
  const double wb = inverse_mass(pair.b, states, direction, surface_.components);
  if (wa + wb == 0.0) return {0.0, 0.0};
  const bool paper = law_->enforcement == Enforcement::penalty && law_->impact_update == ImpactUpdate::impedance;
  if (!paper || wa == 0.0 || wb == 0.0) return {wa / (wa + wb), wb / (wa + wb)};
  // Eq. 25-27: weights rho C, longitudinal along n, shear along t
  const auto impedance = [&](int part) {
    const auto& body = problem_->bodies[static_cast<std::size_t>(states[static_cast<std::size_t>(part)].body)];
    const bool along_normal = direction == surface_.normal;
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
    for (int c = 0; c < surface_.components; ++c) {
      values[offsets_[static_cast<std::size_t>(side.part)] + side.node * surface_.components + c] += amount * direction[c];
    }
  }
}

void ImplicitContact::update_rates(const std::vector<BodyState>& states, Eigen::VectorXd& velocity,
                                   Eigen::VectorXd& acceleration) {
  const bool never = law_->enforcement == Enforcement::penalty && law_->impact_update == ImpactUpdate::none;
  if (never || !remembered() || massless()) return;
  for (std::size_t i = 0; i < surface_.pairs.size(); ++i) {
    if (trial_.states[i] == State::open) continue;
    set_mean(surface_.pairs[i], states, surface_.normal, velocity);
    set_mean(surface_.pairs[i], states, surface_.normal, acceleration);
    if (surface_.components == 1 || trial_.states[i] != State::stick) continue;
    set_mean(surface_.pairs[i], states, surface_.tangent, velocity);
    set_mean(surface_.pairs[i], states, surface_.tangent, acceleration);
  }
}

void ImplicitContact::account(std::vector<BodyState>& states, const Eigen::VectorXd& bracket, const Eigen::VectorXd& increment,
                              const Eigen::VectorXd& jump, const Eigen::VectorXd& mean_velocity, double dt) {
  for (const auto& pair : surface_.pairs) {
    for (const auto& side : {pair.a, pair.b}) {
      if (side.part < 0) continue;
      const int first = offsets_[static_cast<std::size_t>(side.part)] + side.node * surface_.components;
      const auto along = [&](const Eigen::VectorXd& values, const Eigen::Vector2d& direction) {
        double sum = 0.0;
        for (int c = 0; c < surface_.components; ++c) sum += direction[c] * values[first + c];
        return sum;
      };
      const auto work = [&](const Eigen::Vector2d& d) {
        return 0.5 * along(bracket, d) * along(increment, d) + along(jump, d) * along(mean_velocity, d);
      };
      work_normal_j_ += work(surface_.normal);
      dissipated_friction_j_ -= work(surface_.tangent);
      if (pair.b.part >= 0) continue;
      auto& totals = states[static_cast<std::size_t>(side.part)].totals;
      totals.impulse_n_kg_m_s += 0.5 * dt * along(bracket, surface_.normal) + along(jump, surface_.normal);
      totals.impulse_t_kg_m_s += 0.5 * dt * along(bracket, surface_.tangent) + along(jump, surface_.tangent);
      if (surface_.components == 2) {
        states[static_cast<std::size_t>(side.part)].add_angular_impulse(
            side.node, 0.5 * dt * bracket.segment<2>(first) + jump.segment<2>(first));
      }
    }
  }
}

int ImplicitContact::pairs_closed() const {
  return static_cast<int>(accepted_.states.size()) -
         static_cast<int>(std::count(accepted_.states.begin(), accepted_.states.end(), State::open));
}

solver::Report ImplicitContact::report(const std::vector<BodyState>& states) {
  const std::size_t pairs = surface_.pairs.size();
  reported_.resize(pairs);
  for (std::size_t i = 0; i < pairs; ++i) {
    reported_[i].normal = accepted_.force[static_cast<Eigen::Index>(i)];
    if (root_->friction()) reported_[i].tangential = accepted_.force[static_cast<Eigen::Index>(pairs + i)];
    reported_[i].state = accepted_.states[i];
  }
  solver::Report report = surface_.report(states, reported_);
  report.energy_contact_j = work_normal_j_;
  report.energy_friction_j = dissipated_friction_j_;
  return report;
}

}  // namespace ricochet::implicit_solver

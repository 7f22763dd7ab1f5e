#pragma once

#include <optional>
#include <utility>

#include "implicit_solver/contact/implicit_contact.hpp"
#include "tests/support/contact_plates.hpp"

namespace ricochet::test {

/// One window of plates that meet, their contact, and the trial's increments and rates. The operator is M alone, as for
/// a very short window, so that everything can be worked out from the rows.
template <class Meeting>
struct TrialOf {
  static constexpr double dt = 1e-6;
  Meeting plates;
  std::optional<implicit_solver::ImplicitContact> contact;
  Eigen::VectorXd mass, increment, velocity, acceleration, force;

  explicit TrialOf(Meeting meeting) : plates(std::move(meeting)) {
    contact.emplace(plates.problem, plates.surface, plates.states);
    const auto& states = plates.states;
    mass.resize(states[0].mass.size() + states[1].mass.size());
    mass << states[0].mass, states[1].mass;
    velocity.resizeLike(mass);
    velocity << states[0].v, states[1].v;
    acceleration = Eigen::VectorXd::Zero(mass.size());
    force = acceleration;
    increment = dt * velocity;
    const auto& root = contact->root_dofs();
    Eigen::MatrixXd root_inverse =
        Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(root.size()), static_cast<Eigen::Index>(root.size()));
    for (std::size_t i = 0; i < root.size(); ++i)
      root_inverse(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i)) = 1.0 / mass[root[i]];
    contact->prepare(root_inverse, dt);
  }
  void solve() {
    contact->solve(plates.states, increment, false);
    const auto& root = contact->root_dofs();
    for (std::size_t i = 0; i < root.size(); ++i) {
      force[root[i]] = contact->kappa() * contact->root_force()[static_cast<Eigen::Index>(i)];
      const double a = force[root[i]] / mass[root[i]];
      increment[root[i]] += 0.25 * dt * dt * a;
      // the trapezoidal rule's: du = dt v + dt^2/4 (a_n + a_{n+1}), v_{n+1} = v_n + dt/2 (a_n + a_{n+1})
      acceleration[root[i]] = contact->remembered() ? a : 0.0;
      velocity[root[i]] += 0.5 * dt * a;
    }
    contact->update_rates(plates.states, increment, velocity, acceleration);
  }
  [[nodiscard]] double along(const solver::ContactRow& row, const Eigen::VectorXd& values) const {
    const auto second = plates.states[0].part.dofs();
    return row.times([&](int part) { return values.data() + part * second; });
  }
  [[nodiscard]] double gap() const { return along(plates.surface.pairs[0].normal, increment); }
  [[nodiscard]] Eigen::VectorXd momentum() const {
    const int components = plates.surface.components;
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(components);
    for (Eigen::Index dof = 0; dof < mass.size(); ++dof) sum[dof % components] += mass[dof] * velocity[dof];
    return sum;
  }
};
using Trial = TrialOf<ContactPlates>;

}  // namespace ricochet::test

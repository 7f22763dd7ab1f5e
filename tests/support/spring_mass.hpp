#pragma once

#include <cmath>
#include <functional>
#include <optional>

#include "common/participant/participant.hpp"

namespace ricochet::participant {

/// The smallest explicit participant: `nodes` masses m, each on a spring k to an interface node u_link,
///   m u'' = -k (u - u_link),   P = k (u_link - u),
/// by central difference, at rest at first. Without interface nodes one mass on a fixed spring, displaced by 1 mm.
class SpringMass : public Participant {
 public:
  explicit SpringMass(int nodes = 1) : nodes_(nodes), u_(nodes > 0 ? nodes : 1, nodes > 0 ? 0.0 : 1e-3) {
    v_.assign(u_.size(), 0.0);
    trial_u_ = a_ = link_ = v_;
  }

  Description describe() override {
    Description d;
    d.name = "spring";
    d.role = Role::explicit_solver;
    d.solver = "spring_mass";
    d.bodies = {"rod"};
    d.interface_body.assign(static_cast<std::size_t>(nodes_), 0);
    for (int i = 0; i < nodes_; ++i) d.interface_position_m.push_back(0.1 * i);
    d.interface_mass_kg.assign(static_cast<std::size_t>(nodes_), 0.5);
    d.critical_time_step_s = 0.2;
    d.capabilities = capabilities;
    d.record_columns = {"displacement_m", "velocity_m_s"};
    d.axial_stress_columns = axial_stress_columns;
    return d;
  }
  void initialize(const Setup& given, LinkOutput& output) override {
    setup = given;
    force(u_, output);
  }
  void synchronise(Integration, const std::vector<double>& link_input, LinkOutput& output) override {
    for (std::size_t i = 0; i < link_input.size(); ++i) link_[i] = link_input[i];
    for (std::size_t i = 0; i < u_.size(); ++i) a_[i] = -stiffness / mass * (u_[i] - link_[i]);
    force(u_, output);
  }
  void advance(std::int64_t window, const std::vector<double>& link_input, LinkOutput& output) override {
    const double dt = setup.clock.size_s();
    for (std::size_t i = 0; i < u_.size(); ++i) trial_u_[i] = u_[i] + dt * v_[i] + 0.5 * dt * dt * a_[i];
    for (std::size_t i = 0; i < link_input.size(); ++i) link_[i] = link_input[i];
    force(trial_u_, output);
    if (on_advance) on_advance(window, output);
  }
  void accept() override {
    u_ = trial_u_;
    for (std::size_t i = 0; i < u_.size(); ++i) {
      const double a = -stiffness / mass * (u_[i] - link_[i]);
      v_[i] += 0.5 * setup.clock.size_s() * (a_[i] + a);
      a_[i] = a;
    }
  }
  void load_state(const std::vector<double>& state, FrozenContact contact) override {
    for (std::size_t i = 0; i < u_.size(); ++i) {
      u_[i] = state[i];
      v_[i] = state[u_.size() + i];
    }
    frozen = contact;
  }
  void read_state(std::vector<double>& state, std::vector<double>& scale) override {
    state.insert(state.end(), u_.begin(), u_.end());
    state.insert(state.end(), v_.begin(), v_.end());
    scale.assign(u_.size(), std::sqrt(mass) / setup.clock.size_s());
    scale.resize(2 * u_.size() - missing_scales, std::sqrt(mass));
  }
  [[nodiscard]] ContactStatus contact_status() const override { return status; }
  void record(std::vector<double>& row) override { row.insert(row.end(), {u_[0], v_[0]}); }
  void axial_stress(std::vector<double>& row) override { row.push_back(1e9 * u_[0]); }
  void write_fields(std::int64_t window) override { fields.push_back(window); }

  static constexpr double mass = 1.0, stiffness = 100.0;
  std::vector<std::string> axial_stress_columns{};
  std::vector<Capability> capabilities{Capability::repeat_window};
  std::function<void(std::int64_t window, LinkOutput& output)> on_advance;  ///< to spoil a window
  ContactStatus status;
  Setup setup;
  std::optional<FrozenContact> frozen;  ///< of the last `load_state`
  std::size_t missing_scales = 0;       ///< how many scales `read_state` forgets
  std::vector<std::int64_t> fields;     ///< windows at which result fields were asked for

 private:
  void force(const std::vector<double>& u, LinkOutput& output) const {
    output.value.resize(static_cast<std::size_t>(nodes_));
    for (std::size_t i = 0; i < output.value.size(); ++i) output.value[i] = stiffness * (link_[i] - u[i]);
  }
  int nodes_;
  std::vector<double> u_, v_, a_, trial_u_, link_;
};

}  // namespace ricochet::participant

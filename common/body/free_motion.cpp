#include "common/body/free_motion.hpp"

#include <cmath>
#include <utility>

namespace ricochet::solver {

void load_motion(const std::vector<double>& row, std::vector<BodyState>& states) {
  std::size_t next = 0;
  for (auto& state : states) {
    state.external = {};
    for (auto& c : state.constrained) c.motion = {};
    for (auto& d : state.dashpots) d.initial_velocity_m_s = 0.0;
    for (auto* values : {&state.u, &state.v}) {
      values->setZero();
      for (int dof = 0; dof < state.part.dofs(); ++dof) {
        if (state.inverse_mass[dof] > 0.0) (*values)[dof] = row[next++];
      }
    }
  }
}

std::vector<Surroundings> surroundings_of(const std::vector<BodyState>& states) {
  std::vector<Surroundings> all;
  for (const auto& state : states) all.push_back({state.external, state.constrained, state.dashpots});
  return all;
}

void give_back(const std::vector<Surroundings>& surroundings, std::vector<BodyState>& states) {
  for (std::size_t b = 0; b < states.size(); ++b) {
    states[b].external = surroundings[b].external;
    states[b].constrained = surroundings[b].constrained;
    states[b].dashpots = surroundings[b].dashpots;
  }
}

void read_motion(const std::vector<BodyState>& states, double dt, std::vector<double>& row,
                 std::vector<double>& scale) {
  for (const auto& state : states) {
    for (const auto& [values, time_s] : {std::pair{&state.u, dt}, std::pair{&state.v, 1.0}}) {
      for (int dof = 0; dof < state.part.dofs(); ++dof) {
        if (!(state.inverse_mass[dof] > 0.0)) continue;
        row.push_back((*values)[dof]);
        scale.push_back(std::sqrt(state.mass[dof]) / time_s);
      }
    }
  }
}

}  // namespace ricochet::solver

#pragma once

#include <variant>

#include "explicit_solver/explicit_solver.hpp"

namespace ricochet::test {

/// From here on the solver computes the rows that no wave has reached, too.
inline void compute_all_rows(explicit_solver::ExplicitSolver& solver) {
  auto state = solver.state();
  if (auto* motion = std::get_if<explicit_solver::MotionDriven::State>(&state.stepping.drive)) {
    for (auto& front : motion->fronts) front.reach_all();
  } else {
    for (auto& part : std::get<explicit_solver::ForceDriven::State>(state.stepping.drive).parts) part.front.reach_all();
  }
  solver.restore(state);
}

}  // namespace ricochet::test

#pragma once

#include "explicit_solver/explicit_solver.hpp"

namespace ricochet::test {

/// From here on the solver computes the rows that no wave has reached, too.
inline void compute_all_rows(explicit_solver::ExplicitSolver& solver) {
  const auto& stepping = solver.stepping();
  for (std::size_t part = 0; part < stepping.states().size(); ++part) stepping.force(part).reach_all();
}

}  // namespace ricochet::test

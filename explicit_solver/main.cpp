#include "common/solver/main.hpp"

#include "explicit_solver/explicit_solver.hpp"

int main(int argc, char** argv) {
  return ricochet::solver::solver_main<ricochet::explicit_solver::ExplicitSolver>(argc, argv);
}

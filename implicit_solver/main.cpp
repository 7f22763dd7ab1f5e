#include "common/solver/main.hpp"

#include "implicit_solver/implicit_solver.hpp"

int main(int argc, char** argv) {
  return ricochet::solver::solver_main<ricochet::implicit_solver::ImplicitSolver>(argc, argv);
}

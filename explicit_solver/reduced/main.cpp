#include "common/solver/main.hpp"

#include "explicit_solver/reduced/reduced_solver.hpp"

int main(int argc, char** argv) {
  return ricochet::solver::solver_main<ricochet::explicit_solver::ReducedSolver>(argc, argv);
}

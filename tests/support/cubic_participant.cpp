// cubic_participant --scene SCENE --name NAME --connect ENDPOINT: the shipped solver of NAME's role with bars that grow
// stiffer as they are strained, so that its internal force is not linear in the displacement. Tests have it started in
// the place of that solver.
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/solver/main.hpp"
#include "explicit_solver/explicit_solver.hpp"
#include "implicit_solver/implicit_solver.hpp"
#include "tests/support/cubic_bars.hpp"

namespace ricochet {
namespace {

/// A participant of either role; which one, the scene says.
std::unique_ptr<participant::Participant> cubic_solver(scene::Problem problem, const std::string& name,
                                                       std::optional<double> told_critical_step_s) {
  if (problem.scene.participant(name).role == scene::Role::implicit_solver) {
    return std::make_unique<implicit_solver::ImplicitSolver>(
        std::move(problem), name, told_critical_step_s,
        [](const solver::BodyState& state) { return std::make_unique<test::CubicBars>(state); });
  }
  return std::make_unique<explicit_solver::ExplicitSolver>(
      std::move(problem), name, told_critical_step_s, nullptr,
      [](const solver::BodyState& state, const std::vector<int>&) { return std::make_unique<test::CubicBars>(state); });
}

}  // namespace
}  // namespace ricochet

int main(int argc, char** argv) { return ricochet::solver::solver_main(argc, argv, ricochet::cubic_solver); }

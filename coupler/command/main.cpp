// The `ricochet` command; its subcommands stand in command_line.cpp.
#include <cstdio>
#include <exception>
#include <memory>
#include <optional>

#include "common/base/error.hpp"
#include "common/base/process.hpp"
#include "coupler/command/command_line.hpp"
#include "coupler/processes/inside.hpp"
#include "coupler/run/compute_scene.hpp"
#include "explicit_solver/explicit_solver.hpp"
#include "implicit_solver/implicit_solver.hpp"

int main(int argc, char** argv) {
  using namespace ricochet;
  prepare_process();
  coupler::let_inside([](const scene::Problem& problem, const std::string& name,
                         std::optional<double> critical_step_s) -> std::unique_ptr<participant::Participant> {
    if (problem.scene.participant(name).role == Role::implicit_solver)
      return std::make_unique<implicit_solver::ImplicitSolver>(problem, name, critical_step_s);
    return std::make_unique<explicit_solver::ExplicitSolver>(problem, name, critical_step_s);
  });
  try {
    return coupler::run_command_line(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", command_name, printable(text_of(error)).c_str());
    return coupler::exit_code_of(error);
  }
}

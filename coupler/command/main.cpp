// The `ricochet` command; its subcommands stand in command_line.cpp.
#include <csignal>
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

namespace {

/// Somebody may ask for a checkpoint before there is a run; it waits until a launcher hears it.
void hold_requests() {
  sigset_t requests;
  sigemptyset(&requests);
  sigaddset(&requests, SIGUSR1);
  sigprocmask(SIG_BLOCK, &requests, nullptr);
}

}  // namespace

int main(int argc, char** argv) {
  using namespace ricochet;
  hold_requests();
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

#pragma once

#include <cstdio>
#include <exception>
#include <string>
#include <utility>

#include "common/base/error.hpp"
#include "common/base/process.hpp"
#include "common/participant/participant.hpp"
#include "common/scene/problem.hpp"

namespace ricochet::solver {

/// PROGRAM --scene SCENE --name NAME --connect ENDPOINT [--watch-stdin]: takes part in the run that a coupler serves at
/// ENDPOINT. `Solver` is made from a scene::Problem and the participant's name. Returns the exit code.
template <class Solver>
int solver_main(int argc, char** argv) {
  prepare_process();
  std::string name = argv[0];
  try {
    auto arguments = participant::parse_arguments(argc, argv);
    name = arguments.name;
    if (arguments.scene.empty()) throw ConfigError("--scene is missing");
    auto problem = scene::build_problem(scene::load_scene(arguments.scene));
    arguments.options.timeout_s = problem.scene.coupling.timeout_s;  // until the coupler states its own
    Solver solver(std::move(problem), name);
    return participant::serve(solver, arguments.options);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: error: %s\n", name.c_str(), text_of(error).c_str());
    return exit_code_of_exception(error);
  }
}

}  // namespace ricochet::solver

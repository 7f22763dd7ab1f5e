#pragma once

#include <memory>
#include <utility>

#include "common/base/error.hpp"
#include "common/participant/participant.hpp"
#include "common/problem/problem.hpp"

namespace ricochet::solver {

/// PROGRAM --scene SCENE --name NAME --connect ENDPOINT [--critical-step SECONDS] [--watch-stdin]: takes part in the
/// run that a coupler serves at ENDPOINT. `make` makes the solver from a scene::Problem, the participant's name and the
/// critical step that it was told. Returns the exit code.
template <class Make>
int solver_main(int argc, const char* const* argv, const Make& make) {
  return participant::participant_main(argc, argv, [&](participant::Arguments& arguments) {
    if (arguments.scene.empty()) throw ConfigError("--scene is missing");
    auto problem = scene::build_bodies(scene::load_scene(arguments.scene));
    arguments.options.timeout_s = problem.scene.coupling.timeout_s;  // until the coupler states its own
    return make(std::move(problem), arguments.name, arguments.critical_time_step_s);
  });
}

/// The same with a solver of that class.
template <class Solver>
int solver_main(int argc, const char* const* argv) {
  return solver_main(argc, argv, [](auto&&... what) { return std::make_unique<Solver>(std::move(what)...); });
}

}  // namespace ricochet::solver

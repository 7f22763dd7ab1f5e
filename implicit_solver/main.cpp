#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <string>
#include <utility>

#include "common/base/error.hpp"
#include "common/participant/participant.hpp"
#include "common/scene/problem.hpp"
#include "implicit_solver/implicit_solver.hpp"

/// implicit_solver --scene SCENE --name NAME --connect ENDPOINT: takes part in the run that a coupler serves at ENDPOINT.
int main(int argc, char** argv) {
  CLI::App app{"Implicit participant of ricochet."};
  std::string scene, name;
  ricochet::participant::ServeOptions options;
  app.add_option("--scene", scene, "scene file (TOML)")->required();
  app.add_option("--name", name, "name of the participant in the scene")->required();
  app.add_option("--connect", options.endpoint, "endpoint of the coupler, ipc://... or tcp://address:port")->required();
  app.add_flag("--watch-stdin", options.watch_stdin, "end at once when standard input closes");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : static_cast<int>(ricochet::ExitCode::config);
  }
  try {
    auto problem = ricochet::scene::build_problem(ricochet::scene::load_scene(scene));
    options.timeout_s = problem.scene.coupling.timeout_s;  // until the coupler states its own
    ricochet::implicit_solver::ImplicitSolver solver(std::move(problem), name);
    return ricochet::participant::serve(solver, options);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: error: %s\n", name.c_str(), error.what());
    const auto* known = dynamic_cast<const ricochet::Error*>(&error);
    return static_cast<int>(known ? known->code() : ricochet::ExitCode::participant);
  }
}

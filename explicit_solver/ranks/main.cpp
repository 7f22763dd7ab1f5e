#include <fmt/format.h>

#include <cstdio>
#include <exception>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "common/base/error.hpp"
#include "common/participant/participant.hpp"
#include "common/problem/problem.hpp"
#include "explicit_solver/explicit_solver.hpp"
#include "explicit_solver/ranks/first_rank.hpp"
#include "explicit_solver/ranks/mpi_communicator.hpp"

namespace {

using namespace ricochet;
using explicit_solver::FirstRank;
using explicit_solver::MpiCommunicator;

scene::Problem problem_of(const participant::Arguments& arguments, int ranks) {
  if (arguments.scene.empty()) throw ConfigError("--scene is missing");
  auto problem = scene::build_bodies(scene::load_scene(arguments.scene));
  const auto& spec = problem.scene.participant(arguments.name);
  if (spec.ranks.value_or(1) != ranks) {
    throw ConfigError(
        fmt::format("{}: participant '{}' has ranks = {}, and {} were started; start as many as the scene says",
                    problem.scene.path, arguments.name, spec.ranks.value_or(1), ranks));
  }
  return problem;
}

/// The first rank is the participant.
int take_part(int argc, char** argv, MpiCommunicator& communicator) {
  FirstRank ranks(communicator);
  const int code = participant::participant_main(argc, argv, [&](participant::Arguments& arguments) {
    auto problem = problem_of(arguments, communicator.count());
    arguments.options.timeout_s = problem.scene.coupling.timeout_s;  // until the coupler states its own
    return std::make_unique<explicit_solver::ExplicitSolver>(std::move(problem), arguments.name,
                                                             arguments.critical_time_step_s, &ranks);
  });
  if (ranks.going_on()) communicator.abort(code);
  std::string nothing;
  if (!ranks.begun()) communicator.broadcast(nothing);
  return code;
}

/// The first rank says what is wrong with the scene as well, to the coupler: the others wait for that.
void follow(int argc, char** argv, MpiCommunicator& communicator) {
  std::string said, name;
  std::optional<scene::Problem> problem;
  std::exception_ptr wrong;
  try {
    const auto arguments = participant::parse_arguments(argc, argv);
    name = arguments.name;
    problem = problem_of(arguments, communicator.count());
  } catch (...) {
    wrong = std::current_exception();
  }
  communicator.broadcast(said);
  if (said.empty()) return;
  try {
    if (wrong) std::rethrow_exception(wrong);
    explicit_solver::follow(*problem, name, said, communicator);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "participant '%s', rank %d: %s\n", name.c_str(), communicator.rank(), error.what());
    communicator.abort(exit_code_of_exception(error));
  }
}

}  // namespace

/// explicit_solver in several processes, started together by mpirun or srun.
int main(int argc, char** argv) {
  MpiCommunicator communicator(argc, argv);
  if (communicator.rank() == 0) return take_part(argc, argv, communicator);
  follow(argc, argv, communicator);
  return 0;
}

#include "coupler/processes/executable.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <sstream>

#include "common/base/error.hpp"
#include "common/base/process.hpp"

namespace ricochet::coupler {
namespace {

namespace fs = std::filesystem;

bool executable(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored) && access(path.c_str(), X_OK) == 0;
}

/// Empty if it is in none of its folders.
std::string in_search_path(const std::string& program) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');) {
    if (executable(fs::path(folder) / program)) return fs::path(folder) / program;
  }
  return "";
}

fs::path shipped_path(const scene::ParticipantSpec& participant) {
  std::error_code error;
  const auto self = fs::read_symlink("/proc/self/exe", error);
  if (error)
    throw MachineError(
        fmt::format("cannot read /proc/self/exe: {} (errno {}); ricochet needs /proc", error.message(), error.value()));
  return self.parent_path() / shipped_program(participant);
}

/// The command that starts the processes of a participant that has several.
std::vector<std::string> mpirun(int ranks) {
  std::vector<std::string> words = {"mpirun", "-n", std::to_string(ranks), "--oversubscribe", "--bind-to", "none"};
  if (geteuid() == 0) words.insert(words.begin() + 1, "--allow-run-as-root");
  return words;
}

}  // namespace

std::string shipped_program(const scene::ParticipantSpec& participant) {
  if (participant.role == scene::Role::implicit_solver) return "implicit_solver";
  if (participant.reduced) return "reduced_solver";
  return participant.ranks ? "explicit_solver_mpi" : "explicit_solver";
}

std::string find_executable(const scene::Scene& scene, const scene::ParticipantSpec& participant) {
  const bool own = participant.executable.empty();
  const bool bare_name = !own && participant.executable.find('/') == std::string::npos;
  if (bare_name) {
    if (auto found = in_search_path(participant.executable); !found.empty()) return found;
    throw ParticipantError(
        fmt::format("participant '{}': the program {} is in no folder of PATH; correct `executable` in the "
                    "scene (a path with '/' counts from the folder of the scene file)",
                    participant.name, participant.executable));
  }
  fs::path path = own ? shipped_path(participant) : fs::path(scene.path).parent_path() / participant.executable;
  path = fs::absolute(path).lexically_normal();
  if (executable(path)) return path.string();
  std::error_code no_status;  // of a name that no file can have
  const std::string advice =
      own && participant.ranks
          ? "ranks need OpenMPI and METIS: install libopenmpi-dev, openmpi-bin and libmetis-dev and build again"
      : own ? "build it (cmake --build), or name another program with `executable` in the scene"
            : "correct `executable` in the scene, paths count from the folder of the scene file";
  throw ParticipantError(fmt::format("participant '{}': the program {} {}; {}", participant.name, path.string(),
                                     fs::exists(path, no_status) ? "may not be executed (chmod +x?)" : "does not exist",
                                     advice));
}

std::vector<std::string> launch_prefix(const scene::Scene& scene, const scene::ParticipantSpec& participant) {
  const bool slurm = scene.coupling.launcher == scene::LaunchedBy::slurm;
  if (slurm && !std::getenv("SLURM_JOB_ID")) {
    throw ConfigError(fmt::format(
        "{}: found \"slurm\" outside an allocation of Slurm (SLURM_JOB_ID is not set); `{} slurm-script {}` "
        "writes the script to submit, \"local\" starts all participants on this machine",
        scene.where("coupling.launcher"), command_name, scene.path));
  }
  auto words = participant.launch;
  if (words.empty() && slurm) {
    // One step each, with processors that no other step has, and with the memory of the job, which is not shared out.
    words = {"srun", "--exact", "--mem=0", participant.ranks ? "--mpi=pmix" : "--nodes=1",
             fmt::format("--ntasks={}", participant.ranks.value_or(1))};
    if (participant.threads) words.push_back(fmt::format("--cpus-per-task={}", *participant.threads));
  } else if (words.empty() && participant.ranks) {
    words = mpirun(*participant.ranks);
  }
  if (words.empty()) return words;
  const bool on_path = words.front().find('/') == std::string::npos;
  const std::string found = on_path ? in_search_path(words.front()) : executable(words.front()) ? words.front() : "";
  if (found.empty()) {
    throw ParticipantError(fmt::format("participant '{}': the program {}, by which it is to be launched, {}",
                                       participant.name, words.front(),
                                       on_path ? "is in no folder of PATH" : "does not exist or may not be executed"));
  }
  words.front() = found;
  return words;
}

}  // namespace ricochet::coupler

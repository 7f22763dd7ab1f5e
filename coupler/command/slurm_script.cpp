#include "coupler/command/slurm_script.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <regex>

#include "common/base/error.hpp"
#include "common/base/write_file.hpp"
#include "coupler/processes/given_scene.hpp"
#include "coupler/processes/machine_check.hpp"

namespace ricochet::coupler {
namespace {

namespace fs = std::filesystem;

// The shell waits for the run in the background, because it hears no signal while it waits for a program in front;
// `wait` ends at the signal, and once more when the run has ended.
constexpr const char* batch_script =
    R"script(#!/bin/bash
# Computes {scene_path} on Slurm; written by `ricochet slurm-script` (docs/large_runs.md).
#   sbatch SCRIPT [DIR]    DIR: the results folder; from a checkpoint in it the run goes on
#SBATCH --job-name={name}
#SBATCH {tasks}
{time}#SBATCH --signal=B:TERM@60
#SBATCH --requeue
#SBATCH --open-mode=append

ricochet={ricochet}
scene={scene}
results=${{1:-{results}}}

last_checkpoint() {{ ls "$results/checkpoint" 2> /dev/null | grep '^[0-9]*\.json$' | sort -n | tail -n 1; }}

begun_at=$(last_checkpoint)
if [ -n "$begun_at" ]; then
  "$ricochet" resume "$results" --scene {resumed} &
else
  "$ricochet" run "$scene" --out "$results" &
fi
run=$!
# A minute before the time limit: the run makes a checkpoint and ends.
trap 'signalled=yes; kill -TERM $run' TERM
wait $run
code=$?
while [ -n "$signalled" ]; do
  signalled=
  wait $run
  code=$?
done
# The time limit (143) and a lost participant or node (4) end this job, not the run, as long as it gets further. A job
# that was cancelled is not RUNNING any more.
case $code in
  4 | 143)
    state=$(squeue --noheader --jobs "$SLURM_JOB_ID" --format %T)
    if [ "$(last_checkpoint)" != "$begun_at" ] && [ "$state" = RUNNING ]; then
      scontrol requeue "$SLURM_JOB_ID"
    fi
    ;;
esac
exit $code
)script";

/// A word for the shell, whatever is in it.
std::string quoted(const std::string& word) {
  std::string result = "'";
  for (const char letter : word) result += letter == '\'' ? std::string("'\\''") : std::string(1, letter);
  return result + "'";
}

/// A line of the script could end in it, and another begin.
void require_printable(const std::string& path) {
  const auto control = [](unsigned char c) { return c < ' ' || c == 0x7f; };
  if (std::none_of(path.begin(), path.end(), control)) return;
  throw ConfigError(
      fmt::format("{}: found a control character in this path, allowed is none in a batch script; rename it", path));
}

std::string own_path() { return fs::read_symlink("/proc/self/exe").string(); }

/// One processor for each thread of each process of a participant that is launched and one for the coupler: on one
/// node, or tasks on any nodes. A task of several processors has all of them on one node; tasks are of one size.
std::string tasks_of(const scene::Scene& scene) {
  int launched = 0, threads = 0, most_threads = 1;
  for (const auto& participant : scene.participants) {
    if (participant.start != scene::Start::launch) continue;
    const int processes = participant.ranks.value_or(1);
    launched += processes;
    threads += processes * participant.threads.value_or(1);
    most_threads = std::max(most_threads, participant.threads.value_or(1));
  }
  if (scene.coupling.launcher != scene::LaunchedBy::slurm)
    return fmt::format("--nodes=1 --ntasks=1 --cpus-per-task={}", threads + 1);
  return fmt::format("--ntasks={}", launched + 1) +
         (most_threads > 1 ? fmt::format(" --cpus-per-task={}", most_threads) : "");
}

std::string time_line(const std::optional<std::string>& time) {
  if (!time) return "";
  static const std::regex known(R"((\d+-)?\d+(:\d+){0,2})");
  if (!std::regex_match(*time, known)) {
    throw ConfigError(
        fmt::format("--time: found \"{}\", allowed: MINUTES, MINUTES:SECONDS, HOURS:MINUTES:SECONDS or "
                    "DAYS-HOURS[:MINUTES[:SECONDS]]",
                    *time));
  }
  return fmt::format("#SBATCH --time={}\n", *time);
}

std::string job_name(const std::string& stem) {
  static const std::regex unusual("[^A-Za-z0-9_.-]");
  return std::regex_replace(stem, unusual, "_");
}

}  // namespace

void write_slurm_script(const std::string& scene_path, const std::string& out, const std::optional<std::string>& time) {
  const auto problem = load_problem(scene_path);
  const auto& path = problem.scene.path;
  const std::string stem = fs::path(path).stem().string();
  const auto program = own_path(), results = fs::absolute("out/" + stem).string();
  for (const auto& each : {path, program, results}) require_printable(each);
  const std::string changed = quoted(changed_scene_name(path));
  const std::string resumed = problem.scene.leaves_open() ? "\"$results\"/" + changed : "\"$scene\"";
  const auto script = fmt::format(batch_script, fmt::arg("resumed", resumed), fmt::arg("scene_path", path),
                                  fmt::arg("name", job_name(stem)), fmt::arg("tasks", tasks_of(problem.scene)),
                                  fmt::arg("time", time_line(time)), fmt::arg("ricochet", quoted(program)),
                                  fmt::arg("scene", quoted(path)), fmt::arg("results", quoted(results)));
  if (out.empty()) {
    fmt::print("{}", script);
    return;
  }
  std::error_code no_status;  // of a name that no file can have: writing it says so
  if (fs::exists(out, no_status))
    throw ConfigError(fmt::format("{} exists already; give another name or remove it first", out));
  write_atomically(out, script, 0755);
  fmt::print("wrote {}: sbatch {}\n", out, out);
}

}  // namespace ricochet::coupler

#include "tests/bench/process_run.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "common/base/error.hpp"
#include "tests/support/places.hpp"

namespace ricochet::bench {
namespace {

std::string file_text(const std::string& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

[[noreturn]] void become(std::vector<std::string>& command, const std::string& log) {
  const int file = open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  if (file < 0) _exit(126);
  dup2(file, STDOUT_FILENO);
  dup2(file, STDERR_FILENO);
  std::vector<char*> arguments;
  for (auto& word : command) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  execv(arguments[0], arguments.data());
  _exit(127);
}

double seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

std::vector<std::string> cells(const std::string& line) {
  std::vector<std::string> result;
  std::istringstream stream(line);
  for (std::string cell; std::getline(stream, cell, ',');) result.push_back(cell);
  return result;
}

/// Change of a column of history.csv from its first row to its last.
double change(const std::string& path, const std::string& column) {
  std::ifstream file(path);
  std::string line, first, last;
  std::getline(file, line);
  const auto names = cells(line);
  const auto index = static_cast<std::size_t>(std::find(names.begin(), names.end(), column) - names.begin());
  while (std::getline(file, line)) {
    if (first.empty()) first = line;
    last = line;
  }
  return std::stod(cells(last).at(index)) - std::stod(cells(first).at(index));
}

pid_t start(std::vector<std::string>& command, const std::string& log) {
  const pid_t child = fork();
  if (child < 0) throw ParticipantError("cannot start another process");
  if (child == 0) become(command, log);
  return child;
}

[[noreturn]] void refuse_failed(const std::vector<std::string>& command, const std::string& log) {
  throw ParticipantError(fmt::format("{} failed:\n{}", fmt::join(command, " "), file_text(log)));
}

bool succeeded(int status) { return WIFEXITED(status) && WEXITSTATUS(status) == 0; }

/// The memory of a process and all that it started; 0 once it is gone [bytes].
double resident_b(const std::string& process) {
  double pages = 0.0, all = 0.0, below_b = 0.0;
  std::ifstream("/proc/" + process + "/statm") >> all >> pages;
  std::ifstream children("/proc/" + process + "/task/" + process + "/children");
  for (std::string child; children >> child;) below_b += resident_b(child);
  return pages * static_cast<double>(sysconf(_SC_PAGESIZE)) + below_b;
}

std::vector<std::string> command_of_run(const std::string& scene, const std::string& out) {
  return {test::build_folder() + "/ricochet", "run", scene, "--out", out};
}

}  // namespace

double peak_memory_of_run_b(const std::string& scene, const std::string& out) {
  using namespace std::chrono_literals;
  auto command = command_of_run(scene, out);
  const std::string log = out + ".log";
  const pid_t child = start(command, log);
  double peak = 0.0;
  int status = 0;
  pid_t ended = 0;
  while ((ended = waitpid(child, &status, WNOHANG)) == 0) {
    peak = std::max(peak, resident_b(std::to_string(child)));
    std::this_thread::sleep_for(10ms);
  }
  if (ended != child || !succeeded(status)) refuse_failed(command, log);
  return peak;
}

Usage run_command(std::vector<std::string> command, const std::string& log) {
  const auto begin = std::chrono::steady_clock::now();
  const pid_t child = start(command, log);
  int status = 0;
  rusage used{};
  if (wait4(child, &status, 0, &used) != child || !succeeded(status)) refuse_failed(command, log);
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin;
  return {wall.count(), seconds(used.ru_utime) + seconds(used.ru_stime), 1024.0 * static_cast<double>(used.ru_maxrss)};
}

SceneRun run_scene(const std::string& scene, int substeps, const std::string& out) {
  SceneRun run;
  run.usage = run_command(command_of_run(scene, out), out + ".log");
  const auto summary = nlohmann::json::parse(file_text(out + "/summary.json"));
  const auto& phases = summary.at("phases");
  run.stepping_s = phases.at("stepping_s").get<double>();
  run.wall_s = summary.at("wall_s").get<double>();
  run.peak_force_n = summary.at("peak_contact_force_n").get<double>();
  run.window_s = run.stepping_s / summary.at("windows").get<double>();
  run.step_s = run.window_s / substeps;
  run.setup_s = phases.at("start_s").get<double>() + phases.at("setup_s").get<double>();
  run.speed_change_m_s = change(out + "/history.csv", "velocity_mean_steel_m_s");
  return run;
}

}  // namespace ricochet::bench

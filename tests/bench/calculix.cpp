#include "tests/bench/calculix.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <sstream>

#include "common/base/error.hpp"
#include "common/base/write_file.hpp"
#include "coupler/report/parts/history_table.hpp"
#include "tests/bench/line_picture.hpp"
#include "tests/bench/process_run.hpp"
#include "tests/bench/reference_scene.hpp"

namespace ricochet::bench {
namespace {

const std::vector<std::string> protocols = {"hughes_liu", "all_implicit"};

bool on_path(const std::string& program) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');) {
    if (access((folder + "/" + program).c_str(), X_OK) == 0) return true;
  }
  return false;
}

/// history.csv without its first row, t = 0.
PressureHistory history_of(const std::string& run) {
  const auto table = report::read_history(run + "/history.csv");
  const auto &time_s = *table.find("time_s"), &pressure_pa = *table.find("contact_pressure_mean_pa");
  return {{time_s.begin() + 1, time_s.end()}, {pressure_pa.begin() + 1, pressure_pa.end()}};
}

/// Mean over the later half of the steps: the plateau, after the oscillations of the first contact.
double plateau_pa(const PressureHistory& history) {
  const auto& p = history.pressure_pa;
  double sum = 0.0;
  for (std::size_t i = p.size() / 2; i < p.size(); ++i) sum += p[i];
  return sum / static_cast<double>(p.size() - p.size() / 2);
}

/// RMS of the difference from step `first` (0-based) on, over the plateau of `ours`.
double deviation(const PressureHistory& ours, const PressureHistory& other, std::size_t first) {
  double squares = 0.0;
  for (std::size_t i = first; i < ours.pressure_pa.size(); ++i) {
    squares += std::pow(ours.pressure_pa[i] - other.pressure_pa.at(i), 2);
  }
  return std::sqrt(squares / static_cast<double>(ours.pressure_pa.size() - first)) / plateau_pa(ours);
}

PictureLine line(const std::string& label, const char* colour, const char* dash, const PressureHistory& history) {
  PictureLine line{label, colour, dash, history.time_s, history.pressure_pa};
  for (double& time : line.x) time *= 1e6;
  for (double& pressure : line.y) pressure *= 1e-6;
  return line;
}

}  // namespace

CalculixRuns::CalculixRuns(std::string folder, long steps)
    : folder_(std::move(folder)), steps_(steps), installed_(on_path("ccx")) {}

void CalculixRuns::repeat() {
  if (!installed_) return;
  SceneChoice choice;
  choice.steps = steps_;
  choice.every_step = true;
  const std::string path = folder_ + "/scene.toml";
  run_calculix(write_reference_scene(choice, path));
  for (const auto& protocol : protocols) {
    choice.protocol = protocol;
    run_ours(protocol, write_reference_scene(choice, path));
  }
}

void CalculixRuns::run_calculix(const std::string& scene) {
  const std::string job = folder_ + "/calculix";  // a folder: ccx litters where it runs
  std::filesystem::create_directories(job);
  write_atomically(job + "/deck.inp", calculix_deck(scene::build_problem(scene::load_scene(scene)), steps_));
  const auto usage = run_command({"/usr/bin/env", "--chdir=" + job, "ccx", "-i", "deck"}, job + "/deck.log");
  calculix_wall_s_.push_back(usage.wall_s);
  calculix_ = calculix_pressure(report::read_text(job + "/deck.dat"));
  if (calculix_.time_s.size() == static_cast<std::size_t>(steps_)) return;
  throw ParticipantError(fmt::format("CalculiX gave contact forces of {} steps, expected {}; see {}/deck.log",
                                     calculix_.time_s.size(), steps_, job));
}

void CalculixRuns::run_ours(const std::string& protocol, const std::string& scene) {
  const std::string out = folder_ + "/run";
  auto& runs = ours_[protocol];
  runs.wall_s.push_back(run_scene(scene, 1, out).usage.wall_s);
  runs.history = history_of(out);
  runs.deviation.push_back(deviation(runs.history, calculix_, 0));
  runs.deviation_later.push_back(deviation(runs.history, calculix_, 1));
}

std::vector<Row> CalculixRuns::rows() const {
  const std::string mesh = mesh_name(1), missing = installed_ ? "" : "calculix-ccx not installed";
  std::vector<Row> rows;
  for (const auto& protocol : protocols) {
    const auto found = ours_.find(protocol);
    const Runs runs = found == ours_.end() ? Runs{} : found->second;
    rows.push_back({fmt::format("CalculiX / {}, first {} steps, wall time of the whole command", protocol, steps_),
                    mesh,
                    quotients(calculix_wall_s_, runs.wall_s),
                    {},
                    missing});
    const auto add = [&](int first, const std::vector<double>& values) {
      rows.push_back({fmt::format("CalculiX - {}, contact pressure: RMS of steps {} to {} / mean of the later half",
                                  protocol, first, steps_),
                      mesh,
                      values,
                      {},
                      missing});
    };
    add(1, runs.deviation);
    add(2, runs.deviation_later);
  }
  return rows;
}

std::vector<std::string> CalculixRuns::write_picture() const {
  if (calculix_.time_s.empty()) return {};
  const auto &hybrid = ours_.at("hughes_liu").history, &implicit = ours_.at("all_implicit").history;
  std::string csv = "time_s,calculix_pa,hughes_liu_pa,all_implicit_pa\n";
  for (std::size_t i = 0; i < calculix_.time_s.size(); ++i) {
    csv += fmt::format("{:.9g},{:.9g},{:.9g},{:.9g}\n", calculix_.time_s[i], calculix_.pressure_pa[i],
                       hybrid.pressure_pa[i], implicit.pressure_pa[i]);
  }
  write_atomically(folder_ + "/calculix.csv", csv);
  write_atomically(
      folder_ + "/calculix.svg",
      line_picture(
          fmt::format("Mean contact pressure, mesh {}, friction 0.1, the first {} steps", mesh_name(1), steps_),
          "time [µs]", "contact pressure [MPa]",
          {line("hughes_liu", "#0072b2", "", hybrid), line("all_implicit", "#d55e00", "8 6", implicit),
           line("CalculiX, penalty", "#000000", "2 3", calculix_)},
          1.5e-6 * plateau_pa(implicit)));
  return {"calculix.csv", "calculix.svg"};
}

}  // namespace ricochet::bench

#include "coupler/study/study_case.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <map>

#include "common/base/error.hpp"
#include "common/base/process.hpp"
#include "common/base/sha256.hpp"
#include "common/scene/toml_file.hpp"
#include "coupler/processes/machine_check.hpp"
#include "coupler/processes/participants.hpp"
#include "coupler/report/parts/history_table.hpp"
#include "coupler/report/run_page/summary_page.hpp"
#include "coupler/run/compute_scene.hpp"

namespace ricochet::coupler {
namespace {

namespace fs = std::filesystem;

/// Programs are read once; several MB each.
const std::string& program_digest(const std::string& path) {
  static std::map<std::string, std::string> known;
  auto& digest = known[path];
  if (digest.empty()) digest = sha256_hex(report::read_text(path));
  return digest;
}

std::string key_of(const std::string& variant_path) {
  try {
    const auto scene = scene::load_scene(variant_path);
    std::vector<std::string> digests{program_digest("/proc/self/exe")};
    for (const auto& program : find_executables(scene)) {
      if (!program.empty()) digests.push_back(program_digest(program));
    }
    return run_key(scene.sha256, digests);
  } catch (const Error&) {  // refused below, where the error can name the file in its place
    return run_key(sha256_hex(report::read_text(variant_path)), {});
  }
}

}  // namespace

std::string run_key(const std::string& scene_sha256, const std::vector<std::string>& program_sha256) {
  return sha256_hex(fmt::format("{} {} {}", RICOCHET_VERSION, scene_sha256, fmt::join(program_sha256, " ")))
      .substr(0, 16);
}

StudyCase::StudyCase(const std::string& scene_path, std::vector<scene::Override> changes, const std::string& folder) {
  for (const char* output : {"output.fields_every", "output.axial_stress_every"}) changes.push_back({output, 0.0});
  fs::create_directories(folder);
  OwnFiles own(folder);
  own.claim({"draft.toml"});
  const std::string draft = folder + "/draft.toml";
  scene::write_variant(scene_path, changes, draft);
  folder_ = folder + "/" + key_of(draft);
  own.claim({key() + "/scene.toml"});
  fs::create_directories(folder_);
  const std::string path = folder_ + "/scene.toml";
  fs::rename(draft, path);
  try {
    problem_ = load_problem(path);
    plan_ = scene::plan(*problem_);
    executables_ = find_executables(problem_->scene);
  } catch (const Error& error) {
    fail(status_of(error), static_cast<int>(error.code()), error.what());
    return;
  }
  while (read_repeat(repeats() + 1)) continue;
}

std::string StudyCase::key() const { return fs::path(folder_).filename().string(); }

/// Takes a repeat that is there; false if there is none that counts.
bool StudyCase::read_repeat(int repeat) {
  const std::string path = repeat_folder(repeat) + "/summary.json";
  if (!scene::is_file(path)) return false;
  const auto summary = report::read_summary(path);
  const auto status = find_named<RunStatus>(summary.value("status", ""));
  // A run that left the model, but was not stopped by that, has its results; its own page says what they are worth.
  const bool ended =
      status == RunStatus::done || (status == RunStatus::left_model && summary.value("exit_code", 0) == 0);
  if (status == RunStatus::unstable || (status == RunStatus::left_model && !ended)) {
    fail(*status, summary.value("exit_code", 0), summary.value("error", std::string(name_of(*status))));
    return false;
  }
  if (!ended) return false;
  const auto value = [](const report::Json& json, const char* key) { return report::number(json, key).value_or(0.0); };
  const auto& phases = summary.at("phases");
  costs_.push_back({value(summary, "wall_s"), value(summary, "cpu_s"), value(phases, "start_s"),
                    value(phases, "setup_s"), value(phases, "stepping_s")});
  steps_ = summary.value("windows", 0LL);
  status_ = RunStatus::done;
  return true;
}

void StudyCase::fail(RunStatus status, int exit_code, const std::string& error) {
  status_ = status;
  exit_code_ = exit_code;
  error_ = printable(error.substr(0, error.find('\n')));
}

void StudyCase::compute() {
  const int repeat = repeats() + 1;
  if (read_repeat(repeat)) return;  // by another method or setting that comes to the same scene
  try {
    auto from = checkpoint_of(repeat_folder(repeat), problem_->scene);  // of a study that was interrupted
    const ResultsDirectory results(repeat_folder(repeat), files_of_run(problem_->scene), {},
                                   from ? Former::kept : Former::removed);
    if (from) results.go_on_from(from->window, participant_names(problem_->scene));
    compute_scene(*problem_, *plan_, executables_, results, std::move(from));
  } catch (const Error& error) {
    fail(status_of(error), static_cast<int>(error.code()), error.what());
    return;
  }
  if (!read_repeat(repeat)) fail(RunStatus::participant_failed, 1, "no summary.json in " + repeat_folder(repeat));
}

Observation StudyCase::observation() const {
  const std::string folder = repeat_folder(1);
  const std::string probes = folder + "/probes.csv";
  return observe(report::read_history(folder + "/history.csv"), report::read_summary(folder + "/summary.json"),
                 scene::is_file(probes) ? report::read_history(probes) : report::HistoryTable());
}

}  // namespace ricochet::coupler

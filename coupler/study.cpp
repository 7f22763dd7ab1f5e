#include "coupler/study.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "common/base/error.hpp"
#include "common/base/write_file.hpp"
#include "coupler/report/report.hpp"
#include "coupler/results_directory.hpp"
#include "coupler/study_results.hpp"

namespace ricochet::coupler {
namespace {

using Json = nlohmann::ordered_json;

class Study {
 public:
  Study(StudyFile file, const ResultsDirectory& results) : file_(std::move(file)), results_(results) {}
  void run();

 private:
  void find_reference();
  void compute_reference();
  void prepare_rows();
  void compute_rows();
  void measure(StudyRow& row) const;
  [[nodiscard]] double remaining_s(std::size_t next, int repeat) const;
  void write_files() const;
  [[nodiscard]] Json description() const;

  StudyFile file_;
  const ResultsDirectory& results_;
  Observation reference_;
  std::string reference_text_;
  std::vector<std::optional<double>> reference_errors_;  ///< of the study's quantities
  std::vector<StudyRow> rows_;
};

/// What is measured is the computation, not the snapshots.
std::vector<scene::Override> with_no_fields(std::vector<scene::Override> changes) {
  changes.push_back({"output.fields_every", 0.0});
  changes.push_back({"output.axial_stress_every", 0.0});
  return changes;
}

StudyCase computed(const std::string& what, const std::string& scene, const std::vector<scene::Override>& changes,
                   const std::string& folder) {
  StudyCase run(scene, with_no_fields(changes), folder);
  if (!run.failed() && run.repeats() == 0) {
    fmt::print("{}: computed in {}\n", what, run.folder());
    std::fflush(stdout);
    run.compute();
  } else if (!run.failed()) {
    fmt::print("{}: from {}\n", what, run.folder());
  }
  if (run.failed()) {
    throw Error(static_cast<ExitCode>(run.exit_code()), fmt::format("the {} failed: {}", what, run.error()));
  }
  return run;
}

void Study::compute_reference() {
  const auto& spec = file_.reference;
  const auto run = computed("reference", file_.scene, spec.changes, results_.file("reference"));
  auto finer = spec.changes;
  finer.insert(finer.end(), spec.refine.begin(), spec.refine.end());
  const auto refined = computed("reference, refined", file_.scene, finer, results_.file("reference"));
  reference_ = run.observation();
  const auto check = refined.observation();
  for (const auto& quantity : file_.quantities) reference_errors_.push_back(error_of(quantity, reference_, check));
  std::vector<std::string> words;
  for (const auto& change : spec.changes) words.push_back(fmt::format("{} = {}", change.key, text_of(change)));
  reference_text_ = fmt::format("{}", fmt::join(words, ", "));
}

void Study::find_reference() {
  if (!file_.reference.exact) {
    compute_reference();
  } else {
    reference_ = exact_impact(scene::build_problem(scene::load_scene(file_.scene)));
    reference_text_ = "impedance theory, exact";
    reference_errors_.assign(file_.quantities.size(), 0.0);
  }
  fmt::print("reference: {}\n", reference_text_);
  for (std::size_t q = 0; q < file_.quantities.size(); ++q) {
    const auto& error = reference_errors_[q];
    fmt::print("  own error of {:<18} {}\n", file_.quantities[q], error ? fmt::format("{:.3g}", *error) : "no value");
  }
}

void Study::prepare_rows() {
  for (const auto& settings : combinations(file_.variations)) {
    for (const auto& method : file_.methods) {
      auto changes = settings;
      changes.push_back({"coupling.protocol", method});
      rows_.push_back({method, settings, StudyCase(file_.scene, with_no_fields(changes), results_.file("runs")), {}});
      rows_.back().errors.resize(file_.quantities.size());
      if (rows_.back().run.repeats() > 0) measure(rows_.back());
    }
  }
  const auto refused = [](const StudyRow& row) { return row.run.status() == "scene_wrong"; };
  if (std::all_of(rows_.begin(), rows_.end(), refused)) {
    throw ConfigError(fmt::format("{}: every run of the study is refused, the first with: {}", file_.path,
                                  rows_.front().run.error()));
  }
}

void Study::measure(StudyRow& row) const {
  const auto seen = row.run.observation();
  for (std::size_t q = 0; q < file_.quantities.size(); ++q) {
    row.errors[q] = error_of(file_.quantities[q], seen, reference_);
  }
}

/// Estimate: what is still to run takes as long as it did before, or as long as the mean of all others.
double Study::remaining_s(std::size_t next, int repeat) const {
  double sum = 0.0, known_s = 0.0;
  int known = 0, unknown = 0;
  for (const auto& row : rows_) {
    for (const auto& cost : row.run.costs()) known_s += cost.wall_s;
    known += row.run.repeats();
  }
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    const auto& run = rows_[r].run;
    const int left = file_.repeats - std::max(run.repeats(), r < next ? repeat : repeat - 1);
    if (run.failed() || left <= 0) continue;
    if (run.repeats() > 0)
      sum += left * run.costs().back().wall_s;
    else
      unknown += left;
  }
  return sum + (known > 0 ? unknown * known_s / known : 0.0);
}

/// Methods take turns, so that what disturbs the machine for a while disturbs all of them.
void Study::compute_rows() {
  const auto total = rows_.size() * static_cast<std::size_t>(file_.repeats);
  for (int repeat = 1; repeat <= file_.repeats; ++repeat) {
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      auto& row = rows_[r];
      if (row.run.failed() || row.run.repeats() >= repeat) continue;
      row.run.compute();
      if (!row.run.failed() && repeat == 1) measure(row);
      write_files();
      const std::string cost =
          row.run.failed()
              ? row.run.error()
              : fmt::format("{:.3f} s wall, {:.3f} s CPU", row.run.costs().back().wall_s, row.run.costs().back().cpu_s);
      fmt::print("[{}/{}] {}: {}, {}; about {:.0f} s left\n",
                 static_cast<std::size_t>(repeat - 1) * rows_.size() + r + 1, total, label_of(row), row.run.status(),
                 cost, remaining_s(r + 1, repeat));
      std::fflush(stdout);
    }
  }
}

Json Study::description() const {
  Json errors = Json::object();
  for (std::size_t q = 0; q < file_.quantities.size(); ++q) {
    errors[file_.quantities[q]] = reference_errors_[q] ? Json(*reference_errors_[q]) : Json(nullptr);
  }
  return {{"study", file_.path},        {"study_file", file_.text},         {"scene", file_.scene},
          {"methods", file_.methods},   {"parameters", varied_keys(file_)}, {"quantities", file_.quantities},
          {"repeats", file_.repeats},   {"reference", reference_text_},     {"reference_errors", errors},
          {"version", RICOCHET_VERSION}};
}

void Study::write_files() const {
  write_atomically(results_.file("results.csv"), to_csv(file_, rows_));
  write_atomically(results_.file("study.json"),
                   description().dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

void Study::run() {
  find_reference();
  prepare_rows();
  write_files();
  compute_rows();
  fmt::print("\n{}", to_table(file_, rows_));
}

}  // namespace

void run_study(const std::string& study_path, const std::string& out) {
  auto file = load_study(study_path);
  const std::string stem = std::filesystem::path(file.path).stem().string();
  const ResultsDirectory results(out.empty() ? "out/" + stem : out);
  Study(std::move(file), results).run();
  report::write_report(results.path());
  fmt::print("results in {}: results.csv, study.json, report.html, runs/, reference/\n", results.path());
}

}  // namespace ricochet::coupler

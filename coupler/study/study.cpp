#include "coupler/study/study.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "common/base/error.hpp"
#include "common/base/write_file.hpp"
#include "coupler/processes/given_scene.hpp"
#include "coupler/report/report.hpp"
#include "coupler/results/results_directory.hpp"
#include "coupler/study/study_reference.hpp"
#include "coupler/study/study_results.hpp"

namespace ricochet::coupler {
namespace {

using Json = nlohmann::ordered_json;

class Study {
 public:
  Study(StudyFile file, const ResultsDirectory& results) : file_(std::move(file)), results_(results) {}
  void run();

 private:
  void prepare_rows();
  void compute_rows();
  void measure(StudyRow& row) const;
  [[nodiscard]] std::size_t compared_with(const StudyRow& row) const;
  void compare_histories();
  [[nodiscard]] double remaining_s(std::size_t next, int repeat) const;
  void write_results() const;
  void write_histories() const;
  [[nodiscard]] Json description() const;

  StudyFile file_;
  const ResultsDirectory& results_;
  std::vector<StudyReference> references_;
  std::vector<StudyRow> rows_;
  std::vector<std::size_t> compared_;  ///< per row that whose history its own is compared with
};

void Study::prepare_rows() {
  std::vector<std::vector<std::vector<scene::Override>>> of_methods;
  for (const auto& method : file_.methods) of_methods.push_back(combinations(file_.variations, method.name));
  for (const auto& settings : all_combinations(file_)) {
    for (std::size_t m = 0; m < file_.methods.size(); ++m) {
      if (!is_of(of_methods[m], settings)) continue;
      const auto& method = file_.methods[m];
      auto changes = merged(settings, method.changes);
      changes.push_back({"coupling.protocol", method.protocol});
      StudyCase run(file_.scene, changes, results_.file("runs"));
      rows_.push_back({method.name, settings, std::move(run), {}, {}, {}, {}, {}});
      rows_.back().errors.resize(file_.quantities.size());
      if (rows_.back().run.repeats() > 0) measure(rows_.back());
    }
  }
  const auto refused = [](const StudyRow& row) { return row.run.status() == RunStatus::scene_wrong; };
  if (std::all_of(rows_.begin(), rows_.end(), refused)) {
    throw ConfigError(fmt::format("{}: every run of the study is refused, the first with: {}", file_.path,
                                  rows_.front().run.error()));
  }
}

void Study::measure(StudyRow& row) const {
  const auto& reference = reference_of(references_, row.settings).seen;
  row.seen = row.run.observation();
  if (!file_.values.empty()) row.values = values_of(row.run.folder() + "/1", row.run.problem().scene);
  for (std::size_t q = 0; q < file_.quantities.size(); ++q) {
    row.errors[q] = error_of(file_.quantities[q], *row.seen, reference);
  }
}

/// The run of the other method at the same settings, or, where one of them has keys of its own, at the same ones of all
/// methods.
std::size_t Study::compared_with(const StudyRow& row) const {
  const auto of_other = [&](const StudyRow& other) { return other.method == file_.histories.compare_to; };
  const auto common = of_all_methods(file_, row.settings);
  auto found = std::find_if(rows_.begin(), rows_.end(), [&](const StudyRow& other) {
    return of_other(other) && same_settings(other.settings, row.settings);
  });
  if (found == rows_.end())
    found = std::find_if(rows_.begin(), rows_.end(), [&](const StudyRow& other) {
      return of_other(other) && same_settings(of_all_methods(file_, other.settings), common);
    });
  return static_cast<std::size_t>(found - rows_.begin());
}

void Study::compare_histories() {
  const auto& histories = file_.histories;
  if (!histories.wanted()) return;
  const auto rms = [&](const Observation& run, const Observation& other) -> std::optional<double> {
    const auto difference = rms_difference(histories.quantity, run, other);
    return difference ? std::optional(*difference / histories.over_pa) : std::nullopt;
  };
  for (std::size_t r = compared_.size(); r < rows_.size(); ++r) compared_.push_back(compared_with(rows_[r]));
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    auto& row = rows_[r];
    if (!row.seen) continue;
    if (!row.rms_reference) row.rms_reference = rms(*row.seen, reference_of(references_, row.settings).seen);
    const auto& other = rows_[compared_[r]];
    if (!row.rms_compared && other.seen) row.rms_compared = rms(*row.seen, *other.seen);
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
      if (!row.run.failed() && repeat == 1) {
        measure(row);
        compare_histories();
        write_histories();
      }
      write_results();
      const std::string cost =
          row.run.failed()
              ? row.run.error()
              : fmt::format("{:.3f} s wall, {:.3f} s CPU", row.run.costs().back().wall_s, row.run.costs().back().cpu_s);
      fmt::print("[{}/{}] {}: {}, {}; about {:.0f} s left\n",
                 static_cast<std::size_t>(repeat - 1) * rows_.size() + r + 1, total, label_of(file_, row),
                 row.run.status_text(), cost, remaining_s(r + 1, repeat));
      std::fflush(stdout);
    }
  }
}

/// Settings as a table of texts, as they stand in results.csv.
Json described(const std::vector<scene::Override>& settings) {
  Json table = Json::object();
  for (const auto& setting : settings) table[setting.key] = text_of(setting);
  return table;
}

Json described(const StudyFile& file, const StudyReference& reference) {
  Json errors = Json::object();
  for (std::size_t q = 0; q < file.quantities.size(); ++q) {
    errors[file.quantities[q]] = reference.errors[q] ? Json(*reference.errors[q]) : Json(nullptr);
  }
  return {{"reference", reference.text},
          {"run", reference.key},
          {"follows", described(reference.follows)},
          {"errors", errors}};
}

Json described(const HistoriesSpec& histories) {
  if (!histories.wanted()) return nullptr;
  return {{"quantity", histories.quantity},
          {"over_pa", histories.over_pa},
          {"over_name", histories.over_name},
          {"compare_to", histories.compare_to}};
}

Json described(const PublishedRatio& ratio) {
  return {{"methods", ratio.methods},
          {"over", ratio.over},
          {"at", described(ratio.at)},
          {"time_ratio", ratio.time_ratio},
          {"source", ratio.source}};
}

Json described(const StudyAxis& axis) {
  Json at = Json::object();
  for (const auto& [text, number] : axis.at) at[text] = number;
  return {{"title", axis.title}, {"at", at}};
}

Json described(const Measurement& one) {
  return {{"value", one.value},
          {"at", one.at},
          {"measured", one.measured},
          {"error", one.error > 0.0 ? Json(one.error) : Json(nullptr)},
          {"source", one.source}};
}

Json Study::description() const {
  Json references = Json::array(), published = Json::array(), axes = Json::array(), measured = Json::array();
  for (const auto& reference : references_) references.push_back(described(file_, reference));
  for (const auto& ratio : file_.published) published.push_back(described(ratio));
  for (const auto& one : file_.measurements) measured.push_back(described(one));
  Json together = Json::array();
  for (const auto& variation : file_.variations) {
    for (const auto& key : telling_keys(variation))
      if (std::find(axes.begin(), axes.end(), key) == axes.end()) axes.push_back(key);
    if (std::find(variation.keys.begin(), variation.keys.end(), file_.along) != variation.keys.end())
      together = variation.keys;
  }
  return {{"study", file_.path},
          {"study_file", file_.text},
          {"scene", file_.scene},
          {"methods", method_names(file_)},
          {"parameters", varied_keys(file_)},
          {"axes", axes},
          {"along", file_.along},
          {"along_together", together},
          {"axis", file_.axis ? described(*file_.axis) : Json(nullptr)},
          {"quantities", file_.quantities},
          {"values", file_.values},
          {"repeats", file_.repeats},
          {"references", references},
          {"histories", described(file_.histories)},
          {"published", published},
          {"measured", measured},
          {"version", RICOCHET_VERSION}};
}

void Study::write_results() const {
  write_atomically(results_.file("results.csv"), to_csv(file_, rows_));
  write_atomically(results_.file("study.json"),
                   description().dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

void Study::write_histories() const {
  if (file_.histories.wanted())
    write_atomically(results_.file("histories.csv"), histories_csv(file_, references_, rows_));
}

void Study::run() {
  references_ = find_references(file_, results_.file("reference"));
  prepare_rows();
  compare_histories();
  write_results();
  write_histories();
  compute_rows();
  fmt::print("\n{}", to_table(file_, rows_));
}

}  // namespace

void run_study(const std::string& study_path, const std::string& out, const std::vector<std::string>& set) {
  auto file = load_study(study_path);
  const GivenScene given{file.scene, set};
  if (!set.empty()) (void)given.load();  // refused before anything is written
  const std::string stem = std::filesystem::path(file.path).stem().string();
  std::vector<std::string> files{"results.csv", "study.json", "histories.csv", "report.html"};
  if (!set.empty()) files.push_back(changed_scene_name(file.scene));
  const ResultsDirectory results(out.empty() ? "out/" + stem : out, files, {file.path, file.scene});
  if (!set.empty()) {
    file.scene = write_changed_scene(given.path, given.changes(), results.path());
  }
  const bool histories = file.histories.wanted();
  Study(std::move(file), results).run();
  report::write_report(results.path());
  fmt::print("results in {}: results.csv, study.json, {}report.html, runs/, reference/\n", results.path(),
             histories ? "histories.csv, " : "");
}

}  // namespace ricochet::coupler

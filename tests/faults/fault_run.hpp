#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/places.hpp"
#include "tests/support/process.hpp"
#include "tests/support/process_table.hpp"
#include "tests/support/run.hpp"
#include "tests/support/same_results.hpp"
#include "tests/support/scene_file.hpp"

/// Runs that something bad happens to, and what must be true of every one of them afterwards.
namespace ricochet::test {

using testing::HasSubstr;

inline constexpr int all_windows = 12000, few_windows = 1000, fields_every = 500;

/// Two bars for so many windows; result fields tell a test from outside which window is reached.
inline std::string bars(int windows, double timeout_s = 60.0) {
  std::ostringstream end_s, timeout;
  end_s << windows * 2.226e-6;
  timeout << timeout_s;
  const std::string text = with_key(config_text("two_bars"), "time", "end_s", end_s.str());
  return with_key(with_key(text, "output", "fields_every", std::to_string(fields_every)), "coupling", "timeout_s",
                  timeout.str());
}

/// With a process for every participant, however few processors there are.
inline std::string apart(const std::string& text) { return with_key(text, "coupling", "transport", "\"shm\""); }

/// A scene with its two participants spelled out; `explicit_keys` and `implicit_keys` are lines of TOML.
inline std::string with_participants(const std::string& text, const std::string& explicit_name,
                                     const std::string& explicit_keys, const std::string& implicit_keys = "") {
  return text + "\n[[participant]]\nname = \"" + explicit_name +
         "\"\nrole = \"explicit\"\nbodies = [\"left\", \"right\"]\n" + explicit_keys +
         "\n[[participant]]\nname = \"implicit\"\nrole = \"implicit\"\n" + implicit_keys + "\n";
}

inline std::vector<std::string> lines_of(const std::string& path) {
  std::ifstream file(path);
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);) lines.push_back(line);
  return lines;
}

inline std::string program(const std::string& name) { return build_folder() + "/" + name; }

/// `ricochet run` in the background, into `folder`/out, with a scene file no other process of this machine knows.
class FaultRun {
 public:
  FaultRun(const TemporaryFolder& folder, const std::string& scene_text)
      : folder_(folder.path().string()),
        scene_(folder.write(scene_text)),
        out_(folder_ + "/out"),
        coupler_({ricochet_binary(), "run", scene_, "--out", out_}, folder_ + "/stdout.txt", folder_ + "/stderr.txt") {}

  [[nodiscard]] const std::string& scene() const { return scene_; }
  [[nodiscard]] const std::string& out() const { return out_; }
  [[nodiscard]] Process& coupler() { return coupler_; }
  [[nodiscard]] std::string error_text() const { return file_text(folder_ + "/stderr.txt"); }
  [[nodiscard]] std::string log(const std::string& name) const { return file_text(out_ + "/logs/" + name + ".log"); }
  [[nodiscard]] nlohmann::json summary() const { return nlohmann::json::parse(file_text(out_ + "/summary.json")); }
  [[nodiscard]] std::string run_id() const { return summary().at("run_id"); }

  /// The process of a participant (or "coupler"), as soon as it exists.
  [[nodiscard]] pid_t pid_of(const std::string& name) {
    if (name == "coupler") return coupler_.pid();
    std::vector<pid_t> found;
    wait_until([&] { return !(found = processes_with("--scene " + scene_ + " --name " + name + " ")).empty(); }, 20.0);
    if (found.empty()) throw std::runtime_error("no process of participant " + name + ": " + error_text());
    return found.front();
  }
  /// Waits until a window (a multiple of `fields_every`) is computed.
  void reach(int window) {
    wait_until([&] { return !fields_of(out_, "implicit", window).empty() || !coupler_.running(); }, 60.0);
    ASSERT_TRUE(coupler_.running()) << error_text();
  }
  /// Waits until every participant has been started.
  void reach_start() {
    for (const auto* name : {"explicit", "implicit"}) static_cast<void>(pid_of(name));
  }
  [[nodiscard]] bool participants_gone(double within_s) const {
    return wait_until([&] { return processes_with("--scene " + scene_).empty(); }, within_s);
  }

 private:
  std::string folder_, scene_, out_;
  Process coupler_;
};

/// Every row has all its numbers, the rows follow one another, and they are those of an undisturbed run.
inline void expect_rows_of(const std::string& history, const std::string& undisturbed) {
  const std::string text = file_text(history);
  ASSERT_FALSE(text.empty());
  EXPECT_EQ(text.back(), '\n') << "the last row is not complete";
  const auto rows = lines_of(history), expected = lines_of(undisturbed);
  const auto columns = std::count(rows[0].begin(), rows[0].end(), ',');
  for (const auto& row : rows) ASSERT_EQ(std::count(row.begin(), row.end(), ','), columns) << row;
  for (std::size_t i = 0; i < std::min(rows.size(), expected.size()); ++i) ASSERT_EQ(rows[i], expected[i]);
}

/// Nothing half-written and nothing temporary lies in the results.
inline void expect_whole_files(const std::string& out) {
  const std::vector<std::string> kinds = {".csv", ".json", ".log",   ".vtu",   ".vtm",
                                          ".pvd", ".html", ".state", ".sha256"};
  for (const auto& entry : std::filesystem::recursive_directory_iterator(out)) {
    if (entry.is_directory() || entry.path().filename() == ".ricochet-files") continue;
    const auto path = entry.path();
    EXPECT_THAT(kinds, testing::Contains(path.extension())) << path;
    EXPECT_TRUE(path.extension() != ".html" || file_text(path).find("</html>") != std::string::npos) << path;
    const bool fields = path.extension() == ".vtu" || path.extension() == ".vtm" || path.extension() == ".pvd";
    EXPECT_TRUE(!fields || file_text(path).find("</VTKFile>") != std::string::npos) << path;
    EXPECT_TRUE(path.extension() != ".json" || nlohmann::json::accept(file_text(path))) << path;
  }
}

/// No process of the set and no socket.
inline void expect_nothing_left(FaultRun& run) {
  EXPECT_TRUE(wait_until([&] { return processes_with(run.scene()).empty(); }, 3.0)) << "processes are left";
  EXPECT_FALSE(unix_socket_with("/ricochet-" + std::to_string(run.coupler().pid()) + "-"));
}

/// The error, in short: exit code, words on stderr, status and words in summary.json.
inline void expect_failure(FaultRun& run, int code, const std::string& status, const std::vector<std::string>& words,
                           double within_s = 10.0) {
  ASSERT_EQ(run.coupler().wait(within_s), code) << run.error_text();
  const auto summary = run.summary();
  EXPECT_EQ(summary.at("status"), status);
  EXPECT_EQ(summary.at("exit_code"), code);
  for (const auto& word : words) {
    EXPECT_THAT(run.error_text(), HasSubstr(word));
    EXPECT_THAT(std::string(summary.at("error")), HasSubstr(word));
  }
}

/// A clean run of the first windows in its own folder; path of its history.
inline std::string clean_history(const TemporaryFolder& folder) {
  const RunResult clean = run_text(bars(few_windows), folder, "clean");
  return clean.folder + "/history.csv";
}

/// Facts that hold after any fault: whole files, rows as without the fault, nothing left, and the next run in the same
/// folder works as if nothing had been.
inline void expect_recovery(FaultRun& run, const TemporaryFolder& folder) {
  const std::string clean = clean_history(folder);
  expect_whole_files(run.out());
  expect_rows_of(run.out() + "/history.csv", clean);
  expect_nothing_left(run);
  const RunResult next = run_file(folder.write(bars(few_windows), "next.toml"), folder);
  EXPECT_EQ(next.outcome.code, 0) << next.outcome.error;
  EXPECT_EQ(file_text(run.out() + "/history.csv"), file_text(clean));
  EXPECT_EQ(next.summary.at("status"), "done");
  expect_whole_files(run.out());
}

}  // namespace ricochet::test

#pragma once

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>
#include <vector>

#include "tests/support/run.hpp"

/// Runs that must leave the same: interrupted ones that went on, and one that was not.
namespace ricochet::test {

/// summary.json without what is of one run: times, processes, its name.
inline nlohmann::json lasting_summary(const std::string& folder) {
  auto json = nlohmann::json::parse(file_text(folder + "/summary.json"));
  for (const auto* key : {"run_id", "wall_s", "cpu_s", "phases", "processes"}) json.erase(key);
  return json;
}

inline std::set<std::string> names_in(const std::string& folder) {
  std::set<std::string> names;
  std::error_code none;
  for (const auto& entry : std::filesystem::directory_iterator(folder, none))
    names.insert(entry.path().filename().string());
  return names;
}

/// The same bytes: history, axial stress, probes, fields and shapes; of the summary all but times and names, and
/// `other_keys`.
inline void expect_same_results(const std::string& folder, const std::string& undisturbed,
                                const std::vector<std::string>& other_keys = {}) {
  for (const auto* file : {"/history.csv", "/axial_stress.csv", "/probes.csv"})
    EXPECT_TRUE(file_text(folder + file) == file_text(undisturbed + file)) << file << " differs in " << folder;
  auto summary = lasting_summary(folder), expected = lasting_summary(undisturbed);
  for (const auto& key : other_keys) {
    summary.erase(key);
    expected.erase(key);
  }
  EXPECT_EQ(summary, expected);
  const auto fields = names_in(undisturbed + "/fields");
  EXPECT_EQ(names_in(folder + "/fields"), fields);
  for (const auto& name : fields) {
    EXPECT_TRUE(file_text(folder + "/fields/" + name) == file_text(undisturbed + "/fields/" + name))
        << "fields/" << name << " differs in " << folder;
  }
}

/// The files of fields that a participant wrote at a window, one for each of its bodies.
inline std::vector<std::string> fields_of(const std::string& folder, const std::string& participant, int window) {
  const std::string tail = fmt::format("_{:08}.vtu", window);
  std::vector<std::string> paths;
  for (const auto& name : names_in(folder + "/fields"))
    if (name.starts_with(participant + ".") && name.ends_with(tail)) paths.push_back(folder + "/fields/" + name);
  return paths;
}

/// Windows of the checkpoints in a folder of results, ascending.
inline std::vector<int> checkpoints_in(const std::string& folder) {
  std::vector<int> windows;
  for (const auto& name : names_in(folder + "/checkpoint")) {
    const std::filesystem::path path(name);
    if (path.extension() == ".json") windows.push_back(std::stoi(path.stem()));
  }
  std::sort(windows.begin(), windows.end());
  return windows;
}

inline Outcome resume(const std::string& results, const TemporaryFolder& folder,
                      const std::vector<std::string>& options = {}, double timeout_s = 120.0) {
  std::vector<std::string> command = {ricochet_binary(), "resume", results};
  command.insert(command.end(), options.begin(), options.end());
  return run_command(command, folder.path().string(), timeout_s);
}

/// Takes the last of the two checkpoints off a copy of a run's results, goes on from the other, and expects the same
/// bytes. Returns how the second half ended; its results are in `whole.folder` + "_half".
inline Outcome expect_the_same_from_the_earlier_checkpoint(const RunResult& whole, const TemporaryFolder& folder) {
  const std::string half = whole.folder + "_half";
  std::filesystem::copy(whole.folder, half, std::filesystem::copy_options::recursive);
  const auto windows = checkpoints_in(half);
  EXPECT_EQ(windows.size(), 2U);
  if (windows.size() != 2) return {};
  std::filesystem::remove(half + "/checkpoint/" + std::to_string(windows.back()) + ".json");
  Outcome outcome = resume(half, folder);
  EXPECT_EQ(outcome.code, 0) << outcome.error;
  if (outcome.code == 0) expect_same_results(half, whole.folder);
  return outcome;
}

}  // namespace ricochet::test

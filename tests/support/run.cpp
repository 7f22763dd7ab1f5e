#include "tests/support/run.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "tests/support/places.hpp"

template class nlohmann::basic_json<>;

namespace ricochet::test {

History read_history(const std::string& path) {
  std::ifstream file(path);
  std::string line, cell;
  std::vector<std::string> names;
  History history;
  std::getline(file, line);
  for (std::istringstream header(line); std::getline(header, cell, ',');) names.push_back(cell);
  while (std::getline(file, line)) {
    std::istringstream row(line);
    for (const auto& name : names) {
      std::getline(row, cell, ',');
      history[name].push_back(std::strtod(cell.c_str(), nullptr));  // std::stod refuses what is nearly zero
    }
  }
  return history;
}

const std::vector<double>& RunResult::column(const std::string& name) const {
  const auto found = history.find(name);
  if (found == history.end()) throw std::runtime_error("history.csv has no column " + name);
  return found->second;
}

double RunResult::mean(const std::string& name, double begin_s, double end_s) const {
  const auto& time = column("time_s");
  const auto& values = column(name);
  double sum = 0.0;
  int count = 0;
  for (std::size_t i = 0; i < time.size(); ++i) {
    if (time[i] < begin_s || time[i] > end_s) continue;
    sum += values[i];
    ++count;
  }
  return count ? sum / count : std::nan("");
}

double RunResult::deviation(const std::string& name, double begin_s, double end_s) const {
  const double average = mean(name, begin_s, end_s);
  const auto& time = column("time_s");
  const auto& values = column(name);
  double sum = 0.0;
  int count = 0;
  for (std::size_t i = 0; i < time.size(); ++i) {
    if (time[i] < begin_s || time[i] > end_s) continue;
    sum += (values[i] - average) * (values[i] - average);
    ++count;
  }
  return count ? std::sqrt(sum / count) : std::nan("");
}

double RunResult::smallest(const std::string& name) const {
  const auto& values = column(name);
  return *std::min_element(values.begin(), values.end());
}

double RunResult::largest(const std::string& name) const {
  const auto& values = column(name);
  return *std::max_element(values.begin(), values.end());
}

std::string ricochet_binary() { return build_folder() + "/ricochet"; }

RunResult run_file(const std::string& scene, const TemporaryFolder& folder, const std::string& out, double timeout_s) {
  RunResult run;
  run.folder = (folder.path() / out).string();
  run.outcome = run_command({ricochet_binary(), "run", scene, "--out", run.folder}, folder.path().string(), timeout_s);
  run.history = read_history(run.folder + "/history.csv");
  const std::string text = file_text(run.folder + "/summary.json");
  if (!text.empty()) run.summary = nlohmann::json::parse(text);
  return run;
}

RunResult run_text(const std::string& text, const TemporaryFolder& folder, const std::string& name) {
  RunResult run = run_file(folder.write(text, name + ".toml"), folder, name);
  EXPECT_EQ(run.outcome.code, 0) << run.outcome.error;
  return run;
}

std::string config_text(const std::string& name) {
  const std::string text = file_text(source_folder() + "/configs/" + name + ".toml");
  if (text.empty()) throw std::runtime_error("no configs/" + name + ".toml");
  return text;
}

std::string with_absolute_meshes(std::string text) {
  const std::string key = "gmsh = \"";
  for (auto at = text.find(key); at != std::string::npos; at = text.find(key, at + 1))
    text.insert(at + key.size(), source_folder() + "/configs/");
  return text;
}

std::string with_key(const std::string& text, const std::string& table, const std::string& key,
                     const std::string& value) {
  const std::string header = "[" + table + "]", entry = key + " = " + value + "\n";
  std::istringstream lines(text);
  std::string result, line;
  bool inside = false, done = false;
  while (std::getline(lines, line)) {
    if (!line.empty() && line[0] == '[') inside = line == header;
    if (inside && line.rfind(key + " ", 0) == 0) continue;  // the old value
    result += line + "\n";
    if (!inside || line != header) continue;
    result += entry;
    done = true;
  }
  return done ? result : result + header + "\n" + entry;
}

std::string with_protocol(const std::string& text, const std::string& protocol) {
  return with_key(text, "coupling", "protocol", "\"" + protocol + "\"");
}

std::string with_protocol_of_two_steps(const std::string& text, const std::string& protocol) {
  const std::string by = with_protocol(text, protocol);
  return protocol == "prakash_hjelmstad" ? with_key(by, "coupling", "substeps", "2") : by;
}

std::string check_refusal(const std::string& text) {
  const TemporaryFolder folder;
  const Outcome outcome = run_command({ricochet_binary(), "check", folder.write(text)}, folder.path().string(), 60.0);
  EXPECT_EQ(outcome.code, 2) << outcome.out;
  return outcome.error;
}

}  // namespace ricochet::test

#pragma once

#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/support/process.hpp"
#include "tests/support/scene_file.hpp"

extern template class nlohmann::basic_json<>;  // compiled once, in run.cpp

/// Whole runs: `ricochet run SCENE` with its three processes, and what it leaves behind.
namespace ricochet::test {

using History = std::map<std::string, std::vector<double>>;

History read_history(const std::string& path);

struct RunResult {
  Outcome outcome;
  std::string folder;
  History history;
  nlohmann::json summary;

  [[nodiscard]] const std::vector<double>& column(const std::string& name) const;
  [[nodiscard]] double last(const std::string& name) const { return column(name).back(); }
  /// Mean of a column over begin <= t <= end.
  [[nodiscard]] double mean(const std::string& name, double begin_s, double end_s) const;
  [[nodiscard]] double deviation(const std::string& name, double begin_s, double end_s) const;
  [[nodiscard]] double smallest(const std::string& name) const;
  [[nodiscard]] double largest(const std::string& name) const;
};

std::string ricochet_binary();

/// Runs a scene file into `folder`/out and reads what it left, whether it succeeded or not.
RunResult run_file(const std::string& scene, const TemporaryFolder& folder, const std::string& out = "out",
                   double timeout_s = 120.0);

/// Runs a scene given as text and expects it to be done.
RunResult run_text(const std::string& text, const TemporaryFolder& folder, const std::string& name = "scene");

/// The error of `ricochet check` for a scene that it is expected to refuse.
std::string check_refusal(const std::string& text);

std::string config_text(const std::string& name);

/// A configuration's text for a scene file elsewhere: the meshes that it names lie beside it.
std::string with_absolute_meshes(std::string text);

/// A scene's text with one key of one table set; the table is added if the scene lacks it.
std::string with_key(const std::string& text, const std::string& table, const std::string& key,
                     const std::string& value);

std::string with_protocol(const std::string& text, const std::string& protocol);

/// The same, `prakash_hjelmstad` with two substeps.
std::string with_protocol_of_two_steps(const std::string& text, const std::string& protocol);

}  // namespace ricochet::test

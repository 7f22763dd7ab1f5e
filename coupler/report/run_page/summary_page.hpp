#pragma once

#include <optional>
#include <string>
#include <vector>

#include "coupler/report/parts/chart.hpp"

namespace ricochet::report {

/// Reads summary.json. Throws ConfigError if it is not the summary of a run.
[[nodiscard]] Json read_summary(const std::string& path);

/// A number of the summary; empty if it is missing or null.
[[nodiscard]] std::optional<double> number(const Json& summary, const std::string& key);

/// Name of the scene: its file name without ending.
[[nodiscard]] std::string scene_name(const Json& summary);

/// HTML: scene, protocol, status with error text, version.
[[nodiscard]] std::string header_html(const Json& summary);

/// HTML: results beside theory, balances, switches, notes; then the processes with their times.
[[nodiscard]] std::string tables_html(const Json& summary);

}  // namespace ricochet::report

#pragma once

#include <string>
#include <vector>

#include "coupler/report/parts/chart.hpp"

namespace ricochet::report {

/// One point of a stability map.
struct StabilityCell {
  std::string contact;     ///< "open" | "sticking"
  std::size_t column = 0;  ///< which value of the other parameter
  double step = 0.0;       ///< on the map's axis: Courant number or seconds
  double growth = 0.0;     ///< per window
  bool stable = false;
};

/// A stability limit in one column of the map, on the step's axis.
struct StabilityEdge {
  std::string contact;
  std::size_t column = 0;
  double step = 0.0;
  std::string kind;  ///< "predicted" | "measured"
};

struct StabilityMap {
  std::string title, step_title, against_title;
  std::vector<std::string> against;    ///< label of each column
  std::vector<double> against_number;  ///< its place on the axis; empty: evenly spaced
  bool logarithmic = false;            ///< the axis of the other parameter
  std::vector<std::string> notes;
  std::vector<StabilityCell> cells;
  std::vector<StabilityEdge> edges;
};

/// As stability.json, from which maps and page are made again: data, no program.
[[nodiscard]] std::string to_json(const StabilityMap& map);
/// Throws ConfigError naming the file if it is none that `to_json` wrote.
[[nodiscard]] StabilityMap read_stability_map(const std::string& path);

/// One map for each state of the contact.
[[nodiscard]] std::vector<Chart> stability_charts(const StabilityMap& map);

/// A self-contained page with one map for each state of the contact.
[[nodiscard]] std::string stability_page(const StabilityMap& map);

}  // namespace ricochet::report

#pragma once

#include <string>

namespace ricochet::report {

/// A page that this process wrote, and what it wrote.
struct Page {
  std::string path, text;
};

/// `ricochet report DIR`: writes DIR/report.html, one page without references to the network, from history.csv,
/// summary.json and, where they exist, fields/*.shapes.json, axial_stress.csv, trace.json and a stability map
/// (stability_maps.hpp) of a run, finished or not, or from results.csv and study.json of a study; DIR/stability.html
/// from stability.json, where there is nothing else. It reads data alone: no page that lies there. Throws ConfigError
/// if a file is missing or wrong, or the page cannot be written, and does not replace a file that is not ours.
Page write_report(const std::string& directory);

}  // namespace ricochet::report

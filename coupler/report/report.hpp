#pragma once

#include <string>

namespace ricochet::report {

/// `ricochet report DIR`: writes DIR/report.html, one page without references to the network, from history.csv,
/// summary.json and, where they exist, axial_stress.csv, trace.json and a stability map (stability_maps.hpp) of a run,
/// finished or not, or from results.csv and study.json of a study; returns its path. The results of `ricochet stability`
/// have their page already: its path. Throws ConfigError if a file is missing or wrong, or the page cannot be written.
std::string write_report(const std::string& directory);

}  // namespace ricochet::report

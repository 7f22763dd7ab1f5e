#pragma once

#include <string>
#include <utility>
#include <vector>

namespace ricochet::report {

/// Which points (cost, error) are on the Pareto front: no other one costs no more and errs no more, and less in one.
[[nodiscard]] std::vector<bool> pareto_front(const std::vector<std::pair<double, double>>& points);

/// A self-contained page of a study from its study.json, results.csv and, if it asks for histories, histories.csv:
/// times beside published ones, histories over each other, errors and times along a varied key, error against wall time
/// and against CPU time for every quantity, a table of all runs. Throws ConfigError if a file is missing or wrong.
[[nodiscard]] std::string study_page(const std::string& folder);

}  // namespace ricochet::report

#pragma once

#include <string>
#include <vector>

namespace ricochet::coupler {

/// `ricochet study`: computes the reference and every run of a study that is not in `out` yet (empty: "out/<name of the
/// study file>"), and writes results.csv after each run, study.json and report.html. A run that fails is a row that
/// says why. `set`: arguments "KEY=VALUE" that change the scene before all else. Throws ConfigError for a wrong study
/// file, what ended the reference, or Interrupted.
void run_study(const std::string& study_path, const std::string& out, const std::vector<std::string>& set = {});

}  // namespace ricochet::coupler

#pragma once

#include <map>
#include <string>
#include <vector>

#include "tests/bench/process_run.hpp"
#include "tests/bench/table.hpp"

namespace ricochet::bench {

/// The rounded striker (configs/rounded_striker.toml): wall time of whole runs, each method at its cheapest setting
/// that keeps the peak force to 0.5 %, and the error it has. The reference is all-explicit on the same mesh with half
/// the step, computed once: what is compared is time integration and coupling. Repeated like the scenes.
class RoundedStriker {
 public:
  explicit RoundedStriker(std::string folder);
  void repeat();
  [[nodiscard]] std::vector<Row> rows() const;

 private:
  std::string folder_;
  double reference_peak_n_ = 0.0;
  std::map<std::string, std::vector<SceneRun>> runs_;  ///< by method
};

}  // namespace ricochet::bench

#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "tests/bench/process_run.hpp"
#include "tests/bench/table.hpp"

namespace ricochet::bench {

/// A bar that strikes a stop: one mesh and one step, against a fine zone at the stop that is tied to elements four
/// times as long, which take steps four times as long. Chan (2025) found it 12.98 times cheaper.
class TiedBars {
 public:
  explicit TiedBars(std::string folder) : folder_(std::move(folder)) {}
  void repeat();
  [[nodiscard]] std::vector<Row> rows() const;

 private:
  std::string folder_;
  std::map<std::string, std::vector<SceneRun>> runs_;  ///< by protocol
};

}  // namespace ricochet::bench

#pragma once

#include <map>
#include <string>
#include <vector>

#include "tests/bench/process_run.hpp"
#include "tests/bench/table.hpp"

namespace ricochet::bench {

/// Cost of checkpoints to the hybrid of the reference scene: whole runs with `cuts` of them beside runs without. From
/// the difference follows what one of them takes, and by how much a run becomes longer that makes one every
/// `default_interval_s`.
class CheckpointCosts {
 public:
  static constexpr int cuts = 4;
  static constexpr double default_interval_s = 300.0;
  /// `steps`: of the 0.5 mm mesh; there are as many more as the mesh is finer.
  CheckpointCosts(std::string folder, std::vector<int> refinements, long steps)
      : folder_(std::move(folder)), refinements_(std::move(refinements)), steps_(steps) {}
  void repeat();
  [[nodiscard]] std::vector<Row> rows() const;

 private:
  [[nodiscard]] double wall_s(int refinement, bool checkpoints) const;
  std::string folder_;
  std::vector<int> refinements_;
  long steps_;
  std::map<int, std::vector<double>> with_, without_;  ///< per refinement [s]
};

}  // namespace ricochet::bench

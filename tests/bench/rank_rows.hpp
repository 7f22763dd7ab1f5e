#pragma once

#include <map>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "tests/bench/process_run.hpp"
#include "tests/bench/table.hpp"

namespace ricochet::bench {

/// Whole runs of an explicit solver without MPI and in two ranks: of the same bodies (strong scaling) and of bodies
/// twice as large (weak scaling).
class RankRuns {
 public:
  RankRuns(std::string folder, long steps) : folder_(std::move(folder)), steps_(steps) {}
  void repeat();
  [[nodiscard]] std::vector<Row> rows() const;

 private:
  struct Choice {
    bool solid, twice_as_large;
    int ranks;
    bool operator<(const Choice& other) const {
      return std::tie(solid, twice_as_large, ranks) < std::tie(other.solid, other.twice_as_large, other.ranks);
    }
  };
  std::string folder_;
  long steps_;
  std::map<Choice, std::vector<double>> window_s_;
};

}  // namespace ricochet::bench

#pragma once

#include <map>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "tests/bench/process_run.hpp"
#include "tests/bench/table.hpp"

namespace ricochet::bench {

/// Whole runs of the baselines by one thread and by two, which are what is free beside nobody on two processors.
class ThreadRuns {
 public:
  ThreadRuns(std::string folder, std::vector<int> refinements, long steps)
      : folder_(std::move(folder)), refinements_(std::move(refinements)), steps_(steps) {}
  void repeat();
  [[nodiscard]] std::vector<Row> rows() const;

 private:
  struct Choice {
    std::string protocol;
    int refinement, threads;
    bool operator<(const Choice& other) const {
      return std::tie(protocol, refinement, threads) < std::tie(other.protocol, other.refinement, other.threads);
    }
  };
  std::string folder_;
  std::vector<int> refinements_;
  long steps_;
  std::map<Choice, std::vector<double>> window_s_;
};

}  // namespace ricochet::bench

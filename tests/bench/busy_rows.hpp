#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "tests/bench/table.hpp"

namespace ricochet::bench {

/// The hybrid of the reference scene at 0.25 mm while other processes, one or two, compute without end: what a user has
/// on a machine that is not his alone.
class BusyMachine {
 public:
  BusyMachine(std::string folder, long steps) : folder_(std::move(folder)), steps_(steps) {}
  void repeat();
  [[nodiscard]] std::vector<Row> rows() const;

 private:
  struct Times {
    std::vector<double> hybrid_s, implicit_s, one_process_s;  ///< stepping, per step
  };
  std::string folder_;
  long steps_;
  std::map<int, Times> times_;  ///< by busy processes
};

}  // namespace ricochet::bench

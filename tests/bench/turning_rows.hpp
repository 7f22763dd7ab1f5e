#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "tests/bench/process_run.hpp"
#include "tests/bench/table.hpp"

namespace ricochet::bench {

/// The price of large_rotation: two discs of steel that meet at 10 m/s, without it, with it, and with a spin.
class TurningDiscs {
 public:
  explicit TurningDiscs(std::string folder);
  void repeat();
  [[nodiscard]] std::vector<Row> rows() const;

 private:
  std::string folder_;
  std::map<std::pair<std::string, std::string>, std::vector<double>> stepping_s_;  ///< by protocol and kind of scene
};

}  // namespace ricochet::bench

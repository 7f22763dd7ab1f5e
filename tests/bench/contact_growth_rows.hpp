#pragma once

#include <map>
#include <string>
#include <vector>

#include "tests/bench/process_run.hpp"
#include "tests/bench/table.hpp"

namespace ricochet::bench {

/// How set-up and twenty windows grow with the number of contact pairs: two flat cylinders, friction 0.3, elements of
/// one size, so wide that as many pairs touch.
class ContactGrowth {
 public:
  explicit ContactGrowth(std::string folder) : folder_(std::move(folder)) {}
  void repeat();
  [[nodiscard]] std::vector<Row> rows() const;

 private:
  std::string folder_;
  std::map<int, std::vector<SceneRun>> runs_;  ///< by pairs
};

/// The time of a window while all pairs of such cylinders touch, over what it takes before they do; and how a window of
/// solids grows from fewer than 800 pairs to more.
class ContactWindows {
 public:
  explicit ContactWindows(std::string folder) : folder_(std::move(folder)) {}
  void repeat();
  [[nodiscard]] std::vector<Row> rows() const;

 private:
  std::string folder_;
  std::map<int, std::vector<double>> ratios_;  ///< by pairs
  std::vector<double> powers_;
};

}  // namespace ricochet::bench

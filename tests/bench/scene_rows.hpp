#pragma once

#include <map>
#include <string>
#include <tuple>
#include <vector>

#include "tests/bench/kernel_rows.hpp"
#include "tests/bench/process_run.hpp"
#include "tests/bench/table.hpp"

namespace ricochet::bench {

/// Whole runs of the reference scene: every method once on every mesh, then all of them again.
class SceneRuns {
 public:
  /// `refinements` ascend. `steps`: of the explicit side, a multiple of 4; the contact stays closed for the first 570.
  SceneRuns(const std::string& folder, const std::vector<int>& refinements, long steps);
  void repeat();
  /// `kernels`: for the rows against the machine's bound, or null.
  [[nodiscard]] std::vector<Row> rows(const Kernels* kernels) const;

 private:
  using Runs = std::vector<SceneRun>;
  [[nodiscard]] const Runs& at(int refinement, const std::string& method) const;
  void add_unreached(int refinement, std::vector<Row>& rows) const;
  void add_costs(int refinement, std::vector<Row>& rows) const;
  void add_others(int n, std::vector<Row>& rows) const;
  void add_dual(int refinement, std::vector<Row>& rows) const;
  void add_bounds(int refinement, const Kernels& kernels, std::vector<Row>& rows) const;
  void add_openradioss(int refinement, const Kernels& kernels, std::vector<Row>& rows) const;
  void add_history(int refinement, std::vector<Row>& rows) const;
  void add_setup(int refinement, std::vector<Row>& rows) const;
  void add_growth(int refinement, std::vector<Row>& rows) const;

  std::string folder_;
  std::vector<int> refinements_;
  long steps_;
  std::map<int, double> unknowns_;                   ///< of the whole structure
  std::map<int, std::map<std::string, Runs>> runs_;  ///< by refinement and method
  /// all_explicit in one process [s per step]: by refinement, length of the carbide cylinder and whether all rows are
  /// computed.
  std::map<std::tuple<int, int, bool>, std::vector<double>> unreached_s_;
};

/// The exchange of a window through the coupler over a plain ping-pong of the same bytes; repeated like the scenes.
class Exchanges {
 public:
  explicit Exchanges(std::string folder) : folder_(std::move(folder)) {}
  void repeat();
  [[nodiscard]] std::vector<Row> rows() const;

 private:
  std::string folder_;
  std::map<int, std::vector<double>> plain_s_, shared_memory_s_, zeromq_s_;  ///< by interface nodes
};

}  // namespace ricochet::bench

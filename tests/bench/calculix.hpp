#pragma once

#include <map>
#include <string>
#include <vector>

#include "tests/bench/calculix_deck.hpp"
#include "tests/bench/table.hpp"

namespace ricochet::bench {

/// CalculiX against `hughes_liu` and `all_implicit` on the first steps of the reference scene: same mesh, step and
/// friction. Times are those of whole commands, reading and factorising included, CalculiX with as many threads as it
/// takes by itself.
class CalculixRuns {
 public:
  /// Looks for `ccx` on the PATH; without it nothing is run, and the rows say so.
  CalculixRuns(std::string folder, long steps);
  void repeat();
  [[nodiscard]] std::vector<Row> rows() const;
  /// The pressure histories of the last repeat, FOLDER/calculix.csv and .svg; the names of what was written.
  [[nodiscard]] std::vector<std::string> write_picture() const;

 private:
  struct Runs {
    std::vector<double> wall_s;
    PressureHistory history;                         ///< of the last repeat
    std::vector<double> deviation, deviation_later;  ///< from CalculiX, see `rows`
  };
  void run_calculix(const std::string& scene);
  void run_ours(const std::string& protocol, const std::string& scene);

  std::string folder_;
  long steps_;
  bool installed_;
  std::vector<double> calculix_wall_s_;
  PressureHistory calculix_;
  std::map<std::string, Runs> ours_;  ///< by protocol
};

}  // namespace ricochet::bench

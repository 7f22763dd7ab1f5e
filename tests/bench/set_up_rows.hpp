#pragma once

#include <map>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "tests/bench/process_run.hpp"
#include "tests/bench/table.hpp"

namespace ricochet::bench {

/// `ricochet check` and the beginning of a run on large meshes: how long, and how that grows with the mesh.
class SetUps {
 public:
  explicit SetUps(std::string folder) : folder_(std::move(folder)) {}
  void repeat();
  [[nodiscard]] std::vector<Row> rows() const;

 private:
  struct Choice {
    std::string protocol;
    int refinement;
    bool operator<(const Choice& other) const {
      return std::tie(protocol, refinement) < std::tie(other.protocol, other.refinement);
    }
  };
  struct Times {
    std::vector<double> check_s, begin_s;
  };
  std::string folder_;
  std::map<Choice, Times> times_;
};

}  // namespace ricochet::bench

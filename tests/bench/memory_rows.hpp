#pragma once

#include <string>
#include <vector>

#include "tests/bench/process_run.hpp"
#include "tests/bench/table.hpp"

namespace ricochet::bench {

/// Memory that a run needs, all its processes together, at the peak. For two bodies of 102 400 quadrilaterals, and
/// for a hybrid of a million unknowns, two blocks of hexahedra with friction, 2025 pairs of contact nodes, the layer at
/// the contact implicit. Measured once, however many repeats are asked for.
class Memory {
 public:
  explicit Memory(std::string folder) : folder_(std::move(folder)) {}
  void repeat();
  [[nodiscard]] std::vector<Row> rows() const;

 private:
  std::string folder_;
  struct Peak {
    std::string scene;
    double per_unknown_b;
  };
  std::vector<Peak> peaks_;
};

}  // namespace ricochet::bench

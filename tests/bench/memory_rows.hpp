#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tests/bench/process_run.hpp"
#include "tests/bench/table.hpp"

namespace ricochet::bench {

/// What a hybrid of a million unknowns needs of memory: two blocks of hexahedra with friction, 2025 pairs of contact
/// nodes, the layer at the contact implicit. Measured once, however many repeats are asked for.
class Memory {
 public:
  explicit Memory(std::string folder) : folder_(std::move(folder)) {}
  void repeat();
  [[nodiscard]] std::vector<Row> rows() const;

 private:
  std::string folder_;
  std::optional<Usage> usage_;
};

}  // namespace ricochet::bench

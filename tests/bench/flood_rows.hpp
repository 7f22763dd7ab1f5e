#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tests/bench/process_run.hpp"
#include "tests/bench/table.hpp"

namespace ricochet::bench {

/// Cost of strangers: the hybrid of the reference scene over TCP while a process floods its port, over the same
/// while the same process floods the port of somebody else, so that the processor time of the flood itself is in both.
/// Repeated like the scenes.
class Floods {
 public:
  /// `steps`: of the 0.5 mm mesh; there are as many more as the mesh is finer.
  Floods(std::string folder, long steps) : folder_(std::move(folder)), steps_(steps) {}
  void repeat();
  [[nodiscard]] std::vector<Row> rows() const;

 private:
  [[nodiscard]] SceneRun run_at(std::uint16_t port, std::uint16_t flooded_port) const;
  std::string folder_;
  long steps_;
  std::vector<SceneRun> flooded_, elsewhere_;
};

}  // namespace ricochet::bench

#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/check/check.hpp"
#include "coupler/protocols/protocol.hpp"

namespace ricochet::test {

class LocalParticipant;

/// A scene with both solvers in this process: the same protocol, time loop, links and sessions as three processes, but
/// messages are passed as objects. The numbers are the same to the last bit.
class OneProcess {
 public:
  /// Starts and initialises the participants. `all_rows`: the explicit solver computes those that no wave has reached,
  /// too. Throws ConfigError for a scene that cannot work.
  explicit OneProcess(const std::string& scene_path, bool all_rows = false);
  ~OneProcess();
  OneProcess(const OneProcess&) = delete;
  OneProcess& operator=(const OneProcess&) = delete;

  /// Computes every window. `on_records(window)`: see coupler::TimeLoop; it may take the links' history rows. Returns
  /// the stepping time per window [s].
  double run(std::function<void(std::int64_t)> on_records);
  [[nodiscard]] const scene::Problem& problem() const { return problem_; }
  [[nodiscard]] coupler::Coupling& coupling() { return *coupling_; }
  [[nodiscard]] coupler::Protocol& protocol() { return *protocol_; }

 private:
  scene::Problem problem_;
  scene::Plan plan_;
  std::vector<std::unique_ptr<LocalParticipant>> participants_;
  std::unique_ptr<coupler::Coupling> coupling_;
  std::unique_ptr<coupler::Protocol> protocol_;
};

/// Stepping time per window [s] of a whole run, its history rows thrown away.
double run_in_one_process(const std::string& scene_path, bool all_rows = false);

}  // namespace ricochet::test

#pragma once

#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>

#include "common/participant/participant.hpp"

namespace ricochet::participant {

/// Tells the coupler every second that a long `initialize` is at work, as long as this process uses a processor: one
/// that hangs or is stopped stays silent. It is over with this object.
class Heartbeat {
 public:
  explicit Heartbeat(TellProgress tell);
  ~Heartbeat();
  Heartbeat(const Heartbeat&) = delete;
  Heartbeat& operator=(const Heartbeat&) = delete;

  /// From here on. `expected_s`: processor time that it takes, from which the share that is done follows; 0: unknown.
  void begin(const std::string& doing, double expected_s = 0.0);

 private:
  void beat();

  TellProgress tell_;
  std::mutex mutex_;
  std::condition_variable end_;
  bool over_ = false;
  std::string doing_;
  double began_s_, expected_s_ = 0.0;
  std::thread thread_;  ///< last, since it uses all others
};

}  // namespace ricochet::participant

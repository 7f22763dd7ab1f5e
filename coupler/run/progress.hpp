#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>

#include "common/base/window_clock.hpp"
#include "coupler/results/history.hpp"

namespace ricochet::coupler {

/// The progress line on stderr: rewritten in place on a terminal, a plain line every 2 s otherwise.
class Progress {
 public:
  Progress(std::int64_t last_window, bool has_contact);
  /// After `window` windows of the clock; `row`: the newest merged history row.
  void show(std::int64_t window, const WindowClock& clock, const HistoryRow& row);
  /// Before the first window: what a participant is doing; `share_done` < 0: it does not know.
  void show_start(const std::string& name, std::string_view doing, double share_done);
  /// Ends a line that was rewritten in place, so that what follows starts on a new one.
  void close();

 private:
  using Clock = std::chrono::steady_clock;
  std::int64_t last_window_;
  bool has_contact_, terminal_, open_ = false;
  [[nodiscard]] bool due();
  void put(const std::string& line);
  Clock::time_point begin_, shown_;
};

}  // namespace ricochet::coupler

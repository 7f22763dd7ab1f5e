#pragma once

#include <cstdint>
#include <limits>

#include "common/base/archive.hpp"

namespace ricochet {

/// Separated: after a contact, every pair open and the smallest gap growing for a stated number of windows
/// (`coupling.separation_windows` of the scene). The separation window is the first of that streak.
class SeparationWatch {
 public:
  SeparationWatch() = default;
  explicit SeparationWatch(int windows) : needed_(windows) {}

  /// Call once per accepted window.
  void update(std::int64_t window, int pairs_closed, double gap_min_m) {
    const bool nothing_opposite = gap_min_m == std::numeric_limits<double>::max();
    const bool growing = gap_min_m > last_gap_m_ || nothing_opposite;
    last_gap_m_ = gap_min_m;
    if (pairs_closed > 0) {
      last_gap_m_ =
          -std::numeric_limits<double>::infinity();  // a closed gap is 0 up to round-off: any open one has grown
      touched_ = true;
      separated_ = false;
      streak_ = 0;
      return;
    }
    streak_ = growing ? streak_ + 1 : 0;
    if (touched_ && streak_ >= needed_) {
      separated_ = true;
      touched_ = false;
      separation_window_ = window - streak_ + 1;
    }
  }

  /// True from the end of a streak until the next contact.
  [[nodiscard]] bool separated() const { return separated_; }
  /// At whose end the bodies last separated; negative before the first time.
  [[nodiscard]] std::int64_t separation_window() const { return separation_window_; }

  void archive(Archive& a) { a(last_gap_m_, streak_, touched_, separated_, separation_window_); }

 private:
  int needed_ = 1;
  double last_gap_m_ = 0.0;
  int streak_ = 0;
  bool touched_ = false;
  bool separated_ = false;
  std::int64_t separation_window_ = -1;
};

}  // namespace ricochet

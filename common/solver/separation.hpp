#pragma once

#include <cstdint>
#include <limits>

namespace ricochet::solver {

/// Separated: after a contact, every pair open and the smallest gap growing for a stated number of windows
/// (`coupling.separation_windows` of the scene). The separation time is the end of the first window of that streak.
class SeparationWatch {
 public:
  SeparationWatch() = default;
  SeparationWatch(int windows, double window_size_s) : needed_(windows), window_size_s_(window_size_s) {}

  /// Call once per accepted window.
  void update(std::int64_t window, int pairs_closed, double gap_min_m) {
    const bool growing = gap_min_m > last_gap_m_;
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
      separation_time_s_ = static_cast<double>(window - streak_ + 1) * window_size_s_;
    }
  }

  /// True from the end of a streak until the next contact.
  [[nodiscard]] bool separated() const { return separated_; }
  /// Of the last separation; negative before the first [s].
  [[nodiscard]] double separation_time_s() const { return separation_time_s_; }

 private:
  int needed_ = 1;
  double window_size_s_ = 0.0;
  double last_gap_m_ = 0.0;
  int streak_ = 0;
  bool touched_ = false;
  bool separated_ = false;
  double separation_time_s_ = -1.0;
};

}  // namespace ricochet::solver

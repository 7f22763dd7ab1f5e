#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace ricochet {

class Archive;

/// The time of windows. Window n ends at
///   t_n = t_k + (n - n_k) dt_k,   k the last change of size before window n: at the end of window n_k, at t_k
/// and of windows of one size at n dt. Windows are counted from 1; 0 is the start. Code that needs a time or a size
/// asks the clock, and keeps numbers of windows. (C++17, as all that is installed.)
class WindowClock {
 public:
  /// Every window has one size [s]. Not explicit: a size is a clock.
  WindowClock(double size_s = 0.0) : segments_{{0, 0.0, size_s}} {}  // NOLINT(google-explicit-constructor)

  /// At the end of a window [s].
  [[nodiscard]] double time_s(std::int64_t window) const {
    const Segment& segment = last_before(window);
    return segment.from_s + static_cast<double>(window - segment.window) * segment.size_s;
  }
  /// Size of a window, from 1 on [s].
  [[nodiscard]] double size_s(std::int64_t window) const { return last_before(window).size_s; }
  /// Size of the windows after the last change [s].
  [[nodiscard]] double size_s() const { return segments_.back().size_s; }
  /// Largest of all windows, those that may come included [s].
  [[nodiscard]] double largest_size_s() const {
    const auto smaller = [](const Segment& a, const Segment& b) { return a.size_s < b.size_s; };
    return std::max(may_come_s_, std::max_element(segments_.begin(), segments_.end(), smaller)->size_s);
  }
  /// Windows of this size may come, too, as only the run will know [s].
  void let_come(double size_s) { may_come_s_ = std::max(may_come_s_, size_s); }

  /// Windows after `window` have another size, and no other change follows.
  void change(std::int64_t window, double size_s) {
    while (segments_.size() > 1 && segments_.back().window >= window) segments_.pop_back();
    if (size_s == segments_.back().size_s) return;
    segments_.push_back({window, time_s(window), size_s});
    if (window == 0) segments_.erase(segments_.begin());
  }
  bool operator==(const WindowClock& other) const { return segments_ == other.segments_; }
  [[nodiscard]] bool changes() const { return segments_.size() > 1 || may_come_s_ > 0.0; }
  /// The first window after `window` whose successor has another size; < 0: none.
  [[nodiscard]] std::int64_t next_change(std::int64_t window) const {
    for (const auto& segment : segments_)
      if (segment.window > window) return segment.window;
    return -1;
  }
  /// The first window after the last change that ends at `time_s` or later, but for rounding.
  [[nodiscard]] double window_at(double time_s) const {
    const Segment& last = segments_.back();
    return static_cast<double>(last.window) + std::ceil((time_s - last.from_s) / last.size_s - 1e-9);
  }

  void archive(Archive& a);

 private:
  struct Segment {
    std::int64_t window = 0;            ///< after which its windows come
    double from_s = 0.0, size_s = 0.0;  ///< end of that window, size of those after it
    bool operator==(const Segment& other) const {
      return window == other.window && from_s == other.from_s && size_s == other.size_s;
    }
    void archive(Archive& a);
  };
  [[nodiscard]] const Segment& last_before(std::int64_t window) const {
    auto segment = segments_.end() - 1;
    while (segment != segments_.begin() && segment->window >= window) --segment;
    return *segment;
  }

  double may_come_s_ = 0.0;
  std::vector<Segment> segments_;
};

}  // namespace ricochet

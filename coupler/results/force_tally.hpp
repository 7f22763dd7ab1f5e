#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <optional>
#include <utility>
#include <vector>

#include "common/base/archive.hpp"
#include "common/base/window_clock.hpp"

namespace ricochet::coupler {

/// The numbers that are kept of a contact force, window by window, for the end of a run.
///
/// First contact and separation are events of a force above a level, `level_share` of the largest one: forces of
/// bodies that only touch are rounding. The level is known at the end alone, so the windows are kept in which the force
/// exceeded all before them, and those whose force none after them reached; either list holds what is above the level
/// so far, each item a thousandth from the next.
///
/// In the first window of an impact of flat surfaces the mass of the contact nodes stops, whatever the step is: a force
/// that goes with 1/step. `settled` is the largest force of windows that begin later than the rise time 2h/c after the
/// force came above the level; `gauge` the largest mean over 2h/c, which a gauge sees that resolves no less.
class ForceTally {
 public:
  static constexpr double level_share = 1e-3;

  struct Peak {
    std::int64_t window = 0;
    double force_n = 0.0;
    void take(std::int64_t other, double other_force_n) {
      if (other_force_n > force_n) *this = {other, other_force_n};
    }
    void archive(Archive& a) { a(window, force_n); }
  };

  ForceTally() = default;
  /// At the ends of `separation_windows` in a row all pairs are open: then bodies are separate. In the first of these
  /// there may still have been a force; all others are at or below the level. `rise_time_s`: 2h/c. `clock` must outlive
  /// it.
  ForceTally(const WindowClock& clock, double rise_time_s, int separation_windows)
      : clock_(&clock), rise_time_s_(rise_time_s), free_windows_(std::max(1, separation_windows - 1)) {}
  ForceTally(WindowClock&& clock, double rise_time_s, int separation_windows) = delete;

  /// Mean force over a window [N]; windows ascend, and one that is left out has the force of the next.
  void add(std::int64_t window, double force_n);

  [[nodiscard]] double level_n() const { return level_share * largest_.force_n; }
  /// At the end of the first window above the level.
  [[nodiscard]] std::optional<double> first_contact_s() const;
  /// At the end of the last window above the level before the last separation.
  [[nodiscard]] std::optional<double> separation_time_s() const;
  [[nodiscard]] const Peak& largest() const { return largest_; }
  /// Empty if no contact lasted longer than 2h/c.
  [[nodiscard]] std::optional<Peak> settled() const;
  /// The force of the first window above the level [N].
  [[nodiscard]] double first_window_n() const { return rises_.empty() ? 0.0 : rises_.front().force_n; }
  [[nodiscard]] double gauge_n() const { return gauge_n_; }
  [[nodiscard]] double rise_time_s() const { return rise_time_s_; }
  [[nodiscard]] double time_s(std::int64_t window) const { return clock_->time_s(window); }

  void archive(Archive& a);

 private:
  void note_rise(const Peak& now);
  void note_fall(const Peak& now);
  void note_settled(const Peak& now);
  void note_gauge(const Peak& now);

  inline static const WindowClock none_;  ///< of no contact
  const WindowClock* clock_ = &none_;
  double rise_time_s_ = 0.0;
  int free_windows_ = 1;  ///< without a force, that are a separation
  std::int64_t last_window_ = 0;
  Peak largest_, settled_;
  std::vector<Peak> rises_, falls_;  ///< ascending and descending forces above the level
  std::int64_t begin_ = -1;          ///< window since which the force has been above the level; < 0: it is not
  Peak phase_;                       ///< largest of the last time above the level
  struct Separation {
    std::int64_t window = -1;
    double largest_n = 0.0;  ///< of the contact that it ended
    void archive(Archive& a) { a(window, largest_n); }
  } separation_;  ///< the last with the levels of its time
  struct Impulse {
    double time_s = 0.0, impulse_n_s = 0.0;
    void archive(Archive& a) { a(time_s, impulse_n_s); }
  };
  std::deque<Impulse> impulses_{Impulse{}};  ///< at ends of windows, over the last 2h/c
  double gauge_n_ = 0.0;
};

}  // namespace ricochet::coupler

#include "coupler/results/force_tally.hpp"

#include <algorithm>

namespace ricochet::coupler {
namespace {

/// Forces that differ by less are one item of a list.
constexpr double step = 1.001;
/// Rounding of times that are multiples of the window.
constexpr double almost = 1.0 - 1e-9;

}  // namespace

void ForceTally::add(std::int64_t window, double force_n) {
  const Peak now{window, force_n};
  largest_.take(window, force_n);
  note_rise(now);
  note_fall(now);
  note_settled(now);
  note_gauge(now);
  last_window_ = window;
}

void ForceTally::note_rise(const Peak& now) {
  if (now.force_n > 0.0 && (rises_.empty() || now.force_n > step * rises_.back().force_n)) rises_.push_back(now);
  const auto above = [this](const Peak& peak) { return peak.force_n > level_n(); };
  rises_.erase(rises_.begin(), std::find_if(rises_.begin(), rises_.end(), above));
}

void ForceTally::note_fall(const Peak& now) {
  const auto drop_to = [this](double force_n) {
    while (!falls_.empty() && falls_.back().force_n <= force_n) falls_.pop_back();
  };
  drop_to(std::max(level_n(), now.force_n));
  if (now.force_n > level_n()) {
    if (!falls_.empty() && falls_.back().force_n <= step * now.force_n) {
      falls_.back().window = now.window;
    } else {
      falls_.push_back(now);
    }
    return;
  }
  const std::int64_t since = falls_.empty() ? -1 : falls_.back().window;
  if (since >= 0 && now.window - since >= free_windows_) separation_ = {since, phase_.force_n};
}

void ForceTally::note_settled(const Peak& now) {
  if (now.force_n <= level_n()) {
    begin_ = -1;
    return;
  }
  if (begin_ < 0) {
    begin_ = now.window;
    phase_ = {};
  }
  phase_.take(now.window, now.force_n);
  if (now.window > begin_ && time_s(now.window - begin_) >= almost * rise_time_s_)
    settled_.take(now.window, now.force_n);
}

void ForceTally::note_gauge(const Peak& now) {
  const double end_s = time_s(now.window), from_s = end_s - rise_time_s_;
  const double lasts_s = time_s(now.window - last_window_);
  if (lasts_s <= 0.0) return;  // the start
  impulses_.push_back({end_s, impulses_.back().impulse_n_s + now.force_n * lasts_s});
  if (lasts_s >= almost * rise_time_s_) {
    gauge_n_ = std::max(gauge_n_, now.force_n);
    impulses_.erase(impulses_.begin(), impulses_.end() - 1);
    return;
  }
  while (impulses_.size() > 2 && impulses_[1].time_s <= from_s) impulses_.pop_front();
  const auto &low = impulses_[0], &high = impulses_[1];
  const double share = std::clamp((from_s - low.time_s) / (high.time_s - low.time_s), 0.0, 1.0);
  const double before = low.impulse_n_s + share * (high.impulse_n_s - low.impulse_n_s);
  gauge_n_ = std::max(gauge_n_, (impulses_.back().impulse_n_s - before) / rise_time_s_);
}

std::optional<double> ForceTally::first_contact_s() const {
  return rises_.empty() ? std::nullopt : std::optional(time_s(rises_.front().window));
}

std::optional<double> ForceTally::separation_time_s() const {
  if (!falls_.empty() && last_window_ - falls_.back().window >= free_windows_) return time_s(falls_.back().window);
  if (separation_.window >= 0 && separation_.largest_n > level_n()) return time_s(separation_.window);
  return std::nullopt;
}

std::optional<ForceTally::Peak> ForceTally::settled() const {
  return settled_.force_n > 0.0 ? std::optional(settled_) : std::nullopt;
}

void ForceTally::archive(Archive& a) {
  a(last_window_, largest_, settled_, rises_, falls_, begin_, phase_, separation_, impulses_, gauge_n_);
  if (impulses_.empty()) a.refuse("a force without its impulse");
}

}  // namespace ricochet::coupler

#pragma once

#include <algorithm>

#include "coupler/interface/link.hpp"

namespace ricochet::coupler {

/// When the implicit participant integrates explicitly, or windows are those of a flight: after separation, until the
/// bodies could meet again.
///
/// The fastest closing of any pair so far bounds how much of a gap one window can close. Away: separated, and the
/// smallest gap is more than four windows of that closing. Back: the smallest gap is less than two windows of it, so
/// that a whole explicit window still fits before contact. Different numbers, so that one gap does not switch to and
/// fro.
class SeparationSwitch {
 public:
  /// Call after every accepted window; returns whether the implicit participant is to integrate explicitly from here
  /// on.
  bool update(const wire::ContactReport& contact, double window_size_s) {
    return away(contact, window_size_s, contact.separated);
  }
  /// The same of a window of any size, whether the bodies have touched before or not: none closes in it.
  bool apart(const wire::ContactReport& contact, double window_size_s) { return away(contact, window_size_s, true); }

  void archive(Archive& a) { a(fastest_closing_m_s_, away_now_); }

 private:
  bool away(const wire::ContactReport& contact, double window_size_s, bool may_begin) {
    fastest_closing_m_s_ = std::max(fastest_closing_m_s_, -contact.gap_rate_min_m_s);
    const double one_window_m = fastest_closing_m_s_ * window_size_s;
    if (away_now_) {
      away_now_ = contact.pairs_closed == 0 && contact.gap_min_m > 2.0 * one_window_m;
    } else {
      away_now_ = may_begin && contact.pairs_closed == 0 && contact.gap_min_m > 4.0 * one_window_m;
    }
    return away_now_;
  }

  double fastest_closing_m_s_ = 0.0;
  bool away_now_ = false;
};

}  // namespace ricochet::coupler

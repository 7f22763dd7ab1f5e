#pragma once

#include <algorithm>

#include "coupler/interface/link.hpp"

namespace ricochet::coupler {

/// When the implicit participant integrates explicitly: after separation, until the bodies could meet again.
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
    fastest_closing_m_s_ = std::max(fastest_closing_m_s_, -contact.gap_rate_min_m_s);
    const double one_window_m = fastest_closing_m_s_ * window_size_s;
    if (explicit_now_) {
      explicit_now_ = contact.pairs_closed == 0 && contact.gap_min_m > 2.0 * one_window_m;
    } else {
      explicit_now_ = contact.separated && contact.pairs_closed == 0 && contact.gap_min_m > 4.0 * one_window_m;
    }
    return explicit_now_;
  }

  void archive(Archive& a) { a(fastest_closing_m_s_, explicit_now_); }

 private:
  double fastest_closing_m_s_ = 0.0;
  bool explicit_now_ = false;
};

}  // namespace ricochet::coupler

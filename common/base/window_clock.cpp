#include "common/base/window_clock.hpp"

#include <algorithm>
#include <cmath>

#include "common/base/archive.hpp"

namespace ricochet {

void WindowClock::Segment::archive(Archive& a) { a(window, from_s, size_s); }

void WindowClock::archive(Archive& a) {
  a.any_size(segments_);
  const auto wrong = [](const Segment& s) { return s.window < 0 || !(s.size_s > 0.0) || !std::isfinite(s.from_s); };
  const auto later = [](const Segment& x, const Segment& y) { return x.window >= y.window; };
  if (segments_.empty() || segments_.front().window != 0 || std::any_of(segments_.begin(), segments_.end(), wrong) ||
      std::adjacent_find(segments_.begin(), segments_.end(), later) != segments_.end())
    a.refuse("a clock that goes wrong");
}

}  // namespace ricochet

#include <gtest/gtest.h>

#include "common/base/error.hpp"
#include "common/base/window_clock.hpp"

namespace ricochet {
namespace {

/// To the last bit what a product gives: whole runs have the bytes that they had.
TEST(WindowClock, OfOneSizeMultiplies) {
  const WindowClock clock = 1.0 / 3.0;
  for (std::int64_t n = 0; n < 1000; ++n) EXPECT_EQ(clock.time_s(n), static_cast<double>(n) * (1.0 / 3.0));
  EXPECT_EQ(clock.size_s(1), 1.0 / 3.0);
  EXPECT_FALSE(clock.changes());
  EXPECT_EQ(clock.next_change(0), -1);
}

TEST(WindowClock, AddsUpTheSizesOfItsWindows) {
  WindowClock clock = 0.5;
  clock.change(4, 0.25);
  clock.change(8, 1.0);
  double time_s = 0.0;
  for (std::int64_t n = 1; n < 20; ++n) {
    time_s += clock.size_s(n);
    EXPECT_EQ(clock.size_s(n), n <= 4 ? 0.5 : n <= 8 ? 0.25 : 1.0);
    EXPECT_EQ(clock.time_s(n), time_s);
  }
  EXPECT_EQ(clock.size_s(), 1.0);
  EXPECT_EQ(clock.largest_size_s(), 1.0);
  EXPECT_EQ(clock.next_change(0), 4);
  EXPECT_EQ(clock.next_change(4), 8);
  EXPECT_EQ(clock.next_change(8), -1);
}

TEST(WindowClock, FindsTheFirstWindowThatEndsAtATime) {
  WindowClock clock = 0.1;
  EXPECT_EQ(clock.window_at(0.3), 3) << "0.3/0.1 is 2.9999999999999996";
  EXPECT_EQ(clock.window_at(0.31), 4);
  clock.change(4, 0.05);
  EXPECT_EQ(clock.window_at(0.5), 6);
}

TEST(WindowClock, ForgetsChangesThatAnotherOneComesBefore) {
  WindowClock clock = 1.0;
  clock.change(5, 2.0);
  clock.change(9, 3.0);
  clock.change(7, 0.5);
  EXPECT_EQ(clock.time_s(20), 5.0 + 2 * 2.0 + 13 * 0.5);
  clock.change(5, 1.0);
  EXPECT_EQ(clock, WindowClock(1.0)) << "the size that it had before is no change";
  clock.change(0, 4.0);
  EXPECT_EQ(clock, WindowClock(4.0));
}

TEST(WindowClock, IsKeptAndRefusedIfItGoesWrong) {
  WindowClock clock = 0.5, read;
  clock.change(3, 0.25);
  Archive out;
  out(clock);
  const std::string bytes = out.take();
  Archive in(bytes, "the clock");
  in(read);
  in.end();
  EXPECT_EQ(read, clock);
  WindowClock stopped = 0.0;
  Archive wrong;
  EXPECT_THROW(wrong(stopped), ConfigError);
}

}  // namespace
}  // namespace ricochet

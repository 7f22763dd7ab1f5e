#pragma once

#include <gtest/gtest.h>

#include "tests/support/run.hpp"

namespace ricochet::test {

/// An oblique impact of bodies without a frame of their own keeps both momenta, makes no energy, loses at most
/// `most_lost` of it, and has the impulses of `reference`, another protocol's run.
inline void expect_both_momenta(const RunResult& run, const RunResult& reference, double most_lost) {
  EXPECT_LT(run.summary["momentum_error_max"].get<double>(), 1e-10);
  EXPECT_LT(run.summary["angular_momentum_error_max"].get<double>(), 1e-3) << "bodies without a frame of their own";
  EXPECT_LT(run.summary["energy_error_highest"].get<double>(), 1e-2);
  EXPECT_GT(run.summary["energy_error_lowest"].get<double>(), -most_lost);
  EXPECT_NEAR(run.last("contact_impulse_n_s") / reference.last("contact_impulse_n_s"), 1.0, 0.02);
  EXPECT_NEAR(run.last("friction_impulse_n_s") / reference.last("friction_impulse_n_s"), 1.0, 0.05);
}

}  // namespace ricochet::test

#include <fmt/format.h>

#include <algorithm>

#include "tests/support/run.hpp"

// Without a static step, a load that grows slowly makes the state at rest.

namespace ricochet::test {
namespace {

struct Range {
  double smallest, largest;
};

/// A bar of unit length and wave speed, held at its start; its strain energy over that at rest, sigma^2 V / (2 E), from
/// t = 4, its period, on. The load grows for `ramp_s`.
Range energy_after_a_ramp(double ramp_s) {
  const TemporaryFolder folder;
  const RunResult run = run_text(
      fmt::format("model = \"bar\"\n[[body]]\nname = \"rod\"\nmaterial = {{ youngs_modulus_pa = 1.0, density_kg_m3 = "
                  "1.0 }}\nmesh = {{ length_m = 1.0, elements = 100 }}\nsupport = [{{ surface = \"start\", fixed = "
                  "[\"x\"] }}]\ntraction = [{{ surface = \"end\", traction_pa = [-1e-3], amplitude = {{ time_s = [0.0, "
                  "{}], factor = [0.0, 1.0] }} }}]\n[time]\nstep_s = 0.005\nend_s = 12.0\n[coupling]\nprotocol = "
                  "\"all_explicit\"\n",
                  ramp_s),
      folder);
  const auto &time = run.column("time_s"), &energy = run.column("energy_strain_j");
  Range range{1e300, 0.0};
  for (std::size_t i = 0; i < time.size(); ++i) {
    if (time[i] < 4.0) continue;
    range.smallest = std::min(range.smallest, energy[i] / 5e-7);
    range.largest = std::max(range.largest, energy[i] / 5e-7);
  }
  return range;
}

/// A ramp of length T leaves of a vibration of period P the share |sin(pi T/P) / (pi T/P)|: nothing of those of this
/// bar, P = 4, 4/3, 4/5, ..., for T = 4.
TEST(StaticStart, IsALoadThatGrowsForThePeriodOfTheBody) {
  const Range range = energy_after_a_ramp(4.0);
  EXPECT_NEAR(range.smallest, 1.0, 1e-3);
  EXPECT_NEAR(range.largest, 1.0, 1e-3);
}

TEST(StaticStart, IsNoneWhereTheLoadGrowsFaster) {
  EXPECT_NEAR(energy_after_a_ramp(2.0).largest, 7.0 / 3.0, 0.01);
  EXPECT_NEAR(energy_after_a_ramp(1e-9).largest, 4.0, 0.1);
}

}  // namespace
}  // namespace ricochet::test

#pragma once

#include <cmath>
#include <string>

#include "tests/support/run.hpp"

namespace ricochet::test {

/// A bar (E = 1 GPa, rho = 1000 kg/m^3, c = 1000 m/s, L = 1 m, A = 1e-4 m^2) meets a rigid plane at 1 m/s with its end
/// of elements `ratio` times finer than the last: exact, it pushes with rho c v A = 100 N for 2 L/c = 2 ms and leaves
/// with 1 m/s. The largest element is `ratio` (q - 1)/(q^n - 1) with q^(n - 1) = ratio, and the step 0.9 of its own.
struct GradedBar {
  int ratio, elements;

  [[nodiscard]] double step_s() const {
    const double q = std::pow(ratio, 1.0 / (elements - 1));
    return 0.9 * ratio * (q - 1.0) / (std::pow(q, elements) - 1.0) / 1000.0;
  }
  [[nodiscard]] std::string text(const std::string& protocol, double step_s) const {
    return R"(model = "bar"
[[body]]
name = "bar"
material = { youngs_modulus_pa = 1e9, density_kg_m3 = 1000.0 }
area_m2 = 1e-4
mesh = { length_m = 1.0, elements = )" +
           std::to_string(elements) + ", grading = " + std::to_string(ratio) + R"( }
initial_velocity_m_s = [-1.0]
[contact]
surfaces = ["bar.start", "rigid_plane"]
[time]
step_s = )" +
           std::to_string(1e9 * step_s) + "e-9\nend_s = 3e-3\n[coupling]\nprotocol = \"" + protocol + "\"\n";
  }
};

inline double released_s(const RunResult& run) {
  double last = 0.0;
  const auto &time = run.column("time_s"), &force = run.column("contact_force_n");
  for (std::size_t i = 0; i < time.size(); ++i)
    if (force[i] > 0.0) last = time[i];
  return last;
}

}  // namespace ricochet::test

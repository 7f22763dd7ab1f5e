#pragma once

#include <cmath>

#include "tests/support/run.hpp"

/// Shared by the tests of docs/limits.md: where a method's edge lies, and what the program says on either side.
namespace ricochet::test {

/// The number between `lower` and `upper` from which on `beyond` holds, by bisection to 0.5 %; it must not hold at
/// `lower` and must hold at `upper`.
template <class Predicate>
double measured_edge(double lower, double upper, const Predicate& beyond) {
  EXPECT_FALSE(beyond(lower)) << lower;
  EXPECT_TRUE(beyond(upper)) << upper;
  while (upper > 1.005 * lower) {
    const double middle = std::sqrt(lower * upper);
    (beyond(middle) ? upper : lower) = middle;
  }
  const double edge = std::sqrt(lower * upper);
  testing::Test::RecordProperty("measured_edge", std::to_string(edge));
  return edge;
}

inline std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.17g", value);
  return text;
}

/// configs/rod_on_stop.toml stretched by a thousandth: the same motion, and what grows in it turns no element inside
/// out.
inline std::string small_rod_on_stop() {
  return replaced(config_text("rod_on_stop"), "start = [0.5]", "start = [0.5e-3]");
}

/// `ricochet check` on a scene given as text: its output and warnings, or its refusal.
inline Outcome check_text(const std::string& text, const TemporaryFolder& folder) {
  return run_command({ricochet_binary(), "check", folder.write(text, "check.toml")}, folder.path().string());
}
inline bool refused(const std::string& text, const TemporaryFolder& folder) {
  return check_text(text, folder).code == 2;
}

/// Whether the energy watch stops the run: growth above `coupling.energy_growth_limit`, 5 % unless the scene says
/// otherwise.
inline bool grows(const std::string& text, const TemporaryFolder& folder) {
  const RunResult run = run_file(folder.write(text), folder, "grows");
  EXPECT_TRUE(run.outcome.code == 0 || run.outcome.code == 3) << run.outcome.error;
  return run.outcome.code == 3;
}

/// The scene as if nobody watched its energy, and the largest growth that it then shows.
inline double unwatched_growth(const std::string& text, const TemporaryFolder& folder) {
  return run_text(with_key(text, "coupling", "energy_growth_limit", "1e9"), folder).largest("energy_error");
}

inline std::string with_penalty(const std::string& text, double penalty_pa_m) {
  return with_key(with_key(text, "contact", "enforcement", "\"penalty\""), "contact", "penalty_pa_m",
                  number(penalty_pa_m));
}

inline std::string with_step(const std::string& text, double step_s) {
  const std::string from =
      text.find("safety_factor = 0.9") != std::string::npos ? "safety_factor = 0.9" : "step_s = 2.226e-6";
  return replaced(text, from, "step_s = " + number(step_s));
}

}  // namespace ricochet::test

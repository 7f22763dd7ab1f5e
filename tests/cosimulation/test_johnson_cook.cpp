// Hardening by a power, the rate of strain and heat (Johnson, Cook 1983), through scene files.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "tests/support/plastic_bar_scenes.hpp"
#include "tests/support/vtu.hpp"

namespace ricochet::test::plastic {
namespace {

using testing::HasSubstr;

/// y = (yield_pa + hardening_pa p^exponent) (1 + factor ln max(1, p'/reference)) (1 - (T - T0)/(melting - T0)).
struct Law {
  double hardening_pa = 1e9, exponent = 0.5, factor = 0.0, reference_per_s = 1.0;
  double specific_heat = 200.0, melting_k = 393.15, start_k = 293.15;

  [[nodiscard]] std::string keys() const {
    const std::string rate =
        factor > 0 ? fmt::format(", rate_factor = {}, reference_rate_per_s = {}", factor, reference_per_s) : "";
    return fmt::format(", hardening_exponent = {}{}, heat = {{ specific_heat_j_kg_k = {}, melting_k = {} }}", exponent,
                       rate, specific_heat, melting_k);
  }
  [[nodiscard]] double yield(double p, double rate_per_s, double temperature_k) const {
    return (yield_pa + hardening_pa * std::pow(p, exponent)) *
           (1.0 + factor * std::log(std::max(1.0, rate_per_s / reference_per_s))) *
           (1.0 - (temperature_k - start_k) / (melting_k - start_k));
  }
  [[nodiscard]] double heating(double work_j_m3) const { return 0.9 * work_j_m3 / (density * specific_heat); }
};

/// Behind the fan of plastic waves of a bar that flies onto a wall. A stress travels by sqrt(d stress/d
/// strain/density), and the bar stops where the integral of d stress/(density speed) has taken all of its velocity (von
/// Karman and Duwez 1950). Without a rate every element follows one curve: stress and temperature by the plastic strain
/// p.
struct Fan {
  double stress_pa = yield_pa, plastic_strain = 0.0, temperature_k;

  explicit Fan(const Law& law, double flight_m_s) : temperature_k(law.start_k) {
    double left_m_s = flight_m_s - yield_pa / (density * sound_m_s);
    while (left_m_s > 0.0) {
      // p = s^(1/exponent) would have an infinite slope in p at its begin: equal steps of s.
      const double p = std::pow(std::pow(plastic_strain, law.exponent) + 1e-6, 1.0 / law.exponent);
      const double hotter = temperature_k + law.heating(stress_pa * (p - plastic_strain));
      const double next_pa = law.yield(p, 0.0, hotter), rise_pa = next_pa - stress_pa;
      left_m_s -= std::sqrt(rise_pa * (rise_pa / young_pa + p - plastic_strain) / density);
      stress_pa = next_pa;
      plastic_strain = p;
      temperature_k = hotter;
    }
  }
};

class JohnsonCookWave : public testing::TestWithParam<const char*> {};

TEST_P(JohnsonCookWave, HasTheStressAndTheTemperatureOfTheFan) {
  const TemporaryFolder folder;
  const Law law;
  const Fan fan(law, speed_m_s);
  const std::string probe =
      "[output]\nprobes_every = 10\n[[output.probe]]\nname = \"p\"\nbody = \"rod\"\nat_m = [0.9225]\n";
  double error[2];
  for (const int k : {0, 1}) {
    const Impact impact{.protocol = GetParam(),
                        .elements = 100 << (2 * k),
                        .hardening = law.hardening_pa,
                        .more = probe,
                        .law = law.keys()};
    const RunResult run = run_text(scene_of(impact), folder, fmt::format("k{}", k));
    error[k] = run.mean("contact_pressure_mean_pa", 0.05e-3, 0.14e-3) / fan.stress_pa - 1.0;
    const History probes = read_history(run.folder + "/probes.csv");
    EXPECT_NEAR((probes.at("p.temperature_k").back() - law.start_k) / (fan.temperature_k - law.start_k), 1.0, 0.01);
    EXPECT_NEAR((run.last("temperature_max_k") - law.start_k) / (fan.temperature_k - law.start_k), 1.0, 0.03);
    EXPECT_NEAR(probes.at("p.equivalent_plastic_strain").back() / fan.plastic_strain, 1.0, 0.01);
    EXPECT_DOUBLE_EQ(run.summary.at("temperature_max_k").get<double>(), run.last("temperature_max_k"));
    EXPECT_THAT(run.outcome.out, HasSubstr(" K\n"));
  }
  EXPECT_LT(std::abs(error[0]), 2e-3);
  EXPECT_LT(std::abs(error[1]), 0.5 * std::abs(error[0])) << error[0] << ", " << error[1];
}

INSTANTIATE_TEST_SUITE_P(Protocols, JohnsonCookWave,
                         testing::Values("hughes_liu", "fixed_point", "prakash_hjelmstad", "all_implicit",
                                         "all_explicit"),
                         [](const auto& info) { return std::string(info.param); });

/// A bar of four elements, whose end moves as given, slowly: all are strained alike, at 0.1/s and 0.2/s.
std::string pulled(const std::string& protocol, const Law& law) {
  return fmt::format(R"(model = "bar"
[[body]]
name = "rod"
material = {{ youngs_modulus_pa = {}, density_kg_m3 = {}, plasticity = {{ yield_stress_pa = {}, hardening_pa = {}{} }} }}
mesh = {{ length_m = 1.0, elements = 4 }}
area_m2 = {}
support = [{{ surface = "start", fixed = ["x"] }}]
prescribed = [{{ surface = "end", component = "x", displacement_m = 0.01, amplitude = {{ time_s = [0.0, 0.1, 0.2], factor = [0.0, 1.0, -1.0] }} }}]
[time]
step_s = 2e-5
end_s = 0.2
[coupling]
protocol = "{}"
[output]
history_every = 50
fields_every = 10000
)",
                     young_pa, density, yield_pa, law.hardening_pa, law.keys(), area_m2, protocol);
}

/// The law of a point that is strained so, in many small steps.
struct Point {
  Law law;
  double strain = 0.0, plastic = 0.0, equivalent = 0.0, work_j_m3 = 0.0, temperature_k = law.start_k, stress_pa = 0.0;

  void strain_to(double target, double duration_s) {
    constexpr int steps = 200'000;
    const double from = strain, dt = duration_s / steps;
    for (int n = 1; n <= steps; ++n) {
      strain = from + (target - from) * n / steps;
      const double trial = young_pa * (strain - plastic);
      double low = 0.0, high = std::abs(trial) / young_pa;
      if (std::abs(trial) <= law.yield(equivalent, 0.0, temperature_k)) high = 0.0;
      for (int i = 0; i < 60 && high > 0.0; ++i) {
        const double middle = 0.5 * (low + high);
        const bool flows =
            std::abs(trial) - young_pa * middle > law.yield(equivalent + middle, middle / dt, temperature_k);
        (flows ? low : high) = middle;
      }
      const double before_pa = stress_pa, flow = std::copysign(high, trial);
      plastic += flow;
      equivalent += high;
      stress_pa = young_pa * (strain - plastic);
      work_j_m3 += 0.5 * (before_pa + stress_pa) * flow;
      temperature_k = law.start_k + law.heating(work_j_m3);
    }
  }
};

class JohnsonCookBar : public testing::TestWithParam<const char*> {};

TEST_P(JohnsonCookBar, FollowsRateAndTemperature) {
  const TemporaryFolder folder;
  const Law law{.factor = 0.05, .reference_per_s = 1e-3};
  const std::string protocol = GetParam();
  const RunResult run = run_text(pulled(protocol, law), folder);
  Point point{law};
  point.strain_to(0.01, 0.1);
  point.strain_to(-0.01, 0.1);
  const double slow_pa = law.yield(point.equivalent, 0.0, point.temperature_k);
  EXPECT_GT(-point.stress_pa, 1.2 * slow_pa);  // the rate matters
  EXPECT_GT(point.temperature_k, 297.0);
  EXPECT_NEAR(run.last("plastic_work_j") / (point.work_j_m3 * area_m2), 1.0, 1e-3);
  EXPECT_NEAR(run.last("equivalent_plastic_strain_max") / point.equivalent, 1.0, 2e-3);
  EXPECT_NEAR((run.last("temperature_max_k") - law.start_k) / (point.temperature_k - law.start_k), 1.0, 2e-3);
  const auto fields = field_files(run.folder, protocol == "all_explicit" ? "explicit" : "implicit", 10000);
  for (const double stress : vtu_component(fields, "stress", "xx")) EXPECT_NEAR(stress / point.stress_pa, 1.0, 5e-3);
  for (const double temperature_k : vtu_array(fields, "temperature"))
    EXPECT_NEAR((temperature_k - law.start_k) / (point.temperature_k - law.start_k), 1.0, 2e-3);
  EXPECT_LT(largest_error(run), protocol == "all_explicit" ? 1e-9 : 2e-3);
}

INSTANTIATE_TEST_SUITE_P(Sides, JohnsonCookBar, testing::Values("all_explicit", "all_implicit"),
                         [](const auto& info) { return std::string(info.param); });

}  // namespace
}  // namespace ricochet::test::plastic

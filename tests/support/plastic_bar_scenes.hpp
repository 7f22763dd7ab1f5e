#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "tests/support/run.hpp"

/// Scenes of bars with material.plasticity, and what theory says of them.
namespace ricochet::test::plastic {

inline constexpr double young_pa = 2e11, density = 8000.0, yield_pa = 4e8, hardening_pa = 2e10, speed_m_s = 20.0;
inline constexpr double area_m2 = 1e-4, sound_m_s = 5000.0;

/// A bar of 1 m that flies onto a rigid wall at twice its yield velocity; until its free end's wave is back.
struct Impact {
  std::string protocol = "hughes_liu";
  int elements = 100;
  double end_s = 0.15e-3, hardening = hardening_pa;
  std::string implicit = "0.1", coupling = "", contact = "", participants = "", more = "";
  std::string law = "";  ///< further keys of its plasticity
  double finer = 1.0;    ///< the last element is so much shorter than the first

  /// 0.9 of what the first element bears.
  [[nodiscard]] double step_s() const {
    if (finer == 1.0) return 0.9 / elements / sound_m_s;
    const double q = std::pow(finer, -1.0 / (elements - 1));
    return 0.9 * (1.0 - q) / (1.0 - std::pow(q, elements)) / sound_m_s;
  }
};

inline std::string scene_of(const Impact& impact) {
  const bool baseline = impact.protocol.rfind("all_", 0) == 0 || impact.protocol == "local_explicit";
  const std::string partition =
      baseline ? "" : fmt::format("[partition]\nimplicit_length_m = {{ rod = {} }}\n", impact.implicit);
  return fmt::format(R"(model = "bar"
[[body]]
name = "rod"
material = {{ youngs_modulus_pa = {}, density_kg_m3 = {}, plasticity = {{ yield_stress_pa = {}, hardening_pa = {}{} }} }}
mesh = {{ length_m = 1.0, elements = {}, grading = {} }}
area_m2 = {}
initial_velocity_m_s = [{}]
[contact]
surfaces = ["rod.end", "rigid_plane"]
{}{}[time]
step_s = {:.17g}
end_s = {}
[coupling]
protocol = "{}"
{}{}{})",
                     young_pa, density, yield_pa, impact.hardening, impact.law, impact.elements, 1.0 / impact.finer,
                     area_m2, speed_m_s, impact.contact, partition, impact.step_s(), impact.end_s, impact.protocol,
                     impact.coupling, impact.participants, impact.more);
}

/// Behind the elastic precursor of yield_pa comes a second front of the speed c_p, behind which the bar rests.
struct Plateau {
  double speed_m_s = std::sqrt(young_pa * hardening_pa / (young_pa + hardening_pa) / density);
  double stress_pa = yield_pa + density * speed_m_s * (plastic::speed_m_s - yield_pa / (density * sound_m_s));
  double plastic_strain = (stress_pa - yield_pa) / hardening_pa;
  /// Plastic work at a time: what the front has run over, times the mean stress [J].
  [[nodiscard]] double work_j(double time_s) const {
    return 0.5 * (yield_pa + stress_pa) * plastic_strain * area_m2 * speed_m_s * time_s;
  }
};

/// Strain without hardening gathers in the element that yields first.
inline const std::string go_on = "outside_model = \"go_on\"\n";

inline double largest_error(const RunResult& run) {
  double largest = 0.0;
  for (const double e : run.column("energy_error")) largest = std::max(largest, std::abs(e));
  return largest;
}

}  // namespace ricochet::test::plastic

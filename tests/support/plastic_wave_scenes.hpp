#pragma once

#include <fmt/format.h>

#include <cmath>
#include <string>

/// A strip of a plate that flies onto a rigid wall, its flanks on rollers: waves of uniaxial strain that yield.
namespace ricochet::test::plastic {

struct Plate {
  std::string model = "plane_strain", protocol = "hughes_liu";
  int elements = 100;
  double end_s = 0.13e-3;
  std::string coupling{}, more{};
};

/// Behind the elastic precursor of sigma_HEL = yield (1 - nu)/(1 - 2 nu) comes a second front, whose speed is that of
/// the tangent modulus K + 4/3 G H/(3 G + H), with K = E/(3 (1 - 2 nu)) and G = E/(2 (1 + nu)). Behind it the plate
/// rests (Meyers: Dynamic Behavior of Materials, 1994, chapter 2).
struct PlateTheory {
  static constexpr double young_pa = 2e11, nu = 0.3, density = 8000.0, yield_pa = 4e8, hardening_pa = 2e10,
                          speed_m_s = 30.0;
  double shear_pa = 0.5 * young_pa / (1.0 + nu), bulk_pa = young_pa / 3.0 / (1.0 - 2.0 * nu);
  double elastic_m_s = std::sqrt((bulk_pa + 4.0 / 3.0 * shear_pa) / density);
  double plastic_m_s =
      std::sqrt((bulk_pa + 4.0 / 3.0 * shear_pa * hardening_pa / (3.0 * shear_pa + hardening_pa)) / density);
  double precursor_pa = yield_pa * (1.0 - nu) / (1.0 - 2.0 * nu);
  double left_m_s = speed_m_s - precursor_pa / (density * elastic_m_s);  ///< behind the precursor
  double stress_pa = precursor_pa + density * plastic_m_s * left_m_s;
  double strain = precursor_pa / (density * elastic_m_s * elastic_m_s) + left_m_s / plastic_m_s;
  double equivalent = (2.0 * shear_pa * strain - yield_pa) / (3.0 * shear_pa + hardening_pa);
  double von_mises_pa = yield_pa + hardening_pa * equivalent;
  /// Plastic work at a time, of a square metre [J].
  [[nodiscard]] double work_j_m2(double time_s) const {
    return 0.5 * (yield_pa + von_mises_pa) * equivalent * plastic_m_s * time_s;
  }
};

inline double width_of(const Plate& plate) { return 2.0 / plate.elements; }
inline double area_of(const Plate& plate) {
  const double w = width_of(plate);
  return plate.model == "plane_strain" ? w : plate.model == "solid" ? w * w : std::acos(-1.0) * w * w;
}

inline std::string scene_of(const Plate& plate) {
  const bool solid = plate.model == "solid", round = plate.model == "axisymmetric";
  const double w = width_of(plate);
  const std::string mesh = solid
                               ? fmt::format("height_m = {0}, width_m = {0}, elements = [2, 2, {1}]", w, plate.elements)
                           : round ? fmt::format("radius_m = {}, elements = [2, {}]", w, plate.elements)
                                   : fmt::format("height_m = {}, elements = [2, {}]", w, plate.elements);
  const std::string rollers =
      round ? R"({ surface = "outer", fixed = ["r"] })"
            : std::string(R"({ surface = "inner", fixed = ["x"] }, { surface = "outer", fixed = ["x"] })") +
                  (solid ? R"(, { surface = "front", fixed = ["y"] }, { surface = "back", fixed = ["y"] })" : "");
  const PlateTheory theory;
  return fmt::format(R"(model = "{}"
[[body]]
name = "plate"
material = {{ youngs_modulus_pa = {}, poisson_ratio = {}, density_kg_m3 = {}, plasticity = {{ yield_stress_pa = {}, hardening_pa = {} }} }}
mesh = {{ length_m = 1.0, {} }}
support = [{}]
initial_velocity_m_s = [{}{:.1f}]
[contact]
surfaces = ["plate.end", "rigid_plane"]
{}[time]
step_s = {:.17g}
end_s = {}
[coupling]
protocol = "{}"
{}{})",
                     plate.model, theory.young_pa, theory.nu, theory.density, theory.yield_pa, theory.hardening_pa,
                     mesh, rollers, solid ? "0.0, 0.0, " : "0.0, ", theory.speed_m_s,
                     plate.protocol.rfind("all_", 0) == 0 ? "" : "[partition]\nimplicit_length_m = { plate = 0.1 }\n",
                     0.6 / plate.elements / theory.elastic_m_s, plate.end_s, plate.protocol, plate.coupling,
                     plate.more);
}

}  // namespace ricochet::test::plastic

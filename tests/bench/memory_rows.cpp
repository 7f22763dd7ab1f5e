#include "tests/bench/memory_rows.hpp"

#include "common/base/write_file.hpp"
#include "tests/bench/reference_scene.hpp"

namespace ricochet::bench {
namespace {

/// 2 x 45 x 45 x 87 nodes.
constexpr const char* blocks = R"(model = "solid"
[[body]]
name = "lower"
material = { youngs_modulus_pa = 48e9, poisson_ratio = 0.2, density_kg_m3 = 2800.0 }
mesh = { start_m = -0.086, length_m = 0.086, height_m = 0.044, width_m = 0.044, elements = [44, 44, 86] }
initial_velocity_m_s = [0.0, 0.0, 1.0]
[[body]]
name = "upper"
material = { youngs_modulus_pa = 48e9, poisson_ratio = 0.2, density_kg_m3 = 2800.0 }
mesh = { length_m = 0.086, height_m = 0.044, width_m = 0.044, elements = [44, 44, 86] }
initial_velocity_m_s = [0.0, 0.0, -1.0]
[contact]
surfaces = ["lower.end", "upper.start"]
friction_coefficient = 0.3
[partition]
implicit_length_m = { lower = 0.0011, upper = 0.0011 }
[time]
step_s = 1e-7
end_s = 2e-6
)";

constexpr double unknowns_of_blocks = 3.0 * 2.0 * 45.0 * 45.0 * 87.0;
constexpr double wanted_b = 1000.0;

constexpr int refinement = 8;  // of 10 x 160 quadrilaterals a body
constexpr double unknowns_of_cylinders = 2.0 * 2.0 * (10 * refinement + 1) * (160 * refinement + 1);

}  // namespace

void Memory::repeat() {
  if (!peaks_.empty()) return;
  const auto measure = [&](const std::string& name, const std::string& scene, double unknowns) {
    peaks_.push_back({name, peak_memory_of_run_b(scene, folder_ + "/run") / unknowns});
  };
  for (const std::string protocol : {"hughes_liu", "all_explicit"}) {
    SceneChoice choice;
    choice.refinement = refinement;
    choice.protocol = protocol;
    choice.steps = 4;
    measure(protocol + ", 2 x 102400 quadrilaterals", write_reference_scene(choice, folder_ + "/cylinders.toml"),
            unknowns_of_cylinders);
  }
  const std::string scene = folder_ + "/million.toml";
  write_atomically(scene, blocks);
  measure("hughes_liu, 1e6 unknowns (solids)", scene, unknowns_of_blocks);
}

std::vector<Row> Memory::rows() const {
  std::vector<Row> rows;
  for (const Peak& peak : peaks_)
    rows.push_back(
        {"memory of all processes / 1 kB an unknown", peak.scene, {peak.per_unknown_b / wanted_b}, Level{true, 1.0}});
  return rows;
}

}  // namespace ricochet::bench

#include "tests/bench/memory_rows.hpp"

#include "common/base/write_file.hpp"

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

constexpr double wanted_b = 8e9;

}  // namespace

void Memory::repeat() {
  if (usage_) return;
  const std::string scene = folder_ + "/million.toml";
  write_atomically(scene, blocks);
  usage_ = run_command({std::string(RICOCHET_BUILD) + "/ricochet", "run", scene, "--out", folder_ + "/run"},
                       folder_ + "/run.log");
}

std::vector<Row> Memory::rows() const {
  // The kernel tells the largest process, which is the coupler or the explicit solver; the other is no larger.
  return {{"twice the largest process / 8 GB, solids of 1e6 unknowns",
           "2025 pairs",
           {2.0 * usage_->largest_process_b / wanted_b},
           Level{true, 1.0}}};
}

}  // namespace ricochet::bench

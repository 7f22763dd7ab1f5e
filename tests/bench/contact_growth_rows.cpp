#include "tests/bench/contact_growth_rows.hpp"

#include <fmt/format.h>

#include <cmath>

#include "common/base/write_file.hpp"

namespace ricochet::bench {
namespace {

constexpr int least = 401, factor = 4;
constexpr int pairs_of_window[] = {1001, 10001};
constexpr int elements_across[] = {25, 29};  ///< elements of the solids
/// Wide enough that the cylinders do not touch in twenty windows [m].
constexpr double apart_m = 1e-4;

/// `pairs` - 1 elements across, 20 of 50 um along each body, of which 6 are implicit.
std::string cylinders(int pairs, double gap_m) {
  constexpr const char* text = R"(model = "axisymmetric"
[[body]]
name = "steel"
material = {{ youngs_modulus_pa = 207e9, poisson_ratio = 0.3, density_kg_m3 = 7860.0 }}
mesh = {{ start_m = {2}, length_m = 0.001, radius_m = {0}, elements = [{1}, 20] }}
initial_velocity_m_s = [0.0, 15.0]
[[body]]
name = "carbide"
material = {{ youngs_modulus_pa = 626.8e9, poisson_ratio = 0.207, density_kg_m3 = 14900.0 }}
mesh = {{ length_m = 0.001, radius_m = {0}, elements = [{1}, 20] }}
initial_velocity_m_s = [0.0, -15.0]
[contact]
surfaces = ["steel.end", "carbide.start"]
friction_coefficient = 0.3
[partition]
implicit_length_m = {{ steel = 0.0003, carbide = 0.0003 }}
[time]
step_s = 4e-9
end_s = 80e-9
)";
  return fmt::format(fmt::runtime(text), 5e-5 * (pairs - 1), pairs - 1, -1e-3 - gap_m);
}

SceneRun run_cylinders(const std::string& folder, int pairs, double gap_m) {
  const std::string scene = fmt::format("{}/cylinders_{}.toml", folder, pairs);
  write_atomically(scene, cylinders(pairs, gap_m));
  return run_scene(scene, 1, folder + "/run");
}

int solid_pairs(int elements) { return (elements + 1) * (elements + 1); }

/// Two blocks of cubes, eight deep, with the nodes of 25 or 29 along either side of the contact, on a window of 0.9
/// h/c: what touches moves all of the surface.
SceneRun run_solids(const std::string& folder, int elements) {
  constexpr const char* text = R"(model = "solid"
[[body]]
name = "steel"
material = {{ youngs_modulus_pa = 210e9, poisson_ratio = 0.3, density_kg_m3 = 7800.0 }}
mesh = {{ start_m = {2}, length_m = {1}, height_m = 0.01, width_m = 0.01, elements = [{0}, {0}, 8] }}
[[body]]
name = "upper"
material = {{ youngs_modulus_pa = 210e9, poisson_ratio = 0.3, density_kg_m3 = 7800.0 }}
mesh = {{ length_m = {1}, height_m = 0.01, width_m = 0.01, elements = [{0}, {0}, 8] }}
initial_velocity_m_s = [0.0, 0.0, -1.0]
[contact]
surfaces = ["steel.end", "upper.start"]
[coupling]
protocol = "all_implicit"
[time]
step_s = {3}
end_s = {4}
)";
  const double edge_m = 0.01 / elements, step_s = 0.9 * edge_m / 5200.0;
  const std::string scene = fmt::format("{}/solids_{}.toml", folder, elements);
  write_atomically(scene,
                   fmt::format(fmt::runtime(text), elements, 8.0 * edge_m, -8.0 * edge_m, step_s, 20.0 * step_s));
  return run_scene(scene, 1, folder + "/run");
}

}  // namespace

void ContactGrowth::repeat() {
  for (const int pairs : {least, factor * least}) runs_[pairs].push_back(run_cylinders(folder_, pairs, 0.0));
}

std::vector<Row> ContactGrowth::rows() const {
  const auto times = [this](int pairs) {
    std::vector<double> values;
    for (const SceneRun& run : runs_.at(pairs)) values.push_back(run.setup_s + run.stepping_s);
    return values;
  };
  std::vector<double> exponents;
  for (const double ratio : quotients(times(factor * least), times(least)))
    exponents.push_back(std::log(ratio) / std::log(factor));
  return {{fmt::format("set-up and 20 windows, power of the contact pairs from {} on", least),
           fmt::format("{} pairs", factor * least), exponents, Level{true, 1.5}}};
}

void ContactWindows::repeat() {
  for (const int pairs : pairs_of_window) {
    const double with_contact_s = run_cylinders(folder_, pairs, 0.0).window_s;
    ratios_[pairs].push_back(with_contact_s / run_cylinders(folder_, pairs, apart_m).window_s);
  }
  const double fewer_s = run_solids(folder_, elements_across[0]).window_s;
  const double grown = run_solids(folder_, elements_across[1]).window_s / fewer_s;
  powers_.push_back(std::log(grown) /
                    std::log(static_cast<double>(solid_pairs(elements_across[1])) / solid_pairs(elements_across[0])));
}

std::vector<Row> ContactWindows::rows() const {
  std::vector<Row> rows{
      {fmt::format("window of solids, power of the contact pairs from {} on", solid_pairs(elements_across[0])),
       fmt::format("{} pairs", solid_pairs(elements_across[1])), powers_, Level{true, 3.0}}};
  for (const int pairs : pairs_of_window)
    rows.push_back(
        {"window with contact / without", fmt::format("{} pairs", pairs), ratios_.at(pairs), Level{true, 2.0}});
  return rows;
}

}  // namespace ricochet::bench

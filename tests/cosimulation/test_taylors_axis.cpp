// One scene as bar, in plane strain, in axisymmetry and as solids, block and cylinder. Without a Poisson's ratio they
// are one discrete problem along the axis; with one, a solid cylinder and an axisymmetric one are two meshes of one
// body.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <numeric>

#include "tests/support/run.hpp"

namespace ricochet::test {
namespace {

/// E = rho = 1, rods of length 1 and `elements` along, which fly at v = 1e-3 onto a rigid plane or each other.
struct Rod {
  const char *model, *across;
  std::string elements;
  int components;
};

const std::vector<Rod> rods{{"bar", "", "20", 1},
                            {"plane_strain", "height_m = 0.1, periodic_across = true, ", "[3, 20]", 2},
                            {"axisymmetric", "radius_m = 0.1, ", "[3, 20]", 2},
                            {"solid", "height_m = 0.1, width_m = 0.3, ", "[2, 3, 20]", 3},
                            {"solid", "radius_m = 0.1, ", "[3, 20]", 3}};

std::string body_text(const Rod& rod, const char* name, double start_m, double length_m, double nu, const char* speed) {
  return fmt::format(
      "[[body]]\nname = \"{}\"\nmaterial = {{ youngs_modulus_pa = 1.0, poisson_ratio = {}, density_kg_m3 = 1.0 }}\n"
      "mesh = {{ start_m = {}, length_m = {}, {}elements = {} }}\ninitial_velocity_m_s = [{}{}]\n",
      name, nu, start_m, length_m, rod.across, rod.elements,
      rod.components == 1   ? ""
      : rod.components == 2 ? "0.0, "
                            : "0.0, 0.0, ",
      speed);
}

std::string impact(const Rod& rod, bool two, const std::string& protocol) {
  const bool hybrid = !protocol.starts_with("all_");
  std::string text = fmt::format("model = \"{}\"\n", rod.model) + body_text(rod, "rod", -1.0, 1.0, 0.0, "1e-3");
  if (two) text += body_text(rod, "other", 0.0, 1.0, 0.0, "-1e-3");
  text += fmt::format("[contact]\nsurfaces = [\"rod.end\", \"{}\"]\n", two ? "other.start" : "rigid_plane");
  if (hybrid) text += fmt::format("[partition]\nimplicit_length_m = {{ rod = 0.3{} }}\n", two ? ", other = 0.3" : "");
  return with_protocol_of_two_steps(text + "[time]\nstep_s = 0.02\nend_s = 3.0\n", protocol);
}

class TaylorsAxis : public testing::TestWithParam<const char*> {};

TEST_P(TaylorsAxis, ForcesPerAreaAreTheSameInEveryModel) {
  constexpr double pressure = 1e-3;  // rho c v
  for (const bool two : {false, true}) {
    std::vector<std::vector<double>> histories;
    for (const Rod& rod : rods) {
      const TemporaryFolder folder;
      const RunResult run = run_text(impact(rod, two, GetParam()), folder);
      const auto& area = rod.components == 1 ? "contact_force_n" : "contact_pressure_mean_pa";
      histories.push_back(run.column(area));
      EXPECT_LT(run.summary.at("momentum_error_max").get<double>(), 1e-9) << rod.model;
      EXPECT_NEAR(run.mean(area, 0.2, 1.8), pressure, 0.02 * pressure) << rod.model;
    }
    for (std::size_t r = 1; r < rods.size(); ++r) {
      ASSERT_EQ(histories[r].size(), histories[0].size());
      double worst = 0.0;
      for (std::size_t i = 0; i < histories[0].size(); ++i)
        worst = std::max(worst, std::abs(histories[r][i] - histories[0][i]));
      EXPECT_LT(worst, 1e-9 * pressure) << rods[r].model << ' ' << rods[r].across << two;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Protocols, TaylorsAxis,
                         testing::Values("hughes_liu", "prakash_hjelmstad", "all_implicit", "all_explicit"),
                         [](const auto& test) { return std::string(test.param); });

/// The push that a cylinder of nu = 0.3, four radii long and `across` elements thick, gives a rigid plane or, at the
/// closing speed against it, another cylinder: impulse so far, over its area or not.
struct Push {
  std::vector<double> impulse, impulse_per_area;

  Push(const char* model, int across, bool two) {
    const Rod rod{model, "radius_m = 0.1, ", fmt::format("[{}, {}]", across, 4 * across), model[0] == 'a' ? 2 : 3};
    std::string text = fmt::format("model = \"{}\"\n", model) + body_text(rod, "rod", -0.4, 0.4, 0.3, "1e-3");
    if (two) text += body_text(rod, "other", 0.0, 0.4, 0.3, "-1e-3");
    text += fmt::format("[contact]\nsurfaces = [\"rod.end\", \"{}\"]\n", two ? "other.start" : "rigid_plane");
    const double step_s = 0.025 / across;
    text += fmt::format("[time]\nstep_s = {}\nend_s = 1.0\n[coupling]\nprotocol = \"all_explicit\"\n", step_s);
    const TemporaryFolder folder;
    const RunResult run = run_text(text, folder);
    for (const auto& [column, sums] :
         {std::pair{"contact_force_n", &impulse}, {"contact_pressure_mean_pa", &impulse_per_area}}) {
      const auto& values = run.column(column);
      std::partial_sum(values.begin(), values.end(), std::back_inserter(*sums));
      for (double& sum : *sums) sum *= step_s;
    }
  }
};

/// Per area the impulses of both differ at any time by less and less; the forces by what the solid's polygon of a base
/// lacks of a circle besides, 0.41/n^2 of its area.
TEST(TaylorsAxisWithPoissonsRatio, ASolidCylinderNearsTheAxisymmetricOne) {
  for (const bool two : {false, true}) {
    double coarser = 0.0;
    for (const int across : two ? std::vector{2, 4} : std::vector{2, 4, 8}) {
      const Push axisymmetric("axisymmetric", across, two), solid("solid", across, two);
      double worst = 0.0;
      for (std::size_t i = 0; i < solid.impulse.size(); ++i)
        worst = std::max(worst, std::abs(solid.impulse_per_area[i] - axisymmetric.impulse_per_area[i]));
      worst /= axisymmetric.impulse_per_area.back();
      EXPECT_LT(worst, 0.004) << across;
      if (coarser > 0.0) {
        EXPECT_LT(worst, coarser / 2.0) << across;
      }
      coarser = worst;
      const double missing = 1.0 - solid.impulse.back() / axisymmetric.impulse.back();
      EXPECT_NEAR(missing * across * across, 0.41, 0.03) << across;
    }
  }
}

/// Loads, an absorbing end, the automatic partition, fields and the x-t picture of a cylinder.
TEST(SolidCylinder, TakesUpAPushAsABarWithoutEnd) {
  const std::string text = R"(model = "solid"
[[body]]
name = "rod"
material = { youngs_modulus_pa = 1.0, poisson_ratio = 0.0, density_kg_m3 = 1.0 }
mesh = { length_m = 1.0, radius_m = 0.1, elements = [3, 40], grading = [1.0, 4.0] }
absorbing = [{ surface = "end", wave = "bar" }]
traction = [{ surface = "start", traction_pa = [0.0, 0.0, 0.01] }]
[[body.support]]
surface = "outer"
fixed = ["x", "y"]
[partition]
rule = "auto"
[time]
step_s = 0.014
end_s = 8.0
[output]
fields_every = 100
axial_stress_every = 1
)";
  const TemporaryFolder folder;
  const RunResult run = run_text(text, folder);
  EXPECT_NEAR(run.mean("velocity_mean_rod_m_s", 4.0, 8.0), 0.01, 2e-5);
  EXPECT_EQ(run.summary.at("processes").size(), 3U) << "the automatic partition has left something to both";
  const History stress = read_history(run.folder + "/axial_stress.csv");
  EXPECT_EQ(stress.size(), 41U);
  for (const auto& [column, values] : stress) {
    if (column == "time_s") continue;
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    const double mean = std::accumulate(middle, values.end(), 0.0) / static_cast<double>(values.end() - middle);
    EXPECT_NEAR(mean, -0.01, 2e-4) << column;
  }
  EXPECT_TRUE(std::filesystem::exists(run.folder + "/fields/scene.pvd"));
}

}  // namespace
}  // namespace ricochet::test

#include "tests/support/run.hpp"
#include "tests/support/triangle_mesh.hpp"

// Two plates meshed with triangles (and a quadrilateral) by Gmsh files, held at their sides, meet end on: uniaxial
// strain, so that the contact pressure is rho c_L v until the waves have been to the free ends and back, 2 L/c_L, and
// the plates fly apart as they came. Half of the nodes of a surface have twice the mass of the others, which the exact
// solution does not know: what is left of it is noise of that wave length.

namespace ricochet::test {
namespace {

constexpr double speed = 10.0, length = 0.5, height = 0.03;
const double c_l = std::sqrt(1e9 * 0.75 / (1000 * 1.25 * 0.5));

std::string plates(const TemporaryFolder& folder) {
  std::string text = "model = \"plane_strain\"\n";
  for (const auto& [name, start, sign] : {std::tuple{"lower", -length, ""}, std::tuple{"upper", 0.0, "-"}}) {
    (void)folder.write(
        rectangle_msh(name, {.width_m = height, .start_m = start, .length_m = length, .across = 4, .along = 64}),
        std::string(name) + ".msh");
    text += std::string("[[body]]\nname = \"") + name + "\"\n" +
            "material = { youngs_modulus_pa = 1e9, poisson_ratio = 0.25, density_kg_m3 = 1000.0 }\n"
            "mesh = { gmsh = \"" +
            name +
            ".msh\" }\n"
            "support = [{ surface = \"inner\", fixed = [\"x\"] }, { surface = \"outer\", fixed = [\"x\"] }]\n"
            "initial_velocity_m_s = [0.0, " +
            sign + "10.0]\n";
  }
  return text +
         "[contact]\nsurfaces = [\"lower.end\", \"upper.start\"]\n[partition]\nimplicit_length_m = { lower = 0.05, "
         "upper = 0.05 }\n"
         "[time]\nstep_s = 2e-6\nend_s = 1.5e-3\n";
}

class TrianglePlates : public testing::TestWithParam<const char*> {};

TEST_P(TrianglePlates, MeetUnderTheExactPressureAndPart) {
  const TemporaryFolder folder;
  const RunResult r = run_text(with_protocol(plates(folder), GetParam()), folder);
  const double pressure = 1000 * c_l * speed, period = 2.0 * length / c_l;
  EXPECT_NEAR(r.mean("contact_pressure_mean_pa", 0.1 * period, 0.9 * period), pressure, 0.005 * pressure);
  EXPECT_LT(r.summary.at("momentum_error_max").get<double>(), 1e-10);
  EXPECT_NEAR(r.column("contact_impulse_n_s").back(), 2.0 * 1000 * length * height * speed, 0.02 * 300);
  EXPECT_NEAR(r.last("velocity_mean_lower_m_s"), -speed, 0.03 * speed);
  EXPECT_NEAR(r.last("velocity_mean_upper_m_s"), speed, 0.03 * speed);
}

INSTANTIATE_TEST_SUITE_P(Protocols, TrianglePlates,
                         testing::Values("hughes_liu", "prakash_hjelmstad", "all_implicit", "all_explicit"),
                         [](const auto& test) { return std::string(test.param); });

}  // namespace
}  // namespace ricochet::test

#include <iomanip>

#include "tests/support/run.hpp"
#include "tests/support/triangle_mesh.hpp"

// Order of accuracy in time: a mesh is a smooth system of ordinary differential equations, so on a fixed mesh the error
// of a second-order integrator falls to a quarter when dt is halved. Loads start gently (a ramp), no contact.

namespace ricochet::test {
namespace {

const char* const bar = R"(model = "bar"
[[body]]
name = "rod"
material = { youngs_modulus_pa = 1.0, density_kg_m3 = 1.0 }
mesh = { length_m = 1.0, elements = 8 }
support = [{ surface = "start", fixed = ["x"] }]
traction = [{ surface = "end", traction_pa = [0.3], amplitude = { time_s = [0.0, 0.5], factor = [0.0, 1.0] } }]
gravity_m_s2 = [0.2]
)";

const char* const plate = R"(model = "plane_strain"
[[body]]
name = "rod"
material = { youngs_modulus_pa = 1.0, poisson_ratio = 0.3, density_kg_m3 = 1.0 }
mesh = { length_m = 1.0, height_m = 0.5, elements = [3, 8] }
support = [{ surface = "start", fixed = ["x", "y"] }]
traction = [{ surface = "end", traction_pa = [0.1, 0.3], amplitude = { time_s = [0.0, 0.5], factor = [0.0, 1.0] } }]
gravity_m_s2 = [0.1, 0.2]
)";

const char* const triangles = R"(model = "plane_strain"
[[body]]
name = "rod"
material = { youngs_modulus_pa = 1.0, poisson_ratio = 0.3, density_kg_m3 = 1.0 }
mesh = { gmsh = "rod.msh" }
support = [{ surface = "start", fixed = ["x", "y"] }]
traction = [{ surface = "end", traction_pa = [0.1, 0.3], amplitude = { time_s = [0.0, 0.5], factor = [0.0, 1.0] } }]
gravity_m_s2 = [0.1, 0.2]
)";

const char* const cylinder = R"(model = "axisymmetric"
[[body]]
name = "rod"
material = { youngs_modulus_pa = 1.0, poisson_ratio = 0.3, density_kg_m3 = 1.0 }
mesh = { length_m = 1.0, radius_m = 0.5, elements = [3, 8] }
support = [{ surface = "start", fixed = ["z"] }]
traction = [{ surface = "end", traction_pa = [0.0, 0.3], amplitude = { time_s = [0.0, 0.5], factor = [0.0, 1.0] } }]
gravity_m_s2 = [0.0, 0.2]
)";

const char* const block = R"(model = "solid"
[[body]]
name = "rod"
material = { youngs_modulus_pa = 1.0, poisson_ratio = 0.3, density_kg_m3 = 1.0 }
mesh = { length_m = 1.0, height_m = 0.5, width_m = 0.4, elements = [2, 2, 8] }
support = [{ surface = "start", fixed = ["x", "y", "z"] }]
traction = [{ surface = "end", traction_pa = [0.1, 0.2, 0.3], amplitude = { time_s = [0.0, 0.5], factor = [0.0, 1.0] } }]
gravity_m_s2 = [0.1, 0.0, 0.2]
)";

constexpr int samples = 64;  ///< times at which histories are compared

/// Momentum of the body at the sampled times up to t = 2.
std::vector<double> momentum(const std::string& scene, const std::string& protocol, int windows,
                             const TemporaryFolder& folder) {
  std::ostringstream step;
  step << std::setprecision(17) << 2.0 / windows;
  const std::string text = scene + "[time]\nstep_s = " + step.str() +
                           "\nend_s = 2.0\n[coupling]\noutside_model = \"go_on\"\nprotocol = \"" + protocol + "\"\n";
  const RunResult run = run_text(text, folder, protocol + std::to_string(windows));
  EXPECT_EQ(run.summary.at("windows").get<int>(), windows);
  const auto& all = run.column("momentum_n_kg_m_s");
  std::vector<double> sampled;
  for (int i = 1; i <= samples; ++i) sampled.push_back(all.at(static_cast<std::size_t>(i * windows / samples)));
  return sampled;
}

double difference(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum);
}

struct Model {
  const char* name;
  const char* scene;
};

class OrderInTime : public testing::TestWithParam<std::tuple<Model, const char*>> {};

TEST_P(OrderInTime, IsTwo) {
  const auto& [model, protocol] = GetParam();
  const TemporaryFolder folder;
  (void)folder.write(rectangle_msh("rod", {.width_m = 0.5, .length_m = 1.0, .across = 3, .along = 8}), "rod.msh");
  const std::string scene = model.scene;
  const auto coarse = momentum(scene, protocol, 256, folder), middle = momentum(scene, protocol, 512, folder),
             fine = momentum(scene, protocol, 1024, folder);
  // Richardson: (p_h - p_h/2) / (p_h/2 - p_h/4) = 2^order.
  EXPECT_NEAR(std::log2(difference(coarse, middle) / difference(middle, fine)), 2.0, 0.1);
  EXPECT_GT(difference(coarse, middle), 1e-9);
}

INSTANTIATE_TEST_SUITE_P(
    ModelsAndIntegrators, OrderInTime,
    testing::Combine(testing::Values(Model{"bar", bar}, Model{"plane_strain", plate}, Model{"triangles", triangles},
                                     Model{"axisymmetric", cylinder}, Model{"solid", block}),
                     testing::Values("all_explicit", "all_implicit")),
    [](const auto& test) { return std::string(std::get<0>(test.param).name) + "_" + std::get<1>(test.param); });

}  // namespace
}  // namespace ricochet::test

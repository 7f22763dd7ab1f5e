#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "common/contact/surface_stress.hpp"
#include "common/problem/problem.hpp"
#include "tests/support/scene_file.hpp"

// Eq. 29's quantity against numbers worked out by hand, on edges of unequal area.

namespace ricochet::solver {
namespace {

using Field = std::function<Eigen::Vector2d(const Eigen::Vector2d&)>;

// E = 2.5, nu = 0.25: lambda = mu = 1, so stress = (3, 1, 1) times an axial strain and 1 times a shear gamma.
std::string block(const std::string& model, const std::string& across) {
  return "model = \"" + model +
         "\"\n[[body]]\nname = \"block\"\n"
         "material = { youngs_modulus_pa = 2.5, poisson_ratio = 0.25, density_kg_m3 = 1.0 }\n"
         "mesh = { length_m = 2.0, " +
         across +
         " }\n"
         "[contact]\nsurfaces = [\"block.start\", \"rigid_plane\"]\n"
         "[time]\nstep_s = 1e-3\nend_s = 1.0\n[coupling]\nprotocol = \"all_implicit\"\n";
}

double mean_of(const std::string& text, const Field& displacement) {
  const test::TemporaryFolder folder;
  const auto problem = scene::build_problem(scene::load_scene(folder.write(text)));
  const auto states = initial_states(problem, problem.scene.participants.at(0), true);
  std::vector<Eigen::VectorXd> u;
  for (const auto& owned : states) {
    auto& values = u.emplace_back(owned.part.dofs());
    const int width = fem::components(owned.part.mesh.model);
    for (int node = 0; node < owned.part.nodes(); ++node) {
      const auto u_m = displacement(owned.part.mesh.position[static_cast<std::size_t>(node)].head<2>());
      values.segment(width * node, width) = u_m.head(width);
    }
  }
  const auto of_part = [&](int part) -> const Eigen::VectorXd& { return u[static_cast<std::size_t>(part)]; };
  return SurfaceStress(problem, states).mean(of_part);
}

// Edges of 1 and 3 m (grading 3). u_y = -x y: sigma_yy = -3 x on y = 0, where nothing shears; at the edges' midpoints
// -1.5 and -7.5. Mean (1 * 1.5 + 3 * 7.5) / 4 = 6, which is the mean over the length, too; each edge counted once would
// give 4.5.
TEST(SurfaceStress, WeighsUnequalEdgesByTheirArea) {
  const std::string text = block("plane_strain", "height_m = 4.0, elements = [2, 2], grading = [3.0, 1.0]");
  EXPECT_NEAR(mean_of(text, [](const auto& x) { return Eigen::Vector2d(0.0, -x[0] * x[1]); }), 6.0, 1e-12);
}

// Edges from r = 0 to 1 and on to 4 m, areas 1/2 and 15/2 per radian: (0.5 * 1.5 + 7.5 * 7.5) / 8 = 57/8.
TEST(SurfaceStress, WeighsRingsByTheirArea) {
  const std::string text = block("axisymmetric", "radius_m = 4.0, elements = [2, 2], grading = [3.0, 1.0]");
  EXPECT_NEAR(mean_of(text, [](const auto& x) { return Eigen::Vector2d(0.0, -x[0] * x[1]); }), 57.0 / 8.0, 1e-12);
}

// u = (y, -y): gamma = 1, e_yy = -1; stresses (-1, -3, -1) and shear 1. Principal stresses -2 +- sqrt(2) and -1: the
// most compressive is -2 - sqrt(2).
TEST(SurfaceStress, IsTheMostCompressivePrincipalStressUnderShear) {
  const std::string text = block("plane_strain", "height_m = 4.0, elements = [2, 2]");
  EXPECT_NEAR(mean_of(text, [](const auto& x) { return Eigen::Vector2d(x[1], -x[1]); }), 2.0 + std::sqrt(2.0), 1e-12);
}

// It is the surface that counts: u_y = -y^2 / 4 strains the element beside it, from y = 0 to 1, by -1/4 and the next by
// -3/4.
TEST(SurfaceStress, IsThatOfTheElementsBesideTheSurface) {
  const std::string text = block("plane_strain", "height_m = 4.0, elements = [2, 2]");
  EXPECT_NEAR(mean_of(text, [](const auto& x) { return Eigen::Vector2d(0.0, -0.25 * x[1] * x[1]); }), 0.75, 1e-12);
}

// An element whose stress changes across it has that at the edge: u_x = x y strains x by y, which is 0 on the surface.
TEST(SurfaceStress, IsTakenAtTheEdgeNotInTheMiddle) {
  const std::string text = block("plane_strain", "height_m = 4.0, elements = [1, 2]");
  const double at_edge = mean_of(text, [](const auto& x) { return Eigen::Vector2d(-(x[0] - 2.0) * x[1], -x[1]); });
  EXPECT_NEAR(at_edge, 3.0, 1e-12) << "sigma_yy = -3, no strain along the surface, no shear at its middle";
}

// E = 2.5. The sides of a bar are free, so 0 is the most compressive principal stress of one in tension.
TEST(SurfaceStress, OfABarInTensionIsZero) {
  const std::string text = block("bar", "elements = 2");
  EXPECT_NEAR(mean_of(text, [](const auto& x) { return Eigen::Vector2d(-x[0], 0.0); }), 2.5, 1e-12);
  EXPECT_EQ(mean_of(text, [](const auto& x) { return Eigen::Vector2d(x[0], 0.0); }), 0.0);
}

}  // namespace
}  // namespace ricochet::solver

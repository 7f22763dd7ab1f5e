#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <numbers>

#include "common/base/error.hpp"
#include "common/problem/problem.hpp"
#include "tests/common/scene/scene_text.hpp"
#include "tests/support/places.hpp"

namespace ricochet::scene {
namespace {

constexpr double pi = std::numbers::pi;

Problem build(const std::string& text) { return build_problem(load_text(text)); }

int count(const std::vector<bool>& flags) { return static_cast<int>(std::count(flags.begin(), flags.end(), true)); }

TEST(ContactPairs, LieAtTheSamePlaceAndAreSortedFromTheAxis) {
  const Problem problem = build(cylinders);
  const ContactGeometry& contact = problem.contacts.front();
  ASSERT_EQ(contact.pairs.size(), 5U);
  EXPECT_EQ(contact.body_a, 0);
  EXPECT_EQ(contact.body_b, 1);
  EXPECT_NEAR((contact.normal - Eigen::Vector3d(0.0, 1.0, 0.0)).norm(), 0.0, 1e-15);
  for (std::size_t i = 0; i < contact.pairs.size(); ++i) {
    const ContactPair& pair = contact.pairs[i];
    const Eigen::Vector3d& a = problem.bodies[0].mesh.position[static_cast<std::size_t>(pair.node_a)];
    const Eigen::Vector3d& b = problem.bodies[1].mesh.position[static_cast<std::size_t>(pair.b.at(0).node)];
    EXPECT_NEAR((a - b).norm(), 0.0, 1e-15);
    EXPECT_NEAR(pair.distance_m, 0.001 * static_cast<double>(i), 1e-15);
    EXPECT_EQ(pair.gap0_m, 0.0);
  }
}

TEST(ContactPairs, AreasAddUpToTheSurface) {
  double circle = 0.0, rectangle = 0.0;
  const Problem round = build(cylinders);
  for (const ContactPair& pair : round.contacts.front().pairs) circle += pair.area_m2;
  EXPECT_NEAR(circle, pi * 0.004 * 0.004, 1e-12 * circle);
  const Problem plane = build(plates);
  for (const ContactPair& pair : plane.contacts.front().pairs) rectangle += pair.area_m2;
  EXPECT_NEAR(rectangle, 0.2 * 0.5, 1e-13);
  EXPECT_NEAR(plane.contacts.front().pairs[0].area_m2, 0.025 * 0.5, 1e-14);
  EXPECT_EQ(build(bars).contacts.front().pairs.at(0).area_m2, 6.4516e-4);
}

TEST(ContactPairs, AxisNodeHasTheIntegralOfItsShapeFunction) {
  // integral over 0..h of (1 - r/h) r dr times 2 pi = pi h^2 / 3
  EXPECT_NEAR(build(cylinders).contacts.front().pairs[0].area_m2, pi * 1e-6 / 3.0, 1e-18);
}

TEST(ContactGap, IsMeshDistancePlusInitialGapPlusNose) {
  EXPECT_NEAR(build(bars).contacts.front().pairs[0].gap0_m, 0.508e-3, 1e-17);
  const Problem problem =
      build(replaced(cylinders, "friction_coef", "initial_gap_m = 1e-5\nnose_radius_m = 0.01\nfriction_coef"));
  for (const ContactPair& pair : problem.contacts.front().pairs)
    EXPECT_NEAR(pair.gap0_m, 1e-5 + pair.distance_m * pair.distance_m / 0.02, 1e-17);
}

TEST(ContactGap, OfARigidPlaneIsMeasuredFromTheSurface) {
  const std::string text = replaced(replaced(bars, "\"right.start\"", "\"rigid_plane\""), ", right = 0.0635", "");
  const Problem problem = build(replaced(text, "surfaces", "initial_gap_m = 0.25\nsurfaces"));
  EXPECT_EQ(problem.contacts.front().body_b, -1);
  EXPECT_TRUE(problem.contacts.front().pairs.at(0).b.empty());
  EXPECT_EQ(problem.contacts.front().pairs.at(0).gap0_m, 0.25);
}

TEST(ContactNormal, OfABarPointsOutOfIt) {
  EXPECT_EQ(build(bars).contacts.front().normal[0], 1.0);
  const Problem other = build(replaced(bars, "[\"left.end\", \"right.start\"]", "[\"right.start\", \"left.end\"]"));
  EXPECT_EQ(other.contacts.front().normal[0], -1.0);
  EXPECT_EQ(other.bodies[static_cast<std::size_t>(other.contacts.front().body_a)].name, "right");
}

TEST(ContactPairs, OfSolidsHaveTheAreasOfTheirNodes) {
  const Problem problem = build(blocks);
  ASSERT_EQ(problem.contacts.front().pairs.size(), 12U);
  EXPECT_EQ(problem.contacts.front().normal, Eigen::Vector3d(0.0, 0.0, 1.0));
  double area = 0.0, smallest = 1.0;
  for (const ContactPair& pair : problem.contacts.front().pairs) {
    EXPECT_LT((problem.bodies[0].mesh.position[static_cast<std::size_t>(pair.node_a)] -
               problem.bodies[1].mesh.position[static_cast<std::size_t>(pair.b.at(0).node)])
                  .norm(),
              1e-15);
    area += pair.area_m2;
    smallest = std::min(smallest, pair.area_m2);
  }
  EXPECT_NEAR(area, 0.2 * 0.3, 1e-15);
  EXPECT_NEAR(smallest, 0.25 * 0.1 * 0.1, 1e-15) << "a quarter of a face at the corners";
  EXPECT_EQ(count(problem.bodies[0].implicit_element), 2 * 3 * 2);
}

TEST(ContactNormal, MayLieAcross) {
  const std::string surfaces =
      replaced(plates, "[\"lower.end\", \"upper.start\"]", "[\"lower.outer\", \"rigid_plane\"]");
  const std::string text = replaced(surfaces, "{ lower = 0.1, upper = 0.05 }", "{ lower = 0.1 }");
  const Problem problem = build(text);
  EXPECT_NEAR((problem.contacts.front().normal - Eigen::Vector3d(1.0, 0.0, 0.0)).norm(), 0.0, 1e-15);
  EXPECT_EQ(problem.contacts.front().pairs.size(), 7U);
  EXPECT_EQ(count(problem.bodies[0].implicit_element), 2 * 6);  // two columns of 50 mm from the outer side
}

TEST(Periodic, WrapsABlockAlongBothDirections) {
  const Problem problem = build(R"(model = "solid"
[[body]]
name = "block"
material = { youngs_modulus_pa = 1e9, poisson_ratio = 0.25, density_kg_m3 = 1000.0 }
mesh = { length_m = 0.4, height_m = 0.3, width_m = 0.2, elements = [3, 4, 2], periodic_across = true }
[time]
step_s = 1e-6
end_s = 1e-5
[coupling]
protocol = "all_explicit"
)");
  const BodyProblem& block = problem.bodies[0];
  EXPECT_EQ(block.mesh.position.size(), 3U * 4U * 3U);
  EXPECT_EQ(block.mesh.surfaces.size(), 2U);
  std::vector<int> all;
  for (int e = 0; e < 24; ++e) all.push_back(e);
  const fem::Part part = fem::extract_part(block.mesh, "block", block.section, block.material, all);
  EXPECT_NEAR(part.lumped_mass.sum(), 1000.0 * 0.4 * 0.3 * 0.2, 1e-9);
  // Uniform shear u_x = z, u_y = 2 z: forces on the two ends only, the same at every node of an end.
  Eigen::VectorXd u = Eigen::VectorXd::Zero(part.dofs());
  for (int i = 0; i < part.nodes(); ++i) {
    const double z = part.mesh.position[static_cast<std::size_t>(i)][2];
    u.segment<2>(3 * i) << z, 2.0 * z;
  }
  const Eigen::VectorXd force = part.stiffness * u;
  const double shear = 1e9 / 2.5 * 0.3 * 0.2 / 12.0;
  for (int i = 0; i < part.nodes(); ++i) {
    const double z = part.mesh.position[static_cast<std::size_t>(i)][2];
    const double end = z == 0.0 ? -1.0 : z == 0.4 ? 1.0 : 0.0;
    EXPECT_LT((force.segment<3>(3 * i) - end * shear * Eigen::Vector3d(1.0, 2.0, 0.0)).norm(), 1e-9 * shear) << i;
  }
}

TEST(Periodic, WrapsTheMeshAcross) {
  const std::string periodic = "height_m = 0.2, elements = [4, 6], periodic_across = true";
  const std::string text = replaced(replaced(plates, "height_m = 0.2, elements = [4, 6]", periodic),
                                    "height_m = 0.2, elements = [4, 6] }", periodic + " }");
  const Problem problem = build(text);
  const BodyProblem& lower = problem.bodies[0];
  EXPECT_EQ(lower.mesh.position.size(), 4U * 7U);
  EXPECT_EQ(lower.mesh.surfaces.size(), 2U);
  ASSERT_EQ(problem.contacts.front().pairs.size(), 4U);
  for (const ContactPair& pair : problem.contacts.front().pairs) EXPECT_NEAR(pair.area_m2, 0.05 * 0.5, 1e-14);
  std::vector<int> all;
  for (int e = 0; e < 24; ++e) all.push_back(e);
  const fem::Part part = fem::extract_part(lower.mesh, "lower", lower.section, lower.material, all);
  EXPECT_NEAR(part.lumped_mass.sum(), 1000.0 * 0.2 * 0.3 * 0.5, 1e-9);
  // Uniform shear u_x = y: forces on the two faces only, the same at every node of a face.
  Eigen::VectorXd u = Eigen::VectorXd::Zero(part.dofs());
  for (int i = 0; i < part.nodes(); ++i) u[2 * i] = part.mesh.position[static_cast<std::size_t>(i)][1];
  const Eigen::VectorXd force = part.stiffness * u;
  const double shear = 1e9 / 2.5 * 0.05 * 0.5;
  for (int i = 0; i < part.nodes(); ++i) {
    const double expected = i < 4 ? -shear : i >= 24 ? shear : 0.0;
    EXPECT_NEAR(force[2 * i], expected, 1e-6 * shear);
    EXPECT_NEAR(force[2 * i + 1], 0.0, 1e-6 * shear);
  }
}

TEST(Constraints, AxisSupportsAndPrescribedMotion) {
  const Problem problem = build(replaced(
      cylinders, "initial_velocity_m_s = [0.0, 30.0]",
      "initial_velocity_m_s = [1.0, 30.0]\nsupport = [{ surface = \"outer\", fixed = [\"r\"] }]\n"
      "prescribed = [{ surface = \"start\", component = \"z\", displacement_m = 2e-4, amplitude = { time_s = [0.0], "
      "factor = [0.5] } }]"));
  const BodyProblem& steel = problem.bodies[0];
  for (int node = 0; node < 45; ++node) {
    const Eigen::Vector3d& x = steel.mesh.position[static_cast<std::size_t>(node)];
    const bool radial = x[0] == 0.0 || std::abs(x[0] - 0.004) < 1e-12, axial = x[1] == -0.02;
    EXPECT_EQ(steel.fixed_dof[static_cast<std::size_t>(2 * node)], radial);
    EXPECT_EQ(steel.fixed_dof[static_cast<std::size_t>(2 * node + 1)], axial);
    EXPECT_EQ(steel.prescribed_index[static_cast<std::size_t>(2 * node + 1)], axial ? 0 : -1);
    EXPECT_EQ(steel.prescribed_displacement_m[2 * node + 1], axial ? 2e-4 : 0.0);
    EXPECT_EQ(steel.initial_displacement_m[2 * node + 1], axial ? 1e-4 : 0.0);
    EXPECT_EQ(steel.initial_velocity_m_s[2 * node], radial ? 0.0 : 1.0);
    EXPECT_EQ(steel.initial_velocity_m_s[2 * node + 1], axial ? 0.0 : 30.0);
  }
}

TEST(InitialState, DisplacementIsLinearAlongTheAxis) {
  const Problem problem =
      build(replaced(bars, "area_m2", "initial_displacement_m = { start = [-2e-4], end = [2e-4] }\narea_m2"));
  for (int i = 0; i <= 20; ++i) EXPECT_NEAR(problem.bodies[0].initial_displacement_m[i], -2e-4 + 2e-5 * i, 1e-17);
}

TEST(SectionOf, HoldsAreaThicknessOrTheCircle) {
  EXPECT_EQ(build(bars).bodies[0].section.measure, 6.4516e-4);
  EXPECT_EQ(build(plates).bodies[0].section.measure, 0.5);
  EXPECT_EQ(build(cylinders).bodies[0].section.measure, 2.0 * pi);
}

TEST(Gmsh, TwoBodiesOutOfOneFile) {
  const Problem problem = build_problem(load_scene(test::source_folder() + "/configs/striker_gmsh.toml"));
  EXPECT_EQ(problem.bodies[0].mesh.elements.size(), 224U);
  EXPECT_EQ(problem.bodies[1].mesh.elements.size(), 392U);
  EXPECT_EQ(count(problem.bodies[0].implicit_element), 80);
  EXPECT_EQ(count(problem.bodies[1].implicit_element), 140);
  EXPECT_EQ(problem.contacts.front().pairs.size(), 9U);
  double area = 0.0;
  for (const ContactPair& pair : problem.contacts.front().pairs) area += pair.area_m2;
  EXPECT_NEAR(area, pi * 0.005 * 0.005, 1e-12 * area);
}

TEST(Gmsh, UnknownGroupsAndSurfacesNameTheLine) {
  const std::string folder = test::source_folder() + "/configs/";
  std::ifstream file(folder + "striker_gmsh.toml");
  std::string text((std::istreambuf_iterator<char>(file)), {});
  while (text.find("\"striker.msh\"") != std::string::npos)
    text = replaced(text, "\"striker.msh\"", "\"" + folder + "striker.msh\"");
  const std::vector<std::array<std::string, 3>> wrong{
      {"[\"striker_tip\"]", "[\"striker_top\"]", "did you mean \"striker_tip\"?"},
      {"striker.striker_face", "striker.striker_fice", "did you mean \"striker_face\"?"},
      {"\"anvil_base\"", "\"anvil_basis\"", "support[0].surface: found surface \"anvil_basis\"; did you mean"},
      {"[partition]\nimplicit_groups = { striker = [\"striker_tip\"],",
       "multiplier_update = \"massless\"\n[partition]\nimplicit_groups = {",
       "contact.multiplier_update: found \"massless\" and an explicit element"},
      {"name = \"anvil\"", "name = \"amvil\"", "amvil"}};
  for (const auto& [from, to, says] : wrong) {
    try {
      (void)build(replaced(text, from, to));
      FAIL() << to;
    } catch (const ConfigError& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr(says));
      EXPECT_THAT(error.what(), testing::ContainsRegex("scene.toml:[0-9]+: "));
    }
  }
}

/// Near z it is along x, however a normal rounds; else it is n turned to the left.
TEST(Tangent, IsNotTurnedByRoundOff) {
  const auto expect = [](const Eigen::Vector3d& normal, const Eigen::Vector3d& tangent) {
    const Eigen::Vector3d found = tangent_of(normal);
    EXPECT_LT((found - tangent).norm(), 1e-15) << normal.transpose() << ": " << found.transpose();
    EXPECT_LT(std::abs(found.dot(normal)), 1e-15);
  };
  expect({0.0, 0.0, 1.0}, {1.0, 0.0, 0.0});
  expect({1e-17, -3e-18, -1.0}, {1.0, 0.0, 0.0});
  expect({-2e-18, 1e-17, -1.0}, {1.0, 0.0, 0.0});
  expect({0.28, 0.0, -0.96}, {0.96, 0.0, 0.28});
  expect({0.0, 0.28, 0.96}, {1.0, 0.0, 0.0});
  expect({0.6, 0.8, 0.0}, {-0.8, 0.6, 0.0});
  expect({0.96, 0.0, 0.28}, {0.0, 1.0, 0.0});
  expect({0.0, -1.0, 0.0}, {1.0, 0.0, 0.0});
}

}  // namespace
}  // namespace ricochet::scene

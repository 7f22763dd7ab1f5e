#include <gmock/gmock.h>

#include <cmath>
#include <fstream>

#include "common/base/error.hpp"
#include "common/problem/outline.hpp"
#include "common/problem/problem.hpp"
#include "tests/common/scene/scene_text.hpp"
#include "tests/support/block_mesh.hpp"
#include "tests/support/places.hpp"

namespace ricochet::scene {
namespace {

Problem build_config(const std::string& name) {
  return build_problem(load_scene(test::source_folder() + "/configs/" + name + ".toml"));
}

/// Two balls of one material that touch: normals of the plane that both deform to, gaps of two parabolas.
TEST(CurvedContact, HasTheNormalsAndGapsOfBalls) {
  const Problem problem = build_config("two_balls");
  const ContactGeometry& contact = problem.contacts.front();
  EXPECT_FALSE(contact.matching);
  EXPECT_EQ(contact.normal, Eigen::Vector3d(0.0, 1.0, 0.0)) << "about an axis, along it";
  const auto& mesh = problem.bodies[0].mesh;
  for (const ContactPair& pair : contact.pairs) {
    const Eigen::Vector3d& x = mesh.position[static_cast<std::size_t>(pair.node_a)];
    EXPECT_NEAR((pair.normal - contact.normal).norm(), 0.0, x[0] < 2.5e-3 ? 0.02 : 0.06)
        << x.transpose() << ", the rim from 3 mm on";
    if (x[0] < 1e-3) {
      EXPECT_NEAR(pair.gap0_m, x[0] * x[0] / 0.01, 1e-7 + 0.02 * pair.gap0_m) << x[0] << ": r^2 / (2 R) of each";
    }
  }
  EXPECT_EQ(contact.pairs.front().normal, Eigen::Vector3d(0.0, 1.0, 0.0)) << "the node on the axis";
}

/// Nodes on planes of symmetry have normals in them.
TEST(CurvedContact, OfAQuarterKeepsItsPlanesOfSymmetry) {
  const Problem problem = build_config("two_balls_solid");
  const auto& body = problem.bodies[0];
  int on_planes = 0;
  for (const ContactPair& pair : problem.contacts.front().pairs) {
    for (int c = 0; c < 2; ++c) {
      if (!body.fixed_dof[static_cast<std::size_t>(3 * pair.node_a + c)]) continue;
      EXPECT_EQ(pair.normal[c], 0.0);
      ++on_planes;
    }
    EXPECT_NEAR(pair.normal.norm(), 1.0, 1e-14);
  }
  EXPECT_GT(on_planes, 10);
}

std::string refusal(const std::string& scene, const SceneFolder& folder) {
  try {
    (void)build_problem(load_scene(folder.write(scene)));
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(CurvedContact, RefusesNormalsIntoTheBodyAndSurfacesThatFaceAllWays) {
  const SceneFolder folder;
  (void)folder.write(test::block_msh("ball", {.across = 2, .along = 2}), "ball.msh");
  const std::string scene = R"(model = "solid"
[[body]]
name = "ball"
material = { youngs_modulus_pa = 1e9, poisson_ratio = 0.2, density_kg_m3 = 1000.0 }
mesh = { gmsh = "ball.msh" }
[contact]
surfaces = ["ball.sides", "rigid_plane"]
[time]
safety_factor = 0.9
end_s = 1.0
[coupling]
protocol = "all_explicit"
)";
  EXPECT_THAT(refusal(scene, folder), testing::HasSubstr("surface \"ball.sides\", which faces all ways"));
  const std::string given = replaced(scene, "rigid_plane\"]", "rigid_plane\"]\nnormal = [2.0, 0.0, 0.0]");
  EXPECT_EQ(refusal(given, folder), "accepted") << "of a surface all around, what is given";
  std::ifstream file(test::source_folder() + "/configs/two_balls.toml");
  std::string balls{std::istreambuf_iterator<char>(file), {}};
  for (int body = 0; body < 2; ++body)
    balls = replaced(balls, "gmsh = \"two", std::string("gmsh =  \"") + test::source_folder() + "/configs/two");
  EXPECT_THAT(refusal(replaced(balls, "upper_cap\"]", "upper_cap\"]\nnormal = [0.0, -1.0]"), folder),
              testing::HasSubstr("a normal into surface \"lower.lower_cap\""));
}

/// A brick flies along a table's face, past its rim: below the face it is beside the table, not in it.
TEST(CurvedContact, ABodyBesideAnotherDoesNotOverlapIt) {
  const SceneFolder folder;
  const std::string scene = R"(model = "solid"
[[body]]
name = "table"
material = { youngs_modulus_pa = 1e9, poisson_ratio = 0.25, density_kg_m3 = 1000.0 }
mesh = { start_m = -0.01, length_m = 0.01, height_m = 0.02, width_m = 0.02, elements = [4, 4, 2] }
[[body]]
name = "brick"
large_rotation = true
material = { youngs_modulus_pa = 1e9, poisson_ratio = 0.25, density_kg_m3 = 1000.0 }
mesh = { length_m = 0.01, height_m = 0.01, width_m = 0.01, elements = [3, 3, 3], place = { moved_m = [0.021, 0.002, Z] } }
initial_velocity_m_s = [-1.0, 0.0, 0.0]
[contact]
surfaces = ["brick.outside", "table.end"]
normal = [0.0, 0.0, -1.0]
[time]
safety_factor = 0.8
end_s = 6e-5
[coupling]
protocol = "all_explicit"
)";
  for (const char* below : {"-0.0005", "-0.005", "-0.008"})
    EXPECT_THAT(refusal(replaced(scene, "Z", below), folder), testing::HasSubstr("lie nowhere opposite each other"));
  for (const char* above : {"0.0", "1e-4"}) EXPECT_EQ(refusal(replaced(scene, "Z", above), folder), "accepted");
  const std::string in_it = replaced(replaced(scene, "0.021, 0.002", "0.012, 0.002"), "Z", "-0.005");
  EXPECT_THAT(refusal(in_it, folder), testing::HasSubstr("bodies that overlap by 0.005 m"));
}

}  // namespace
}  // namespace ricochet::scene

// Contact surfaces with nodes that hang: their rows go to the nodes that carry them.
#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "common/base/error.hpp"
#include "common/fem/hanging_nodes.hpp"
#include "common/problem/mass_scaling.hpp"
#include "common/problem/problem.hpp"
#include "tests/common/scene/scene_text.hpp"

namespace ricochet::scene {
namespace {

/// Two blocks whose boxes do not match; the upper one moves across. `more`: of the lower body, or tables behind it.
Problem blocks(const SceneFolder& folder, double across_m_s, const std::string& second = "upper.start",
               const std::string& more = "") {
  const auto body = [&](const std::string& name, const std::string& mesh, double vx, double vz) {
    return "[[body]]\nname = \"" + name +
           "\"\nmaterial = { youngs_modulus_pa = 2e11, poisson_ratio = 0.3, density_kg_m3 = 7800.0 }\n"
           "initial_velocity_m_s = [" +
           std::to_string(vx) + ", 0.0, " + std::to_string(vz) + "]\n[body.mesh]\n" + mesh;
  };
  return build_problem(load_scene(folder.write(
      "model = \"solid\"\n" +
      body("upper",
           "length_m = 0.004\nheight_m = 0.004\nwidth_m = 0.004\nelements = [4, 4, 4]\n"
           "refine = [{ from_m = [0.001, 0.0, 0.0], to_m = [0.003, 0.002, 0.002], ratio = 3 }]\n",
           across_m_s, -1.0) +
      body("lower",
           "length_m = 0.004\nheight_m = 0.006\nwidth_m = 0.006\nstart_m = -0.004\nelements = [6, 6, 4]\n"
           "refine = [{ from_m = [0.002, 0.002, -0.002], to_m = [0.006, 0.004, 0.0], ratio = 2 }]\n",
           0.0, 0.0) +
      more + "[contact]\nsurfaces = [\"lower.end\", \"" + second + "\"]\n[time]\nstep_s = 1e-8\nend_s = 1e-6\n" +
      (more.find("theirs") == std::string::npos ? "[coupling]\nprotocol = \"all_explicit\"\n" : ""))));
}

/// Forces of an even pressure of 1 Pa at the nodes of both bodies.
std::array<Eigen::VectorXd, 2> even_pressure(const Problem& problem, const std::vector<ContactPair>& pairs) {
  const ContactGeometry& contact = problem.contacts.front();
  std::array<Eigen::VectorXd, 2> force;
  const auto push = [&](int body, const std::vector<WeightedNode>& nodes, const Eigen::Vector3d& size) {
    for (const auto& [node, weight] : nodes) {
      EXPECT_EQ(fem::hanging_at(problem.bodies[fem::at(body)].mesh, node), nullptr);
      force[fem::at(body)].segment<3>(3 * node) += weight * size;
    }
  };
  for (std::size_t b = 0; b < 2; ++b)
    force[b].setZero(3 * static_cast<Eigen::Index>(problem.bodies[b].mesh.position.size()));
  for (const ContactPair& pair : pairs) {
    push(contact.body_a, own_nodes(pair), -pair.area_m2 * pair.normal);
    push(contact.body_b, pair.b, pair.area_m2 * pair.normal);
  }
  return force;
}

Eigen::VectorXd of_load(const BodyProblem& body, const std::string& surface) {
  std::vector<int> all(body.mesh.elements.size());
  std::iota(all.begin(), all.end(), 0);
  return fem::pressure_force(body_part(body, all), surface, 1.0);
}

void expect_balance(const Problem& problem, const std::array<Eigen::VectorXd, 2>& force) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero(), moment = sum;
  for (std::size_t b = 0; b < 2; ++b) {
    for (std::size_t node = 0; node < problem.bodies[b].mesh.position.size(); ++node) {
      const Eigen::Vector3d own = force[b].segment<3>(3 * static_cast<Eigen::Index>(node));
      sum += own;
      moment += problem.bodies[b].mesh.position[node].cross(own);
    }
  }
  EXPECT_LT(sum.norm(), 1e-18);
  EXPECT_LT(moment.norm(), 1e-20);
}

/// The contact patch test: the surface that is covered whole feels what a load of that pressure would be, and forces
/// and moments are in balance; of rows at the start and of such as are written when the bodies have slid.
TEST(RefinedContact, PassesOnAnEvenPressure) {
  const SceneFolder folder;
  for (const double across_m_s : {0.0, 1.0}) {
    const Problem problem = blocks(folder, across_m_s);
    auto force = even_pressure(problem, problem.contacts.front().pairs);
    const Eigen::VectorXd load = of_load(problem.bodies[0], "start");
    EXPECT_LT((force[0] - load).norm(), 1e-12 * load.norm());
    expect_balance(problem, force);
    if (across_m_s == 0.0) continue;
    const Eigen::Vector3d shift(4e-4, 3e-4, 0.0);
    force =
        even_pressure(problem, slid_pairs(problem, 0, problem.contacts.front().body_a == 0 ? -shift : shift, nullptr));
    EXPECT_LT((force[0] - load).norm(), 1e-12 * load.norm());
  }
}

TEST(RefinedContact, PassesOnThePressureOfARigidPlane) {
  const SceneFolder folder;
  Problem problem = blocks(folder, 0.0, "rigid_plane");
  const auto force = even_pressure(problem, problem.contacts.front().pairs);
  const Eigen::VectorXd load = of_load(problem.bodies[1], "end");
  EXPECT_LT((force[1] - load).norm(), 1e-12 * load.norm());
}

/// The corners of a small block below a refined one that turns: one row each, and the nodes of it do not hang.
TEST(RefinedContact, HasARowForEachNodeAtAnEdgeOfTheOtherBody) {
  const SceneFolder folder;
  const std::string steel = "material = { youngs_modulus_pa = 2e11, poisson_ratio = 0.3, density_kg_m3 = 7800.0 }\n";
  const Problem problem = build_problem(load_scene(folder.write(
      "model = \"solid\"\n[[body]]\nname = \"upper\"\nlarge_rotation = true\n" + steel +
      "mesh = { length_m = 0.004, height_m = 0.004, width_m = 0.004, elements = [4, 4, 4], refine = [{ from_m = "
      "[0.001, "
      "0.0, 0.0], to_m = [0.003, 0.002, 0.002], ratio = 3 }] }\n"
      "[[body]]\nname = \"lower\"\n" +
      steel +
      "mesh = { length_m = 0.004, height_m = 0.002, width_m = 0.002, elements = [2, 2, 4], start_m = -0.004, place = { "
      "moved_m = [0.0009, 0.0004, 0.0] } }\n"
      "[contact]\nsurfaces = [\"lower.end\", \"upper.start\"]\n"
      "[time]\nstep_s = 1e-8\nend_s = 1e-6\n[coupling]\nprotocol = \"all_explicit\"\n")));
  const ContactGeometry& contact = problem.contacts.front();
  ASSERT_EQ(contact.body_a, 0);
  std::map<int, int> rows_of_edge;
  for (const ContactPair& pair : contact.pairs) {
    EXPECT_EQ(fem::hanging_at(problem.bodies[0].mesh, pair.node_a), nullptr);
    for (const auto& [node, weight] : own_nodes(pair))
      EXPECT_EQ(fem::hanging_at(problem.bodies[0].mesh, node), nullptr) << node;
    if (pair.patch < -1) ++rows_of_edge[pair.patch];
  }
  EXPECT_GE(rows_of_edge.size(), 4U);
  for (const auto& [patch, rows] : rows_of_edge) EXPECT_EQ(rows, 1) << patch;
}

/// Hanging nodes are no contact nodes, their carriers are.
TEST(RefinedContact, HasNodesThatDoNotHang) {
  const SceneFolder folder;
  for (const double across_m_s : {0.0, 1.0}) {
    const Problem problem = blocks(folder, across_m_s);
    for (int body = 0; body < 2; ++body) {
      for (const int node : contact_nodes(problem.contacts, body))
        EXPECT_EQ(fem::hanging_at(problem.bodies[fem::at(body)].mesh, node), nullptr);
    }
  }
}

/// The dashpots of hanging nodes are their carriers'.
TEST(RefinedSurface, AbsorbsByItsWholeArea) {
  const SceneFolder folder;
  const Problem problem =
      blocks(folder, 0.0, "upper.start", "[[body.absorbing]]\nsurface = \"outer\"\nwave = \"dilatational\"\n");
  const BodyProblem& body = problem.bodies[1];
  double along = 0.0;
  for (Eigen::Index dof = 0; dof < body.damping_kg_s.size(); dof += 3) along += body.damping_kg_s[dof];
  const double speed = std::sqrt(2e11 * 0.7 / (7800.0 * 1.3 * 0.4));
  EXPECT_NEAR(along / (7800.0 * speed * 0.006 * 0.004), 1.0, 1e-12);
  for (const fem::HangingNode& hanging : body.mesh.hanging)
    EXPECT_EQ(body.damping_kg_s.segment<3>(3 * hanging.node).norm(), 0.0);
}

TEST(RefinedSurface, CannotBeJoinedToAForeignBody) {
  const SceneFolder folder;
  try {
    (void)blocks(folder, 0.0, "upper.start",
                 "[[body]]\nname = \"base\"\nforeign = true\njoined_to = \"lower\"\nsurface = \"outer\"\n"
                 "[[participant]]\nname = \"ours\"\nrole = \"explicit\"\nbodies = [\"lower\", \"upper\"]\n"
                 "[[participant]]\nname = \"theirs\"\nrole = \"explicit\"\nbodies = [\"base\"]\nexecutable = "
                 "\"theirs\"\n[[participant]]\nname = \"implicit\"\nrole = \"implicit\"\n");
    ADD_FAILURE();
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("which hangs on larger elements; allowed: nodes inside or outside"));
  }
}

}  // namespace
}  // namespace ricochet::scene

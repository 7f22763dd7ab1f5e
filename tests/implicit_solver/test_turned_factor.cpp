#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <random>
#include <string>
#include <vector>

#include "implicit_solver/turned_factor.hpp"
#include "tests/support/scene_file.hpp"

namespace ricochet::implicit_solver {
namespace {

/// A block that turns and one that does not, of a plane or solids; the lower nodes of the second are held.
std::string two_blocks(bool solid, const std::string& more_of_first = "") {
  const std::string steel = "{ youngs_modulus_pa = 200e9, poisson_ratio = 0.3, density_kg_m3 = 7850.0 }",
                    size = solid ? "length_m = 0.01, height_m = 0.01, width_m = 0.01, elements = [2, 3, 2] }\n"
                                 : "length_m = 0.01, height_m = 0.01, elements = [3, 4] }\n",
                    away = solid ? "place = { moved_m = [0.0, 0.0, -0.05] }, " : "place = { moved_m = [-0.05, 0.0] }, ";
  return std::string("model = \"") + (solid ? "solid" : "plane_strain") +
         "\"\n[[body]]\nname = \"turns\"\nmaterial = " + steel + "\nmesh = { " + size + more_of_first +
         "[[body]]\nname = \"stays\"\nmaterial = " + steel + "\nmesh = { " + away + size +
         "[[body.support]]\nsurface = \"start\"\nfixed = " + (solid ? R"(["x", "y", "z"])" : R"(["x", "y"])") +
         "\n[time]\nstep_s = 1e-7\nend_s = 1e-6\n"
         "[coupling]\nprotocol = \"all_implicit\"\n";
}

/// A = M + dt^2/4 K of both, with a root of some nodes of either.
struct Blocks {
  explicit Blocks(bool solid, const std::string& more_of_first = "large_rotation = true\n")
      : problem(build(two_blocks(solid, more_of_first))),
        states(solver::initial_states(problem, problem.scene.participant("implicit"), true)),
        parts(states),
        components(solid ? 3 : 2) {
    a = parts.block_diagonal(parts.tangents(parts.displacement()));
    a *= 0.25e-14;
    active.resize(static_cast<std::size_t>(parts.dofs()));
    for (std::size_t p = 0; p < parts.size(); ++p) {
      for (int dof = 0; dof < states[p].part.dofs(); ++dof) {
        const auto at = parts.offsets[p] + dof;
        a.coeffRef(at, at) += states[p].mass[dof];
        active[static_cast<std::size_t>(at)] = states[p].free[static_cast<std::size_t>(dof)];
      }
    }
    const auto last = static_cast<int>(parts.dofs()) - components;
    for (const int node : {5, 2, last / components})
      for (int c = components - 1; c >= 0; --c) root.push_back(node * components + c);
    std::mt19937 random(7);
    std::normal_distribution<double> normal;
    b = Eigen::VectorXd::NullaryExpr(parts.dofs(), [&] { return normal(random); });
  }
  static scene::Problem build(const std::string& text) {
    const test::TemporaryFolder folder;
    return scene::build_problem(scene::load_scene(folder.write(text)));
  }
  /// T over all degrees of freedom.
  [[nodiscard]] Eigen::MatrixXd turn_of_all(const Eigen::Matrix3d& turn) const {
    Eigen::MatrixXd all = Eigen::MatrixXd::Identity(parts.dofs(), parts.dofs());
    for (int node = 0; node < states[0].part.nodes(); ++node)
      all.block(node * components, node * components, components, components) =
          turn.topLeftCorner(components, components);
    return all;
  }

  scene::Problem problem;
  std::vector<solver::BodyState> states;
  CombinedParts parts;
  int components;
  fem::SparseMatrix a;
  std::vector<bool> active;
  std::vector<int> root;
  Eigen::VectorXd b;
};

/// That a factor turned by `given` solves as A turned by `turn` does.
void expect_solves(Blocks& blocks, const Eigen::Matrix3d& given, const Eigen::Matrix3d& turn, double off = 1e-9) {
  const Eigen::Matrix3d start = Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  TurnedFactor factor(blocks.parts, {start, Eigen::Matrix3d::Identity()}, blocks.a, blocks.active, blocks.root,
                      nullptr);
  ASSERT_TRUE(factor.may_turn());
  factor.turn({given * start, Eigen::Matrix3d::Identity()});
  const Eigen::MatrixXd all = blocks.turn_of_all(turn);
  Eigen::MatrixXd dense = all * Eigen::MatrixXd(blocks.a) * all.transpose();
  Eigen::VectorXd right = blocks.b;
  for (const int dof : factor.inactive()) {
    dense.row(dof).setZero();
    dense.col(dof).setZero();
    dense(dof, dof) = 1.0;
    right[dof] = 0.0;
  }
  Eigen::VectorXd forces(blocks.components), x = Eigen::VectorXd::Constant(blocks.parts.dofs(), 42.0), x_root;
  for (Eigen::Index i = 0; i < forces.size(); ++i) {
    forces[i] = 1.0 + 0.3 * static_cast<double>(i);
    right[blocks.root[static_cast<std::size_t>(i)]] += forces[i];
  }
  Eigen::VectorXd expected = dense.ldlt().solve(right);
  for (const int dof : factor.inactive()) expected[dof] = 42.0;  // what is not active stays
  factor.forward(blocks.b);
  factor.solve_root(factor.root_rhs(), x_root);
  factor.add_root_motion(forces, x_root);
  factor.backward(x_root, x);
  EXPECT_LT((x - expected).lpNorm<Eigen::Infinity>(), off * expected.lpNorm<Eigen::Infinity>());
  for (const int dof : factor.inactive()) EXPECT_EQ(x[dof], 42.0);
}

Eigen::Matrix3d turn_about(const Eigen::Vector3d& axis, double angle) {
  return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
}

bool may_turn(const Blocks& blocks) {
  return TurnedFactor(blocks.parts, std::vector<Eigen::Matrix3d>(2, Eigen::Matrix3d::Identity()), blocks.a,
                      blocks.active, blocks.root, nullptr)
      .may_turn();
}

class Turned : public testing::TestWithParam<bool> {};

TEST_P(Turned, FactorSolvesAsAWouldThatWasTurned) {
  Blocks blocks(GetParam());
  const Eigen::Matrix3d turn =
      turn_about(GetParam() ? Eigen::Vector3d(1.0, 2.0, -1.0) : Eigen::Vector3d(0.0, 0.0, 1.0), 0.8);
  expect_solves(blocks, turn, turn);
}

TEST_P(Turned, FactorMayNotTurnWhereDirectionsDiffer) {
  Blocks heavier(GetParam());
  heavier.states[0].mass[1] *= 2.0;
  EXPECT_FALSE(may_turn(heavier));
  Blocks cut(GetParam());
  cut.root.erase(cut.root.begin());
  EXPECT_FALSE(may_turn(cut)) << "a node half in the root";
  Blocks of_others(GetParam());
  of_others.root.pop_back();
  EXPECT_TRUE(may_turn(of_others)) << "of a part that does not turn";
  Blocks held(GetParam());
  held.active[0] = false;
  EXPECT_EQ(may_turn(held), GetParam()) << "in a plane nothing turns about x";
  held.active[static_cast<std::size_t>(held.components) + 1] = false;
  EXPECT_FALSE(may_turn(held)) << "along x and y";
}

/// A plane of symmetry holds a half along y; a node of that plane is in the root.
TEST(TurnedHalf, TurnsAboutTheAxisThatAPlaneOfSymmetryLeaves) {
  Blocks half(true);
  for (const std::size_t node : {0, 5, 7}) half.active[3 * node + 1] = false;
  half.root.erase(half.root.begin() + 1);  // of node 5
  const Eigen::Matrix3d turn = turn_about(Eigen::Vector3d::UnitY(), 0.7),
                        tilt = turn_about(Eigen::Vector3d(1.0, 0.0, 0.5), 1e-4);
  expect_solves(half, turn, turn);
  // The tilt moves the angle about y by its square alone.
  expect_solves(half, turn * tilt, turn, 1e-7);
}

INSTANTIATE_TEST_SUITE_P(Models, Turned, testing::Bool(),
                         [](const auto& which) { return which.param ? "solid" : "plane_strain"; });

}  // namespace
}  // namespace ricochet::implicit_solver

// The lowest modes of a part, and what the others do.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <numbers>
#include <string>

#include "common/base/error.hpp"
#include "common/body/body_state.hpp"
#include "explicit_solver/reduced/lowest_modes.hpp"
#include "tests/support/scene_file.hpp"

namespace ricochet::explicit_solver {
namespace {

constexpr double c_m_s = 5000.0, length_m = 0.2;

/// Stiffness and mass of a body by itself; `held`: a share of its degrees of freedom, spread over them.
struct Part {
  fem::SparseMatrix stiffness;
  Eigen::VectorXd mass;
  double scale = 0.0;
};

Part part_of(const std::string& model, const std::string& material, const std::string& mesh) {
  const test::TemporaryFolder folder;
  const auto problem = scene::build_problem(scene::load_scene(
      folder.write("model = \"" + model + "\"\n[[body]]\nname = \"body\"\nmaterial = " + material + "\nmesh = " + mesh +
                   "\n[time]\nstep_s = 1e-9\nend_s = 1e-8\n[coupling]\nprotocol = \"all_explicit\"\n")));
  const auto states = solver::initial_states(problem, problem.scene.participants.front(), true);
  const auto& part = states.front().part;
  const int components = fem::components(part.mesh.model);
  Part result{part.stiffness, Eigen::VectorXd(part.dofs()), std::pow(c_m_s / length_m, 2)};
  for (int dof = 0; dof < part.dofs(); ++dof) result.mass[dof] = part.lumped_mass[dof / components];
  return result;
}

Part bar(int elements) {
  return part_of("bar", "{ youngs_modulus_pa = 200e9, density_kg_m3 = 8000.0 }",
                 "{ length_m = 0.2, elements = " + std::to_string(elements) + " }");
}

/// A cube, whose frequencies come in pairs and triples.
Part cube() {
  return part_of("solid", "{ youngs_modulus_pa = 200e9, poisson_ratio = 0.3, density_kg_m3 = 8000.0 }",
                 "{ length_m = 0.2, height_m = 0.2, width_m = 0.2, elements = [4, 4, 4] }");
}

/// All omega^2, by a dense solver, of what is not held.
Eigen::VectorXd all_of(const Part& part) {
  std::vector<int> free;
  for (int dof = 0; dof < part.mass.size(); ++dof)
    if (part.mass[dof] > 0.0) free.push_back(dof);
  const Eigen::MatrixXd whole = part.stiffness;
  const Eigen::VectorXd root = part.mass(free).cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = root.asDiagonal() * whole(free, free) * root.asDiagonal();
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(scaled, Eigen::EigenvaluesOnly).eigenvalues();
}

// With lumped masses omega_k = 2 c/h sin(k pi/2n), k = 0 to n.
TEST(LowestModes, AreThoseOfAFreeBar) {
  constexpr int elements = 50, count = 30;
  const Part part = bar(elements);
  const LowestModes modes(part.stiffness, part.mass, count, part.scale);
  EXPECT_EQ(modes.omega_squared()[0], 0.0);
  for (int k = 1; k < count; ++k) {
    const double omega = 2.0 * c_m_s * elements / length_m * std::sin(k * std::numbers::pi / (2.0 * elements));
    EXPECT_NEAR(std::sqrt(modes.omega_squared()[k]) / omega, 1.0, 1e-9) << k;
  }
}

TEST(LowestModes, NoneIsMissingWhereFrequenciesAreEqual) {
  Part part = cube();
  for (const bool held : {false, true}) {
    if (held) part.mass.head(75).setZero();  // a face
    const Eigen::VectorXd all = all_of(part);
    for (const int count : {7, 20, 60}) {
      const LowestModes modes(part.stiffness, part.mass, count, part.scale);
      const double scale = all[count];
      EXPECT_LT((modes.omega_squared() - all.head(count)).cwiseAbs().maxCoeff(), 1e-9 * scale) << held << count;
      EXPECT_EQ((modes.omega_squared().array() == 0.0).count(), held ? 0 : 6) << "rigid motion";
      const Eigen::MatrixXd one = modes.shapes().transpose() * modes.momenta();
      EXPECT_LT((one - Eigen::MatrixXd::Identity(count, count)).cwiseAbs().maxCoeff(), 1e-10);
    }
  }
}

// R K u = u less what of it is in the modes.
TEST(LowestModes, TheOthersFollowAForceAtOnce) {
  Part part = cube();
  for (const bool held : {false, true}) {
    if (held) part.mass.head(75).setZero();
    Eigen::MatrixXd u = Eigen::MatrixXd::NullaryExpr(part.mass.size(), 3, [](Eigen::Index i, Eigen::Index j) {
      return std::sin(0.7 * static_cast<double>(i * (j + 1)));
    });
    if (held) u.topRows(75).setZero();
    for (const int count : {6, 40}) {
      const LowestModes modes(part.stiffness, part.mass, count, part.scale);
      const Eigen::MatrixXd rest = u - modes.shapes() * (modes.momenta().transpose() * u);
      const Eigen::MatrixXd force = part.stiffness * u;
      EXPECT_LT((modes.others(force, 1e-12) - rest).norm(), 1e-8 * rest.norm()) << held << count;
      EXPECT_LT((modes.others(force, 1e-5) - rest).norm(), 1e-5 * rest.norm()) << held << count;
    }
  }
}

TEST(LowestModes, SayWhenThereIsNoStiffnessToFindThemOf) {
  Part part = bar(20);
  part.stiffness *= -1.0;
  EXPECT_THROW(LowestModes(part.stiffness, part.mass, 3, part.scale), SolverError);
}

}  // namespace
}  // namespace ricochet::explicit_solver

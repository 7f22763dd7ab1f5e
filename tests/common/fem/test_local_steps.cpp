#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <random>

#include "common/fem/local_steps.hpp"
#include "tests/common/fem/sample_elements.hpp"

namespace ricochet::fem {
namespace {

/// Lines 0 ... length: `fine` intervals of h/ratio, then intervals of h.
std::vector<double> jump(double h, int coarse, int fine, int ratio) {
  std::vector<double> at;
  for (int i = 0; i < fine; ++i) at.push_back(i * h / ratio);
  for (int i = 0; i <= coarse; ++i) at.push_back(fine * h / ratio + i * h);
  return at;
}

Mesh jump_mesh(Model model, int ratio) {
  constexpr double h = 1e-2;
  const auto along = jump(h, 6, 4, ratio);
  if (model == Model::bar) return bar_mesh(jump(h, 20, 2 * ratio, ratio));
  if (model != Model::solid) return quadrilateral_mesh(model, jump(h, 3, 3, ratio), along);
  return block_mesh(jump(h, 2, 2, ratio), {0.0, h, 2.0 * h}, jump(h, 3, 2, ratio));
}

/// A part and its mass; the coarse critical step is that of elements h alone, far from the fine ones.
struct Body {
  explicit Body(const Mesh& mesh, int held = 0)
      : part(sample::whole_part(mesh, sample::section(mesh.model))), components(fem::components(mesh.model)) {
    inverse_mass.resize(part.dofs());
    for (Eigen::Index dof = 0; dof < part.dofs(); ++dof)
      inverse_mass[dof] = held > 0 && dof % held == 0 ? 0.0 : 1.0 / part.lumped_mass[dof / components];
  }
  Part part;
  int components;
  Eigen::VectorXd inverse_mass;

  [[nodiscard]] Eigen::MatrixXd stiffness_of(LocalSteps& steps) const {
    Eigen::MatrixXd k(part.dofs(), part.dofs());
    for (int dof = 0; dof < part.dofs(); ++dof) {
      Eigen::VectorXd force = part.stiffness * Eigen::VectorXd::Unit(part.dofs(), dof);
      steps.spread(force);
      k.col(dof) = force;
    }
    return k;
  }
  [[nodiscard]] Eigen::VectorXd frequencies_squared(const Eigen::MatrixXd& k) const {
    const Eigen::VectorXd scale = inverse_mass.cwiseSqrt();
    const Eigen::MatrixXd scaled = scale.asDiagonal() * k * scale.asDiagonal();
    return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(0.5 * (scaled + scaled.transpose())).eigenvalues();
  }
};

/// The critical step of a uniform mesh of the coarse elements [s].
double coarse_step(Model model) {
  const Body body(jump_mesh(model, 1));
  return 2.0 / std::sqrt(body.frequencies_squared(body.part.stiffness).maxCoeff());
}

class LocalStepsOf : public testing::TestWithParam<Model> {};
INSTANTIATE_TEST_SUITE_P(Models, LocalStepsOf, testing::ValuesIn(sample::every_model),
                         [](const auto& tested) { return sample::name(tested.param); });

TEST_P(LocalStepsOf, AreAnotherSymmetricStiffnessThatBearsTheCoarseStep) {
  const double coarse_s = coarse_step(GetParam());
  for (const int ratio : {2, 8, 32}) {
    for (const int held : {0, 7}) {
      const Body body(jump_mesh(GetParam(), ratio), held);
      for (const double share : {0.5, 0.9, 0.95, 0.99}) {
        const double window_s = share * coarse_s;
        LocalSteps steps(body.part.stiffness, body.inverse_mass, body.components, window_s);
        const auto shown = testing::Message() << "ratio " << ratio << ", held " << held << ", share " << share;
        const Eigen::MatrixXd k = body.stiffness_of(steps);
        EXPECT_LT((k - k.transpose()).cwiseAbs().maxCoeff(), 1e-13 * k.cwiseAbs().maxCoeff()) << shown;
        const Eigen::VectorXd squared = body.frequencies_squared(k);
        EXPECT_LE(window_s * std::sqrt(squared.maxCoeff()) / 2.0, 1.0) << shown;
        EXPECT_GT(squared.minCoeff(), -1e-9 * squared.maxCoeff()) << shown;
        const auto nodes = steps.nodes_by_level();
        if (share > 0.9 || ratio * share < 1.5 || (held > 0 && ratio == 2)) continue;
        EXPECT_TRUE(steps.any()) << shown;
        EXPECT_GT(nodes.front(), 0) << "the coarse elements take one step; " << shown;
        EXPECT_LE(std::ssize(nodes) - 1, std::ceil(std::log2(ratio)) + 1) << shown;
      }
    }
  }
}

/// K less what a share of the elements, drawn by lot, have lost of theirs.
Eigen::MatrixXd softened(const Body& body, std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const double flowing = uniform(random), lost = 0.99 - 0.5 * uniform(random);
  const Mesh& mesh = body.part.mesh;
  Eigen::MatrixXd tangent(body.part.stiffness);
  for (int e = 0; e < static_cast<int>(mesh.elements.size()); ++e) {
    if (uniform(random) > flowing) continue;
    const ElementMatrix own = element_stiffness(body.part.section, body.part.material, element_geometry(mesh, e));
    std::vector<int> dofs;
    for (const int node : mesh.elements[at(e)])
      for (int c = 0; c < body.components; ++c) dofs.push_back(node * body.components + c);
    for (Eigen::Index i = 0; i < own.rows(); ++i)
      for (Eigen::Index j = 0; j < own.cols(); ++j) tangent(dofs[at(i)], dofs[at(j)]) -= lost * own(i, j);
  }
  return tangent;
}

/// Elements that flow have less than the stiffness K_T that S was made for. S K_T is not symmetric where they meet
/// others: eigenvalues may have an imaginary part, by which a motion could grow while the same elements flow.
TEST_P(LocalStepsOf, BearElementsThatFlow) {
  std::mt19937 random(7);
  for (const int ratio : {2, 8, 32}) {
    for (const double share : {0.5, 0.99}) {
      const Body body(jump_mesh(GetParam(), ratio));
      const double window_s = share * coarse_step(GetParam());
      LocalSteps steps(body.part.stiffness, body.inverse_mass, body.components, window_s);
      for (int trial = 0; trial < 2; ++trial) {
        Eigen::MatrixXd tangent = softened(body, random);
        for (auto column : tangent.colwise()) {
          Eigen::VectorXd force = column;
          steps.spread(force);
          column = window_s * window_s * body.inverse_mass.cwiseProduct(force);
        }
        const Eigen::VectorXcd squared = Eigen::EigenSolver<Eigen::MatrixXd>(tangent, false).eigenvalues();
        EXPECT_LE(squared.real().maxCoeff(), 4.0) << ratio << ", " << share;
        EXPECT_GE(squared.real().minCoeff(), -1e-9) << ratio << ", " << share;
        EXPECT_LE(squared.imag().cwiseAbs().maxCoeff(), 2e-3) << ratio << ", " << share;
      }
    }
  }
}

TEST_P(LocalStepsOf, KeepTheSumOfForces) {
  const Body body(jump_mesh(GetParam(), 8));
  LocalSteps steps(body.part.stiffness, body.inverse_mass, body.components, 0.9 * coarse_step(GetParam()));
  for (int dof = 0; dof < body.part.dofs(); dof += 5) {
    if (GetParam() == Model::axisymmetric && dof % 2 == 0) continue;  // no translation
    Eigen::VectorXd force = Eigen::VectorXd::Unit(body.part.dofs(), dof);
    steps.spread(force);
    for (int c = 0; c < body.components; ++c) {
      if (GetParam() == Model::axisymmetric && c == 0) continue;
      double sum = 0.0;
      for (int i = c; i < body.part.dofs(); i += body.components) sum += force[i];
      EXPECT_NEAR(sum, dof % body.components == c ? 1.0 : 0.0, 1e-12) << dof;
    }
  }
}

TEST_P(LocalStepsOf, AreNoneWhereEveryElementBearsTheStep) {
  const Body body(jump_mesh(GetParam(), 1));
  LocalSteps steps(body.part.stiffness, body.inverse_mass, body.components, 0.99 * coarse_step(GetParam()));
  EXPECT_FALSE(steps.any());
  Eigen::VectorXd force = Eigen::VectorXd::LinSpaced(body.part.dofs(), -1.0, 2.0);
  const Eigen::VectorXd before = force;
  steps.spread(force);
  EXPECT_EQ(force, before);
}

/// Untried they are found with the smallest scale.
TEST_P(LocalStepsOf, AreExpectedToCostNoMoreThanTheyDo) {
  const double coarse_s = 0.99 * coarse_step(GetParam());
  for (const int ratio : {2, 8, 32}) {
    const Body body(jump_mesh(GetParam(), ratio));
    const auto cost = [&](LocalSteps::Levels levels) {
      return LocalSteps(body.part.stiffness, body.inverse_mass, body.components, coarse_s, levels).extra_rows();
    };
    const double borne = cost(LocalSteps::Levels::borne), expected = cost(LocalSteps::Levels::expected);
    EXPECT_LE(expected, borne) << ratio;
    EXPECT_GE(expected, 0.4 * borne) << ratio;
  }
}

TEST(LocalSteps, CostWhatTheFineRowsTimesTheirStepsDo) {
  const Body body(bar_mesh(jump(1e-2, 1000, 64, 64)));
  LocalSteps steps(body.part.stiffness, body.inverse_mass, 1, 0.9 * coarse_step(Model::bar));
  const double share = 66.0 / body.part.nodes();  // the fine nodes and a layer
  EXPECT_LT(steps.extra_rows(), 128.0 * share) << "seven levels, a little less than halved each";
  EXPECT_GT(steps.extra_rows(), 64.0 * share);
}

/// A bar of unit length, density and modulus meets a rigid wall at unit speed with its fine end: exact, it pushes with
/// 1 for 2 and leaves.
struct Impact {
  double release_s = 0.0, plateau = 0.0, energy_kept = 0.0;
};
Impact impact(int ratio, bool own_mass) {
  constexpr double h = 0.01;
  auto at = jump(h, 90, 10 * ratio, ratio);
  const Part part = extract_part(bar_mesh(at), "bar", {Model::bar, 1.0}, {1.0, 0.0, 1.0}, [&] {
    std::vector<int> all(at.size() - 1);
    std::iota(all.begin(), all.end(), 0);
    return all;
  }());
  const Eigen::VectorXd inverse = part.lumped_mass.cwiseInverse();
  const double dt = 0.9 * h;
  LocalSteps steps(part.stiffness, inverse, 1, dt);
  Eigen::VectorXd unit = Eigen::VectorXd::Unit(part.dofs(), 0), u = Eigen::VectorXd::Zero(part.dofs()),
                  v = Eigen::VectorXd::Constant(part.dofs(), -1.0);
  if (!own_mass) steps.spread(unit);
  const Eigen::VectorXd response = inverse.cwiseProduct(unit);
  const auto elastic = [&] {
    Eigen::VectorXd force = -(part.stiffness * u);
    steps.spread(force);
    return Eigen::VectorXd(inverse.cwiseProduct(force));
  };
  Impact found;
  int of_plateau = 0;
  double share = 0.5;
  for (int n = 0; n < 3.0 / dt; ++n, share = 1.0) {
    const Eigen::VectorXd a = elastic();
    const double gap = u[0] + dt * (v[0] + share * dt * a[0]);
    const double force = std::max(0.0, -gap / (response[0] * dt * dt * share));
    v += share * dt * (a + force * response);
    u += dt * v;
    if (force > 0.0) found.release_s = (n + 1) * dt;
    if (n * dt < 0.3 || n * dt > 1.7) continue;
    found.plateau += force;
    ++of_plateau;
  }
  found.plateau /= of_plateau;
  const Eigen::VectorXd a = elastic(), now = v + 0.5 * dt * a;
  const auto& m = part.lumped_mass;
  const double energy =
      0.5 * now.dot(m.cwiseProduct(now)) - 0.5 * u.dot(m.cwiseProduct(a)) - dt * dt / 8.0 * a.dot(m.cwiseProduct(a));
  found.energy_kept = energy / 0.5;
  return found;
}

TEST(ContactInLocalSteps, IsRightByTheResponseOfTheSmallSteps) {
  for (const int ratio : {2, 8, 32}) {
    const Impact found = impact(ratio, false);
    EXPECT_NEAR(found.release_s, 2.0, 0.005 * 2.0) << ratio;
    EXPECT_NEAR(found.plateau, 1.0, 1e-3) << ratio;
    EXPECT_NEAR(found.energy_kept, 1.0, 0.01) << ratio;
  }
}

TEST(ContactInLocalSteps, ByTheOwnMassOfTheNodeKeepsEnergyAndIsLate) {
  EXPECT_NEAR(impact(2, true).release_s, 2.0, 0.015 * 2.0) << "this side of the edge";
  EXPECT_LT(impact(32, true).plateau, 0.97);
  for (const int ratio : {8, 32}) {
    const Impact found = impact(ratio, true);
    EXPECT_GT(found.release_s, (ratio == 8 ? 1.03 : 1.15) * 2.0) << ratio;
    EXPECT_NEAR(found.energy_kept, 1.0, 0.01) << "energy tells nothing; " << ratio;
  }
}

}  // namespace
}  // namespace ricochet::fem

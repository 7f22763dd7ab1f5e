#include <gtest/gtest.h>

#include <cmath>

#include "common/fem/element.hpp"
#include "common/solver/stress_watch.hpp"

namespace ricochet::solver {
namespace {

using fem::ElementKind;
using fem::Model;

/// One distorted element that is moved and deformed at random.
BodyState element(ElementKind kind, Model model, unsigned seed) {
  std::srand(seed);  // Eigen's numbers
  const auto& traits = fem::traits(kind);
  BodyState state;
  auto& part = state.part;
  part.section = {model, 1.0};
  part.material = {2e9, 0.3, 1000.0};
  part.mesh.model = model;
  const int components = fem::components(model);
  fem::Element nodes{kind, {}};
  for (int i = 0; i < traits.nodes; ++i) {
    nodes.node[fem::at(i)] = i;
    Eigen::Vector3d x = traits.corner[fem::at(i)] + 0.2 * Eigen::Vector3d::Random();
    for (int c = components; c < 3; ++c) x[c] = 0.0;
    if (model == Model::axisymmetric) x[0] += 2.0;
    part.mesh.position.push_back(x);
  }
  part.mesh.elements.push_back(nodes);
  state.u = 1e-3 * Eigen::VectorXd::Random(traits.nodes * components);
  return state;
}

struct ElementOfModel {
  ElementKind kind;
  Model model;
};

class StressInTheMiddle : public testing::TestWithParam<ElementOfModel> {};

/// A limit just below what the element's own stress has is passed by as much, one just above is not.
TEST_P(StressInTheMiddle, IsWhatTheElementItselfHasThere) {
  const auto [kind, model] = GetParam();
  int pulled = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    BodyState state = element(kind, model, seed);
    const auto stress =
        fem::element_stress(state.part.section, state.part.material, fem::element_geometry(state.part.mesh, 0), state.u,
                            fem::traits(kind).centre);
    const double von_mises = fem::von_mises_stress(model, stress), tension = fem::principal_stresses(model, stress)[0];
    state.part.material.yield_stress_pa = von_mises * (1.0 - 1e-9);
    if (tension > 0.0) state.part.material.strength_pa = tension * (1.0 - 1e-9);
    const auto passed = StressWatch({state}).look(0, state);
    EXPECT_NEAR(passed.yield.size / von_mises, 1.0, 1e-9);
    if (tension > 0.0) {
      EXPECT_NEAR(passed.tension.size / tension, 1.0, 1e-9);
    }
    pulled += tension > 0.0;
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const auto& x : state.part.mesh.position) middle += x / static_cast<double>(state.part.mesh.position.size());
    EXPECT_LT((passed.yield.place - middle).norm(), 1e-12);
    state.part.material.yield_stress_pa = von_mises * (1.0 + 1e-9);
    state.part.material.strength_pa = std::abs(tension) * (1.0 + 1e-9);
    const auto none = StressWatch({state}).look(0, state);
    EXPECT_EQ(none.yield.size, 0.0);
    EXPECT_EQ(none.tension.size, 0.0);
  }
  EXPECT_GT(pulled, 5);
}

INSTANTIATE_TEST_SUITE_P(Elements, StressInTheMiddle,
                         testing::Values(ElementOfModel{ElementKind::bar, Model::bar},
                                         ElementOfModel{ElementKind::triangle, Model::plane_strain},
                                         ElementOfModel{ElementKind::quadrilateral, Model::plane_strain},
                                         ElementOfModel{ElementKind::triangle, Model::axisymmetric},
                                         ElementOfModel{ElementKind::quadrilateral, Model::axisymmetric},
                                         ElementOfModel{ElementKind::tetrahedron, Model::solid},
                                         ElementOfModel{ElementKind::hexahedron, Model::solid}));

TEST(StressWatch, LooksAtNothingWithoutALimit) {
  const BodyState state = element(ElementKind::hexahedron, Model::solid, 1);
  const StressWatch watch({state});
  EXPECT_FALSE(watch.watches());
  EXPECT_EQ(watch.look(0, state).yield.size, 0.0);
}

}  // namespace
}  // namespace ricochet::solver

#include <gmock/gmock.h>

#include <cmath>

#include "common/base/error.hpp"
#include "common/contact/massless_nodes.hpp"
#include "tests/support/contact_plates.hpp"
#include "tests/support/rods.hpp"
#include "tests/support/triangle_mesh.hpp"

namespace ricochet::solver {
namespace {

const std::string massless = "multiplier_update = \"massless\"\n";

/// Two rods whose contact nodes, the last of the left and the first of the right one, have given their 1 kg to the
/// 2 kg of their neighbours.
struct Rods : test::SceneStates {
  ContactSurface surface{problem, states};
  MasslessNodes nodes{surface, states};

  Rods() : SceneStates(test::two_rods("all_explicit", massless)) {}
  const Eigen::VectorXd& settle() {
    return nodes.settle(
        states, [&](std::size_t /*part*/) -> const Eigen::VectorXd& { return none; },
        [&](std::size_t part) -> Eigen::VectorXd& { return states[part].u; });
  }
  double give_back(double made_j, double most_n_s = 1e9) {
    return nodes.give_back(0, made_j, most_n_s, states, [&](std::size_t part) { return states[part].v.data(); });
  }
  [[nodiscard]] double kinetic_energy() const {
    double sum = 0.0;
    for (const auto& state : states) sum += 0.5 * (state.mass.array() * state.v.array().square()).sum();
    return sum;
  }
  Eigen::VectorXd none = Eigen::VectorXd::Zero(5);
};

TEST(MasslessNodes, GiveTheirMassToTheirNeighbours) {
  const Rods rods;
  EXPECT_EQ(rods.states[0].mass[4], 0.0);
  EXPECT_EQ(rods.states[0].inverse_mass[4], 0.0);
  EXPECT_EQ(rods.states[0].mass[3], 3.0);
  EXPECT_EQ(rods.states[0].inverse_mass[3], 1.0 / 3.0);
  EXPECT_EQ(rods.states[1].mass[0], 0.0);
  EXPECT_EQ(rods.states[1].mass[1], 3.0);
}

TEST(MasslessNodes, LeaveABodyTheSameMassAlongEveryCoordinate) {
  test::ContactPlates plates("all_explicit", massless);
  const MasslessNodes nodes(plates.surface, plates.states);
  int count = 0;
  nodes.for_each_dof([&](std::size_t part, int dof) {
    ++count;
    EXPECT_EQ(dof % 2, 1) << "along the normal alone";
    EXPECT_EQ(plates.states[part].mass[dof], 0.0);
  });
  EXPECT_EQ(count, 6) << "three nodes of either plate";
  const auto ones = [&](int part) {
    return Eigen::VectorXd::Ones(plates.states[static_cast<std::size_t>(part)].part.dofs());
  };
  const Eigen::Vector2d mass = plates.mass_times(ones);
  EXPECT_NEAR(mass[0], 120.0, 1e-11);
  EXPECT_NEAR(mass[1], 120.0, 1e-11);
}

// Triangles, whose diagonals end at contact nodes too, on a plate of rectangles; 40 kg each.
TEST(MasslessNodes, WithSeveralNeighboursGiveEachAShare) {
  const test::TemporaryFolder folder;
  const std::string mesh = folder.write(test::rectangle_msh("lower", {0.2, -0.2, 0.2, 2, 2}), "lower.msh");
  std::string text = "model = \"plane_strain\"\n";
  for (const auto& [name, given] : {std::pair{"lower", "gmsh = \"" + mesh + "\""},
                                    {"upper", "length_m = 0.2, height_m = 0.2, elements = [2, 2]"}}) {
    text += std::string("[[body]]\nname = \"") + name +
            "\"\nmaterial = { youngs_modulus_pa = 1e9, poisson_ratio = 0.25, density_kg_m3 = 1000.0 }\nmesh = { " +
            given + " }\n";
  }
  test::SceneStates plates(text + "[contact]\nsurfaces = [\"lower.end\", \"upper.start\"]\n" + massless +
                           "[time]\nstep_s = 1e-6\nend_s = 1e-3\n[coupling]\nprotocol = \"all_explicit\"\n");
  const ContactSurface surface(plates.problem, plates.states);
  const MasslessNodes nodes(surface, plates.states);
  for (const auto& state : plates.states) {
    double along_normal = 0.0;
    for (int dof = 1; dof < state.part.dofs(); dof += 2) along_normal += state.mass[dof];
    EXPECT_NEAR(along_normal, 40.0, 1e-12) << state.name;
  }
}

TEST(MasslessNodes, WithoutElementsBehindThemAreRefused) {
  test::ContactPlates plates("all_explicit", massless);
  plates.states[1].part.mesh.elements.clear();
  try {
    const MasslessNodes nodes(plates.surface, plates.states);
    FAIL();
  } catch (const ConfigError& e) {
    EXPECT_THAT(e.what(), testing::HasSubstr("of body 'upper' at (0, 0) m has no neighbour"));
  }
}

// Neighbours that have come 2 mm closer squeeze two springs of 8 N/m in a row.
TEST(MasslessNodes, OfTwoRodsSettleInTheMiddle) {
  Rods rods;
  rods.states[0].u[3] = 3e-3;
  rods.states[1].u[1] = 1e-3;
  const Eigen::VectorXd& force = rods.settle();
  EXPECT_NEAR(force[0], 4.0 * 2e-3, 1e-16);
  EXPECT_NEAR(rods.states[0].u[4], 2e-3, 1e-17);
  EXPECT_NEAR(rods.states[1].u[0], 2e-3, 1e-17);
}

TEST(MasslessNodes, ThatDoNotTouchFollowTheirNeighbours) {
  Rods rods;
  rods.states[0].u[3] = -3e-3;
  rods.states[1].u[1] = 1e-3;
  rods.none[2] = 5.0;  // a load on another node does not concern them
  EXPECT_EQ(rods.settle()[0], 0.0);
  EXPECT_NEAR(rods.states[0].u[4], -3e-3, 1e-17);
  EXPECT_NEAR(rods.states[1].u[0], 1e-3, 1e-17);
}

// f - K u + N^T r = 0 at every massless degree of freedom, of plates of which the upper one is turned by 2e-3 about the
// middle of the surface, so that it is pressed at one end and lifted at the other; and of any small motion beside it.
TEST(MasslessNodes, SettleInBalanceWithoutPenetration) {
  test::ContactPlates plates("all_explicit", massless);
  MasslessNodes nodes(plates.surface, plates.states);
  auto& states = plates.states;
  for (auto& state : states)
    for (int dof = 0; dof < state.part.dofs(); ++dof) state.u[dof] = 2e-5 * std::sin(3.0 * dof);
  for (int node = 0; node < states[1].part.nodes(); ++node) {
    const auto& x = states[1].part.mesh.position[static_cast<std::size_t>(node)];
    states[1].u.segment<2>(2 * node) += 2e-3 * Eigen::Vector2d(-x[1], x[0] - 0.1);
  }
  const Eigen::VectorXd lower_load = Eigen::VectorXd::Constant(states[0].part.dofs(), 2e4),
                        upper_load = Eigen::VectorXd::Constant(states[1].part.dofs(), -1e4);
  const Eigen::VectorXd force = nodes.settle(
      states, [&](std::size_t part) -> const Eigen::VectorXd& { return part == 0 ? lower_load : upper_load; },
      [&](std::size_t part) -> Eigen::VectorXd& { return states[part].u; });
  std::vector<Eigen::VectorXd> rest = {lower_load - states[0].part.stiffness * states[0].u,
                                       upper_load - states[1].part.stiffness * states[1].u};
  int closed = 0;
  for (std::size_t i = 0; i < plates.surface.pairs.size(); ++i) {
    const auto& pair = plates.surface.pairs[i];
    const double r = force[static_cast<Eigen::Index>(i)], gap = pair.gap(displacement_of(states));
    EXPECT_GE(r, 0.0);
    EXPECT_GE(gap, -1e-15);
    EXPECT_NEAR(r * gap, 0.0, 1e-9);
    closed += r > 0.0;
    for (const auto& e : pair.normal.entries) rest[static_cast<std::size_t>(e.part)][e.dof] += e.coefficient * r;
  }
  EXPECT_GT(closed, 0);
  EXPECT_LT(closed, 3) << "both cases are there";
  nodes.for_each_dof([&](std::size_t part, int dof) { EXPECT_NEAR(rest[part][dof], 0.0, 1e-6); });
}

TEST(MasslessNodes, GiveBackTheEnergyThatTheContactMadeOrLost) {
  for (const double made_j : {0.5, -0.5}) {
    Rods rods;
    rods.states[0].v[3] = -1.0;
    rods.states[1].v[1] = 1.0;
    const double before = rods.kinetic_energy();
    const double impulse = rods.give_back(made_j);
    EXPECT_NEAR(rods.kinetic_energy() - before, -made_j, 1e-14);
    EXPECT_NEAR(rods.nodes.trial_work_j(), -made_j, 1e-14);
    EXPECT_NEAR(3.0 * (rods.states[1].v[1] - 1.0), impulse, 1e-14) << "on B along +n";
    EXPECT_NEAR(3.0 * (rods.states[0].v[3] + 1.0), -impulse, 1e-14) << "and the opposite on A";
    rods.nodes.accept();
    EXPECT_NEAR(rods.give_back(0.0), 0.0, 1e-14) << "nothing is left";
  }
}

TEST(MasslessNodes, KeepForTheNextWindowWhatTheLargestImpulseDoesNotGiveBack) {
  Rods rods;
  rods.states[0].v[3] = -1.0;
  rods.states[1].v[1] = 1.0;
  const double before = rods.kinetic_energy();
  EXPECT_EQ(rods.give_back(0.5, 0.1), -0.1);
  EXPECT_NEAR(rods.nodes.trial_work_j(), -0.1 * (2.0 - 0.5 * 0.1 * 2.0 / 3.0), 1e-15) << "the gap opens at 2 m/s";
  rods.nodes.accept();
  rods.give_back(0.0);
  EXPECT_NEAR(rods.kinetic_energy() - before, -0.5, 1e-14);
}

TEST(MasslessNodes, ForgetADebtThatWasNotAcceptedOrIsPutBack) {
  Rods rods;
  rods.states[1].v[1] = 1.0;
  rods.give_back(0.1, 1e-3);
  EXPECT_EQ(rods.give_back(0.0), 0.0) << "a trial that was not accepted";
  const auto before = rods.nodes.state();
  rods.give_back(0.1, 1e-3);
  rods.nodes.accept();
  rods.nodes.restore(before);
  EXPECT_EQ(rods.give_back(0.0), 0.0) << "the state of before";
}

}  // namespace
}  // namespace ricochet::solver

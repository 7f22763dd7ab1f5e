#include <gtest/gtest.h>
#include <unistd.h>

#include <Eigen/Geometry>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <string>

#include "common/solver/model_watch.hpp"

namespace ricochet::solver {
namespace {

using Kind = participant::DepartureKind;

/// Two plates of 4 x 2 elements of 0.05 m x 0.15 m, in touch, and what a watch says of a motion that a test gives them.
struct Plates {
  scene::Problem problem;
  std::vector<BodyState> states;

  explicit Plates(const std::string& model = "plane_strain", const std::string& extra_mesh = "",
                  const std::string& second = "\"upper.start\"]") {
    const std::string across = model == "solid"          ? "width_m = 0.1, height_m"
                               : model == "plane_strain" ? "height_m"
                                                         : "radius_m";
    const std::string elements = model == "solid" ? "[4, 2, 2]" : "[4, 2]";
    std::string text = "model = \"" + model + "\"\n";
    for (const std::string name : {"lower", "upper"}) {
      text += "[[body]]\nname = \"" + name +
              "\"\nmaterial = { youngs_modulus_pa = 1e9, poisson_ratio = 0.25, density_kg_m3 = 1000.0 }\n";
      text += "mesh = { start_m = " + std::string(name == "lower" ? "-0.3" : "0.0") + ", length_m = 0.3, " + across +
              " = 0.2, elements = " + elements + extra_mesh + " }\n";
    }
    text += "[contact]\nsurfaces = [\"lower.end\", " + second +
            "\n[time]\nstep_s = 1e-6\nend_s = "
            "1e-3\n[coupling]\nprotocol = \"all_implicit\"\n";
    const std::string path = testing::TempDir() + "model_watch_" + std::to_string(getpid()) + ".toml";
    std::ofstream(path) << text;
    problem = scene::build_problem(scene::load_scene(path));
    states = initial_states(problem, problem.scene.participants.front(), true);
    std::filesystem::remove(path);
  }
  /// u = motion(x) on the nodes of a solid body.
  template <class Motion>
  void move_solid(std::size_t body, const Motion& motion) {
    auto& state = states[body];
    for (int node = 0; node < state.part.nodes(); ++node) {
      const Eigen::Vector3d u = motion(state.part.mesh.position[static_cast<std::size_t>(node)]);
      state.u.segment<3>(3 * node) = u;
    }
  }
  /// u = motion(x) on the nodes of a body.
  template <class Motion>
  void move(std::size_t body, const Motion& motion) {
    auto& state = states[body];
    for (int node = 0; node < state.part.nodes(); ++node) {
      const Eigen::Vector2d u = motion(state.part.mesh.position[static_cast<std::size_t>(node)].head<2>());
      state.u.segment<2>(2 * node) = u;
    }
  }
  [[nodiscard]] std::vector<participant::Departure> look(bool contact = true) const {
    const ContactSurface surface(problem, states);
    ModelWatch watch(problem, states, contact ? &surface : nullptr);
    watch.look(ModelWatch::every, states);
    watch.look(ModelWatch::every + 1, states);
    return watch.departures();
  }
};

const participant::Departure* find(const std::vector<participant::Departure>& all, Kind kind) {
  for (const auto& d : all)
    if (d.kind == kind) return &d;
  return nullptr;
}

/// A round surface is not the same at all places, as a plane is; and it has no end.
TEST(ModelWatch, SeesSlipOnARigidCylinderAndNoneOnAPlane) {
  for (const bool round : {true, false}) {
    Plates plates("plane_strain", "", round ? "\"rigid_cylinder\"]\nrigid_radius_m = 1.0" : "\"rigid_plane\"]");
    plates.move(0, [](const Eigen::Vector2d&) { return Eigen::Vector2d(0.12, 0.0); });
    const auto found = plates.look();
    const auto* slip = find(found, Kind::slip);
    ASSERT_EQ(slip != nullptr, round);
    EXPECT_EQ(found.size(), round ? 1U : 0U);
    if (round) {
      EXPECT_NEAR(slip->largest, 0.12 / 0.05, 1e-12) << "in edges";
    }
  }
}

TEST(ModelWatch, SeesStrainRotationAndInversionOfSolids) {
  Plates solids("solid");
  const Eigen::Vector3d axis = Eigen::Vector3d(1.0, 2.0, -2.0) / 3.0;
  solids.move_solid(0,
                    [](const Eigen::Vector3d& x) { return Eigen::Vector3d(0.019 * x[1], 0.019 * x[0], 0.019 * x[2]); });
  solids.move_solid(1, [&](const Eigen::Vector3d& x) -> Eigen::Vector3d { return 0.034 * axis.cross(x); });
  EXPECT_TRUE(solids.look(false).empty());
  solids.move_solid(0, [](const Eigen::Vector3d& x) { return Eigen::Vector3d(0.03 * x[1], 0.03 * x[0], 0.0); });
  solids.move_solid(1,
                    [&](const Eigen::Vector3d& x) -> Eigen::Vector3d { return Eigen::AngleAxisd(0.5, axis) * x - x; });
  const auto found = solids.look(false);
  ASSERT_NE(find(found, Kind::strain), nullptr);
  ASSERT_NE(find(found, Kind::rotation), nullptr);
  EXPECT_NEAR(find(found, Kind::rotation)->largest, 0.5, 1e-12) << "of any size";
  solids.move_solid(1, [](const Eigen::Vector3d&) { return Eigen::Vector3d::Zero(); });
  const auto sheared = solids.look(false);
  ASSERT_EQ(sheared.size(), 1U);
  EXPECT_NEAR(sheared[0].largest, 0.03, 1e-12);
  solids.move_solid(0, [](const Eigen::Vector3d& x) { return Eigen::Vector3d(0.0, 0.0, x[2] > -0.1 ? -0.2 : 0.0); });
  EXPECT_NE(find(solids.look(false), Kind::inverted), nullptr);
}

// Edges of 0.05 m along both directions of the surface.
TEST(ModelWatch, SeesSolidsSlipAndLeaveThePartnerEitherWay) {
  for (const auto& along : {Eigen::Vector3d(1.0, 0.0, 0.0), Eigen::Vector3d(0.0, 1.0, 0.0)}) {
    Plates solids("solid");
    const auto slide = [&](double edges) {
      solids.move_solid(1, [&](const Eigen::Vector3d&) -> Eigen::Vector3d { return edges * 0.05 * along; });
      return solids.look();
    };
    EXPECT_TRUE(slide(0.4).empty());
    ASSERT_EQ(slide(-0.6).size(), 1U);
    EXPECT_NEAR(slide(-0.6)[0].largest, 0.6, 1e-12);
    EXPECT_EQ(find(slide(0.9), Kind::off_partner), nullptr);
    ASSERT_NE(find(slide(1.5), Kind::off_partner), nullptr);
    EXPECT_NEAR(find(slide(1.5), Kind::off_partner)->largest, 1.5, 1e-9);
  }
}

// A checkpoint that is damaged, or another participant's.
TEST(ModelWatch, WithoutASurfaceGoesOnFromAStateThatSpeaksOfSlip) {
  Plates plates;
  plates.move(1, [](const Eigen::Vector2d&) { return Eigen::Vector2d(0.04, 0.0); });
  const ContactSurface surface(plates.problem, plates.states);
  ModelWatch watch(plates.problem, plates.states, &surface), without(plates.problem, plates.states, nullptr);
  watch.look(ModelWatch::every, plates.states);
  ASSERT_NE(find(watch.departures(), Kind::slip), nullptr);
  Archive out;
  out(watch);
  const std::string bytes = out.take();
  Archive in(bytes, "state");
  in(without);
  without.look(ModelWatch::every + 1, plates.states);
  EXPECT_EQ(without.departures().size(), watch.departures().size()) << "as they were read";
}

TEST(ModelWatch, SmallMotionIsWithinTheModel) {
  Plates plates;
  plates.move(0, [](const Eigen::Vector2d& x) { return Eigen::Vector2d(3.0 + 0.019 * x[0], 7.0 - 0.019 * x[1]); });
  plates.move(1, [](const Eigen::Vector2d& x) { return Eigen::Vector2d(3.0 - 0.034 * x[1], 7.0 + 0.034 * x[0]); });
  EXPECT_TRUE(plates.look(false).empty());
}

TEST(ModelWatch, TellsTheLargestPrincipalStrain) {
  Plates plates;  // e_xx = 0.01, e_xy = 0.02: principal 0.005 +- hypot(0.005, 0.02)
  plates.move(1, [](const Eigen::Vector2d& x) { return Eigen::Vector2d(0.01 * x[0] + 0.02 * x[1], 0.02 * x[0]); });
  const auto found = plates.look(false);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].kind, Kind::strain);
  EXPECT_EQ(found[0].body, 1);
  EXPECT_NEAR(found[0].largest, 0.005 + std::hypot(0.005, 0.02), 1e-14);
  EXPECT_EQ(found[0].first, ModelWatch::every);
  EXPECT_EQ(found[0].last_without, 0);
  EXPECT_EQ(found[0].looks, 1);
}

TEST(ModelWatch, SeesTheHoopStrainOfARing) {
  Plates plates("axisymmetric");
  plates.move(0, [](const Eigen::Vector2d& x) { return Eigen::Vector2d(0.03 * x[0], -0.001 * x[1]); });
  const auto found = plates.look(false);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_NEAR(found[0].largest, 0.03, 1e-14);
}

TEST(ModelWatch, MeasuresARotationOfAnySizeAndTheStrainThatSmallStrainSeesInIt) {
  Plates plates;
  const double angle = 66.0 * std::numbers::pi / 180.0;
  plates.move(0, [&](const Eigen::Vector2d& x) -> Eigen::Vector2d { return Eigen::Rotation2Dd(angle) * x - x; });
  const auto found = plates.look(false);
  ASSERT_TRUE(find(found, Kind::rotation) && find(found, Kind::strain));
  EXPECT_NEAR(find(found, Kind::rotation)->largest, angle, 1e-12);
  EXPECT_NEAR(find(found, Kind::strain)->largest, 1.0 - std::cos(angle), 1e-12);
  EXPECT_EQ(find(found, Kind::inverted), nullptr) << "a rotated element is whole";
}

TEST(ModelWatch, SeesAnElementTurnedInsideOutByWhateverMotion) {
  Plates thick;  // the middle would say so, too
  thick.move(0, [](const Eigen::Vector2d& x) { return Eigen::Vector2d(0.0, x[1] > -0.1 ? -0.2 : 0.0); });
  ASSERT_TRUE(find(thick.look(false), Kind::inverted));
  EXPECT_NEAR(find(thick.look(false), Kind::inverted)->largest, 1.0 + 0.05 / 0.15, 1e-12);
  Plates hourglass;  // the middle has no strain
  auto& state = hourglass.states[1];
  const auto& nodes = state.part.mesh.elements[0];
  for (int i = 0; i < 4; ++i) state.u[2 * nodes[static_cast<std::size_t>(i)]] = i % 2 == 0 ? 0.06 : -0.06;
  EXPECT_TRUE(find(hourglass.look(false), Kind::inverted));
}

TEST(ModelWatch, TellsSlipOfClosedPairsInEdges) {
  Plates plates;
  plates.move(1, [](const Eigen::Vector2d&) { return Eigen::Vector2d(0.6 * 0.05, 0.0); });
  const auto found = plates.look();
  ASSERT_TRUE(find(found, Kind::slip));
  EXPECT_NEAR(find(found, Kind::slip)->largest, 0.6, 1e-12);
  plates.move(1, [](const Eigen::Vector2d&) { return Eigen::Vector2d(0.4 * 0.05, 0.0); });
  EXPECT_TRUE(plates.look().empty());
  plates.move(1, [](const Eigen::Vector2d&) { return Eigen::Vector2d(0.6 * 0.05, 1e-6); });
  EXPECT_TRUE(plates.look().empty()) << "open";
}

TEST(ModelWatch, FindsAPressedNodeThatIsPastTheEndOfItsPartner) {
  Plates plates;
  plates.move(1, [](const Eigen::Vector2d&) { return Eigen::Vector2d(0.9 * 0.05, 0.0); });
  EXPECT_FALSE(find(plates.look(), Kind::off_partner));
  plates.move(1, [](const Eigen::Vector2d&) { return Eigen::Vector2d(-1.5 * 0.05, 0.0); });
  const auto found = plates.look();
  ASSERT_TRUE(find(found, Kind::off_partner));
  EXPECT_NEAR(find(found, Kind::off_partner)->largest, 1.5, 1e-12);
  EXPECT_EQ(find(found, Kind::off_partner)->first, ModelWatch::every);
  EXPECT_EQ(find(found, Kind::off_partner)->last_without, 0);
  EXPECT_EQ(find(found, Kind::off_partner)->looks, 2) << "looked at after each window once something has slipped";
  plates.move(1, [](const Eigen::Vector2d&) { return Eigen::Vector2d(-10.0, 1e-6); });
  EXPECT_FALSE(find(plates.look(), Kind::off_partner)) << "open: it may fly where it likes";
}

TEST(ModelWatch, APeriodicSurfaceHasNoEnd) {
  Plates plates("plane_strain", ", periodic_across = true");
  plates.move(1, [](const Eigen::Vector2d&) { return Eigen::Vector2d(1.0, 0.0); });
  const auto found = plates.look();
  EXPECT_TRUE(find(found, Kind::slip));
  EXPECT_FALSE(find(found, Kind::off_partner));
}

TEST(ModelWatch, TellsHowDeepAPairHasSunk) {
  Plates plates;
  plates.move(1, [](const Eigen::Vector2d&) { return Eigen::Vector2d(0.0, -1.2 * 0.15); });
  const auto found = plates.look();
  ASSERT_TRUE(find(found, Kind::penetration));
  EXPECT_NEAR(find(found, Kind::penetration)->largest, 1.2, 1e-12);
}

TEST(ModelWatch, LooksEverySoManyWindowsAndAtTheEnd) {
  Plates plates;
  plates.move(0, [](const Eigen::Vector2d& x) { return Eigen::Vector2d(0.03 * x[0], 0.0); });
  ModelWatch watch(plates.problem, plates.states, nullptr);
  watch.look(5, plates.states);
  EXPECT_TRUE(watch.departures().empty());
  watch.look(5, plates.states, true);
  ASSERT_EQ(watch.departures().size(), 1U);
  watch.look(5, plates.states, true);
  EXPECT_EQ(watch.departures()[0].looks, 1) << "the same window again";
  watch.look(ModelWatch::every, plates.states);
  EXPECT_EQ(watch.departures()[0].looks, 2);
}

}  // namespace
}  // namespace ricochet::solver

// The looks of a wrong number of a participant; whole runs of wrong participants are in tests/swap.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <functional>

#include "common/base/error.hpp"
#include "common/problem/problem.hpp"
#include "coupler/watch/scene_comparison.hpp"
#include "coupler/watch/tried_causes.hpp"
#include "tests/support/places.hpp"

namespace ricochet::coupler {
namespace {

using testing::AllOf;
using testing::HasSubstr;

TEST(KnownSlip, IsRecognisedByItsFactor) {
  EXPECT_EQ(known_slip(1.0), "");
  EXPECT_EQ(known_slip(1.37), "");
  EXPECT_THAT(known_slip(-1.0), HasSubstr("its sign is wrong"));
  EXPECT_THAT(known_slip(1.0 / (2.0 * M_PI)), HasSubstr("it is per radian"));
  EXPECT_THAT(known_slip(2.0 * M_PI), HasSubstr("2 pi was multiplied twice"));
  EXPECT_EQ(known_slip(2.0), "") << "a guess at why would be one";
  EXPECT_THAT(known_slip(1e3), HasSubstr("a factor 1000: everything is in SI units"));
  EXPECT_THAT(known_slip(1e-9), HasSubstr("a factor 1e-09: everything is in SI units"));
}

/// The explicit side of two bars, described as it should be.
struct DescribedBars {
  scene::Problem problem;
  PeerDescription description;

  DescribedBars() {
    problem = scene::build_problem(scene::load_scene(test::source_folder() + "/configs/two_bars.toml"));
    description.participant = "explicit";
    description.components = 1;
    description.bodies = {"left", "right"};
    description.interface_body = {2, 1, {0, 1}};
    description.interface_position_m = {2, 1, {-0.0635, 0.508e-3 + 0.0635}};
    const double mass = 0.5 * 7844.066 * 6.4516e-4 * 0.254 / 20;
    description.interface_mass_kg = {2, 1, {mass, mass}};
  }
  [[nodiscard]] std::string refusal() const {
    try {
      SceneComparison(problem, description).check_description();
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "";
  }
};

TEST(SceneComparison, AcceptsWhatTheSceneSays) { EXPECT_EQ(DescribedBars().refusal(), ""); }

TEST(SceneComparison, NamesANodeThatIsNotInTheMesh) {
  DescribedBars bars;
  bars.description.interface_position_m.data[1] += 1e-4;
  EXPECT_THAT(bars.refusal(), AllOf(HasSubstr("participant 'explicit', body 'right', interface node 1 at (0.064108) m"),
                                    HasSubstr("the scene's mesh has no interface node there; the nearest is at "
                                              "(0.064008) m, 0.0001 m away, allowed are 1.28e-10 m")));
}

TEST(SceneComparison, NamesTheOneNodeWhoseMassIsWrong) {
  DescribedBars bars;
  bars.description.interface_mass_kg.data[1] *= 1.002;
  EXPECT_THAT(bars.refusal(), AllOf(HasSubstr("interface node 1"), HasSubstr("(1.002 times); if the body")));
  bars.description.interface_mass_kg.data[1] /= 1.0015;
  EXPECT_EQ(bars.refusal(), "") << "another quadrature";
}

TEST(SceneComparison, LeavesWhatIsNoDescriptionToTheInterfaceMap) {
  const auto possible = [](const std::function<void(PeerDescription&)>& change) {
    DescribedBars bars;
    change(bars.description);
    return SceneComparison::possible(bars.problem, bars.description);
  };
  EXPECT_TRUE(possible([](PeerDescription&) {}));
  EXPECT_FALSE(possible([](PeerDescription& d) { d.components = 2; }));
  EXPECT_FALSE(possible([](PeerDescription& d) { d.interface_position_m.data.pop_back(); }));
  EXPECT_FALSE(possible([](PeerDescription& d) { d.interface_mass_kg.data.pop_back(); }));
  EXPECT_FALSE(possible([](PeerDescription& d) { d.interface_mass_kg.data[0] = 1e300; }));
  EXPECT_FALSE(possible([](PeerDescription& d) { d.interface_body.data[0] = 2; }));
}

TEST(TriedCauses, TurnAndScaleAllPlacesTogether) {
  const std::vector<Eigen::Vector3d> scene{{1.0, 2.0, 3.0}, {4.0, 5.0, 7.0}};
  const auto cause = [&](std::vector<Eigen::Vector3d> places, std::size_t turned = 2) {
    for (std::size_t i = 0; i < turned; ++i) places[i] = {-1e3 * places[i][2], 1e3 * places[i][0], 1e3 * places[i][1]};
    return places_cause(places, {"x", "y", "z"},
                        [&](std::size_t i, const Eigen::Vector3d& x) { return (x - scene[i]).norm() <= 1e-6; });
  };
  EXPECT_EQ(cause(scene), "0.001 times (y, z, -x) of all 2 nodes are places of the scene, which has metres");
  EXPECT_EQ(cause(scene, 1), "") << "it explains one of two";
}

TEST(TriedCauses, ArrangementsAreAppliedAndUndone) {
  const std::vector<double> values{1.0, 2.0, 3.0, 4.0};
  for (const auto& other : other_arrangements({0.0, 0.0}, {"x", "y"})) {
    EXPECT_EQ(other.undone(other.applied(values)), values) << other.name;
    EXPECT_NE(other.applied(values), values) << other.name;
  }
}

/// A window of so many steps, by a force on both interface nodes, against itself and against another number of steps.
TEST(SceneComparison, TellsSubstepsApart) {
  DescribedBars bars;
  const SceneComparison comparison(bars.problem, bars.description);
  const auto probe = comparison.probe(Drive::force);
  EXPECT_NE(probe[0], probe[1]);
  const std::vector<double> nothing(2, 0.0);
  EXPECT_THROW(comparison.check_window(probe, nothing, 2), ConfigError);
  EXPECT_THROW(comparison.check_stiffness(comparison.probe(Drive::displacement), nothing), ConfigError);
}

}  // namespace
}  // namespace ricochet::coupler

// Absorbing surfaces: impedances, and what is refused.
#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

#include "common/base/error.hpp"
#include "common/check/check.hpp"
#include "common/check/check_reach.hpp"
#include "tests/common/scene/scene_text.hpp"
#include "tests/support/places.hpp"

namespace ricochet::scene {
namespace {

using testing::HasSubstr;

/// Sum of the dashpots of one component [kg/s].
double total(const BodyProblem& body, int component) {
  const int components = fem::components(body.section.model);
  double sum = 0.0;
  for (Eigen::Index dof = component; dof < body.damping_kg_s.size(); dof += components) sum += body.damping_kg_s[dof];
  return sum;
}

BodyProblem first_body(const std::string& text) { return build_problem(load_text(text)).bodies.front(); }

TEST(Absorbing, TheEndOfABarHasItsImpedance) {
  const BodyProblem body =
      first_body(replaced(bars, "initial_velocity_m_s = [5.13588]", "absorbing = [{ surface = \"start\" }]"));
  EXPECT_DOUBLE_EQ(body.damping_kg_s[0], 6.4516e-4 * std::sqrt(206.8e9 * 7844.066));
  EXPECT_EQ(body.damping_kg_s.tail(20), Eigen::VectorXd::Zero(20));
}

TEST(Absorbing, ACylinderTakesTheBarSpeedOrTheDilatationalOne) {
  const double area = std::numbers::pi * 0.004 * 0.004, rho = 7860.0, young = 207e9, nu = 0.3;
  const double shear = area * std::sqrt(rho * young / (2.0 * (1.0 + nu)));
  const auto with = [](const char* wave) {
    return replaced(cylinders, "initial_velocity_m_s = [0.0, 30.0]",
                    std::string("absorbing = [{ surface = \"start\", wave = \"") + wave + "\" }]");
  };
  const BodyProblem bar = first_body(with("bar")), wide = first_body(with("dilatational"));
  EXPECT_NEAR(total(bar, 1), area * std::sqrt(rho * young), 1e-12 * total(bar, 1));
  const double lateral = (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu));
  EXPECT_NEAR(total(wide, 1), area * std::sqrt(rho * young * lateral), 1e-12 * total(wide, 1));
  for (const BodyProblem* body : {&bar, &wide}) {
    // Where u_r is held, at the axis, there is none: its share of the area is r/3 of the first edge's, 1/(6 16).
    EXPECT_NEAR(total(*body, 0), shear * (1.0 - 1.0 / 48.0), 1e-12 * shear);
    EXPECT_EQ(body->damping_kg_s[0], 0.0);
  }
}

TEST(Absorbing, APlateTakesItsOwnLongWaveAndShearAlongTheSurface) {
  const double area = 0.3 * 0.5, rho = 1000.0, young = 1e9, nu = 0.25;
  const std::string text =
      replaced(plates, "thickness_m = 0.5\n[[body]]",
               "thickness_m = 0.5\nabsorbing = [{ surface = \"start\", wave = \"bar\" }]\n[[body]]");
  const BodyProblem end = first_body(text);
  EXPECT_NEAR(total(end, 1), 0.2 * 0.5 * std::sqrt(rho * young / (1.0 - nu * nu)), 1e-9);
  // A side of a body without contact: its normal is x.
  std::string alone =
      replaced(text, "surface = \"start\", wave = \"bar\"", "surface = \"inner\", wave = \"dilatational\"");
  alone.erase(alone.find("[contact]"), alone.find("[time]") - alone.find("[contact]"));
  const BodyProblem side = first_body(alone + "[coupling]\nprotocol = \"all_explicit\"\n");
  EXPECT_NEAR(total(side, 0), area * std::sqrt(rho * young * 0.75 / (1.25 * 0.5)), 1e-9);
  EXPECT_NEAR(total(side, 1), area * std::sqrt(rho * young / 2.5), 1e-9);
}

struct Refused {
  std::string name, from, to;
  std::vector<std::string> says;
};
void PrintTo(const Refused& refused, std::ostream* out) { *out << refused.name; }

const std::string velocity = "initial_velocity_m_s = [0.0, 30.0]";
const Refused refused[] = {
    {"unknown_surface", velocity, "absorbing = [{ surface = \"strat\", wave = \"bar\" }]", {"did you mean \"start\"?"}},
    {"no_wave",
     velocity,
     "absorbing = [{ surface = \"start\" }]",
     {"absorbing[0].wave: found nothing", "\"dilatational\""}},
    {"wrong_wave", velocity, "absorbing = [{ surface = \"start\", wave = \"shear\" }]", {"found \"shear\"", "\"bar\""}},
    {"twice",
     velocity,
     "absorbing = [{ surface = \"start\", wave = \"bar\" }, { surface = \"start\", wave = \"bar\" }]",
     {"\"start\" a second time"}},
    {"contact_surface",
     velocity,
     "absorbing = [{ surface = \"end\", wave = \"bar\" }]",
     {"body.steel.absorbing[0].surface: found the contact node at (0, 0) m"}},
    {"beside_the_contact_surface",
     velocity,
     "absorbing = [{ surface = \"outer\", wave = \"bar\" }]",
     {"found the contact node at (0.004, 0) m", "shares no node with the contact surface"}},
    {"axis", velocity, "absorbing = [{ surface = \"inner\", wave = \"bar\" }]", {"held along the surface's normal"}},
    {"support",
     velocity,
     "support = [{ surface = \"start\", fixed = [\"z\"] }]\nabsorbing = [{ surface = \"start\", wave = \"bar\" }]",
     {"held along the surface's normal", "free to move"}},
};

class RefusedAbsorbing : public testing::TestWithParam<Refused> {};

TEST_P(RefusedAbsorbing, SaysPlaceFoundAndAllowed) {
  try {
    (void)build_problem(load_text(replaced(cylinders, GetParam().from, GetParam().to)));
    FAIL() << "accepted";
  } catch (const ConfigError& error) {
    for (const std::string& part : GetParam().says) EXPECT_THAT(error.what(), HasSubstr(part));
    EXPECT_THAT(error.what(), HasSubstr("allowed:"));
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, RefusedAbsorbing, testing::ValuesIn(refused),
                         [](const auto& test) { return test.param.name; });

TEST(Absorbing, ABarHasNoChoiceOfWave) {
  EXPECT_THROW((void)load_text(replaced(bars, "initial_velocity_m_s = [5.13588]",
                                        "absorbing = [{ surface = \"start\", wave = \"bar\" }]")),
               ConfigError);
}

TEST(Absorbing, LeavesTheCriticalStepAsItIs) {
  const auto step = [](const std::string& text) {
    return plan(build_problem(load_text(text))).participants.front().critical_time_step_s;
  };
  EXPECT_EQ(step(bars), step(replaced(bars, "initial_velocity_m_s = [5.13588]",
                                      "initial_velocity_m_s = [5.13588]\nabsorbing = [{ surface = \"start\" }]")));
}

// `check` on what no wave reaches. Bars: c = 5134.6 m/s, in touch after 0.508e-3/(2 * 5.13588) = 49.456 us.

std::vector<std::string> unreached_ends_of(Scene scene, double end_s) {
  scene.time.end_s = end_s;
  return unreached_ends(build_problem(scene));
}

std::vector<std::string> notes(const std::string& text) { return plan(build_problem(load_text(text))).notes; }

TEST(UnreachedEnds, AreReportedByLengthAndElements) {
  // 70 us: 20.5 us after they have met, 105.5 mm from the contact; whole elements of 12.7 mm lie behind 114.3 mm.
  const auto lines = notes(replaced(bars, "end_s = 200e-6", "end_s = 70e-6"));
  ASSERT_EQ(lines.size(), 2U);
  EXPECT_THAT(lines[0], HasSubstr("the 0.1397 m at the low end of \"left\" (11 of 20 elements) before 7e-05 s"));
  EXPECT_THAT(lines[1], HasSubstr("the 0.1397 m at the high end of \"right\" (11 of 20 elements)"));
  const auto problem = build_problem(load_text(replaced(bars, "end_s = 200e-6", "end_s = 70e-6")));
  EXPECT_THAT(to_text(problem, plan(problem)), HasSubstr("\nnote: no wave"));
}

TEST(UnreachedEnds, AreNoneWhereEverythingIsReached) { EXPECT_TRUE(notes(bars).empty()); }

TEST(UnreachedEnds, AreNoneOfABodyThatIsLoadedEverywhere) {
  const std::string brief = replaced(bars, "end_s = 200e-6", "end_s = 20e-6");
  const std::string left = "initial_velocity_m_s = [5.13588]";
  EXPECT_EQ(notes(replaced(brief, left, left + "\ngravity_m_s2 = [-9.81]")).size(), 1U) << "of the other bar";
  EXPECT_EQ(notes(replaced(brief, left, left + "\ninitial_displacement_m = { start = [-1e-5], end = [0.0] }")).size(),
            1U);
}

TEST(UnreachedEnds, CountFromLoadsAndStopsToo) {
  const std::string brief = replaced(bars, "end_s = 200e-6", "end_s = 20e-6");
  const std::string left = "initial_velocity_m_s = [5.13588]";
  // 102.7 mm in 20 us: from the loaded end and, since they may meet earlier, from the contact; 48.6 mm between are no
  // end.
  const std::string loaded =
      replaced(brief, left, left + "\ntraction = [{ surface = \"start\", traction_pa = [1e6] }]");
  ASSERT_EQ(notes(loaded).size(), 1U);
  EXPECT_THAT(notes(loaded)[0], HasSubstr("the 0.1397 m at the high end of \"right\" (11 of 20 elements)"));
  const std::string stopped = replaced(brief, left, left + "\nsupport = [{ surface = \"start\", fixed = [\"x\"] }]");
  EXPECT_EQ(notes(stopped), notes(loaded));
}

TEST(UnreachedEnds, WorkWithAnyMeshByTheDilatationalSpeed) {
  // Steel: c_L = 5954 m/s. 2 us: 11.9 mm; elements of 2.5 mm behind 12.5 mm.
  const auto lines = notes(replaced(cylinders, "end_s = 1e-5", "end_s = 2e-6"));
  ASSERT_EQ(lines.size(), 2U);
  EXPECT_THAT(lines[0], HasSubstr("the 0.0075 m at the low end of \"steel\" (12 of 32 elements)"));
  EXPECT_THAT(lines[1], HasSubstr("the 0.005 m at the high end of \"carbide\" (8 of 32 elements)"));
  const Scene gmsh = load_scene(test::source_folder() + "/configs/striker_gmsh.toml");
  EXPECT_TRUE(unreached_ends_of(gmsh, 30e-6).empty());
  EXPECT_EQ(unreached_ends_of(gmsh, 1e-6).size(), 2U);
}

}  // namespace
}  // namespace ricochet::scene

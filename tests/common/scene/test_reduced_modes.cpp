// partition.reduced_modes: who computes what, and what does not go with it.
#include <gmock/gmock.h>

#include "common/base/error.hpp"
#include "common/check/check.hpp"
#include "common/problem/critical_step.hpp"
#include "tests/common/scene/scene_text.hpp"

namespace ricochet::scene {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

const std::string plates_of_modes = R"(model = "plane_strain"
[[body]]
name = "lower"
material = { youngs_modulus_pa = 1e9, poisson_ratio = 0.25, density_kg_m3 = 1000.0 }
mesh = { start_m = -0.05, length_m = 0.05, height_m = 0.02, elements = [2, 5] }
initial_velocity_m_s = [0.0, 1.0]
[[body]]
name = "upper"
material = { youngs_modulus_pa = 1e9, poisson_ratio = 0.25, density_kg_m3 = 1000.0 }
mesh = { length_m = 0.05, height_m = 0.02, elements = [2, 5] }
[contact]
surfaces = ["lower.end", "upper.start"]
[partition]
implicit_length_m = { lower = 0.01, upper = 0.01 }
reduced_modes = { upper = 12 }
[time]
step_s = 1e-6
end_s = 1e-4
[coupling]
protocol = "belytschko_mullen"
)";

std::string listed(const std::string& bodies, const std::string& more) {
  return plates_of_modes + "[[participant]]\nname = \"far\"\nrole = \"explicit\"\nbodies = " + bodies + "\n" + more +
         "[[participant]]\nname = \"near\"\nrole = \"implicit\"\n";
}

TEST(ReducedModes, HaveAParticipantOfTheirOwn) {
  const Scene scene = load_text(plates_of_modes);
  ASSERT_EQ(scene.participants.size(), 3U);
  EXPECT_THAT(scene.participants[0].bodies, ElementsAre("lower"));
  EXPECT_FALSE(scene.participants[0].reduced);
  EXPECT_EQ(scene.participants[1].name, "reduced");
  EXPECT_THAT(scene.participants[1].bodies, ElementsAre("upper"));
  EXPECT_TRUE(scene.participants[1].reduced);
  EXPECT_EQ(scene.participants[2].role, Role::implicit_solver);
  EXPECT_TRUE(scene.any_reduced());
  const Scene both = load_text(replaced(plates_of_modes, "{ upper = 12 }", "{ upper = 12, lower = 3 }"));
  ASSERT_EQ(both.participants.size(), 2U);
  EXPECT_THAT(both.participants[0].bodies, ElementsAre("lower", "upper"));
}

TEST(ReducedModes, HaveNoCriticalStep) {
  const Problem problem = build_problem(load_text(replaced(plates_of_modes, "{ upper = 12 }\n[time]\nstep_s = 1e-6",
                                                           "{ upper = 12, lower = 3 }\n[time]\nstep_s = 1e-5")));
  const Plan checked = plan(problem);
  EXPECT_FALSE(std::isfinite(checked.participants[0].critical_time_step_s));
  EXPECT_EQ(checked.participants[0].unknowns, 15);
  EXPECT_THROW((void)plan(build_problem(load_text(replaced(plates_of_modes, "step_s = 1e-6", "step_s = 1e-5")))),
               ConfigError)
      << "the other body still has one";
}

// Step and contact alone say what is implicit; modes bear any step.
TEST(ReducedModes, LeaveTheAutomaticPartitionTheContactLayer) {
  const Problem problem = build_problem(load_text(
      replaced(plates_of_modes, "implicit_length_m = { lower = 0.01, upper = 0.01 }\nreduced_modes = { upper = 12 }",
               "rule = \"auto\"\nreduced_modes = { upper = 12, lower = 12 }")));
  for (const BodyProblem& body : problem.bodies)
    EXPECT_EQ(std::count(body.implicit_element.begin(), body.implicit_element.end(), true), 2) << body.name;
}

TEST(ReducedModes, AreNoMatterOfBaselines) {
  for (const std::string baseline : {"all_implicit", "all_explicit"}) {
    const Scene scene = load_text(replaced(plates_of_modes, "belytschko_mullen", baseline));
    EXPECT_FALSE(scene.any_reduced());
    ASSERT_EQ(scene.participants.size(), 1U);
    EXPECT_FALSE(scene.participants[0].reduced);
  }
}

struct WrongOne {
  const char* name;
  std::string scene;
  std::vector<std::string> says;
};

void PrintTo(const WrongOne& wrong, std::ostream* out) { *out << wrong.name; }

std::string with(const std::string& from, const std::string& to) { return replaced(plates_of_modes, from, to); }

/// A line more for the upper body.
std::string upper(const std::string& line) { return with("[contact]", line + "\n[contact]"); }

class WrongModes : public testing::TestWithParam<WrongOne> {};

TEST_P(WrongModes, AreRefusedByName) {
  try {
    (void)plan(build_problem(load_text(GetParam().scene)));
    FAIL() << "accepted";
  } catch (const ConfigError& error) {
    for (const std::string& part : GetParam().says) EXPECT_THAT(error.what(), HasSubstr(part));
    EXPECT_THAT(error.what(), HasSubstr("allowed:"));
  }
}

const std::string away = R"([[body]]
name = "away"
material = { youngs_modulus_pa = 1e9, poisson_ratio = 0.25, density_kg_m3 = 1000.0 }
mesh = { start_m = 1.0, length_m = 0.05, height_m = 0.02, elements = [2, 5] }
)";
const std::string place = ":15: partition.reduced_modes.upper: found ";

INSTANTIATE_TEST_SUITE_P(
    All, WrongModes,
    testing::Values(
        WrongOne{"unknown_body", with("{ upper = 12 }", "{ uper = 12 }"), {"\"uper\"; did you mean \"upper\"?"}},
        WrongOne{
            "not_whole", with("upper = 12 }", "upper = 1.5 }"), {"found 1.5 for body \"upper\"", "a whole number"}},
        WrongOne{"none", with("upper = 12 }", "upper = 0 }"), {"found 0", ">= 1"}},
        WrongOne{"too_many",
                 with("upper = 12 }", "upper = 25 }"),
                 {place + "25; allowed: at most 24, of 30 degrees of freedom less the 6 that are shared"}},
        WrongOne{"of_a_body_that_nothing_touches",
                 replaced(with("[contact]", away + "[contact]"), "{ upper = 12 }", "{ away = 12 }"),
                 {"partition.reduced_modes.away: found a body without implicit elements"}},
        WrongOne{"alone", with("implicit_length_m = { lower = 0.01, upper = 0.01 }\n", ""), {"found 0 of its keys"}},
        WrongOne{"other_protocol",
                 with("\"belytschko_mullen\"", "\"hughes_liu\""),
                 {place + "modes under protocol \"hughes_liu\"", "\"belytschko_mullen\", \"fixed_point\""}},
        WrongOne{"no_step", with("step_s = 1e-6", "safety_factor = 0.5"), {place + "modes, which bear any step"}},
        WrongOne{"largest_step",
                 replaced(with("step_s = 1e-6", "largest_step_s = 1e-6"),
                          "implicit_length_m = { lower = 0.01, upper = 0.01 }", "rule = \"auto\""),
                 {"modes, which bear any step", "time.step_s"}},
        WrongOne{"gravity", upper("gravity_m_s2 = [0.0, -9.81]"), {"found modes of a body with gravity_m_s2"}},
        WrongOne{"large_rotation", upper("large_rotation = true"), {"found modes of a body with large_rotation"}},
        WrongOne{"traction",
                 upper("traction = [{ surface = \"end\", pressure_pa = 1e5 }]"),
                 {"found modes of a body with traction", "no reduced_modes for \"upper\""}},
        WrongOne{"prescribed",
                 upper("prescribed = [{ surface = \"end\", component = \"y\", displacement_m = 1e-5 }]"),
                 {"found modes of a body with prescribed"}},
        WrongOne{"absorbing",
                 upper("absorbing = [{ surface = \"end\", wave = \"bar\" }]"),
                 {"found modes of a body with absorbing"}},
        WrongOne{"initial_displacement",
                 upper("initial_displacement_m = { start = [0.0, 0.0], end = [0.0, 1e-5] }"),
                 {"found modes of a body with initial_displacement_m"}},
        WrongOne{"plasticity",
                 with("{ upper = 12 }", "{ lower = 12 }")
                     .replace(plates_of_modes.find("density_kg_m3 = 1000.0 }"), 24,
                              "density_kg_m3 = 1000.0, plasticity = { yield_stress_pa = 1e6, hardening_pa = 1e6 } }"),
                 {"found modes of a body with plasticity"}},
        WrongOne{"no_layer_at_the_contact",
                 with("upper = 0.01 }", "upper = 0 }"),
                 {place + "no implicit element at the contact node at", "a longer partition.implicit_length_m"}},
        WrongOne{"in_one_with_others",
                 listed("[\"lower\", \"upper\"]", ""),
                 {"\"upper\" with partition.reduced_modes and \"lower\" without"}},
        WrongOne{"a_program_of_ones_own",
                 listed("[\"upper\"]", "executable = \"bin/mine\"\n"),
                 {"executable: found", "only with bodies without partition.reduced_modes"}},
        WrongOne{"ranks", listed("[\"upper\"]", "ranks = 2\n"), {"ranks: found 2"}}),
    [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace ricochet::scene

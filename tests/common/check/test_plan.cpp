#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>

#include "common/base/error.hpp"
#include "common/check/check.hpp"
#include "common/problem/critical_step.hpp"
#include "tests/common/scene/scene_text.hpp"
#include "tests/support/dome_mesh.hpp"
#include "tests/support/scene_file.hpp"

namespace ricochet::scene {
namespace {

using testing::HasSubstr;

const double bar_speed = std::sqrt(206.8e9 / 7844.066);
const double bar_element = 0.254 / 20.0;

Plan plan_of(const std::string& text) { return plan(build_problem(load_text(text))); }

double step_of(const std::string& text) { return build_problem(load_text(text)).clock.size_s(); }

std::string text_of_plan(const std::string& text) {
  const auto problem = build_problem(load_text(text));
  return to_text(problem, plan(problem));
}

std::string with_penalty(double penalty_pa_m) {
  const std::string keys = fmt::format("enforcement = \"penalty\"\npenalty_pa_m = {:.17g}\n", penalty_pa_m);
  return replaced(bars, "surfaces", keys + "surfaces");
}

std::string penalty_bars(double alpha_over_k, double step_s, const std::string& protocol) {
  // alpha_n = alpha A and k = E A / h, so alpha = (alpha_n/k) E / h.
  const std::string text = with_penalty(alpha_over_k * 206.8e9 / bar_element);
  return replaced(text, "2.226e-6", fmt::format("{:.17g}", step_s)) + "[coupling]\nprotocol = \"" + protocol + "\"\n";
}

/// docs/limits.md, 3: (h/c) sqrt(2 / (1 + sqrt(1 + (s alpha/k)^2))), s = 2 for two deformable bodies.
double penalty_limit(double alpha_over_k, double sides) {
  return bar_element / bar_speed * std::sqrt(2.0 / (1.0 + std::sqrt(1.0 + std::pow(sides * alpha_over_k, 2))));
}

TEST(Plan, FindsNoCriticalStepThatTheStepWasFoundFrom) {
  const std::string text = replaced(bars, "step_s = 2.226e-6", "safety_factor = 0.8");
  auto problem = build_problem(load_text(text));
  ASSERT_EQ(problem.critical_time_steps_s.size(), 2U);
  const double critical_s = critical_time_step(plan_participants(problem));
  EXPECT_EQ(problem.clock.size_s(), 0.8 * critical_s);
  problem.critical_time_steps_s[1] = 0.5 * critical_s;
  EXPECT_EQ(critical_time_step(plan_participants(problem)), 0.5 * critical_s) << "it was found anew";
  problem.critical_time_steps_s.clear();
  EXPECT_EQ(critical_time_step(plan_participants(problem)), critical_s) << "found anew it is another";
}

TEST(Plan, CountsWhatEachParticipantOwns) {
  const Plan result = plan_of(cylinders);
  ASSERT_EQ(result.participants.size(), 2U);
  const ParticipantPlan &e = result.participants[0], &i = result.participants[1];
  EXPECT_EQ(e.role, Role::explicit_solver);
  EXPECT_EQ(e.elements, 64 - 20);
  EXPECT_EQ(e.nodes, 7 * 5 + 6 * 5);
  EXPECT_EQ(e.interface_nodes, 10);
  EXPECT_EQ(e.unknowns, 2 * 55 - 11);  // without the shared nodes and u_r on the axis
  EXPECT_EQ(i.elements, 20);
  EXPECT_EQ(i.nodes, 3 * 5 + 4 * 5);
  EXPECT_EQ(i.unknowns, 2 * 35 - 7);
  EXPECT_TRUE(std::isinf(i.critical_time_step_s));
  EXPECT_EQ(result.contact_pairs, 5);
  EXPECT_EQ(result.windows, 100);
  EXPECT_EQ(step_of(cylinders), 1e-7);
  EXPECT_TRUE(result.warnings.empty());
}

TEST(CriticalStep, OfABarIsElementSizeOverWaveSpeed) {
  const Plan result = plan_of(bars + "[coupling]\nprotocol = \"all_explicit\"\n");
  EXPECT_NEAR(result.participants.at(0).critical_time_step_s, bar_element / bar_speed, 1e-8 * bar_element / bar_speed);
}

TEST(CriticalStep, WithSharedMassesIsNoSmaller) {
  // The shared node carries both halves of its mass, which only lowers the highest frequency of the explicit part.
  const double step = plan_of(bars).participants.at(0).critical_time_step_s;
  EXPECT_GT(step, bar_element / bar_speed);
  EXPECT_LT(step, 1.01 * bar_element / bar_speed);
}

TEST(CriticalStep, DoesNotDependOnTheImplicitPart) {
  // Contact zone of the right bar meshed 100 times finer: implicit, so the step stays that of the coarse bar.
  const std::string graded = replaced(bars, "start_m = 0.508e-3, length_m = 0.254, elements = 20",
                                      "start_m = 0.508e-3, length_m = 0.254, elements = 60, grading = 100.0");
  const std::string automatic =
      replaced(graded, "implicit_length_m = { left = 0.0635, right = 0.0635 }", "rule = \"auto\"");
  EXPECT_GT(plan_of(automatic).participants.at(0).critical_time_step_s, 2.226e-6);
}

TEST(SafetyFactor, IsAShareOfTheCriticalStep) {
  const std::string text = replaced(bars, "step_s = 2.226e-6", "safety_factor = 0.5");
  const Plan hybrid = plan_of(text);
  EXPECT_DOUBLE_EQ(step_of(text), 0.5 * hybrid.participants[0].critical_time_step_s);
  const double limit = bar_element / bar_speed;
  EXPECT_NEAR(step_of(text + "[coupling]\nprotocol = \"all_explicit\"\n"), 0.5 * limit, 1e-8 * limit);
  EXPECT_NEAR(step_of(text + "[coupling]\nprotocol = \"all_implicit\"\n"), 0.5 * limit, 1e-8 * limit);
}

TEST(CriticalStep, IsTheEdgeOfWhatIsAccepted) {
  const double limit = plan_of(bars).participants[0].critical_time_step_s;
  const auto with_step = [](double step) { return replaced(bars, "2.226e-6", fmt::format("{:.17g}", step)); };
  EXPECT_TRUE(plan_of(with_step(0.949 * limit)).warnings.empty());
  EXPECT_THAT(plan_of(with_step(0.951 * limit)).warnings, testing::ElementsAre(HasSubstr("from impact to impact")));
  EXPECT_THROW((void)plan_of(with_step(1.001 * limit)), ConfigError);
}

TEST(CriticalStep, RefusalSaysBothTheRatioAndWhatToType) {
  try {
    (void)plan_of(replaced(bars, "2.226e-6", "4.95322e-6"));
    FAIL();
  } catch (const ConfigError& error) {
    for (const char* part : {"time.step_s: found a step of 4.95322e-06 s", "2 times the critical time step 2.4766",
                             "step_s = 2.23e-06 or less"})
      EXPECT_THAT(error.what(), HasSubstr(part));
  }
}

TEST(CriticalStep, BindsStepsOfLater) {
  const std::string changes = "step_s = 2.226e-6\nchanges = [{ from_s = 1e-5, step_s = 4.95322e-6 }]";
  try {
    (void)plan_of(replaced(bars, "step_s = 2.226e-6", changes));
    FAIL();
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.what(), HasSubstr("time.changes: found a step of 4.95322e-06 s, 2 times the critical time step"));
  }
}

TEST(Plan, CountsWindowsOfAllSizes) {
  const auto windows = plan_of(bars).windows;  // 5 of 2.226e-6 end after 1e-5
  const std::string halved = "step_s = 2.226e-6\nchanges = [{ from_s = 1e-5, step_s = 1.113e-6 }]";
  EXPECT_NEAR(static_cast<double>(plan_of(replaced(bars, "step_s = 2.226e-6", halved)).windows),
              2.0 * static_cast<double>(windows) - 5.0, 1.0);
}

TEST(CriticalStep, DoesNotBindTheImplicitBaseline) {
  const std::string text = replaced(bars, "2.226e-6", "1e-5") + "[coupling]\nprotocol = \"all_implicit\"\n";
  EXPECT_NO_THROW((void)plan_of(text));
}

/// Two elements in each bar, one of them implicit: the shared node's mass counts both, the explicit critical step but
/// one.
std::string two_elements(const std::string& text) {
  std::string coarse = replaced(replaced(text, "elements = 20", "elements = 2"), "elements = 20", "elements = 2");
  coarse = replaced(coarse, "{ left = 0.0635, right = 0.0635 }", "{ left = 0.127, right = 0.127 }");
  return replaced(coarse, "step_s = 2.226e-6", "safety_factor = 0.9");
}

TEST(SwitchToExplicit, NeedsTheCriticalStepOfTheWholeBody) {
  const Plan coarse = plan_of(two_elements(bars));
  // Explicit: omega^2 = k (1/(m/2) + 1/m) = 3 k/m, the shared node with the mass of both elements. The whole bar: 4
  // k/m.
  EXPECT_NEAR(step_of(two_elements(bars)), 0.9 * 2.0 / std::sqrt(3.0) * 0.127 / bar_speed,
              1e-6 * step_of(two_elements(bars)));
  EXPECT_THAT(coarse.switch_obstacle, testing::AllOf(HasSubstr("body \"left\" together"), HasSubstr("2.473")));
  EXPECT_THAT(coarse.notes,
              testing::Contains(HasSubstr("stays implicit after separation: explicit and implicit elements")));
  EXPECT_EQ(plan_of(bars).switch_obstacle, "");
}

/// Whether it can, only it can say.
TEST(Checkpoints, AProgramOfOnesOwnIsNamedIfTheyAreAskedFor) {
  const std::string text = bars +
                           "[[participant]]\nname = \"mine\"\nrole = \"explicit\"\nbodies = [\"left\", \"right\"]\n"
                           "executable = \"./bar\"\n[[participant]]\nname = \"implicit\"\nrole = \"implicit\"\n";
  EXPECT_THAT(plan_of(text + "[checkpoint]\n").notes,
              testing::Contains(HasSubstr("checkpoints need the capability \"save_state\" of participant 'mine'")));
  EXPECT_THAT(plan_of(text).notes, testing::Not(testing::Contains(HasSubstr("checkpoints"))));
}

TEST(SwitchToExplicit, IsNotSpokenOfWhereNobodyAsksForIt) {
  const std::string text = two_elements(bars) + "[coupling]\n";
  EXPECT_EQ(plan_of(text + "after_separation = \"implicit\"\n").switch_obstacle, "");
  EXPECT_EQ(plan_of(text + "protocol = \"belytschko_mullen\"\n").switch_obstacle, "");
  EXPECT_EQ(plan_of(text + "protocol = \"all_implicit\"\n").switch_obstacle, "");
}

TEST(ExplicitPenalty, CriticalStepIsTheFormulaForTwoBars) {
  for (const double ratio : {0.1, 1.0, 2.0, 10.0}) {
    const Problem problem = build_problem(load_text(penalty_bars(ratio, 1e-8, "all_explicit")));
    // The formula is of bars without far ends: with a soft penalty the mode still reaches them.
    EXPECT_NEAR(penalty_critical_time_step(problem) / penalty_limit(ratio, 2.0), 1.0, 1e-5) << ratio;
  }
}

TEST(ExplicitPenalty, CriticalStepIsTheFormulaAgainstAPlane) {
  const std::string text = replaced(penalty_bars(2.0, 1e-8, "all_explicit"), "\"right.start\"", "\"rigid_plane\"");
  const Problem problem = build_problem(load_text(replaced(text, ", right = 0.0635", "")));
  EXPECT_NEAR(penalty_critical_time_step(problem) / penalty_limit(2.0, 1.0), 1.0, 1e-6);
}

TEST(ExplicitPenalty, IsRefusedAboveAndWarnedAboveHalfOfIt) {
  const double limit = penalty_limit(2.0, 2.0);
  EXPECT_THROW((void)plan_of(penalty_bars(2.0, 1.001 * limit, "all_explicit")), ConfigError);
  const Plan close = plan_of(penalty_bars(2.0, 0.99 * limit, "all_explicit"));
  EXPECT_THAT(close.warnings, testing::ElementsAre(HasSubstr("opens and closes")));
  EXPECT_NEAR(close.penalty_critical_s, limit, 1e-6 * limit);
  EXPECT_TRUE(plan_of(penalty_bars(2.0, 0.49 * limit, "all_explicit")).warnings.empty());
}

/// Two blocks that face each other node by node, with flat ends that rise along y; their far sides are held along one
/// coordinate. `keys`: of the contact.
std::string sloping_blocks(const test::TemporaryFolder& folder, const std::string& held, const std::string& keys) {
  constexpr double flat_m = 1e9;
  std::string text = "model = \"solid\"\n";
  for (const bool lower : {true, false}) {
    const std::string body = lower ? "lower" : "upper";
    const test::DomeMesh block{.radius_m = flat_m, .start_m = lower ? -0.004 : 0.0, .up = lower, .slope_y = 0.2};
    text += fmt::format(
        "[[body]]\nname = \"{0}\"\nmaterial = {{ youngs_modulus_pa = 48e9, poisson_ratio = 0.2, density_kg_m3 = "
        "2800.0 }}\nmesh = {{ gmsh = \"{1}\" }}\ninitial_velocity_m_s = [0.0, 0.0, {2:.1f}]\n[[body.support]]\n"
        "surface = \"rest\"\nfixed = [\"{3}\"]\n",
        body, folder.write(test::dome_msh(body, block), body + ".msh"), lower ? 2.0 : -2.0, held);
  }
  return text + "[contact]\nsurfaces = [\"lower.cap\", \"upper.cap\"]\n" + keys +
         "[partition]\nimplicit_length_m = { lower = 0.0014, upper = 0.0014 }\n[time]\nstep_s = 1e-7\nend_s = 2e-6\n";
}

/// Laws by pairs of nodes do not know that such a pair's forces move each other.
TEST(SupportsAskewToAContact, AreRefusedWithFrictionUnderLawsOfPairs) {
  const test::TemporaryFolder folder;
  const std::string friction = "friction_coefficient = 0.3\n", massless = "multiplier_update = \"massless\"\n",
                    impedance = "enforcement = \"penalty\"\npenalty_pa_m = 1e12\nimpact_update = \"impedance\"\n";
  for (const auto& law : {massless, impedance}) {
    try {
      (void)plan_of(sloping_blocks(folder, "y", law + friction));
      ADD_FAILURE() << law;
    } catch (const ConfigError& error) {
      EXPECT_THAT(
          std::string(error.what()),
          testing::AllOf(HasSubstr("friction_coefficient: the contact node "), HasSubstr(" of body 'lower' at "),
                         HasSubstr("is held along a coordinate that is neither along the normal nor along"),
                         HasSubstr("multiplier_update = \"trapezoidal_reset\"")));
    }
    EXPECT_NO_THROW((void)plan_of(sloping_blocks(folder, "y", law))) << "no friction: " << law;
    EXPECT_NO_THROW((void)plan_of(sloping_blocks(folder, "x", law + friction))) << "along the tangent: " << law;
  }
  EXPECT_NO_THROW((void)plan_of(sloping_blocks(folder, "y", friction)));
}

TEST(ImplicitPenalty, WarnsWhereTheTrapezoidalRuleGainsEnergy) {
  // End node m = rho A h/2, alpha = q k: sqrt(2 alpha/m) dt = 2 sqrt(q) c dt / h.
  const double q = 10.0, step = 0.9 * bar_element / bar_speed;
  const Plan stiff = plan_of(penalty_bars(q, step, "hughes_liu"));
  EXPECT_NEAR(stiff.penalty_step_ratio, 2.0 * std::sqrt(q) * 0.9, 1e-9);
  EXPECT_NEAR(stiff.penalty_stiffness_ratio, q, 1e-9);
  EXPECT_THAT(stiff.warnings, testing::ElementsAre(HasSubstr("creates energy at every impact")));
  const std::string updated = "impact_update = \"mass\"\nsurfaces";
  EXPECT_TRUE(plan_of(replaced(penalty_bars(q, step, "hughes_liu"), "surfaces", updated)).warnings.empty());
  EXPECT_TRUE(plan_of(penalty_bars(0.2, step, "hughes_liu")).warnings.empty());
}

TEST(Penalty, ReportsTheDelayOfTheRelease) {
  // The published set: alpha = 1.31339e9 N/m makes the release 16.8 % of the contact time late.
  const std::string published = with_penalty(1.31339e9 / 6.4516e-4);
  EXPECT_NEAR(plan_of(published).penalty_delay_s / (2.0 * 0.254 / bar_speed), 0.168, 5e-4);
  EXPECT_THAT(text_of_plan(published), HasSubstr("too long (1.678 tau)"));
}

TEST(Warnings, UnstableProtocolNearlyIncompressibleAndRegularisedFriction) {
  EXPECT_THAT(plan_of(replaced(cylinders, "hughes_liu", "kim_predicted")).warnings,
              testing::ElementsAre(HasSubstr("unstable at almost any step")));
  const std::string soft = replaced(cylinders, "poisson_ratio = 0.3", "poisson_ratio = 0.495");
  const Plan locking = plan_of(replaced(soft, "1e-7", "1e-8"));
  EXPECT_THAT(locking.warnings, testing::ElementsAre(HasSubstr("nearly incompressible")));
  const std::string regularised =
      replaced(cylinders, "friction_coefficient = 0.1", "friction_coefficient = 0.1\nfriction_law = \"regularised\"");
  // mu N dt/(2 m) = mu p dt/(rho h) with p = 963 MPa at 30 m/s: 0.49 m/s, against 10/xi = 10 m/s.
  EXPECT_THAT(plan_of(regularised).warnings, testing::ElementsAre(HasSubstr("creeps")));
  const std::string fast = replaced(regularised, "30.0", "1000.0");
  EXPECT_THAT(plan_of(fast).warnings, testing::ElementsAre(HasSubstr("creeps"), HasSubstr("strains body \"steel\""),
                                                           HasSubstr("strains body \"carbide\"")));
  const std::string penalty =
      replaced(fast, "friction_law", "enforcement = \"penalty\"\npenalty_pa_m = 1e12\nfriction_law");
  EXPECT_THAT(plan_of(penalty).warnings, testing::Contains(HasSubstr("mu N dt/(2 m) = 16.3")));
}

TEST(PlanText, HoldsEveryNumber) {
  const std::string text = text_of_plan(cylinders);
  for (const char* part : {"explicit", "implicit", "critical step [s]", "step 1e-07 s", "100 steps", "5 contact pairs"})
    EXPECT_THAT(text, HasSubstr(part));
  EXPECT_THAT(text_of_plan(replaced(cylinders, "hughes_liu", "kim_predicted")), HasSubstr("warning: protocol"));
}

}  // namespace
}  // namespace ricochet::scene

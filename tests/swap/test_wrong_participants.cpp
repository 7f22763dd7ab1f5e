// A program in the place of a shipped solver with one thing about it that is wrong: a run of it is refused, or
// stopped, with the name of who is wrong and of what. Each one's fault is in tests/support/wrong_participant.cpp.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>
#include <sstream>

#include "tests/support/places.hpp"
#include "tests/support/run.hpp"

namespace ricochet::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

std::string wrong_program() { return build_folder() + "/wrong_participant"; }

std::string participants_of(const std::string& bodies, const std::string& flaw, const std::string& keys) {
  return fmt::format(
      "\n[[participant]]\nname = \"{}\"\nrole = \"explicit\"\nbodies = [{}]\nexecutable = \"{}\"\n{}\n[[participant]]\n"
      "name = \"implicit\"\nrole = \"implicit\"\n",
      flaw, bodies, wrong_program(), keys);
}

/// Two bars, or the first windows of the paper's impact, which is axisymmetric.
std::string bars_by(const std::string& flaw, const std::string& protocol = "hughes_liu", const std::string& keys = "") {
  return with_protocol(config_text("two_bars"), protocol) + participants_of("\"left\", \"right\"", flaw, keys);
}
std::string cylinders_by(const std::string& flaw, const std::string& protocol = "hughes_liu",
                         const std::string& keys = "") {
  std::string text = with_protocol(config_text("kim_impact"), protocol);
  text = replaced(text, "until_separated_plus_s = 10e-6\n", "");
  text = with_key(text, "time", "end_s", "10.8e-6");
  text = replaced(text, "fields_every = 50", "fields_every = 0");
  return text + participants_of("\"steel\", \"carbide\"", flaw, keys);
}
/// The same with the implicit solver in its place.
std::string cylinders_by_implicit(const std::string& flaw) {
  return replaced(replaced(cylinders_by("explicit"), fmt::format("executable = \"{}\"\n", wrong_program()), ""),
                  "name = \"implicit\"\nrole = \"implicit\"\n",
                  fmt::format("name = \"{}\"\nrole = \"implicit\"\nexecutable = \"{}\"\n", flaw, wrong_program()));
}
std::string with_steps(const std::string& text, int substeps) {
  return with_key(text, "coupling", "substeps", std::to_string(substeps));
}
/// Coarser windows for as many substeps, which keeps the steps.
std::string bars_in_two_steps_by(const std::string& flaw, const std::string& keys = "") {
  return with_key(with_steps(bars_by(flaw, "prakash_hjelmstad", keys), 2), "time", "step_s", "4.452e-6");
}

/// The momenta of two equal bars that are equally wrong would cancel.
std::string left_bar_in_two_steps_by(const std::string& flaw, const std::string& keys) {
  return replaced(bars_in_two_steps_by(flaw, keys), "bodies = [\"left\", \"right\"]", "bodies = [\"left\"]") +
         "[[participant]]\nname = \"other\"\nrole = \"explicit\"\nbodies = [\"right\"]\n";
}

/// A bar under its own weight, held at the explicit end, from rest; above it one that waits.
std::string hanging_bar_by(const std::string& flaw) {
  return with_protocol(
             "model = \"bar\"\n[[body]]\nname = \"left\"\nmaterial = { youngs_modulus_pa = 200e9, density_kg_m3 = "
             "7800.0 "
             "}\narea_m2 = 1e-4\nmesh = { start_m = 0.0, length_m = 0.1, elements = 10 }\ngravity_m_s2 = [-9.81]\n"
             "support = [{ surface = \"start\", fixed = [\"x\"] }]\n[[body]]\nname = \"right\"\nmaterial = { "
             "youngs_modulus_pa = 200e9, density_kg_m3 = 7800.0 }\narea_m2 = 1e-4\nmesh = { start_m = 0.1001, length_m "
             "= "
             "0.1, elements = 10 }\n[contact]\nsurfaces = [\"left.end\", \"right.start\"]\n[partition]\n"
             "implicit_length_m = { left = 0.03, right = 0.1 }\n[time]\nstep_s = 1.5e-6\nend_s = 120e-6\n[coupling]\n",
             "hughes_liu") +
         participants_of("\"left\"", flaw, "");
}

struct Misuse {
  const char* flaw;
  std::string scene;
  int code;
  std::vector<std::string> words;
};

void PrintTo(const Misuse& misuse, std::ostream* out) { *out << misuse.flaw; }

class WrongParticipants : public testing::TestWithParam<Misuse> {};

TEST_P(WrongParticipants, AreFoundOut) {
  const auto& misuse = GetParam();
  TemporaryFolder folder;
  const auto run = run_file(folder.write(misuse.scene), folder);
  EXPECT_EQ(run.outcome.code, misuse.code) << run.outcome.error;
  EXPECT_THAT(run.outcome.error, HasSubstr(fmt::format("participant '{}'", misuse.flaw)));
  for (const auto& words : misuse.words) EXPECT_THAT(run.outcome.error, HasSubstr(words));
}

const std::string opt_out = "add differing_bodies = [\"";

INSTANTIATE_TEST_SUITE_P(
    InARun, WrongParticipants,
    testing::Values(
        Misuse{"interface_heavier",
               cylinders_by("interface_heavier"),
               2,
               {"interface node ", "its 'interface_mass_kg' is ", "the scene's mesh and density give ",
                "(1.01 times); likely cause: all 11 nodes have 1.01 times their mass", opt_out}},
        Misuse{"interface_twice", bars_by("interface_twice"), 2, {"(2 times); if the body"}},
        Misuse{"heavier", cylinders_by("heavier"), 2, {"all 11 nodes have 1.01 times their mass"}},
        Misuse{"stiffer",
               cylinders_by("stiffer"),
               2,
               {"its internal force P = K u to displacements of some ", "the scene's own elements give ",
                "likely cause: it is 1.01 times what it should be, at every node", opt_out}},
        Misuse{"stiffer", bars_in_two_steps_by("stiffer"), 2, {"its velocity after a window of 2 steps by forces"}},
        Misuse{"per_radian",
               cylinders_by("per_radian"),
               2,
               {"likely cause: it is per radian, it must be that of the full circle"}},
        Misuse{"slower",
               replaced(bars_in_two_steps_by("slower"), "prakash_hjelmstad", "gravouil_combescure"),
               2,
               {"body 'left': its first row of history has momentum_n_kg_m_s/left = ", "initial velocity give ",
                "likely cause: it is 0.99 times what it should be"}},
        Misuse{"reversed_positions",
               cylinders_by("reversed_positions"),
               2,
               {"likely cause: the order of the nodes is reversed"}},
        Misuse{"far_place",
               cylinders_by("far_place"),
               2,
               {"body 'carbide', interface node 21 at (0.005, 0.0151) m: the scene's mesh has no interface node there; "
                "the nearest is at (0.005, 0.015) m, 0.0001 m away, allowed are "}},
        Misuse{"near_place",
               bars_by("near_place"),
               2,
               {"the scene's mesh has no interface node there; the nearest is at (0.064008) m, 1e-09 m away, allowed "
                "are 1.28e-10 m"}},
        Misuse{"in_millimetres",
               cylinders_by("in_millimetres"),
               2,
               {"likely cause: 0.001 times (r, z) of all 22 nodes are places of the scene, which has metres"}},
        Misuse{"swapped_columns",
               cylinders_by("swapped_columns"),
               2,
               {"likely cause: (z, r) of all 22 nodes are places of the scene"}},
        Misuse{"turned", cylinders_by("turned"), 2, {"likely cause: (z, -r) of all 22 nodes are places of the scene"}},
        Misuse{"short_of_a_node",
               cylinders_by("short_of_a_node"),
               2,
               {"body 'carbide': it has no interface node at (0.005, 0.015) m, where the scene's mesh has a shared one "
                "(1 of 11 are missing); allowed: all of them"}},
        Misuse{"lighter",  // and so with another critical step
               cylinders_by("lighter"),
               2,
               {"its 'interface_mass_kg' is ", "all 11 nodes have 0.5 times their mass"}},
        Misuse{
            "owns_nothing",
            cylinders_by_implicit("owns_nothing"),
            2,
            {"(implicit) described 'contact_owner' = false, allowed: true; of the contact of this scene it integrates "
             "the nodes, and nobody else would keep the surfaces apart"}},
        // Flaws that time brings to light.
        Misuse{"never_moves",
               bars_by("never_moves"),
               2,
               {"at the end of window 1 (t = 2.226e-06 s, in which waves go ", "its internal force is ",
                "the scene's own elements give ", " for the same link input", opt_out}},
        Misuse{"never_moves", bars_in_two_steps_by("never_moves"), 2, {"its velocity after a window of 2 steps"}},
        Misuse{"short_steps", bars_by("short_steps"), 2, {"at the end of window ", "its internal force is "}},
        Misuse{"short_steps", cylinders_by("short_steps"), 2, {"at the end of window ", "its internal force is "}},
        Misuse{"long_steps", bars_by("long_steps"), 2, {"at the end of window ", "its internal force is "}},
        Misuse{"two_long_steps", bars_by("two_long_steps", "prakash_hjelmstad"), 2, {"its velocity after a window"}},
        Misuse{"without_gravity",
               hanging_bar_by("without_gravity"),
               2,
               {"at the start its internal force is ", "likely cause: it computes as if there were no gravity"}},
        Misuse{"without_supports",
               hanging_bar_by("without_supports"),
               2,
               {"at the end of window ", "likely cause: it computes as if there were no supports"}},
        Misuse{"wrong_sign", bars_by("wrong_sign"), 2, {"likely cause: its sign is wrong"}},
        Misuse{"pushes",
               cylinders_by_implicit("pushes"),
               2,
               {"component ", ": its acceleration by forces of some ", "likely cause: its sign is wrong"}},
        Misuse{"reversed_rows",
               cylinders_by("reversed_rows"),
               2,
               {"the order of the nodes is reversed in what it answers"}},
        Misuse{"rows_by_component",
               cylinders_by("rows_by_component"),
               2,
               {"likely cause: rows go by component, not by node in what it answers"}},
        Misuse{"long_step",
               bars_by("long_step"),
               2,
               {"participant 'long_step' declares the critical time step 1.",
                "found a step of 2.226e-06 s; allowed: "
                "time.step_s = 1."}},
        Misuse{"one_step",
               bars_in_two_steps_by("one_step"),
               2,
               {"its velocity after a window of 2 steps by forces of some ", "component 0: "}},
        // A participant that may differ is looked after while it computes.
        Misuse{"one_step",
               left_bar_in_two_steps_by("one_step", "differing_bodies = [\"left\"]"),
               3,
               {"wrong in window ", " % of the momentum came from nowhere or got lost, allowed are 20 %",
                "likely cause: participant 'one_step', a program of your own: ", "check-participant --scene ",
                " --name one_step` compares it with ours"}},
        Misuse{"turns_wrong",
               bars_by("turns_wrong"),
               3,
               {"unstable in window ", "likely cause: participant 'turns_wrong', a program of your own: "}}),
    [](const auto& test) { return fmt::format("{}_{}", test.param.flaw, test.index); });

/// A body in Python whose modulus is lower by 30 % from 20 mm behind its interface on.
TEST(WrongParticipant, IsFoundOutWhereAWaveHasToGoFirst) {
  TemporaryFolder folder;
  const std::string python = source_folder() + "/common/participant/python";
  auto text = file_text(python + "/explicit_bar.py");
  text = replaced(text, "import numpy", "import sys; sys.path.insert(0, \"" + python + "\")\nimport numpy");
  text = replaced(
      text, "        self.m = body",
      "        deep = abs(self.x[:-1] + h / 2 - self.x[self.shared]) > 0.02\n"
      "        for e in np.flatnonzero(deep):\n"
      "            self.k[e:e + 2, e:e + 2] -= 0.3 * modulus * body[\"area_m2\"] / h * np.array([[1, -1], [-1, "
      "1]])\n        self.m = body");
  const auto bar = folder.write(text, "soft_bar.py");
  std::filesystem::permissions(bar, std::filesystem::perms::owner_all);
  const std::string scene =
      config_text("two_bars") + fmt::format(
                                    "[[participant]]\nname = \"soft\"\nrole = \"explicit\"\nbodies = [\"left\"]\n"
                                    "executable = \"{}\"\n[[participant]]\nname = \"other\"\nrole = \"explicit\"\n"
                                    "bodies = [\"right\"]\n[[participant]]\nname = \"implicit\"\nrole = \"implicit\"\n",
                                    bar);
  const auto run = run_file(folder.write(scene), folder);
  EXPECT_EQ(run.outcome.code, 2) << run.outcome.error;
  EXPECT_THAT(run.outcome.error, AllOf(HasSubstr("participant 'soft', body 'left', interface node 0"),
                                       HasSubstr("at the end of window "), HasSubstr("its internal force is ")));
  const auto meant = replaced(scene, "bodies = [\"left\"]\n", "bodies = [\"left\"]\ndiffering_bodies = [\"left\"]\n");
  EXPECT_EQ(run_text(meant, folder, "meant").summary.at("status"), "done");
}

/// The sums of what some tell and some do not would accuse who is right.
TEST(WrongParticipant, WhoLeavesColumnsOutIsNamedAndNobodyIsAccused) {
  TemporaryFolder folder;
  const auto strain = run_text(bars_by("tells_no_strain"), folder, "strain");
  const std::string who = "participant 'tells_no_strain' (energy_strain_j/left)";
  EXPECT_THAT(strain.outcome.error, HasSubstr("energy is not told by " + who +
                                              ": its drift is none, and the energy "
                                              "watch does not run"));
  EXPECT_THAT(strain.outcome.out, HasSubstr("energy drift             not told by " + who));
  EXPECT_TRUE(strain.summary.at("energy_error_max").is_null());
  EXPECT_EQ(strain.summary.at("energy_not_told_by"), nlohmann::json({who}));
  EXPECT_LT(strain.summary.at("momentum_error_max").get<double>(), 1e-10);
  EXPECT_TRUE(std::isnan(strain.last("energy_error")));
  const auto momentum = run_text(bars_by("tells_no_momentum"), folder, "momentum");
  EXPECT_THAT(momentum.outcome.out, HasSubstr("momentum error           not told by participant 'tells_no_momentum' "
                                              "(momentum_n_kg_m_s/left)"));
  EXPECT_TRUE(momentum.summary.at("momentum_error_max").is_null());
  // Made by somebody, but it is not known by whom.
  const auto run = run_file(folder.write(bars_by("tells_no_link")), folder);
  EXPECT_EQ(run.outcome.code, 3) << run.outcome.error;
  EXPECT_THAT(run.outcome.error, AllOf(HasSubstr("it grows most in body '"), Not(HasSubstr("is made "))));
}

TEST(WrongParticipant, IsWarnedOfByTheMomentumOfAnExactProtocol) {
  TemporaryFolder folder;
  const auto leaks = run_text(bars_by("leaks"), folder, "leaks");
  EXPECT_GT(leaks.summary.at("momentum_error_max").get<double>(), 1e-6);
  EXPECT_THAT(
      leaks.outcome.error,
      AllOf(HasSubstr(" % of the momentum came from nowhere or got lost, protocol hughes_liu keeps it to rounding"),
            HasSubstr("participant 'leaks', a program of your own: `ricochet check-participant")));
  EXPECT_THAT(leaks.outcome.out, HasSubstr("keeps it to rounding"));
  EXPECT_THAT(run_text(bars_by("right"), folder, "right").outcome.error, Not(HasSubstr("of the momentum")));
  EXPECT_THAT(run_text(bars_by("right", "kim"), folder, "kim").outcome.error, Not(HasSubstr("of the momentum")))
      << "its momentum sways by itself";
}

TEST(WrongParticipant, IsToldDirectionsAndTheScenesPlaces) {
  TemporaryFolder folder;
  const auto run = run_text(cylinders_by("tells_what_it_is_told"), folder);
  EXPECT_THAT(file_text(run.folder + "/logs/tells_what_it_is_told.log"), HasSubstr("directions 0 1 -1 0; places 0 "));
}

/// Exactly what the scene says is let through, and so is what is meant to differ.
TEST(WrongParticipant, IsLetThroughIfItIsRightOrMeantToDiffer) {
  TemporaryFolder folder;
  const auto right = run_text(cylinders_by("right"), folder, "right");
  EXPECT_EQ(right.summary.at("status"), "done");
  run_text(bars_by("heavier", "hughes_liu", "differing_bodies = [\"left\", \"right\"]"), folder, "heavier");
  run_text(bars_in_two_steps_by("right"), folder, "steps");
}

TEST(WrongParticipant, LosesTheEnergyThatTheSceneAllows) {
  TemporaryFolder folder;
  const std::string may_differ = "differing_bodies = [\"left\", \"right\"]";
  const auto text = with_key(bars_by("heavier", "hughes_liu", may_differ), "coupling", "energy_loss_limit", "1e-9");
  const auto run = run_file(folder.write(text), folder);
  EXPECT_EQ(run.outcome.code, 3) << run.outcome.error;
  EXPECT_THAT(run.outcome.error, AllOf(HasSubstr(" % of the energy got lost (coupling.energy_loss_limit = 1e-07 %)"),
                                       HasSubstr("likely cause: participant 'heavier', a program of your own")));
}

TEST(WrongParticipant, MayTakeLongerToStart) {
  TemporaryFolder folder;
  const auto text = with_key(bars_by("late"), "coupling", "timeout_s", "1");
  const auto refused = run_file(folder.write(text), folder);
  EXPECT_EQ(refused.outcome.code, 4);
  EXPECT_THAT(refused.outcome.error, HasSubstr("(asked to 'initialize', coupling.timeout_s = 1 s)"));
  const auto patient = run_text(with_key(text, "coupling", "start_timeout_s", "60"), folder, "patient");
  EXPECT_EQ(patient.summary.at("status"), "done");
  const auto hasty = run_file(folder.write(with_key(text, "coupling", "start_timeout_s", "1.5")), folder);
  EXPECT_THAT(hasty.outcome.error, HasSubstr("(asked to 'initialize', coupling.start_timeout_s = 1.5 s)"));
}

Outcome check_beside_ours(const TemporaryFolder& folder, const std::string& scene, const std::string& name) {
  return run_command({ricochet_binary(), "check-participant", "--scene", folder.write(scene), "--name", name},
                     folder.path().string(), 120.0);
}

struct Beside {
  const char* flaw;
  std::string scene;
  std::vector<std::string> words;
};

void PrintTo(const Beside& beside, std::ostream* out) { *out << beside.flaw; }

class BesideTheShippedSolver : public testing::TestWithParam<Beside> {};

TEST_P(BesideTheShippedSolver, WhatIsWrongIsNamed) {
  const auto& test = GetParam();
  TemporaryFolder folder;
  const auto outcome = check_beside_ours(folder, test.scene, test.flaw);
  EXPECT_EQ(outcome.code, 5) << outcome.out << outcome.error;
  for (const auto& words : test.words) EXPECT_THAT(outcome.out, HasSubstr(words));
}

INSTANTIATE_TEST_SUITE_P(
    Clauses, BesideTheShippedSolver,
    testing::Values(
        Beside{"interface_heavier",
               cylinders_by("interface_heavier"),
               {"FAILED   declares the scene's own masses and places: participant 'interface_heavier', body"}},
        Beside{"stiffer",
               cylinders_by("stiffer"),
               {"passed   declares the scene's own masses and places", "FAILED   answers as the scene's own elements: ",
                "FAILED   computes what the shipped solver does: window 1, body '", "component ",
                "internal force [N] is ", ", the shipped solver's ", " of the largest"}},
        Beside{"slower", bars_by("slower"), {"FAILED   computes what the shipped solver does: window "}},
        Beside{"wrong_sign",
               bars_by("wrong_sign"),
               {"FAILED   answers unit inputs by a symmetric, positive matrix: its internal force has the wrong sign: "
                "P = K u is positive where it resists"}},
        Beside{"reversed_rows",
               cylinders_by("reversed_rows"),
               {"FAILED   answers unit inputs by a symmetric, positive matrix: its internal force at interface node ",
                "the other way round", "its rows are in another order than the nodes"}},
        Beside{"rows_by_component",
               cylinders_by("rows_by_component"),
               {"FAILED   answers unit inputs by a symmetric, positive matrix: "}},
        Beside{"is_not_linear",
               cylinders_by("is_not_linear"),
               {"-        answers unit inputs by a symmetric, positive matrix: its internal force is not linear, by ",
                "belytschko_mullen and dual protocols with substeps > 1 will refuse it"}},
        Beside{"one_step",
               bars_in_two_steps_by("one_step"),
               {"FAILED   driven by force it takes the steps of a window: window 1, interface node 0: ",
                "driven by force with m = 2 steps in a window; after 2 windows of one step"}},
        Beside{"skips_a_substep",
               bars_in_two_steps_by("skips_a_substep"),
               {"FAILED   single steps of a window end like the whole: "}},
        Beside{
            "one_pulls",
            bars_by("one_pulls"),
            {"FAILED   answers unit inputs by a symmetric, positive matrix: its internal force is not positive: some "
             "input meets a resistance of -1, in units of the largest entry"}},
        Beside{"pushes",
               cylinders_by_implicit("pushes"),
               {"FAILED   answers unit inputs by a symmetric, positive matrix: minus its acceleration has the wrong "
                "sign: the link input L acts with a minus"}},
        Beside{"ignores_stiffness",
               cylinders_by_implicit("ignores_stiffness"),
               {"FAILED   a stiffness on its interface acts like its force: window 1, ",
                "with a stiffness S on the interface; given the force S u itself "}},
        Beside{"stays_implicit",
               cylinders_by_implicit("stays_implicit"),
               {"FAILED   integrates by central differences when it is asked to: window ",
                "by central differences it is"}},
        Beside{"stays_loaded",
               bars_by("stays_loaded"),
               {"FAILED   loads and tells its motion: number 0 of ", "is not linear in what was loaded: "}},
        Beside{
            "tells_more_energy",
            bars_by("tells_more_energy"),
            {"FAILED   computes what the shipped solver does: window ", "history column ", ", the shipped solver's "}},
        Beside{"loads_nothing",
               bars_by("loads_nothing"),
               {"FAILED   loads and tells its motion: number 0 of ", "of its state: loaded ", ", read back "}}),
    [](const auto& test) { return std::string(test.param.flaw); });

TEST(BesideTheShippedSolver, WhatIsRightPasses) {
  TemporaryFolder folder;
  for (const auto& scene : {cylinders_by("right"), bars_in_two_steps_by("right")}) {
    const auto outcome = check_beside_ours(folder, scene, "right");
    EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.error;
    EXPECT_THAT(outcome.out, AllOf(HasSubstr("passed   declares the scene's own masses and places"),
                                   HasSubstr("passed   answers as the scene's own elements"),
                                   HasSubstr("passed   computes what the shipped solver does: "),
                                   HasSubstr("passed   driven by force it takes the steps of a window: m = 1, 2, 4"),
                                   HasSubstr("passed   loads and tells its motion"),
                                   HasSubstr("not tried: loads, supports and contact of a whole run")));
  }
}

/// The implicit solver has clauses of its own; beside itself it is equal.
TEST(BesideTheShippedSolver, TheImplicitOneIsTriedToo) {
  TemporaryFolder folder;
  const auto outcome = check_beside_ours(folder, cylinders_by("right"), "implicit");
  EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.error;
  EXPECT_THAT(outcome.out, AllOf(HasSubstr("passed   a stiffness on its interface acts like its force"),
                                 HasSubstr("passed   integrates by central differences when it is asked to"),
                                 HasSubstr("-        answers as the scene's own elements: it is implicit"),
                                 HasSubstr("passed   computes what the shipped solver does")));
}

/// A spring that knows no body of the scene.
TEST(BesideTheShippedSolver, WhatIsAnotherBodyIsSaid) {
  TemporaryFolder folder;
  const auto check = [&](const std::string& scene, const std::string& name) {
    return run_command({ricochet_binary(), "check-participant", "--scene", folder.write(scene), "--name", name, "--",
                        build_folder() + "/flawed_participant", "sound"},
                       folder.path().string(), 120.0);
  };
  const auto plane = check(cylinders_by("right"), "right");
  EXPECT_EQ(plane.code, 5);
  EXPECT_THAT(plane.out, AllOf(HasSubstr("masses and places: it has 1 components per node, the scene has 2"),
                               HasSubstr("-        answers as the scene's own elements: its interface is another"),
                               HasSubstr("it has 1 interface nodes of 1 components, the shipped solver 22 of 2")));
  const auto bar = check(left_bar_in_two_steps_by("right", ""), "right");
  EXPECT_THAT(bar.out, AllOf(HasSubstr("body 'rod', interface node 0 at (0) m: the scene has no such body"),
                             HasSubstr("FAILED   computes what the shipped solver does: ")));
  const auto other =
      check_beside_ours(folder, bars_by("heavier", "hughes_liu", "differing_bodies = [\"left\"]"), "heavier");
  EXPECT_THAT(other.out, HasSubstr("-        computes what the shipped solver does: the scene says that "
                                   "differing_bodies of participant 'heavier' are other models"));
}

TEST(BesideTheShippedSolver, BothOptionsAreNeeded) {
  TemporaryFolder folder;
  const auto half = run_command({ricochet_binary(), "check-participant", "--name", "right"}, folder.path().string());
  EXPECT_EQ(half.code, 2);
  EXPECT_THAT(half.error, HasSubstr("--scene and --name: found one of them, allowed: both, or none"));
}

/// A body in Python that goes wrong in a window.
TEST(WrongParticipant, InPythonLeavesItsTraceback) {
  TemporaryFolder folder;
  const std::string python = source_folder() + "/common/participant/python";
  auto text = file_text(python + "/explicit_bar.py");
  text = replaced(text, "import numpy", "import sys; sys.path.insert(0, \"" + python + "\")\nimport numpy");
  text = replaced(text, "    def accept(self):\n", "    def accept(self):\n        self.nothing[3] += 1\n");
  const auto bar = folder.write(text, "careless_bar.py");
  std::filesystem::permissions(bar, std::filesystem::perms::owner_all);
  const std::string scene =
      config_text("two_bars") + fmt::format(
                                    "[[participant]]\nname = \"careless\"\nrole = \"explicit\"\nbodies = [\"left\"]\n"
                                    "executable = \"{}\"\n[[participant]]\nname = \"other\"\nrole = \"explicit\"\n"
                                    "bodies = [\"right\"]\n[[participant]]\nname = \"implicit\"\nrole = \"implicit\"\n",
                                    bar);
  const auto run = run_file(folder.write(scene), folder);
  EXPECT_EQ(run.outcome.code, 4);
  EXPECT_THAT(
      run.outcome.error,
      AllOf(HasSubstr("participant 'careless' failed "),
            HasSubstr("AttributeError: 'ExplicitBar' object has no attribute 'nothing' (careless_bar.py, line "),
            HasSubstr(", in accept)"), Not(HasSubstr(": window 1: "))));
  EXPECT_THAT(file_text(run.folder + "/logs/careless.log"),
              AllOf(HasSubstr("Traceback (most recent call last)"), HasSubstr("self.nothing[3] += 1")));
}

}  // namespace
}  // namespace ricochet::test

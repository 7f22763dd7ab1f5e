// A second solver that nobody here wrote: SfePy reads meshes, assembles and integrates; common/participant/python has
// the programs by which it takes part.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <filesystem>
#include <sstream>

#include "tests/support/places.hpp"
#include "tests/support/run.hpp"
#include "tests/support/same_history.hpp"
#include "tests/support/same_results.hpp"

namespace ricochet::test {
namespace {

const std::string sfepy_folder = source_folder() + "/common/participant/python/";
const std::string sfepy_body = sfepy_folder + "sfepy_body.py", sfepy_integrator = sfepy_folder + "sfepy_integrator.py";

/// configs/striker_gmsh.toml for some time, each body's explicit elements by a program; empty for ours.
std::string striker_by(const std::string& protocol, int substeps, const std::string& striker,
                       const std::string& anvil) {
  std::string text = with_protocol(with_absolute_meshes(config_text("striker_gmsh")), protocol);
  text = replaced(text, "until_separated_plus_s = 5e-6\n", "");
  text = with_key(with_key(text, "time", "end_s", "4e-6"), "output", "fields_every", "0");
  if (substeps > 1) text = with_key(text, "coupling", "substeps", std::to_string(substeps));
  for (const auto& [body, program] : {std::pair{"striker", striker}, {"anvil", anvil}}) {
    text += fmt::format("[[participant]]\nname = \"of_{0}\"\nrole = \"explicit\"\nbodies = [\"{0}\"]\n", body);
    if (!program.empty()) text += fmt::format("executable = \"{}\"\n", program);
  }
  return text + "[[participant]]\nname = \"implicit\"\nrole = \"implicit\"\n";
}

struct Driven {
  const char* protocol;
  int substeps;
};

std::string name_of_drive(const testing::TestParamInfo<Driven>& test) {
  return fmt::format("{}_{}", test.param.protocol, test.param.substeps);
}

class SfepyBodies : public testing::TestWithParam<Driven> {};

/// By displacement, by force, in whole windows and in single substeps.
TEST_P(SfepyBodies, GiveTheHistoryOfOurs) {
  const auto& [protocol, substeps] = GetParam();
  TemporaryFolder folder;
  const auto theirs = run_text(striker_by(protocol, substeps, sfepy_body, sfepy_body), folder, "sfepy");
  const auto ours = run_text(striker_by(protocol, substeps, "", ""), folder, "ours");
  expect_same_history(theirs, ours, 1e-11);
  EXPECT_GT(ours.largest("contact_force_n"), 1e4);  // they did touch
  EXPECT_GT(ours.largest("energy_interface_j") - ours.smallest("energy_interface_j"), 1e-3);
}

INSTANTIATE_TEST_SUITE_P(Protocols, SfepyBodies,
                         testing::Values(Driven{"hughes_liu", 1}, Driven{"kim", 1}, Driven{"prakash_hjelmstad", 1},
                                         Driven{"prakash_hjelmstad", 3}, Driven{"gravouil_combescure", 2}),
                         name_of_drive);

/// sfepy_integrator.py takes its parts from sfepy_body.py. SfePy's start, some twenty times, is all that this takes
/// time for.
TEST(Sfepy, KeepsTheContract) {
  TemporaryFolder folder;
  const auto scene = folder.write(striker_by("hughes_liu", 1, "", ""));
  const auto outcome = run_command(
      {ricochet_binary(), "check-participant", "--", sfepy_integrator, "--scene", scene, "--name", "of_striker"},
      folder.path().string(), 200.0);
  EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.error;
}

TEST(Sfepy, GoesOnFromWhatItSaved) {
  TemporaryFolder folder;
  const auto text = striker_by("prakash_hjelmstad", 2, sfepy_body, "");
  const auto whole = run_text(with_key(text, "checkpoint", "every_windows", "10"), folder, "whole");
  const auto half = (folder.path() / "half").string();
  std::filesystem::copy(whole.folder, half, std::filesystem::copy_options::recursive);
  std::filesystem::remove(fmt::format("{}/checkpoint/{}.json", half, checkpoints_in(half).back()));
  const auto outcome = resume(half, folder);
  ASSERT_EQ(outcome.code, 0) << outcome.error;
  expect_same_results(half, whole.folder);
}

/// The verdicts of `ricochet stability` for a scene at a step below the critical one and at one above it.
std::string verdicts(const std::string& scene, const TemporaryFolder& folder, const std::string& name) {
  const auto out = (folder.path() / (name + "_stability")).string();
  const auto outcome = run_command(
      {ricochet_binary(), "stability", folder.write(scene, name + ".toml"), "--out", out, "--sweep", "courant=0.9,1.2"},
      folder.path().string(), 300.0);
  EXPECT_EQ(outcome.code, 0) << outcome.error;
  std::istringstream rows(file_text(out + "/stability.csv"));
  std::string found, line;
  while (std::getline(rows, line)) {
    for (const char* verdict : {",stable,", ",unstable,"}) {
      if (line.find(verdict) != std::string::npos) found += verdict;
    }
  }
  return found;
}

TEST(Sfepy, IsStableWhereOursIs) {
  TemporaryFolder folder;
  const auto ours = verdicts(striker_by("prakash_hjelmstad", 1, "", ""), folder, "ours");
  EXPECT_EQ(verdicts(striker_by("prakash_hjelmstad", 1, sfepy_body, ""), folder, "sfepy"), ours);
  EXPECT_THAT(ours, testing::HasSubstr(",stable,"));
  EXPECT_THAT(ours, testing::HasSubstr(",unstable,"));
}

TEST(Sfepy, RefusesABodyItDoesNotKnow) {
  TemporaryFolder folder;
  const auto text = replaced(striker_by("hughes_liu", 1, sfepy_body, ""), "initial_velocity_m_s = [0.0, 20.0]",
                             "initial_velocity_m_s = [0.0, 20.0]\ngravity_m_s2 = [0.0, 9.81]");
  const auto run = run_file(folder.write(text), folder);
  EXPECT_EQ(run.outcome.code, 4);
  EXPECT_THAT(run.outcome.error, testing::HasSubstr("body 'striker' has what sfepy_body.py does not know"));
}

class SfepyIntegrators : public testing::TestWithParam<Driven> {};

/// SfePy's own velocity-Verlet integrator is central differences.
TEST_P(SfepyIntegrators, GiveTheHistoryOfOurs) {
  const auto& [protocol, substeps] = GetParam();
  TemporaryFolder folder;
  const auto theirs = run_text(striker_by(protocol, substeps, sfepy_integrator, sfepy_integrator), folder, "sfepy");
  expect_same_history(theirs, run_text(striker_by(protocol, substeps, "", ""), folder, "ours"), 1e-11);
}

INSTANTIATE_TEST_SUITE_P(Protocols, SfepyIntegrators,
                         testing::Values(Driven{"hughes_liu", 1}, Driven{"belytschko_mullen", 1},
                                         Driven{"prakash_hjelmstad", 1}, Driven{"prakash_hjelmstad", 3}),
                         name_of_drive);

/// sfepy_integrator.py with other arguments of its `run`.
std::string integrating(const TemporaryFolder& folder, const std::string& arguments) {
  const auto program = folder.write(fmt::format(R"(#!/usr/bin/python3
import sys
sys.path.insert(0, "{}")
from sfepy.solvers.ts_solvers import NewmarkTS, VelocityVerletTS
from sfepy_integrator import run

sys.exit(run({}))
)",
                                                sfepy_folder, arguments),
                                    "integrating.py");
  std::filesystem::permissions(program, std::filesystem::perms::owner_all);
  return program;
}

/// The scene with the body's participant called another model than the scene's, as other steps make it.
std::string with_other_steps(const std::string& scene, const std::string& body) {
  const auto bodies = fmt::format("bodies = [\"{}\"]\n", body);
  return replaced(scene, bodies, bodies + "differing_" + bodies);
}

/// The scene says nothing of the steps that a solver takes in a window.
TEST(SfepyIntegrator, MayTakeStepsOfItsOwn) {
  TemporaryFolder folder;
  const auto own = integrating(folder, "VelocityVerletTS, staggered=True, steps=5");
  const auto with_step = [](const std::string& text) {
    return replaced(text, "safety_factor = 0.9", "step_s = 6.9e-8");
  };
  const auto by_own =
      with_other_steps(with_other_steps(striker_by("prakash_hjelmstad", 1, own, own), "striker"), "anvil");
  const auto theirs = run_text(with_step(by_own), folder, "sfepy");
  const auto ours = run_text(with_step(striker_by("prakash_hjelmstad", 5, "", "")), folder, "ours");
  expect_same_history(theirs, ours, 1e-11);
}

/// Another scheme on the side that we call explicit: the trapezoidal rule, which is Newmark's with beta = 1/4.
TEST(SfepyIntegrator, MayBeImplicitItself) {
  TemporaryFolder folder;
  const auto program = integrating(folder, "NewmarkTS, staggered=False");
  const auto newmark =
      run_text(with_other_steps(striker_by("prakash_hjelmstad", 1, program, ""), "striker"), folder, "newmark");
  const auto ours = run_text(striker_by("prakash_hjelmstad", 1, "", ""), folder, "ours");
  EXPECT_GT(column_difference(newmark, ours, "energy_strain_j"), 1e-9) << "it is another scheme";
  for (const char* column : {"contact_impulse_n_s", "momentum_n_kg_m_s", "energy_strain_j"})
    EXPECT_LT(column_difference(newmark, ours, column), 0.01) << column;
  EXPECT_LT(newmark.summary.at("momentum_error_max").get<double>(), 1e-12);
}

}  // namespace
}  // namespace ricochet::test

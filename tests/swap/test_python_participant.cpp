// A participant in Python, common/participant/python/explicit_bar.py, in the place of ours.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>
#include <memory>

#include "common/base/parallel.hpp"
#include "common/wire/lifecycle.hpp"
#include "tests/support/places.hpp"
#include "tests/support/run.hpp"
#include "tests/support/same_history.hpp"
#include "tests/support/same_results.hpp"

namespace ricochet::test {
namespace {

const std::string python_folder = source_folder() + "/common/participant/python";

/// A1 with one explicit participant a body; `executable`: what computes them, empty for ours.
std::string two_bars(const std::string& protocol, const std::string& executable) {
  std::string text = with_protocol(config_text("two_bars"), protocol);
  for (const char* body : {"left", "right"}) {
    text += fmt::format("[[participant]]\nname = \"of_{0}\"\nrole = \"explicit\"\nbodies = [\"{0}\"]\n", body);
    if (!executable.empty()) text += fmt::format("executable = \"{}\"\n", executable);
  }
  return text + "[[participant]]\nname = \"implicit\"\nrole = \"implicit\"\n";
}

/// The same with bodies that are meant to be others than the scene's: of other steps, or not linear.
std::string two_other_bars(const std::string& protocol, const std::string& executable) {
  std::string text = two_bars(protocol, executable);
  for (const std::string body : {"left", "right"})
    text = replaced(text, "bodies = [\"" + body + "\"]\n",
                    "bodies = [\"" + body + "\"]\ndiffering_bodies = [\"" + body + "\"]\n");
  return text;
}

double largest(const std::vector<double>& values) {
  double result = 0.0;
  for (const double value : values) result = std::max(result, std::abs(value));
  return result;
}

/// Largest difference of a column, relative to its largest value; where that is a sum that cancels, to what is summed.
double difference(const RunResult& a, const RunResult& b, const std::string& column) {
  const auto& x = a.column(column);
  const auto& y = b.column(column);
  double scale = largest(y);
  if (column.find("momentum") == 0) scale = 2.0 * 7844.066 * 6.4516e-4 * 0.254 * 5.13588;
  if (column == "energy_error" || column == "contact_residual") scale = 1.0;
  double result = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) result = std::max(result, std::abs(x[i] - y[i]));
  return scale > 0.0 ? result / scale : result;
}

class PythonBars : public testing::TestWithParam<const char*> {};

TEST_P(PythonBars, GiveTheHistoryOfOurs) {
  TemporaryFolder folder;
  const auto python = run_text(two_bars(GetParam(), python_folder + "/explicit_bar.py"), folder, "python");
  const auto ours = run_text(two_bars(GetParam(), ""), folder, "ours");
  ASSERT_EQ(python.column("time_s").size(), ours.column("time_s").size());
  for (const auto& [column, values] : ours.history) EXPECT_LT(difference(python, ours, column), 1e-12) << column;
  EXPECT_NEAR(largest(python.column("contact_force_n")), 1.45e5, 1e4);  // they did meet; Z v is 1.33e5
  for (const auto& process : python.summary.at("processes")) {          // each its own way in one run
    const std::string role = process.at("role"), of_implicit = usable_processors() < 3 ? "inside" : "shm";
    EXPECT_EQ(process.at("transport"), role == "explicit" ? "shm" : role == "implicit" ? of_implicit : "");
  }
}

INSTANTIATE_TEST_SUITE_P(Protocols, PythonBars, testing::Values("hughes_liu", "kim"),
                         [](const auto& test) { return std::string(test.param); });

/// Its bars take the scene's material by name; a material of the library is none that it knows.
TEST(PythonBars, KnowMaterialsByTheScenesNames) {
  TemporaryFolder folder;
  std::string text = two_bars("hughes_liu", python_folder + "/explicit_bar.py");
  const auto inline_tables = run_text(text, folder, "inline");
  const std::string table = "{ youngs_modulus_pa = 206.8e9, density_kg_m3 = 7844.066 }";
  for (int bar = 0; bar < 2; ++bar) text = replaced(text, "material = " + table, "material = \"shared\"");
  const std::string named = text + "[material.shared]\nyoungs_modulus_pa = 206.8e9\ndensity_kg_m3 = 7844.066\n";
  EXPECT_EQ(run_text(named, folder, "named").history, inline_tables.history);
  const std::string library = replaced(replaced(text, "\"shared\"", "\"copper\""), "\"shared\"", "\"copper\"");
  const auto refused = run_file(folder.write(library, "library.toml"), folder, "library");
  EXPECT_EQ(refused.outcome.code, 4) << "the participant refused";
  EXPECT_THAT(refused.outcome.error, testing::HasSubstr("the same numbers in a table [material.copper]"));
}

/// explicit_bar.py with more; `more` stands before its last line.
std::string bar_with(const TemporaryFolder& folder, const std::string& name, const std::string& capabilities,
                     const std::string& more) {
  auto text = file_text(python_folder + "/explicit_bar.py");
  text = replaced(text, "import numpy", "import sys; sys.path.insert(0, \"" + python_folder + "\")\nimport numpy");
  text = replaced(text, "import ConfigError", "import pack_state, unpack_state, ConfigError");
  text = replaced(text, "interface_body=[0]", "capabilities=" + capabilities + ", interface_body=[0]");
  text = replaced(text, "main(ExplicitBar)", more + "\nmain(ExplicitBar)");
  const auto path = folder.write(text, name);
  std::filesystem::permissions(path, std::filesystem::perms::owner_all);
  return path;
}

/// Two processes of Python, one of ours, gone on with after a checkpoint.
TEST(PythonBarsWithCheckpoints, GoOnFromWhatTheySaved) {
  TemporaryFolder folder;
  const auto bar = bar_with(folder, "saving_bar.py", "['repeat_window', 'save_state']", R"(    def save_state(self):
        return pack_state(u=self.u, v=self.v, a=self.a, internal=self.internal, work=self.work)

    def restore_state(self, saved):
        vars(self).update(unpack_state(saved))
)");
  const auto contract = run_command({ricochet_binary(), "check-participant", "--", bar, "--scene",
                                     folder.write(two_bars("hughes_liu", ""), "contract.toml"), "--name", "of_left"},
                                    folder.path().string());
  EXPECT_THAT(contract.out, testing::HasSubstr("passed   another process goes on from its saved state"));
  const auto text = with_key(two_bars("hughes_liu", bar), "checkpoint", "every_windows", "60");
  const auto whole = run_text(text, folder, "whole");
  const auto half = (folder.path() / "half").string();
  std::filesystem::copy(whole.folder, half, std::filesystem::copy_options::recursive);
  std::filesystem::remove(fmt::format("{}/checkpoint/{}.json", half, checkpoints_in(half).back()));
  const auto outcome = resume(half, folder);
  ASSERT_EQ(outcome.code, 0) << outcome.error;
  EXPECT_THAT(outcome.error, testing::HasSubstr("going on from window 60 "));
  expect_same_results(half, whole.folder);
}

/// Two processes of Python whose windows change their size, against ours; and without the capability.
TEST(PythonBarsWithChangingWindows, GiveTheHistoryOfOurs) {
  TemporaryFolder folder;
  const auto bar =
      bar_with(folder, "changing_bar.py", "['repeat_window', 'reconfigure']", R"(    def reconfigure(self, setup):
        self.dt = setup["window_size_s"]
)");
  const auto changing = [](const std::string& executable) {
    return with_key(two_bars("hughes_liu", executable), "time", "changes",
                    "[{ from_s = 80e-6, step_s = 1.113e-6 }, { from_s = 110e-6, step_s = 2.226e-6 }]");
  };
  const auto python = run_text(changing(bar), folder, "python"), ours = run_text(changing(""), folder, "ours");
  ASSERT_EQ(python.column("time_s").size(), ours.column("time_s").size());
  for (const auto& [column, values] : ours.history) EXPECT_LT(difference(python, ours, column), 1e-12) << column;
  const auto unable = run_file(folder.write(changing(python_folder + "/explicit_bar.py")), folder);
  EXPECT_EQ(unable.outcome.code, 2);
  EXPECT_THAT(unable.outcome.error,
              testing::HasSubstr("participant 'of_left' (explicit) cannot take part in a run whose windows change "
                                 "their size: it lacks the capability \"reconfigure\""));
}

TEST(PythonBarsWithCheckpoints, ThatSaveNoStateAreNamedIfCheckpointsAreAskedFor) {
  TemporaryFolder folder;
  const auto bar = python_folder + "/explicit_bar.py";
  const auto asked = with_key(two_bars("hughes_liu", bar), "checkpoint", "every_windows", "60");
  const auto run = run_file(folder.write(asked), folder);
  EXPECT_EQ(run.outcome.code, 2);
  EXPECT_THAT(run.outcome.error,
              testing::HasSubstr("participant 'of_left' (explicit) cannot take part in checkpoints: it "
                                 "lacks the capability \"save_state\""));
  const auto empty = bar_with(folder, "empty_bar.py", "['save_state']", "");
  const auto promised =
      run_file(folder.write(with_key(two_bars("hughes_liu", empty), "checkpoint", "every_windows", "60")), folder);
  EXPECT_EQ(promised.outcome.code, 4);
  EXPECT_THAT(promised.outcome.error,
              testing::HasSubstr("it announces the capability 'save_state' but cannot save its state"));
}

/// explicit_bar.py with what it takes to tell its axial stress.
std::string telling_bar(const TemporaryFolder& folder) {
  auto text = file_text(python_folder + "/explicit_bar.py");
  text = replaced(text, "import numpy", "import sys; sys.path.insert(0, \"" + python_folder + "\")\nimport numpy");
  text = replaced(text, "self.step = ", "self.modulus, self.step = modulus, ");
  text =
      replaced(text, "record_columns=[",
               "axial_stress_columns=[f'{self.body}/{low:.9g}/{high:.9g}/1' for low, high in zip(self.x, self.x[1:])],"
               " record_columns=[");
  text = replaced(text, "main(ExplicitBar)", R"(    def axial_stress(self):
        return self.modulus * np.diff(self.u) / np.diff(self.x)

main(ExplicitBar))");
  const auto path = folder.write(text, "telling_bar.py");
  std::filesystem::permissions(path, std::filesystem::perms::owner_all);
  return path;
}

/// Its element 1 has the probe.
TEST(PythonBar, TellsOfAProbeLikeOurs) {
  TemporaryFolder folder;
  const auto probed = [&](const std::string& executable, const std::string& name) {
    const auto text =
        two_bars("hughes_liu", executable) + "[[output.probe]]\nname = \"far\"\nbody = \"left\"\nat_m = [-0.237067]\n";
    return run_text(text, folder, name);
  };
  auto text = file_text(telling_bar(folder));
  text = replaced(text, "record_columns=[",
                  "probe_columns=['far.displacement_x_m/1', 'far.velocity_x_m_s/1', 'far.stress_xx_pa/1'] if self.body "
                  "== 'left' else (), "
                  "record_columns=[");
  text = replaced(text, "main(ExplicitBar)", R"(    def probes(self):
        at = (-0.237067 - self.x[1]) / (self.x[2] - self.x[1])
        here = lambda values: (1 - at) * values[1] + at * values[2]
        return [here(self.u), here(self.v), self.axial_stress()[1]]

main(ExplicitBar))");
  const auto bar = folder.write(text, "probed_bar.py");
  std::filesystem::permissions(bar, std::filesystem::perms::owner_all);
  const History ours = read_history(probed("", "ours").folder + "/probes.csv");
  const RunResult run = probed(bar, "told");
  const History told = read_history(run.folder + "/probes.csv");
  for (const auto& [column, size] : {std::pair{"time_s", 1.0},
                                     {"far.displacement_x_m", 1e-3},
                                     {"far.velocity_x_m_s", 5.0},
                                     {"far.stress_xx_pa", 2e8}}) {
    ASSERT_EQ(told.at(column).size(), ours.at(column).size());
    for (std::size_t row = 0; row < ours.at(column).size(); ++row)
      EXPECT_NEAR(told.at(column)[row], ours.at(column)[row], 1e-5 * size) << column << " row " << row;
  }
  EXPECT_GT(*std::max_element(ours.at("far.velocity_x_m_s").begin(), ours.at("far.velocity_x_m_s").end()), 5.0);
  for (const double value : told.at("far.strain_xx")) EXPECT_TRUE(std::isnan(value)) << "nobody tells it";
  const auto wrong = folder.write(replaced(text, "self.axial_stress()[1]]", "]"), "wrong_bar.py");
  std::filesystem::permissions(wrong, std::filesystem::perms::owner_all);
  const auto stopped = run_file(folder.write(two_bars("hughes_liu", wrong) +
                                             "[[output.probe]]\nname = \"far\"\nbody = \"left\"\nat_m = [-0.2]\n"),
                                folder);
  EXPECT_EQ(stopped.outcome.code, 4);
  EXPECT_THAT(stopped.outcome.error, testing::HasSubstr("probes told 2 numbers, announced 3 probe_columns"));
}

/// A probe where a program of somebody else's has the elements is nan and named, one elsewhere is told.
TEST(PythonBar, LeavesOfProbesNothingUnsaid) {
  TemporaryFolder folder;
  const auto text = two_bars("hughes_liu", python_folder + "/explicit_bar.py") +
                    "[[output.probe]]\nname = \"far\"\nbody = \"left\"\nat_m = [-0.2]\n"
                    "[[output.probe]]\nname = \"near\"\nbody = \"left\"\nat_m = [-0.01]\n";
  const RunResult run = run_text(text, folder);
  EXPECT_THAT(run.outcome.error, testing::HasSubstr("far in probes.csv is nan where shares are missing: of_left tells "
                                                    "of no probe and no gauge"));
  const History told = read_history(run.folder + "/probes.csv");
  for (const char* column : {"velocity_x_m_s", "stress_xx_pa"}) {
    for (const double value : told.at(std::string("far.") + column)) EXPECT_TRUE(std::isnan(value)) << column;
    for (const double value : told.at(std::string("near.") + column)) EXPECT_TRUE(std::isfinite(value)) << column;
  }
}

/// Stress that nobody else knows reaches axial_stress.csv; layers of which nobody tells are not in it.
TEST(PythonBar, TellsItsAxialStressLikeOurs) {
  TemporaryFolder folder;
  const auto stress = [&folder](const std::string& executable, const std::string& name) {
    const auto text = with_key(two_bars("hughes_liu", executable), "output", "axial_stress_every", "3");
    return read_history(run_text(text, folder, name).folder + "/axial_stress.csv");
  };
  const History ours = stress("", "ours"), told = stress(telling_bar(folder), "told"),
                silent = stress(python_folder + "/explicit_bar.py", "silent");
  EXPECT_EQ(ours.size(), 41U);
  EXPECT_LT(silent.size(), 41U) << "only the layers of the implicit participant";
  for (const auto& [column, values] : ours) {
    ASSERT_EQ(told.count(column), 1U) << column;
    const auto& other = told.at(column);
    ASSERT_EQ(other.size(), values.size());
    for (std::size_t row = 0; row < values.size(); ++row) {
      EXPECT_NEAR(other[row], values[row], column == "time_s" ? 0.0 : 1e-5 * 206.9e6) << column << " row " << row;
    }
  }
}

TEST(PythonBar, ConsistsOfAtMostSixtyLines) {
  const std::string text = file_text(python_folder + "/explicit_bar.py");
  EXPECT_GT(text.size(), 0U);
  EXPECT_LE(std::count(text.begin(), text.end(), '\n'), 60);
}

TEST(PythonBar, RefusesABodyItDoesNotKnow) {
  TemporaryFolder folder;
  const std::string scene = replaced(two_bars("hughes_liu", python_folder + "/explicit_bar.py"), "elements = 20 }",
                                     "elements = 20, grading = 1.0 }");
  const auto run = run_file(folder.write(scene), folder);
  EXPECT_EQ(run.outcome.code, 4);
  EXPECT_THAT(run.outcome.error, testing::HasSubstr("body 'left' has what explicit_bar.py does not know"));
}

/// explicit_bar.py's numbers in a time loop of its own, so many steps in a window, between whose ends the shared node
/// moves evenly; `more` stands at the end of each turn.
std::string looping_bar(const TemporaryFolder& folder, const std::string& more = "", int steps = 1) {
  const auto text = bar_with(folder, "with_callbacks.py", "['repeat_window']", "");
  const auto path = folder.write(replaced(replaced(file_text(text), "import pack_state, unpack_state, ConfigError",
                                                   "import OwnLoop, arguments, ConfigError"),
                                          "main(ExplicitBar)", fmt::format("STEPS = {}\n", steps) + R"(import copy

options = arguments()
bar = ExplicitBar(options.scene, options.name)
with OwnLoop(bar.describe(), options) as loop:
    loop.initialize(0.0, np.zeros(5))
    window = loop.setup["window_size_s"]
    while loop.ongoing():
        if loop.must_save():
            saved = copy.deepcopy(vars(bar))
        steps = STEPS if loop.max_time_step() > 0 else 1
        bar.dt, begin = loop.max_time_step() / steps, bar.u[bar.shared]
        for step in range(1, steps + 1):
            force = bar.advance(0, begin + step / steps * (loop.read() - begin))
            bar.accept()
        bar.dt = window / STEPS
        loop.write(force, bar.record())
        loop.advance()
        if loop.must_restore():
            vars(bar).update(copy.deepcopy(saved))
)" + more + "sys.exit(loop.finalize())"),
                                 "looping_bar.py");
  std::filesystem::permissions(path, std::filesystem::perms::owner_all);
  return path;
}

class PythonOwnLoops : public testing::TestWithParam<const char*> {};

TEST_P(PythonOwnLoops, GiveTheHistoryOfOurs) {
  TemporaryFolder folder;
  const auto loop = run_text(two_bars(GetParam(), looping_bar(folder)), folder, "loop");
  expect_same_history(loop, run_text(two_bars(GetParam(), ""), folder, "ours"), 1e-11);
}

INSTANTIATE_TEST_SUITE_P(Protocols, PythonOwnLoops,
                         testing::Values("hughes_liu", "kim", "belytschko_mullen", "fixed_point"),
                         [](const auto& test) { return std::string(test.param); });

/// Between `initialize` and its first turn, and at no other time. A run writes a line of it every two seconds.
TEST(PythonOwnLoop, TellsOfALongSetUp) {
  TemporaryFolder folder;
  const auto bar = looping_bar(folder,
                               "        import ricochet_wire\n        try: loop.progress('late'); sys.exit(9)\n"
                               "        except ricochet_wire.ConfigError: pass\n");
  const auto told = folder.write(replaced(file_text(bar), "    while loop.ongoing():",
                                          "    import time\n    for i in range(5):\n        time.sleep(0.6)\n"
                                          "        loop.progress('casting', i / 5)\n    while loop.ongoing():"),
                                 "telling_bar.py");
  std::filesystem::permissions(told, std::filesystem::perms::owner_all);
  const auto run = run_text(two_bars("hughes_liu", told), folder, "told");
  EXPECT_THAT(run.outcome.error, testing::ContainsRegex("set-up: 'of_(left|right)' casting, "));
}

/// The interface makes and loses some energy, with four steps a window as with one.
TEST(PythonOwnLoop, MayTakeStepsOfItsOwn) {
  TemporaryFolder folder;
  for (const char* protocol : {"hughes_liu", "kim", "belytschko_mullen", "fixed_point"}) {
    const auto run = run_text(two_other_bars(protocol, looping_bar(folder, "", 4)), folder, protocol);
    EXPECT_LT(run.summary.at("momentum_error_max").get<double>(), 1e-12) << protocol;
    EXPECT_LT(largest(run.column("energy_interface_j")), 0.015 * run.column("energy_kinetic_j").front()) << protocol;
    EXPECT_GT(run.largest("contact_force_n"), 1.3e5) << protocol;
  }
}

TEST(PythonOwnLoop, KeepsTheContract) {
  TemporaryFolder folder;
  const auto scene = folder.write(two_bars("hughes_liu", ""));
  const auto outcome = run_command(
      {ricochet_binary(), "check-participant", "--", looping_bar(folder), "--scene", scene, "--name", "of_left"},
      folder.path().string());
  EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.error;
}

TEST(PythonOwnLoop, TellsTheCouplerWhyItIsLeft) {
  TemporaryFolder folder;
  const auto outcome_of = [&folder](const std::string& more) {
    return run_file(folder.write(two_bars("hughes_liu", looping_bar(folder, more))), folder).outcome;
  };
  const auto unstable = outcome_of("        if bar.u.any(): raise ArithmeticError(\"the rod has burst\")\n");
  EXPECT_EQ(unstable.code, 3);
  EXPECT_THAT(unstable.error, testing::HasSubstr("ArithmeticError: the rod has burst"));
  const auto input = outcome_of("        if bar.u.any(): raise ConfigError(\"the rod is not straight\")\n");
  EXPECT_EQ(input.code, 2);
  EXPECT_THAT(input.error, testing::HasSubstr("the rod is not straight"));
  EXPECT_THAT(input.error, testing::Not(testing::HasSubstr("Traceback")));
  const auto left = outcome_of("        if bar.u.any(): sys.exit(0)\n");
  EXPECT_EQ(left.code, 4);
  EXPECT_THAT(left.error, testing::HasSubstr("the solver left its time loop before the run was over"));
}

/// Elements that harden, N = k e + c e^3: the coupler needs no K.
TEST(PythonBar, MayBeNonlinear) {
  TemporaryFolder folder;
  auto text = replaced(file_text(bar_with(folder, "linear_bar.py", "['repeat_window']", R"(    def inner(self, u):
        e = np.diff(u)
        return self.k @ u + 2e18 * (np.append(0, e**3) - np.append(e**3, 0))
)")),
                       "return (self.k @ self.trial)", "return self.inner(self.trial)");
  text = replaced(text, "self.internal = self.k @ self.trial", "self.internal = self.inner(self.trial)");
  text =
      replaced(text, "0.5 * self.u @ self.internal", "0.5 * self.u @ self.k @ self.u + 5e17 * sum(np.diff(self.u)**4)");
  const auto path = folder.write(text, "hard_bar.py");
  std::filesystem::permissions(path, std::filesystem::perms::owner_all);
  const auto hard = run_text(two_other_bars("hughes_liu", path), folder, "hard");
  const auto linear = run_text(two_bars("hughes_liu", ""), folder, "linear");
  EXPECT_GT(difference(hard, linear, "contact_force_n"), 0.01);
  EXPECT_LT(hard.summary.at("momentum_error_max").get<double>(), 1e-12);
  EXPECT_LT(std::abs(hard.last("energy_error")), 1.2 * largest(linear.column("energy_error")));
}

/// Driven by force a participant answers with its motion; what it lacks is named.
TEST(PythonBar, ThatAnswersWithAnotherShapeIsNamed) {
  TemporaryFolder folder;
  const auto forced = bar_with(folder, "forced_bar.py", "['repeat_window', 'driven_by_force', 'single_substep']", "");
  const auto force = run_file(folder.write(two_bars("prakash_hjelmstad", forced)), folder);
  EXPECT_EQ(force.outcome.code, 4);
  EXPECT_THAT(
      force.outcome.error,
      testing::HasSubstr("the link output has not the shape of 3 x (1, 1): displacement, velocity, acceleration"));
  const auto moving = bar_with(folder, "moving_bar.py", "['repeat_window', 'driven_by_force', 'single_substep']",
                               R"(    def initialize(self, setup):
        self.dt = setup["window_size_s"]
        return np.zeros((3, 1))

    def synchronise(self, integration, link):
        return np.zeros((3, 1))
)");
  const auto substep = run_file(folder.write(two_bars("gravouil_combescure", moving)), folder);
  EXPECT_EQ(substep.outcome.code, 4);
  EXPECT_THAT(substep.outcome.error,
              testing::HasSubstr("it announces the capability 'single_substep' but cannot compute a single substep"));
}

/// As a user installs it who has no way to a registry.
TEST(PythonPackage, IsInstalledByPip) {
  TemporaryFolder folder;
  const auto source = folder.path() / "python", environment = folder.path() / "venv";
  std::filesystem::copy(python_folder, source);  // pip builds in the folder that it is given
  const auto run = [&folder](const std::vector<std::string>& command) {
    const auto outcome = run_command(command, folder.path().string());
    EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.error;
    return outcome.out;
  };
  run({"/usr/bin/python3", "-m", "venv", "--system-site-packages", environment});
  run({environment / "bin/pip", "install", "--no-build-isolation", "--no-deps", "--no-index", source});
  std::filesystem::remove_all(source);
  EXPECT_THAT(run({environment / "bin/python3", "-c",
                   "import ricochet_participant as r; print(r.__file__, r.Participant, r.OwnLoop)"}),
              testing::HasSubstr((environment / "lib").string()));
  EXPECT_THAT(file_text(python_folder + "/pyproject.toml"), testing::HasSubstr("version = \"" RICOCHET_VERSION "\""))
      << "of the project";
}

std::string python_says(const std::string& expression, const TemporaryFolder& folder) {
  const auto outcome =
      run_command({"/usr/bin/python3", "-c",
                   fmt::format("import sys; sys.path.insert(0, '{}')\nfrom ricochet_session import ORDER\n"
                               "from ricochet_wire import *\nprint({})",
                               python_folder, expression)},
                  folder.path().string());
  EXPECT_EQ(outcome.code, 0) << outcome.error;
  return outcome.out;
}

TEST(PythonSession, RefusesWhatItsParticipantCannotDo) {
  TemporaryFolder folder;
  const auto refusal = [&folder](const std::string& arguments) {
    const auto outcome = run_command({"/usr/bin/python3", "-c",
                                      fmt::format(R"(
import sys
sys.path.insert(0, '{}')
from ricochet_participant import *


class Stub(Participant):
    def __init__(self, able):
        self.able = able

    def describe(self):
        return Description('p', 'explicit', 's', bodies=['b'], interface_body=[0], interface_position_m=[0.0],
                           interface_mass_kg=[1.0], capabilities=self.able)

    def initialize(self, setup):
        return [0.0] * 3 if setup['driven_by'] == 'force' else 0.0


def drive(able, substep=0, **change):
    session, none = Session(Stub(able)), np.zeros((0, 0))
    session.initialize(dict(window_size_s=1.0, history_every=1, substeps=2, driven_by='force',
                            interface_mass_kg=np.ones((1, 1)), interface_stiffness=none,
                            scene_position_m=np.zeros((1, 1)), directions=np.ones((1, 1))) | change)
    session.check_substep(dict(substep=substep))


try:
    drive({})
except ProtocolError as error:
    print(error)
)",
                                                  python_folder, arguments)},
                                     folder.path().string());
    EXPECT_EQ(outcome.code, 0) << outcome.error;
    return outcome.out;
  };
  EXPECT_EQ(refusal("['driven_by_force', 'single_substep'], substep=1"), "");
  EXPECT_EQ(refusal("[], driven_by='displacement'"), "");
  EXPECT_EQ(refusal("['interface_stiffness'], driven_by='displacement', interface_stiffness=np.ones((1, 1))"), "");
  EXPECT_EQ(refusal("[]"), "the coupler sent 'initialize' that drives it by force, which it is not made for\n");
  EXPECT_EQ(refusal("['driven_by_force'], interface_stiffness=np.ones((1, 1))"),
            "the coupler sent an interface stiffness of shape (1, 1), which this participant cannot do\n");
  EXPECT_EQ(refusal("['driven_by_force'], substep=1"), "the coupler sent substep 1 of 2, 0 are accepted\n");
  EXPECT_EQ(refusal("['driven_by_force', 'single_substep'], substep=2"),
            "the coupler sent substep 2 of 2, 0 are accepted\n");
  EXPECT_EQ(refusal("['driven_by_force'], substeps=0"), "the coupler sent a wrong 'initialize'\n");
}

TEST(PythonWire, HasTheFieldsOfTheSchema) {
  TemporaryFolder folder;
  const char* types[] = {"text", "boolean", "integer", "float", "text", "texts", "array", "bytes"};
  std::string expected;
  const auto message = std::make_unique<wire::Message>();
  for (const auto kind : wire::all_kinds()) {
    expected += fmt::format("{}", wire::name(kind));
    message->kind = kind;
    for (const auto& fields : {wire::header_fields(), wire::fields_of(kind)}) {
      for (const auto& field : fields) expected += fmt::format(" {}:{}", field.name, types[field.in(*message).index()]);
    }
    expected += "\n";
  }
  EXPECT_EQ(
      python_says("'\\n'.join(' '.join([k] + [f'{n}:{t}' for n, t in f.items()]) for k, f in FIELDS.items())", folder),
      expected);
  EXPECT_EQ(python_says("VERSION", folder), fmt::format("{}\n", wire::protocol_version));
}

TEST(PythonWire, KnowsTheLegalOrder) {
  TemporaryFolder folder;
  for (const auto state : wire::all_states()) {
    std::vector<std::string> asked;
    for (const auto& row : wire::transitions()) {
      const std::string kind(wire::name(row.kind));
      if (row.state == state && row.sender == wire::Side::coupler && (asked.empty() || asked.back() != kind)) {
        asked.push_back(kind);
      }
    }
    const auto said = python_says(fmt::format("' '.join(ORDER.get('{}', []))", wire::name(state)), folder);
    std::string expected = fmt::format("{}\n", fmt::join(asked, " "));
    EXPECT_EQ(said, expected) << wire::name(state);
  }
}

TEST(PythonWire, RefusesWhatIsNoMessageByName) {
  TemporaryFolder folder;
  // The answer of the Python end to a message of the coupler that is `welcome` but for one entry.
  const auto refusal = [&](const std::string& change) {
    const auto outcome = run_command(
        {"/usr/bin/python3", "-c",
         fmt::format("import sys; sys.path.insert(0, '{}')\nfrom ricochet_wire import *\n"
                     "m = dict(kind='welcome', version=VERSION, run_id='r', sequence=0, window=0, substep=0, "
                     "participant='p', timeout_s=1.0, shared_memory=False)\ndata = None\n{}\n"
                     "try:\n  decode(data or msgpack.packb(m)); print('accepted')\n"
                     "except ProtocolError as error:\n  print(error)",
                     python_folder, change)},
        folder.path().string());
    EXPECT_EQ(outcome.code, 0) << outcome.error;
    return outcome.out;
  };
  using testing::HasSubstr;
  EXPECT_EQ(refusal("pass"), "accepted\n");
  EXPECT_THAT(refusal("m['version'] = 99"), HasSubstr("speaks version 99 of the wire protocol, this program speaks"));
  EXPECT_THAT(refusal("del m['timeout_s']"), HasSubstr("'welcome' without the field 'timeout_s'"));
  EXPECT_THAT(refusal("m['color'] = 1"), HasSubstr("'welcome' with the unknown field 'color'"));
  EXPECT_THAT(refusal("m['timeout_s'] = float('nan')"), HasSubstr("field 'timeout_s' is not finite"));
  EXPECT_THAT(refusal("m['sequence'] = True"), HasSubstr("field 'sequence' is not of type int"));
  EXPECT_THAT(refusal("m['kind'] = 'wellcome'"), HasSubstr("unknown kind 'wellcome'"));
  EXPECT_THAT(refusal("data = msgpack.packb(m) + b'0'"), HasSubstr("bytes that are no message"));
  EXPECT_THAT(refusal("data = b'\\x82' + msgpack.packb('kind') * 4"), HasSubstr("a field there twice"));
  EXPECT_THAT(
      refusal("m.update(kind='synchronise', integration='x', link_absolute=array([1, 2], 1)); "
              "m.pop('participant'); m.pop('timeout_s'); m.pop('shared_memory'); m['link_absolute']['shape'] = [3, 1]"),
      HasSubstr("field 'link_absolute' has the shape 3 x 1 but other data"));
}

}  // namespace
}  // namespace ricochet::test

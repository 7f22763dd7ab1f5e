// A run that goes on from a checkpoint gives the bytes of one that was never interrupted.
#include <fmt/format.h>

#include <csignal>

#include "tests/support/process_table.hpp"
#include "tests/support/same_results.hpp"

namespace ricochet::test {
namespace {

using testing::HasSubstr;

std::string with_checkpoints(const std::string& text, int every_windows) {
  return with_key(text, "checkpoint", "every_windows", std::to_string(every_windows));
}

/// The last checkpoint is that of the end: the run is to go on from the one before.
void forget_the_end(const std::string& results) {
  const auto windows = checkpoints_in(results);
  ASSERT_EQ(windows.size(), 2U);
  std::filesystem::remove(fmt::format("{}/checkpoint/{}.json", results, windows.back()));
}

struct Case {
  std::string name, text;
  int every = 0;  ///< windows
};

void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

class GoesOn : public testing::TestWithParam<Case> {};

TEST_P(GoesOn, ToTheSameBytes) {
  const TemporaryFolder folder;
  const RunResult whole = run_text(with_checkpoints(GetParam().text, GetParam().every), folder);
  const std::string half = (folder.path() / "half").string();
  std::filesystem::copy(whole.folder, half, std::filesystem::copy_options::recursive);
  ASSERT_NO_FATAL_FAILURE(forget_the_end(half));
  const auto outcome = resume(half, folder);
  ASSERT_EQ(outcome.code, 0) << outcome.error;
  EXPECT_THAT(outcome.error, HasSubstr("going on from window "));
  expect_same_results(half, whole.folder);
}

std::vector<Case> by_protocol_and_transport() {
  std::vector<Case> cases;
  for (const std::string protocol : {"hughes_liu", "kim", "kim_predicted", "belytschko_mullen", "fixed_point",
                                     "prakash_hjelmstad", "gravouil_combescure", "all_implicit", "all_explicit"}) {
    for (const std::string transport : {"shm", "zmq", "tcp"}) {
      std::string text = with_protocol_of_two_steps(config_text("two_bars"), protocol);
      text = with_key(with_key(text, "coupling", "transport", "\"" + transport + "\""), "output", "fields_every", "20");
      cases.push_back({protocol + "_over_" + transport, text, 50});
    }
  }
  return cases;
}

std::string name_of_case(const testing::TestParamInfo<Case>& test) { return test.param.name; }

INSTANTIATE_TEST_SUITE_P(Protocols, GoesOn, testing::ValuesIn(by_protocol_and_transport()), name_of_case);

std::vector<Case> by_law() {
  const auto contact = [](const std::string& config, const std::string& key, const std::string& value) {
    return with_key(with_absolute_meshes(config_text(config)), "contact", key, value);
  };
  std::vector<Case> cases;
  const std::string bars = with_key(with_protocol(config_text("two_bars"), "belytschko_mullen"), "partition",
                                    "reduced_modes", "{ left = 10, right = 9 }");
  cases.push_back({"modes", bars, 50});
  cases.push_back(
      {"modes_after_another_window", with_key(bars, "time", "changes", "[{ from_s = 4e-5, step_s = 1.2e-6 }]"), 100});
  cases.push_back({"local_steps_in_contact",
                   with_protocol(with_absolute_meshes(config_text("rounded_striker")), "local_explicit"), 400});
  for (const std::string protocol : {"hughes_liu", "prakash_hjelmstad", "all_implicit", "all_explicit"}) {
    const auto add = [&](const std::string& name, const std::string& text, int every) {
      cases.push_back({name + "_" + protocol, with_protocol_of_two_steps(text, protocol), every});
    };
    // 400 windows: in contact; 700: in flight after the switch.
    add("in_contact", with_key(config_text("kim_impact"), "output", "axial_stress_every", "7"), 400);
    add("after_the_switch", config_text("kim_impact"), 700);
    add("massless", contact("kim_impact", "multiplier_update", "\"massless\""), 300);
    add("friction_with_regularised_law",
        with_key(contact("slipping_plates", "friction_law", "\"regularised\""), "contact",
                 "friction_regularisation_s_m", "1.0"),
        70);
    add("slipping", config_text("slipping_plates"), 70);
    add("sticking", config_text("sticking_plates"), 70);
    add("bouncing", config_text("bouncing_bar"), 3500);
    if (protocol == "all_explicit") continue;
    if (protocol == "hughes_liu") {
      add("fully_implicit", contact("kim_impact", "multiplier_update", "\"fully_implicit\""), 400);
      add("solids_that_slide", with_absolute_meshes(config_text("alumina_ball")), 160);
    } else if (protocol == "prakash_hjelmstad") {
      add("trapezoidal", contact("kim_impact", "multiplier_update", "\"trapezoidal_reset\""), 400);
    }
    add("curved", with_absolute_meshes(config_text("two_balls")), 430);
    add("solids_with_unequal_meshes", with_absolute_meshes(config_text("oblique_ball")), 160);
  }
  return cases;
}

INSTANTIATE_TEST_SUITE_P(Laws, GoesOn, testing::ValuesIn(by_law()), name_of_case);

/// Columns that slide, several contacts and loads from outside in one scene: a pile on a shaken floor.
std::string shaken_pile(const std::string& protocol) {
  const auto block = [](const char* name, double y, const char* more) {
    return fmt::format(R"([[body]]
name = "{}"
material = {{ youngs_modulus_pa = 1e9, poisson_ratio = 0.25, density_kg_m3 = 1000.0 }}
mesh = {{ start_m = {}, length_m = 4e-3, height_m = 6e-3, elements = [6, 4] }}
gravity_m_s2 = [0.0, -2e5]
{}
)",
                       name, y, more);
  };
  return "model = \"plane_strain\"\n" +
         block("floor", 0.0,
               "[[body.prescribed]]\nsurface = \"start\"\ncomponent = \"x\"\ndisplacement_m = 2e-4\n"
               "amplitude = { time_s = [0.0, 2e-5, 4e-5, 6e-5], factor = [0.0, 1.0, -1.0, 0.0] }\n"
               "[[body.support]]\nsurface = \"start\"\nfixed = [\"y\"]") +
         block("middle", 4e-3, "") + block("top", 8e-3, "initial_velocity_m_s = [0.5, 0.0]") +
         fmt::format(R"([[contact]]
name = "low"
surfaces = ["floor.end", "middle.start"]
friction_coefficient = 0.2
[[contact]]
name = "high"
surfaces = ["middle.end", "top.start"]
friction_coefficient = 0.4
[partition]
implicit_length_m = {{ floor = 1e-3, middle = 1e-3, top = 1e-3 }}
[time]
safety_factor = 0.8
end_s = 6e-5
[output]
fields_every = 40
axial_stress_every = 3
[coupling]
protocol = "{}"
energy_growth_limit = 10.0
)",
                     protocol);
}

INSTANTIATE_TEST_SUITE_P(Piles, GoesOn,
                         testing::Values(Case{"hybrid", shaken_pile("hughes_liu"), 50},
                                         Case{"all_implicit", shaken_pile("all_implicit"), 50},
                                         Case{"all_explicit", shaken_pile("all_explicit"), 50}),
                         name_of_case);

struct Interruption {
  const char* name;
  int signal;
};

/// A long run, so that the test comes in between: two bars that fly on.
std::string long_run() {
  return with_key(with_key(config_text("two_bars"), "time", "end_s", "0.05"), "output", "fields_every", "500");
}

/// The windows that a test waits for are told of by what is written.
bool reaches(Process& run, const std::string& results, int window) {
  return wait_until([&] { return !fields_of(results, "implicit", window).empty() || !run.running(); }, 60.0) &&
         run.running();
}

TEST(Checkpoint, IsMadeWhenTheBatchSystemSaysThatTimeIsUp) {
  const TemporaryFolder folder;
  const RunResult whole = run_text(long_run(), folder, "whole");
  const auto scene = folder.write(long_run(), "whole.toml");
  const auto out = (folder.path() / "out").string();
  Process run({ricochet_binary(), "run", scene, "--out", out}, folder.path() / "o", folder.path() / "e");
  ASSERT_TRUE(reaches(run, out, 2000));
  kill(run.pid(), SIGTERM);
  EXPECT_EQ(run.wait(10.0), 143);
  const auto windows = checkpoints_in(out);
  ASSERT_EQ(windows.size(), 1U);
  EXPECT_GE(windows[0], 1999);
  EXPECT_THAT(file_text(folder.path() / "e"), HasSubstr(fmt::format("resume {}", out)));
  EXPECT_EQ(resume(out, folder).code, 0);
  expect_same_results(out, whole.folder);
}

TEST(Checkpoint, IsMadeAtARequestAndTheRunGoesOn) {
  const TemporaryFolder folder;
  const RunResult whole = run_text(long_run(), folder, "whole");
  const auto scene = folder.write(long_run(), "whole.toml");
  const auto out = (folder.path() / "out").string(), half = (folder.path() / "half").string();
  Process run({ricochet_binary(), "run", scene, "--out", out}, folder.path() / "o", folder.path() / "e");
  ASSERT_TRUE(reaches(run, out, 1000));
  kill(run.pid(), SIGUSR1);
  ASSERT_TRUE(wait_until([&] { return checkpoints_in(out).size() == 1; }, 20.0));
  std::filesystem::create_directories(folder.path() / "asked");
  const auto asked = run_command({ricochet_binary(), "checkpoint", out}, (folder.path() / "asked").string());
  EXPECT_EQ(asked.code, 0) << asked.error;
  EXPECT_THAT(asked.out, HasSubstr("checkpoint at window "));
  EXPECT_EQ(checkpoints_in(out).size(), 2U);
  EXPECT_EQ(run.wait(120.0), 0) << file_text(folder.path() / "e");
  expect_same_results(out, whole.folder);
  const auto late = run_command({ricochet_binary(), "checkpoint", out}, (folder.path() / "asked").string());
  EXPECT_EQ(late.code, 2);
  EXPECT_THAT(late.error, HasSubstr("no run is writing into"));
  EXPECT_EQ(resume(out, folder).code, 0);  // from where it was asked for
  expect_same_results(out, whole.folder);
}

TEST(Checkpoint, IsMadeByWallTime) {
  const TemporaryFolder folder;
  const RunResult run = run_text(with_key(long_run(), "checkpoint", "every_s", "0.1"), folder);
  const auto windows = checkpoints_in(run.folder);
  ASSERT_EQ(windows.size(), 2U);  // the last two are kept
  EXPECT_EQ(windows.back(), run.summary.at("windows"));
}

TEST(Resume, GoesOnToALaterEnd) {
  const TemporaryFolder folder;
  const std::string text = with_checkpoints(with_key(config_text("two_bars"), "time", "end_s", "1e-4"), 20);
  const RunResult early = run_text(text, folder, "early");
  const auto outcome = resume(early.folder, folder, {"--until", "2e-4"});
  ASSERT_EQ(outcome.code, 0) << outcome.error;
  const RunResult late = run_text(with_key(text, "time", "end_s", "2e-4"), folder, "late");
  EXPECT_EQ(file_text(early.folder + "/history.csv"), file_text(late.folder + "/history.csv"));
  const auto back = resume(early.folder, folder, {"--until", "1e-5"});
  EXPECT_EQ(back.code, 2);
  EXPECT_THAT(back.error, HasSubstr("--until: found 1e-05 s, which is window 5; allowed: from window "));
}

/// A run of less than 1000 windows is watched after each of them, a longer one every eight.
TEST(Resume, GoesOnToAnEndThatIsWatchedAtOtherWindows) {
  const TemporaryFolder folder;
  const auto text = [](int checkpoint_every, const std::string& end_s) {
    const std::string scene = with_checkpoints(config_text("two_bars"), checkpoint_every);
    return with_key(with_key(with_key(scene, "time", "step_s", "2e-7"), "output", "history_every", "4"), "time",
                    "end_s", end_s);
  };
  const RunResult early = run_text(text(70, "1e-4"), folder, "early"),
                  late = run_text(text(702, "2.4e-4"), folder, "late");
  const auto longer = resume(early.folder, folder, {"--until", "2.4e-4"});
  ASSERT_EQ(longer.code, 0) << longer.error;
  EXPECT_EQ(file_text(early.folder + "/history.csv"), file_text(late.folder + "/history.csv"));
  forget_the_end(late.folder);
  const auto shorter = resume(late.folder, folder, {"--until", "1.6e-4"});
  ASSERT_EQ(shorter.code, 0) << shorter.error;
  const RunResult whole = run_text(text(702, "1.6e-4"), folder, "whole");
  EXPECT_EQ(file_text(late.folder + "/history.csv"), file_text(whole.folder + "/history.csv"));
}

class Refused : public testing::Test {
 protected:
  void SetUp() override {
    scene_ = folder_.write(with_checkpoints(config_text("two_bars"), 50), "scene.toml");
    results_ = run_file(scene_, folder_).folder;
  }
  void expect_refused(const std::vector<std::string>& words) {
    const auto history = file_text(results_ + "/history.csv");
    const auto outcome = resume(results_, folder_);
    EXPECT_EQ(outcome.code, 2) << outcome.error;
    for (const auto& word : words) EXPECT_THAT(outcome.error, HasSubstr(word));
    EXPECT_EQ(file_text(results_ + "/history.csv"), history) << "results so far are lost";
  }
  [[nodiscard]] std::string file(const std::string& name) const {
    return fmt::format("{}/checkpoint/{}{}", results_, checkpoints_in(results_).back(), name);
  }
  TemporaryFolder folder_;
  std::string scene_, results_;
};

/// Debian's reference BLAS stands beside OpenBLAS, which the script asks for.
TEST_F(Refused, NotWithAnotherBlasButItSaysSo) {
  const auto outcome = run_command(
      {"/bin/sh", "-c",
       "LD_LIBRARY_PATH=$(dirname /usr/lib/*/blas/libblas.so.3) " + ricochet_binary() + " resume " + results_},
      folder_.path().string());
  EXPECT_EQ(outcome.code, 0) << outcome.error;
  EXPECT_THAT(outcome.error, HasSubstr("the run began with processor \""));
  EXPECT_THAT(outcome.error, HasSubstr("/blas/libblas.so.3"));
  EXPECT_THAT(outcome.error, HasSubstr("last bits may differ"));
}

TEST_F(Refused, WithoutACheckpoint) {
  std::filesystem::remove_all(results_ + "/checkpoint");
  expect_refused({"has no checkpoint; `ricochet run` makes one every checkpoint.every_s seconds"});
}

TEST_F(Refused, IfTheSceneHasChanged) {
  const auto changed = replaced(file_text(scene_), "elements = ", "elements = 1");
  static_cast<void>(folder_.write(changed, "scene.toml"));
  expect_refused({"scene.toml: the scene or a mesh of it has changed since the checkpoint", "--until SECONDS"});
}

TEST_F(Refused, IfAnotherVersionWroteIt) {
  for (const auto window : checkpoints_in(results_)) {
    const auto path = fmt::format("{}/checkpoint/{}.json", results_, window);
    const auto text = replaced(file_text(path), "\"ricochet\": \"", "\"ricochet\": \"9.");
    std::ofstream(path) << text;
  }
  expect_refused({"was written by ricochet 9.", "resume with the version that began"});
}

TEST_F(Refused, IfTheHistoryWasCut) {
  std::filesystem::resize_file(results_ + "/history.csv", 1000);
  expect_refused({"history.csv has 1000 bytes, expected at least "});
}

/// The one before goes on to the same bytes.
TEST_F(Refused, APartThatIsDamaged) {
  const auto whole = (folder_.path() / "whole").string();
  std::filesystem::copy(results_, whole, std::filesystem::copy_options::recursive);
  const auto path = file(".explicit.state");
  auto bytes = file_text(path);
  bytes[bytes.size() / 2] ^= 1;
  std::ofstream(path, std::ios::binary) << bytes;
  const auto outcome = resume(results_, folder_);
  EXPECT_EQ(outcome.code, 0) << outcome.error;
  EXPECT_THAT(outcome.error, HasSubstr("warning: " + path + " is not what was written"));
  expect_same_results(results_, whole);
}

TEST_F(Refused, IfNoPartIsWhole) {
  for (const auto window : checkpoints_in(results_))
    std::filesystem::remove(fmt::format("{}/checkpoint/{}.state", results_, window));
  expect_refused({"has no checkpoint that is whole: ", ".state is missing"});
}

}  // namespace
}  // namespace ricochet::test

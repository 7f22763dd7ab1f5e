// Programs that are not there, cannot be executed, end at once or never come: exit code 4, the participant and the
// reason named.
#include "common/check/check.hpp"
#include "tests/faults/fault_run.hpp"

namespace ricochet::test {
namespace {

struct BadProgram {
  const char* name;
  const char* text;  ///< of the program; empty: no such file
  bool executable;
  std::vector<std::string> words;
};

void PrintTo(const BadProgram& program, std::ostream* out) { *out << program.name; }

const std::vector<BadProgram> programs = {
    {"missing", "", false, {"solver.sh does not exist", "correct `executable` in the scene"}},
    {"not_executable", "#!/bin/sh\nexit 0\n", false, {"solver.sh may not be executed (chmod +x?)"}},
    {"no_program", "this is no program\n", true, {}},
    {"missing_interpreter", "#!/nowhere/shell\n", true, {"cannot start", "solver.sh: no such file or directory"}},
    {"exits_at_once", "#!/bin/sh\nexit 1\n", true, {"ended with exit code 1 before it said hello", "log"}},
    {"exits_at_once_without_error", "#!/bin/sh\n", true, {"ended with exit code 0 before it said hello"}},
    {"complains", "#!/bin/sh\necho no license >&2\nexit 3\n", true, {"ended with exit code 3", "no license"}},
    {"killed_by_itself", "#!/bin/sh\nkill -SEGV $$\n", true, {"was killed by signal 11 (SIGSEGV)"}},
    {"never_connects", "#!/bin/sh\ntail -f \"$0\"\n", true, {"has not said hello within 1 s"}},
    {"deaf", "#!/bin/sh\ntrap '' TERM\nwhile :; do sleep 0.1; done\n", true, {"has not said hello within 1 s"}},
    {"leaves_a_child", "#!/bin/sh\ntail -f \"$0\" &\nexit 5\n", true, {"ended with exit code 5"}},
};

class Programs : public testing::TestWithParam<BadProgram> {
 protected:
  /// The program beside the scene: `executable` counts from there.
  void write_program() const {
    const std::string text = GetParam().text;
    if (text.empty()) return;
    const std::string path = folder_.write(text, "solver.sh");
    using std::filesystem::perms;
    if (GetParam().executable) std::filesystem::permissions(path, perms::owner_all);
  }
  const TemporaryFolder folder_;
};

TEST_P(Programs, end_the_run_and_are_named) {
  write_program();
  FaultRun run(folder_, with_participants(bars(few_windows, 1.0), "tired", "executable = \"./solver.sh\""));
  ASSERT_EQ(run.coupler().wait(8.0), 4) << run.error_text();
  EXPECT_THAT(run.error_text(), HasSubstr("participant 'tired'"));
  for (const auto& word : GetParam().words) EXPECT_THAT(run.error_text(), HasSubstr(word));
  EXPECT_TRUE(wait_until([&] { return processes_with(folder_.path().string()).empty(); }, 3.0));
  if (!std::filesystem::exists(run.out() + "/summary.json")) return;  // refused before anything was started
  EXPECT_EQ(run.summary().at("status"), "participant_failed");
  expect_recovery(run, folder_);
}

INSTANTIATE_TEST_SUITE_P(Faults, Programs, testing::ValuesIn(programs),
                         [](const auto& test) { return test.param.name; });

TEST(WrapperScripts, work) {
  const TemporaryFolder folder;
  const std::string script = folder.write("#!/bin/sh\n" + program("explicit_solver") + " \"$@\"\n", "solver.sh");
  std::filesystem::permissions(script, std::filesystem::perms::owner_all);
  FaultRun run(folder, with_participants(bars(few_windows), "explicit", "executable = \"./solver.sh\""));
  EXPECT_EQ(run.coupler().wait(20.0), 0) << run.error_text();
  expect_recovery(run, folder);
}

/// The script waits for its child: when the coupler dies, the child hears it and the script goes with it.
TEST(WrapperScripts, leave_no_orphan_when_the_coupler_is_killed) {
  const TemporaryFolder folder;
  const std::string script = folder.write("#!/bin/sh\n" + program("explicit_solver") + " \"$@\"\n", "solver.sh");
  std::filesystem::permissions(script, std::filesystem::perms::owner_all);
  FaultRun run(folder, with_participants(bars(all_windows), "explicit", "executable = \"./solver.sh\""));
  ASSERT_NO_FATAL_FAILURE(run.reach(1000));
  kill(run.coupler().pid(), SIGKILL);
  EXPECT_EQ(run.coupler().wait(5.0), 128 + SIGKILL);
  expect_recovery(run, folder);
}

/// A scene whose explicit participant is started by a script of these lines, which prints what it is called with.
std::string by_script(const TemporaryFolder& folder, const std::string& lines) {
  const std::string script = folder.write("#!/bin/sh\necho \"$@\"\n" + lines + "\n", "start.sh");
  std::filesystem::permissions(script, std::filesystem::perms::owner_all);
  return with_participants(bars(few_windows), "explicit", "launch = [\"" + script + "\"]");
}

// Their wave takes 2.5 us through an element of the bars.
TEST(ToldCriticalStep, IsTheOneThatTheCouplerHasFound) {
  const TemporaryFolder folder;
  FaultRun run(folder, by_script(folder, "exec \"$@\""));
  ASSERT_EQ(run.coupler().wait(20.0), 0) << run.error_text();
  const auto log = file_text(run.out() + "/logs/explicit.log");
  const std::string option = "--critical-step ";
  ASSERT_THAT(log, HasSubstr(option));
  const auto plans = scene::plan_participants(scene::build_problem(scene::load_scene(run.scene())));
  EXPECT_EQ(std::stod(log.substr(log.find(option) + option.size())), plans.front().critical_time_step_s);
}

TEST(ToldCriticalStep, ThatTheElementsDoNotHaveEndsTheRun) {
  const TemporaryFolder folder;
  FaultRun run(folder, by_script(folder, "exec \"$@\" --critical-step 1e-5"));
  ASSERT_EQ(run.coupler().wait(20.0), 4) << run.error_text();
  EXPECT_THAT(run.error_text(), HasSubstr("participant 'explicit' was told the critical time step 1e-05 s"));
  expect_recovery(run, folder);
}

}  // namespace
}  // namespace ricochet::test

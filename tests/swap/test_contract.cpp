// `ricochet check-participant`: sound participants pass, and each flaw fails its clause and no other.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <sstream>

#include "tests/support/places.hpp"
#include "tests/support/process_table.hpp"
#include "tests/support/run.hpp"

namespace ricochet::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

Outcome check(const TemporaryFolder& folder, std::vector<std::string> command) {
  std::vector<std::string> words{ricochet_binary(), "check-participant", "--timeout", "10", "--"};
  words.insert(words.end(), command.begin(), command.end());
  return run_command(words, folder.path().string());
}

/// The clauses with a verdict, without the explanations after the colon.
std::vector<std::string> clauses(const Outcome& outcome, const std::string& verdict) {
  std::vector<std::string> found;
  std::istringstream lines(outcome.out);
  for (std::string line; std::getline(lines, line);) {
    const std::string begin = fmt::format("  {:<8} ", verdict);
    if (line.rfind(begin, 0) == 0) found.push_back(line.substr(begin.size(), line.find(':') - begin.size()));
  }
  return found;
}

void expect_sound(const Outcome& outcome) {
  EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.error;
  EXPECT_THAT(clauses(outcome, "FAILED"), IsEmpty()) << outcome.out;
  EXPECT_GE(clauses(outcome, "passed").size(), 8U) << outcome.out;
}

std::string program(const std::string& name) { return build_folder() + "/" + name; }
std::string config(const std::string& name) { return fmt::format("{}/configs/{}.toml", source_folder(), name); }

struct Sound {
  const char *name, *solver, *scene, *participant;
};

class SoundSolvers : public testing::TestWithParam<Sound> {};

TEST_P(SoundSolvers, KeepTheContract) {
  const auto& [name, solver, scene, participant] = GetParam();
  TemporaryFolder folder;
  expect_sound(check(folder, {program(solver), "--scene", config(scene), "--name", participant}));
}

INSTANTIATE_TEST_SUITE_P(Shipped, SoundSolvers,
                         testing::Values(Sound{"ExplicitBars", "explicit_solver", "two_bars", "explicit"},
                                         Sound{"ImplicitBars", "implicit_solver", "two_bars", "implicit"},
                                         Sound{"ExplicitCylinders", "explicit_solver", "kim_impact", "explicit"},
                                         Sound{"ImplicitCylinders", "implicit_solver", "kim_impact", "implicit"}),
                         [](const auto& test) { return std::string(test.param.name); });

/// At rest, every clause applies.
TEST(Contract, IsKeptAtRestByOurSolvers) {
  TemporaryFolder folder;
  std::string text = config_text("two_bars");
  for (const char* velocity : {"initial_velocity_m_s = [5.13588]\n", "initial_velocity_m_s = [-5.13588]\n"}) {
    text = replaced(text, velocity, "");
  }
  const auto scene = folder.write(text);
  for (const char* role : {"explicit", "implicit"}) {
    const auto outcome = check(folder, {program(fmt::format("{}_solver", role)), "--scene", scene, "--name", role});
    expect_sound(outcome);
    EXPECT_EQ(clauses(outcome, "passed").size(), 15U) << outcome.out;  // the others are for the other role
  }
}

TEST(Contract, IsKeptByThePythonBar) {
  TemporaryFolder folder;
  const auto scene = folder.write(config_text("two_bars") +
                                  "[[participant]]\nname = \"of_left\"\nrole = \"explicit\"\nbodies = [\"left\"]\n");
  expect_sound(check(
      folder, {source_folder() + "/common/participant/python/explicit_bar.py", "--scene", scene, "--name", "of_left"}));
}

struct Flaw {
  const char *name, *clause, *explanation;
};

class FlawedParticipants : public testing::TestWithParam<Flaw> {};

TEST_P(FlawedParticipants, FailTheirClauseAndNoOther) {
  const auto& [name, clause, explanation] = GetParam();
  TemporaryFolder folder;
  const auto outcome = check(folder, {program("flawed_participant"), name, "--name", "spring"});
  EXPECT_EQ(outcome.code, 5) << outcome.out << outcome.error;
  EXPECT_THAT(clauses(outcome, "FAILED"), ElementsAre(clause)) << outcome.out;
  EXPECT_THAT(outcome.out, HasSubstr(explanation));
}

INSTANTIATE_TEST_SUITE_P(
    Flaws, FlawedParticipants,
    testing::Values(
        Flaw{"negative_mass", "describes itself consistently", "interface node 0 has the mass -1 kg"},
        Flaw{"exit_code", "computes 20 windows and ends with exit code 0", "after 'finish' it ended with exit code 1"},
        Flaw{"process_dependent", "a second process gives the same bits", "differs from window 1 on"},
        Flaw{"trial_leaks", "a repeated trial of a window gives the same bits",
             "window 1: the same input, tried again"},
        Flaw{"forgets_its_state", "another process goes on from its saved state to the same bits",
             "a process restored at window 10 differs from window 11 on"},
        Flaw{"keeps_its_size", "told another window size it computes with that",
             "initialised for windows of 0.05 s and told 0.1 s before the first, its link output differs by"},
        Flaw{"drifts", "zero input stays zero", "its link output reaches 1e-09"},
        Flaw{"wrong_work", "interface work equals force times motion", "force times motion is"},
        Flaw{"pulls", "answers unit inputs by a symmetric, positive matrix", "its internal force has the wrong sign"},
        Flaw{"deaf", "answers unit inputs by a symmetric, positive matrix",
             "its internal force does not depend on its link input"},
        Flaw{"any_version", "refuses another version of the protocol", "it was silent for 10 s"}),
    [](const auto& test) { return std::string(test.param.name); });

TEST(Contract, NoticesWhoOutlivesItsCoupler) {
  TemporaryFolder folder;
  const auto outcome = check(folder, {program("flawed_participant"), "outlives_coupler", "--name", "spring"});
  EXPECT_EQ(outcome.code, 5);
  EXPECT_THAT(clauses(outcome, "FAILED"),
              ElementsAre("ends by itself when the coupler dies", "ends by itself when the coupler falls silent"));
  EXPECT_TRUE(processes_with("flawed_participant outlives_coupler").empty());
}

TEST(Contract, IsKeptByTheSameParticipantWithoutAFlaw) {
  TemporaryFolder folder;
  const auto outcome = check(folder, {program("flawed_participant"), "sound", "--name", "spring"});
  expect_sound(outcome);
  EXPECT_EQ(clauses(outcome, "passed").size(), 12U) << outcome.out;
}

TEST(Contract, NamesAProgramThatIsNotThereOrNoParticipant) {
  TemporaryFolder folder;
  const auto missing = check(folder, {"/nowhere/solver"});
  EXPECT_EQ(missing.code, 5);
  EXPECT_THAT(missing.out, HasSubstr("cannot start /nowhere/solver: no such file or directory"));
  const auto other = check(folder, {"/bin/echo", "hello"});
  EXPECT_EQ(other.code, 5);
  EXPECT_THAT(other.out, HasSubstr("before it said hello it ended with exit code 0; it printed"));
}

TEST(Contract, RefusesAWrongCommandLine) {
  TemporaryFolder folder;
  const auto refusal = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {ricochet_binary(), "check-participant"});
    const auto outcome = run_command(arguments, folder.path().string());
    EXPECT_EQ(outcome.code, 2);
    return outcome.error;
  };
  EXPECT_THAT(refusal({}), HasSubstr("COMMAND is required"));
  EXPECT_THAT(refusal({"--step", "-1", "--", "/bin/true"}),
              HasSubstr("--step: found -1, allowed: a number of seconds > 0"));
  EXPECT_THAT(refusal({"--timeout", "0", "--", "/bin/true"}), HasSubstr("--timeout: found 0, allowed"));
  EXPECT_THAT(refusal({"--tmeout", "1", "--", "/bin/true"}), HasSubstr("did you mean \"--timeout\"?"));
}

TEST(Contract, LeavesNoProcessWhenInterrupted) {
  TemporaryFolder folder;
  const std::string out = folder.path() / "out.txt";
  Process process(
      {ricochet_binary(), "check-participant", "--", program("flawed_participant"), "any_version", "--name", "s"}, out,
      out);
  const auto running = [] { return !processes_with("flawed_participant any_version --name s").empty(); };
  ASSERT_TRUE(wait_until([&] { return file_text(out).find("computes 20") != std::string::npos && running(); }, 10.0));
  kill(process.pid(), SIGINT);
  EXPECT_EQ(process.wait(10.0), 130);
  EXPECT_TRUE(wait_until([&] { return !running(); }, 5.0));
}

}  // namespace
}  // namespace ricochet::test

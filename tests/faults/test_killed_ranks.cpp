// One of a participant's ranks dies or stops: the run ends as if the participant had, and says which rank it was.
#include "tests/faults/fault_run.hpp"

namespace ricochet::test {
namespace {

/// Ranks are the processes of that name whose program is the solver: mpirun, which started them, names it, too.
std::vector<pid_t> ranks_of(const FaultRun& run) {
  std::vector<pid_t> ranks;
  for (const pid_t pid : processes_with("--scene " + run.scene() + " --name explicit")) {
    if (proc_text("/proc/" + std::to_string(pid) + "/comm").starts_with("explicit_solver")) ranks.push_back(pid);
  }
  std::sort(ranks.begin(), ranks.end());
  return ranks;
}

constexpr int many_windows = 10 * all_windows;

class KilledRankOf : public testing::TestWithParam<int> {};

TEST_P(KilledRankOf, EndsTheRunByItsName) {
  const TemporaryFolder folder;
  FaultRun run(folder, with_participants(bars(many_windows), "explicit", "ranks = 3"));
  run.reach(fields_every);
  const auto ranks = ranks_of(run);
  ASSERT_EQ(ranks.size(), 3U);
  kill(ranks[static_cast<std::size_t>(GetParam())], SIGKILL);
  EXPECT_EQ(run.coupler().wait(20.0), 4) << run.error_text();
  EXPECT_THAT(run.error_text(), HasSubstr("participant 'explicit'"));
  EXPECT_THAT(run.error_text(), HasSubstr("process rank " + std::to_string(GetParam()) + " with PID"));
  EXPECT_THAT(run.error_text(), HasSubstr("(Killed)"));
  EXPECT_TRUE(wait_until([&] { return processes_with("--scene " + run.scene()).empty(); }, 10.0)) << "an orphan";
}

INSTANTIATE_TEST_SUITE_P(Ranks, KilledRankOf, testing::Values(0, 1, 2));

TEST(StoppedRank, IsNoticedAtTheDeadline) {
  const TemporaryFolder folder;
  FaultRun run(folder, with_participants(bars(many_windows, 2.0), "explicit", "ranks = 2"));
  run.reach(fields_every);
  const auto ranks = ranks_of(run);
  ASSERT_EQ(ranks.size(), 2U);
  kill(ranks.back(), SIGSTOP);
  EXPECT_EQ(run.coupler().wait(30.0), 4) << run.error_text();
  EXPECT_THAT(run.error_text(), HasSubstr("participant 'explicit'"));
  EXPECT_TRUE(wait_until([&] { return processes_with("--scene " + run.scene()).empty(); }, 10.0)) << "an orphan";
}

TEST(KilledRank, IsReplacedFromTheLastCheckpoint) {
  const TemporaryFolder folder;
  std::string text = with_key(bars(all_windows), "checkpoint", "every_windows", "200");
  text = with_key(text, "checkpoint", "on_failure", "\"resume\"");
  FaultRun run(folder, with_participants(text, "explicit", "ranks = 3"));
  run.reach(fields_every);
  const auto ranks = ranks_of(run);
  ASSERT_EQ(ranks.size(), 3U);
  kill(ranks[1], SIGKILL);
  EXPECT_EQ(run.coupler().wait(60.0), 0) << run.error_text();
  EXPECT_THAT(run.error_text(), HasSubstr("process rank 1 with PID"));
  EXPECT_THAT(run.error_text(), HasSubstr("going on from window "));
  EXPECT_EQ(run.summary().at("windows"), all_windows);
}

/// As where it was built without OpenMPI, or installed from the package.
TEST(Ranks, NeedAProgramOfTheirOwnAndSaySo) {
  const TemporaryFolder folder;
  const auto alone = (folder.path() / "ricochet").string();
  std::filesystem::copy_file(ricochet_binary(), alone);
  const auto scene = folder.write(with_participants(bars(few_windows), "explicit", "ranks = 2"));
  const auto outcome = run_command({alone, "run", scene}, folder.path().string());
  EXPECT_EQ(outcome.code, 4) << outcome.error;
  EXPECT_THAT(outcome.error, HasSubstr("explicit_solver_mpi does not exist; ranks need OpenMPI and METIS: install "
                                       "libopenmpi-dev, openmpi-bin and libmetis-dev and build again"));
}

TEST(KilledCoupler, LeavesNoRank) {
  const TemporaryFolder folder;
  FaultRun run(folder, with_participants(bars(many_windows), "explicit", "ranks = 3"));
  run.reach(fields_every);
  kill(run.coupler().pid(), SIGKILL);
  EXPECT_TRUE(wait_until([&] { return processes_with("--scene " + run.scene()).empty(); }, 20.0)) << "an orphan";
}

}  // namespace
}  // namespace ricochet::test

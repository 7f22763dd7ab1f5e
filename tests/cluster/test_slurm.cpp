// Runs on a Slurm that the test starts: many jobs, a cancelled one, time limits, nodes that are lost.
#include <fmt/format.h>

#include <chrono>
#include <csignal>
#include <memory>
#include <thread>

#include "tests/cluster/slurm_cluster.hpp"
#include "tests/support/process_table.hpp"
#include "tests/support/same_results.hpp"

namespace ricochet::test {
namespace {

using testing::HasSubstr;

class OnSlurm : public testing::Test {
 protected:
  void SetUp() override {
    if (const auto obstacle = SlurmCluster::obstacle(); !obstacle.empty()) GTEST_SKIP() << obstacle;
    cluster_ = std::make_unique<SlurmCluster>();
  }
  /// Whatever happened, nothing goes on.
  void TearDown() override {
    if (!cluster_) return;
    for (const pid_t pid : cluster_->processes(true)) {
      if (process_state(pid) == 'T') kill(pid, SIGKILL);  // a machine that hangs is switched off
    }
    const auto left = [this] { return cluster_->processes(); };
    cluster_->ask({"scancel", "--user=root"});
    EXPECT_TRUE(wait_until([&] { return left().empty(); }, 15.0)) << left().size() << " processes are left";
  }
  [[nodiscard]] std::string path(const std::string& name) const { return (cluster_->folder().path() / name).string(); }
  /// The script of a scene as the command writes it.
  std::string script_of(const std::string& text, const std::vector<std::string>& options = {}) {
    const auto scene = cluster_->folder().write(with_key(text, "coupling", "launcher", "\"slurm\""), "on_slurm.toml");
    std::vector<std::string> command = {ricochet_binary(), "slurm-script", scene, "--out", path("job.sh")};
    command.insert(command.end(), options.begin(), options.end());
    const auto outcome = run_command(command, cluster_->folder().path().string());
    EXPECT_EQ(outcome.code, 0) << outcome.error;
    return path("job.sh");
  }
  /// The history of the scene without Slurm.
  std::string history_here(const std::string& text) {
    const auto run = run_text(text, cluster_->folder(), "here");
    return file_text(run.folder + "/history.csv");
  }
  void expect_results(const std::string& folder, const std::string& history) const {
    EXPECT_TRUE(file_text(folder + "/history.csv") == history) << folder << " has another history";
    const auto summary = nlohmann::json::parse(file_text(folder + "/summary.json"), nullptr, false);
    EXPECT_EQ(summary.value("status", ""), "done") << folder;
    EXPECT_FALSE(std::filesystem::exists(folder + "/keys")) << "keys are left";
  }
  bool wait_for_checkpoint(const std::string& folder, double timeout_s) {
    return wait_until([&] { return !checkpoints_in(folder).empty(); }, timeout_s);
  }

  void signal_solver(int signal) {
    for (const pid_t pid : cluster_->processes()) {
      if (proc_text(fmt::format("/proc/{}/comm", pid)) == "explicit_solver\n") kill(pid, signal);
    }
  }

  std::unique_ptr<SlurmCluster> cluster_;
};

std::string long_bars(int windows) {
  const auto text = with_key(config_text("two_bars"), "time", "end_s", fmt::format("{}", windows * 2.226e-6));
  return with_key(with_key(text, "output", "history_every", "20"), "checkpoint", "every_windows", "200");
}

TEST_F(OnSlurm, AHundredJobsOfAHundredSucceed) {
  const auto history = history_here(config_text("two_bars"));
  const auto script = script_of(config_text("two_bars"));
  constexpr int jobs = 100;
  const auto begin = std::chrono::steady_clock::now();
  std::vector<std::string> numbers;
  for (int job = 0; job < jobs; ++job)
    numbers.push_back(
        cluster_->submit({"--output=" + path(fmt::format("log{}", job)), script, path(fmt::format("out{}", job))}));
  ASSERT_TRUE(cluster_->wait_until_empty(300.0)) << cluster_->ask({"squeue"});
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin;
  int done = 0, across_nodes = 0;
  for (int job = 0; job < jobs; ++job) {
    const auto told = cluster_->ask({"scontrol", "--oneliner", "show", "job", numbers[static_cast<std::size_t>(job)]});
    const bool completed = told.find("JobState=COMPLETED") != std::string::npos;
    EXPECT_TRUE(completed) << told << file_text(path(fmt::format("log{}", job)));
    EXPECT_THAT(told, HasSubstr("Restarts=0 "));
    done += completed ? 1 : 0;
    across_nodes += told.find(" NumNodes=1 ") == std::string::npos ? 1 : 0;
    expect_results(path(fmt::format("out{}", job)), history);
  }
  EXPECT_EQ(done, jobs);
  fmt::print("{} jobs of {} done in {:.1f} s, {} of them on several nodes\n", done, jobs, elapsed.count(),
             across_nodes);
}

/// Ranks of the explicit participant, over several nodes.
TEST_F(OnSlurm, RanksAreOneStep) {
  const auto text = with_key(config_text("kim_impact"), "time", "end_s", "6e-6");
  const auto history = history_here(text);
  const std::string participants =
      "\n[[participant]]\nname = \"implicit\"\nrole = \"implicit\"\n"
      "[[participant]]\nname = \"explicit\"\nrole = \"explicit\"\nbodies = [\"steel\", \"carbide\"]\nranks = 5\n";
  const auto script = script_of(text + participants);
  // By their host's name OpenMPI would take these nodes for one, whose ranks can read each other's memory.
  const auto job =
      cluster_->submit({"--export=ALL,OMPI_MCA_btl=^vader", "--output=" + path("job.log"), script, path("out")});
  ASSERT_TRUE(cluster_->wait_until_empty(120.0)) << cluster_->ask({"squeue"});
  EXPECT_EQ(cluster_->state_of(job), "COMPLETED") << file_text(path("job.log"));
  expect_results(path("out"), history);
  const auto told = cluster_->ask({"scontrol", "--oneliner", "show", "job", job});
  EXPECT_THAT(told, testing::Not(HasSubstr(" NumNodes=1 "))) << "seven processors are more than a node has";
}

TEST_F(OnSlurm, ACancelledJobLeavesNothing) {
  const auto script = script_of(long_bars(1000000));
  const auto job = cluster_->submit({"--output=" + path("job.log"), script, path("out")});
  ASSERT_TRUE(wait_for_checkpoint(path("out"), 60.0)) << file_text(path("job.log"));
  cluster_->ask({"scancel", job});
  ASSERT_TRUE(cluster_->wait_until_empty(30.0)) << cluster_->ask({"squeue"});
  EXPECT_EQ(cluster_->state_of(job), "CANCELLED");
  EXPECT_TRUE(wait_until([&] { return cluster_->processes().empty(); }, 5.0)) << "processes are left";
  EXPECT_FALSE(std::filesystem::exists(path("out/keys")));
  for (const auto& entry : std::filesystem::recursive_directory_iterator(path("out")))
    EXPECT_NE(entry.path().extension(), ".part") << entry.path();
  for (int node = 1; node <= SlurmCluster::nodes; ++node) {
    for (const auto& name : names_in(path(fmt::format("spool/node{}", node)))) EXPECT_FALSE(name.starts_with("job"));
  }
}

TEST_F(OnSlurm, AParticipantThatIsKilledIsNamedWithWhatSlurmSaysOfItsStep) {
  cluster_->submit({"--output=" + path("job.log"), script_of(long_bars(1000000)), path("out")});
  ASSERT_TRUE(wait_for_checkpoint(path("out"), 60.0)) << file_text(path("job.log"));
  signal_solver(SIGKILL);
  const auto named = [&] { return file_text(path("job.log")).find("participant 'explicit'") != std::string::npos; };
  ASSERT_TRUE(wait_until(named, 10.0)) << file_text(path("job.log"));
  EXPECT_THAT(file_text(path("job.log")), HasSubstr("ended with exit code 137 in window"));
  EXPECT_THAT(file_text(path("job.log")), HasSubstr("task 0: Killed"));
}

/// The signal that Slurm sends before the limit, sent by hand.
TEST_F(OnSlurm, TheSignalBeforeTheLimitEndsInACheckpointAndTheNextJobGoesOn) {
  const auto text = long_bars(6000);
  const auto history = history_here(text);
  const auto script = script_of(text);
  const auto job = cluster_->submit({"--output=" + path("job.log"), script, path("out")});
  ASSERT_TRUE(wait_for_checkpoint(path("out"), 60.0)) << file_text(path("job.log"));
  cluster_->ask({"scancel", "--batch", "--signal=TERM", job});
  ASSERT_TRUE(cluster_->wait_for_answer({"squeue", "--noheader", "--format=%T"}, "PENDING\n", 30.0))
      << file_text(path("job.log"));
  const auto reached = checkpoints_in(path("out")).back();
  ASSERT_TRUE(cluster_->wait_until_empty(90.0)) << cluster_->ask({"squeue"});
  system(("cp -r " + cluster_->folder().path().string() + " /tmp/sl").c_str());
  EXPECT_EQ(cluster_->state_of(job), "COMPLETED") << file_text(path("job.log"));
  EXPECT_THAT(file_text(path("job.log")), HasSubstr(fmt::format("going on from window {} ", reached)));
  expect_results(path("out"), history);
}

/// Slurm looks at limits every 30 s, so that a limit of a minute means a signal within the first half of it. Until then
/// the explicit solver is stopped, and the run waits.
TEST_F(OnSlurm, ALimitOfAMinuteEndsInACheckpointAndTheNextJobGoesOn) {
  const auto text = long_bars(8000);
  const auto history = history_here(text);
  const auto job = cluster_->submit({"--output=" + path("job.log"), script_of(text, {"--time", "1"}), path("out")});
  const auto begin = std::chrono::steady_clock::now();
  ASSERT_TRUE(wait_for_checkpoint(path("out"), 60.0)) << file_text(path("job.log"));
  signal_solver(SIGSTOP);
  const auto before = checkpoints_in(path("out")).back();
  std::this_thread::sleep_until(begin + std::chrono::seconds(35));
  signal_solver(SIGCONT);
  ASSERT_TRUE(cluster_->wait_for_answer({"squeue", "--noheader", "--format=%T"}, "PENDING\n", 20.0))
      << file_text(path("job.log"));
  const auto reached = checkpoints_in(path("out")).back();
  EXPECT_LE(reached, before + 400) << "it went on after the signal";
  ASSERT_TRUE(cluster_->wait_until_empty(60.0)) << cluster_->ask({"squeue"});
  system(("cp -r " + cluster_->folder().path().string() + " /tmp/sl").c_str());
  EXPECT_EQ(cluster_->state_of(job), "COMPLETED") << file_text(path("job.log"));
  EXPECT_THAT(file_text(path("job.log")), HasSubstr(fmt::format("going on from window {} ", reached)));
  expect_results(path("out"), history);
}

struct LostNode {
  const char* how;
  int signal;
  const char* words;
};

void PrintTo(const LostNode& lost, std::ostream* out) { *out << lost.how; }

class NodeOfSlurm : public OnSlurm, public testing::WithParamInterface<LostNode> {};

TEST_P(NodeOfSlurm, IsNamedWithinTheDeadlineAndTheRunGoesOnElsewhere) {
  constexpr double timeout_s = 4.0;
  const auto text = with_key(long_bars(6000), "coupling", "timeout_s", fmt::format("{}", timeout_s));
  const auto history = history_here(text);
  const auto script = script_of(text);
  const auto job =
      cluster_->submit({"--nodes=3", "--ntasks-per-node=1", "--output=" + path("job.log"), script, path("out")});
  ASSERT_TRUE(wait_for_checkpoint(path("out"), 60.0)) << file_text(path("job.log"));
  const auto steps = cluster_->ask({"squeue", "--steps", "--noheader", "--format=%i %N", "--jobs", job});
  const auto node_of = [&](const std::string& step) {
    const auto at = steps.find(job + "." + step + " ");
    return at == std::string::npos ? "" : steps.substr(at + job.size() + step.size() + 2, 5);
  };
  const auto coupler = node_of("batch"), lost = node_of("0") == coupler ? node_of("1") : node_of("0");
  ASSERT_NE(lost, coupler) << steps;
  ASSERT_EQ(lost.size(), 5U) << steps;
  const auto begin = std::chrono::steady_clock::now();
  cluster_->signal_node(lost, GetParam().signal);
  const auto named = [&] { return file_text(path("job.log")).find(" on " + lost + " ") != std::string::npos; };
  // The words come when everything that still runs on the other machines has been ended.
  ASSERT_TRUE(wait_until(named, timeout_s + 6.0)) << file_text(path("job.log"));
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin;
  EXPECT_THAT(file_text(path("job.log")), HasSubstr(GetParam().words));
  fmt::print("{} {} after {:.1f} s\n", lost, GetParam().words, elapsed.count());
  ASSERT_TRUE(cluster_->wait_until_empty(120.0)) << cluster_->ask({"squeue"}) << file_text(path("job.log"));
  system(("cp -r " + cluster_->folder().path().string() + " /tmp/sl").c_str());
  EXPECT_EQ(cluster_->state_of(job), "COMPLETED") << file_text(path("job.log"));
  expect_results(path("out"), history);
}

INSTANTIATE_TEST_SUITE_P(Lost, NodeOfSlurm,
                         testing::Values(LostNode{"dead", SIGKILL, "is gone in window"},
                                         LostNode{"hanging", SIGSTOP, "has been silent for"}),
                         [](const auto& test) { return test.param.how; });

}  // namespace
}  // namespace ricochet::test

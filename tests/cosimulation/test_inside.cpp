#include <sched.h>
#include <unistd.h>

#include "tests/support/places.hpp"
#include "tests/support/process.hpp"
#include "tests/support/run.hpp"
#include "tests/support/scene_file.hpp"
#include "tests/support/vtu.hpp"

// The implicit participant in the coupler's process, where processors are fewer than processes.

namespace ricochet::test {
namespace {

/// A process that is started meanwhile has one processor.
class OneProcessor {
 public:
  OneProcessor() {
    sched_getaffinity(0, sizeof before_, &before_);
    int first = 0;
    while (!CPU_ISSET(first, &before_)) ++first;
    cpu_set_t one;
    CPU_ZERO(&one);
    CPU_SET(first, &one);
    sched_setaffinity(0, sizeof one, &one);
  }
  ~OneProcessor() { sched_setaffinity(0, sizeof before_, &before_); }
  OneProcessor(const OneProcessor&) = delete;
  OneProcessor& operator=(const OneProcessor&) = delete;

 private:
  cpu_set_t before_;
};

std::string short_impact(const std::string& protocol) {
  auto text = with_protocol_of_two_steps(config_text("kim_impact"), protocol);
  text = with_key(text, "time", "end_s", "6e-6");
  return with_key(text, "output", "fields_every", "20");
}

const nlohmann::json& process_of(const RunResult& run, const std::string& name) {
  for (const auto& process : run.summary.at("processes"))
    if (process.at("name") == name) return process;
  throw std::runtime_error("no process " + name);
}

class InsideTheCoupler : public testing::TestWithParam<const char*> {};

TEST_P(InsideTheCoupler, TheImplicitParticipantGivesTheBitsOfAProcess) {
  const TemporaryFolder folder;
  const OneProcessor alone;
  const auto inside = run_text(short_impact(GetParam()), folder, "inside");
  const auto apart = run_text(with_key(short_impact(GetParam()), "coupling", "transport", "\"shm\""), folder, "apart");
  EXPECT_EQ(process_of(inside, "implicit").at("transport"), "inside");
  EXPECT_EQ(process_of(inside, "implicit").at("process_id"), process_of(inside, "coupler").at("process_id"));
  EXPECT_GT(process_of(inside, "implicit").at("compute_s").get<double>(), 0.0);
  EXPECT_EQ(process_of(apart, "implicit").at("transport"), "shm");
  EXPECT_NE(process_of(apart, "implicit").at("process_id"), process_of(apart, "coupler").at("process_id"));
  ASSERT_GT(inside.largest("contact_force_n"), 1e4);
  EXPECT_TRUE(file_text(inside.folder + "/history.csv") == file_text(apart.folder + "/history.csv"));
  for (const char* participant : {"implicit", "explicit"}) {
    const auto files = field_files(inside.folder, participant, 20), others = field_files(apart.folder, participant, 20);
    ASSERT_FALSE(files.empty());
    ASSERT_EQ(files.size(), others.size());
    for (std::size_t f = 0; f < files.size(); ++f) EXPECT_TRUE(file_text(files[f]) == file_text(others[f])) << files[f];
  }
}

INSTANTIATE_TEST_SUITE_P(Protocols, InsideTheCoupler,
                         testing::Values("hughes_liu", "kim", "kim_predicted", "belytschko_mullen", "prakash_hjelmstad",
                                         "gravouil_combescure", "fixed_point"),
                         [](const auto& test) { return std::string(test.param); });

/// The last windows of a run that was stopped are for its report.
TEST(InsideTheCoupler, WhoLeavesEarlyLeavesWhatTheReportIsDrawnFrom) {
  const TemporaryFolder folder;
  const OneProcessor alone;
  std::string fast = config_text("two_bars");
  for (const char* sign : {" = [", " = [-"})
    fast = replaced(fast, std::string("initial_velocity_m_s") + sign + "5.13588",
                    std::string("initial_velocity_m_s") + sign + "9000.0");
  const auto run = run_file(folder.write(with_key(fast, "time", "step_s", "8e-8")), folder);
  EXPECT_EQ(run.outcome.code, 6) << run.outcome.error;
  EXPECT_EQ(process_of(run, "implicit").at("transport"), "inside");
  for (const char* name : {"implicit", "explicit"})
    EXPECT_NE(file_text(run.folder + "/fields/" + name + ".shapes.json"), "") << name;
}

TEST(InsideTheCoupler, IsNobodyWhoWasGivenAProcess) {
  const TemporaryFolder folder;
  const OneProcessor alone;
  const auto foreign = run_text(short_impact("hughes_liu") +
                                    "[[participant]]\nname = \"explicit\"\nrole = \"explicit\"\nbodies = [\"steel\", "
                                    "\"carbide\"]\n[[participant]]\nname = \"implicit\"\nrole = \"implicit\"\n"
                                    "executable = \"" +
                                    build_folder() + "/implicit_solver\"\n",
                                folder);
  EXPECT_EQ(process_of(foreign, "implicit").at("transport"), "shm");
  EXPECT_EQ(process_of(run_text(short_impact("all_implicit"), folder), "implicit").at("transport"), "shm");
}

}  // namespace
}  // namespace ricochet::test

#include "tests/support/run.hpp"

// What must not change a result: the transport, and how explicit bodies are spread over processes.

namespace ricochet::test {
namespace {

std::string short_kim() {
  std::string text = with_key(config_text("kim_impact"), "output", "fields_every", "0");
  return with_key(text, "coupling", "resynchronise_every", "70");
}

std::string participants(const std::string& first, const std::string& second) {
  return "\n[[participant]]\nname = \"" + first + "\"\nrole = \"explicit\"\nbodies = [\"steel\"]\n" +
         "\n[[participant]]\nname = \"" + second + "\"\nrole = \"explicit\"\nbodies = [\"carbide\"]\n" +
         "\n[[participant]]\nname = \"contact\"\nrole = \"implicit\"\n";
}

std::string history_of(const RunResult& run) { return file_text(run.folder + "/history.csv"); }

TEST(Invariance, TransportAndNumberOfExplicitParticipantsGiveBitIdenticalHistories) {
  const TemporaryFolder folder;
  const RunResult shm = run_text(with_key(short_kim(), "coupling", "transport", "\"shm\""), folder, "shm");
  const RunResult zmq = run_text(with_key(short_kim(), "coupling", "transport", "\"zmq\""), folder, "zmq");
  const RunResult tcp = run_text(with_key(short_kim(), "coupling", "transport", "\"tcp\""), folder, "tcp");
  const RunResult two = run_text(
      with_key(short_kim(), "coupling", "transport", "\"shm\"") + participants("left", "right"), folder, "two");
  const RunResult again = run_text(short_kim(), folder, "shm");  // into the directory of the first run
  ASSERT_GT(history_of(shm).size(), 100000U);
  for (const auto* other : {&zmq, &tcp, &two, &again}) {
    EXPECT_TRUE(history_of(shm) == history_of(*other)) << other->folder;
  }
  for (const auto& [run, transport] : {std::pair{&shm, "shm"}, {&zmq, "zmq"}, {&tcp, "tcp"}, {&two, "shm"}}) {
    for (const auto& process : run->summary.at("processes")) {
      EXPECT_EQ(process.at("transport"), process.at("name") == "coupler" ? "" : transport);
    }
  }
  EXPECT_EQ(two.summary.at("processes").size(), 4U);
}

TEST(Invariance, IncrementsDoNotDriftFromTheAbsoluteValues) {
  const TemporaryFolder folder;
  const RunResult often = run_text(short_kim(), folder, "often");
  EXPECT_LT(often.summary.at("largest_drift").get<double>(), 1e-12);
  const RunResult never = run_text(with_key(short_kim(), "coupling", "resynchronise_every", "0"), folder, "never");
  const auto &a = often.column("velocity_mean_steel_m_s"), &b = never.column("velocity_mean_steel_m_s");
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], 1e-8) << i;
}

}  // namespace
}  // namespace ricochet::test

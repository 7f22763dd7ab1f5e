// kill -9 and SIGSTOP of every process, at the start, in the middle and near the end of a run.
#include "tests/faults/fault_run.hpp"

namespace ricochet::test {
namespace {

struct Fault {
  const char* who;
  int signal;
  const char* when;
  std::string transport = "shm";
};

void PrintTo(const Fault& fault, std::ostream* out) {
  *out << fault.who << " " << fault.when << " over " << fault.transport;
}

std::string name_of(const testing::TestParamInfo<Fault>& info) {
  return std::string(info.param.signal == SIGKILL ? "kill_" : "stop_") + info.param.who + "_" + info.param.when +
         "_over_" + info.param.transport;
}

std::vector<Fault> all_faults() {
  std::vector<Fault> faults;
  for (const auto* who : {"explicit", "implicit", "coupler"}) {
    for (const int signal : {SIGKILL, SIGSTOP}) {
      for (const auto* when : {"at_the_start", "in_the_middle", "near_the_end"}) faults.push_back({who, signal, when});
      faults.push_back({who, signal, "in_the_middle", "zmq"});
    }
  }
  return faults;
}

/// With kill -9 no deadline may be needed; with SIGSTOP nothing else can tell.
constexpr int windows_between_records = 32;
constexpr double patience_s = 60.0, deadline_s = 2.0, slack_s = 5.0;

class KilledOrStopped : public testing::TestWithParam<Fault> {
 protected:
  [[nodiscard]] static bool stopped() { return GetParam().signal == SIGSTOP; }
  /// Windows computed before the fault.
  [[nodiscard]] static int reached() {
    const std::string when = GetParam().when;
    return when == "at_the_start" ? 0 : when == "in_the_middle" ? all_windows / 2 : all_windows - 2000;
  }
  void strike() {
    victim_ = run_.pid_of(GetParam().who);
    if (reached() > 0) {
      run_.reach(reached());
    } else if (victim_ == run_.coupler().pid()) {
      run_.reach_start();
    }
    ASSERT_EQ(kill(victim_, GetParam().signal), 0);
  }
  void expect_coupler_names_the_culprit() {
    const std::string culprit = std::string("participant '") + GetParam().who + "' ";
    const std::string what =
        stopped() ? "(has not said hello within|has been silent for)" : "was killed by signal 9 .SIGKILL";
    expect_failure(run_, 4, "participant_failed", {culprit}, stopped() ? deadline_s + slack_s : slack_s);
    EXPECT_THAT(run_.error_text(), testing::ContainsRegex(culprit + what));
    const auto steps = run_.summary().at("windows").get<int>();
    EXPECT_GE(steps, reached() - 1);  // the snapshot is there before the coupler hears of the window
    EXPECT_LT(steps, all_windows);
    const auto rows = static_cast<int>(lines_of(run_.out() + "/history.csv").size()) - 2;  // without names and t = 0
    EXPECT_GE(rows, reached() - windows_between_records);
    EXPECT_LE(rows, steps);
  }
  void expect_participants_end_without_coupler() {
    ASSERT_EQ(run_.coupler().wait(slack_s), 128 + SIGKILL);
    EXPECT_TRUE(run_.participants_gone(slack_s));
    EXPECT_EQ(run_.summary().at("status"), "running");
    for (const auto* name : {"explicit", "implicit"}) EXPECT_THAT(run_.log(name), HasSubstr("the coupler is gone"));
  }
  /// A participant gives the coupler twice the time: the coupler may be waiting for another one meanwhile.
  void expect_participants_end_at_their_deadline() {
    EXPECT_TRUE(run_.participants_gone(2 * deadline_s + slack_s));
    EXPECT_EQ(process_state(victim_), 'T');
    for (const auto* name : {"explicit", "implicit"})
      EXPECT_THAT(run_.log(name), HasSubstr("the coupler has not answered within"));
    kill(victim_, SIGCONT);
    expect_failure(run_, 4, "participant_failed", {"participant '", "the coupler has not answered within"}, slack_s);
  }

  const TemporaryFolder folder_;
  FaultRun run_{folder_, with_key(bars(all_windows, stopped() ? deadline_s : patience_s), "coupling", "transport",
                                  "\"" + GetParam().transport + "\"")};
  pid_t victim_ = 0;
};

TEST_P(KilledOrStopped, everything_ends_and_the_next_run_works) {
  ASSERT_NO_FATAL_FAILURE(strike());
  if (GetParam().who != std::string("coupler")) {
    expect_coupler_names_the_culprit();
  } else if (stopped()) {
    expect_participants_end_at_their_deadline();
  } else {
    expect_participants_end_without_coupler();
  }
  expect_recovery(run_, folder_);
}

INSTANTIATE_TEST_SUITE_P(Faults, KilledOrStopped, testing::ValuesIn(all_faults()), name_of);

}  // namespace
}  // namespace ricochet::test

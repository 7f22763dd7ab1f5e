// Ctrl-C, SIGTERM and SIGHUP: to the coupler alone, and to its process group as a terminal does.
#include "tests/faults/fault_run.hpp"

namespace ricochet::test {
namespace {

struct Request {
  const char* name;
  int signal;
  bool whole_group;
  const char* words;
};

void PrintTo(const Request& request, std::ostream* out) { *out << request.name; }

class Interrupted : public testing::TestWithParam<Request> {};

TEST_P(Interrupted, ends_in_order_with_the_results_so_far) {
  const auto& request = GetParam();
  const TemporaryFolder folder;
  FaultRun run(folder, bars(all_windows));
  ASSERT_NO_FATAL_FAILURE(run.reach(2000));
  kill(request.whole_group ? -run.coupler().pid() : run.coupler().pid(), request.signal);
  expect_failure(run, 128 + request.signal, "interrupted", {request.words}, 5.0);
  EXPECT_GE(run.summary().at("windows"), 1999);  // the snapshot is there before the coupler hears of the window
  expect_recovery(run, folder);
}

INSTANTIATE_TEST_SUITE_P(Faults, Interrupted,
                         testing::Values(Request{"ctrl_c_to_the_coupler", SIGINT, false, "interrupted by Ctrl-C"},
                                         Request{"ctrl_c_in_a_terminal", SIGINT, true, "interrupted by Ctrl-C"},
                                         Request{"term_to_the_coupler", SIGTERM, false, "interrupted by SIGTERM"},
                                         Request{"term_to_the_group", SIGTERM, true, "interrupted by SIGTERM"},
                                         Request{"terminal_closed", SIGHUP, true, "interrupted by SIGHUP"}),
                         [](const auto& test) { return test.param.name; });

TEST(InterruptedEarly, while_participants_have_not_said_hello) {
  const TemporaryFolder folder;
  FaultRun run(folder, with_participants(bars(few_windows), "explicit", "", "start = \"by_hand\""));
  ASSERT_TRUE(wait_until([&] { return run.error_text().find("by hand") != std::string::npos; }, 10.0));
  static_cast<void>(run.pid_of("explicit"));
  kill(run.coupler().pid(), SIGINT);
  expect_failure(run, 130, "interrupted", {"interrupted by Ctrl-C"}, 5.0);
  expect_recovery(run, folder);
}

TEST(InterruptedEarly, while_a_participant_is_stopped) {
  const TemporaryFolder folder;
  FaultRun run(folder, apart(bars(all_windows)));
  ASSERT_NO_FATAL_FAILURE(run.reach(1000));
  kill(run.pid_of("implicit"), SIGSTOP);
  kill(run.coupler().pid(), SIGINT);
  expect_failure(run, 130, "interrupted", {"interrupted by Ctrl-C"}, 5.0);
  expect_recovery(run, folder);
}

}  // namespace
}  // namespace ricochet::test

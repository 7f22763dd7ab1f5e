// Runs that cannot begin (exit code 2) or cannot go on because their numbers have lost their meaning (exit code 3), and
// stops that are no faults.
#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include "tests/faults/fault_run.hpp"

namespace ricochet::test {
namespace {

/// A tcp port of the loopback address that somebody listens at.
class TakenPort {
 public:
  TakenPort() : socket_(socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    auto* generic = reinterpret_cast<sockaddr*>(&address);
    if (bind(socket_, generic, size) != 0 || listen(socket_, 1) != 0) throw std::runtime_error("cannot take a port");
    getsockname(socket_, generic, &size);
    port_ = ntohs(address.sin_port);
  }
  TakenPort(const TakenPort&) = delete;
  TakenPort& operator=(const TakenPort&) = delete;
  ~TakenPort() { close(socket_); }
  [[nodiscard]] std::string text() const { return std::to_string(port_); }

 private:
  int socket_, port_ = 0;
};

TEST(Refused, a_port_that_is_in_use) {
  const TemporaryFolder folder;
  const TakenPort port;
  const std::string scene =
      replaced(bars(few_windows), "[coupling]\n", "[coupling]\ntransport = \"tcp\"\nport = " + port.text() + "\n");
  FaultRun run(folder, scene);
  EXPECT_EQ(run.coupler().wait(10.0), 2);
  const std::string endpoint = "'tcp://127.0.0.1:" + port.text() + "'";
  EXPECT_THAT(run.error_text(), HasSubstr("cannot listen at " + endpoint + ": Address already in use"));
  EXPECT_TRUE(run.participants_gone(0.0));
}

TEST(Refused, a_results_folder_that_cannot_be_written) {
  const TemporaryFolder folder;
  const std::string scene = folder.write(bars(few_windows)), file = folder.write("a file", "taken");
  for (const std::string& out : {file, file + "/out", std::string("/proc/nowhere")}) {
    const auto outcome = run_command({ricochet_binary(), "run", scene, "--out", out}, folder.path().string(), 10.0);
    EXPECT_EQ(outcome.code, 2) << out;
    EXPECT_THAT(outcome.error, HasSubstr("cannot create the results folder " + out));
  }
  EXPECT_EQ(file_text(file), "a file");
}

TEST(Refused, a_results_folder_that_another_run_writes_to) {
  const TemporaryFolder folder;
  FaultRun run(folder, bars(all_windows / 2));
  ASSERT_NO_FATAL_FAILURE(run.reach(1000));
  const auto second = run_file(folder.write(bars(few_windows), "second.toml"), folder);
  EXPECT_EQ(second.outcome.code, 2);
  EXPECT_THAT(second.outcome.error, HasSubstr("another run is writing to " + run.out()));
  EXPECT_EQ(run.coupler().wait(20.0), 0) << run.error_text();
  expect_recovery(run, folder);
}

TEST(Unstable, energy_growth_is_stopped_and_explained) {
  const TemporaryFolder folder;
  const std::string stays_implicit = with_key(bars(all_windows), "coupling", "after_separation", "\"implicit\"");
  FaultRun run(folder, with_protocol(stays_implicit, "kim_predicted"));
  expect_failure(run, 3, "unstable",
                 {"unstable in window ", "the energy balance has grown by 5", "coupling.energy_growth_limit = 5 %",
                  "is made at the interface between the participants",
                  "likely cause: protocol kim_predicted is unstable", "use hughes_liu or kim"});
  expect_whole_files(run.out());
  expect_nothing_left(run);
  const auto error = read_history(run.out() + "/history.csv").at("energy_error");
  EXPECT_GT(error.back(), 0.05) << "the row that stopped the run is in the table";
  EXPECT_LE(*std::max_element(error.begin(), error.end() - 8), 0.05) << "the watch looks every 8 windows";
}

/// A process that is stopped for a moment (Ctrl-Z and fg, a busy machine) is no fault.
class StoppedForAMoment : public testing::TestWithParam<const char*> {};

TEST_P(StoppedForAMoment, the_run_goes_on) {
  const TemporaryFolder folder;
  FaultRun run(folder, apart(bars(all_windows / 2, 10.0)));
  ASSERT_NO_FATAL_FAILURE(run.reach(1000));
  const pid_t process = run.pid_of(GetParam());
  kill(process, SIGSTOP);
  std::this_thread::sleep_for(std::chrono::milliseconds(700));
  kill(process, SIGCONT);
  EXPECT_EQ(run.coupler().wait(20.0), 0) << run.error_text();
  expect_recovery(run, folder);
}

INSTANTIATE_TEST_SUITE_P(Faults, StoppedForAMoment, testing::Values("explicit", "implicit", "coupler"),
                         [](const auto& test) { return test.param; });

}  // namespace
}  // namespace ricochet::test

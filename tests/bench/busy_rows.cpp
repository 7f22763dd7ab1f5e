#include "tests/bench/busy_rows.hpp"

#include <fmt/format.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <memory>
#include <optional>

#include "common/base/error.hpp"
#include "tests/bench/in_child.hpp"
#include "tests/bench/process_run.hpp"
#include "tests/bench/reference_scene.hpp"
#include "tests/support/one_process.hpp"

namespace ricochet::bench {
namespace {

constexpr int refinement = 2;

/// Computes until it is destroyed.
class BusyProcess {
 public:
  BusyProcess() : process_(fork()) {
    if (process_ < 0) throw ParticipantError("cannot start another process");
    if (process_ > 0) return;
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    for (volatile unsigned count = 0;;) count = count + 1;
  }
  ~BusyProcess() {
    kill(process_, SIGKILL);
    waitpid(process_, nullptr, 0);
  }
  BusyProcess(const BusyProcess&) = delete;
  BusyProcess& operator=(const BusyProcess&) = delete;

 private:
  pid_t process_;
};

}  // namespace

void BusyMachine::repeat() {
  SceneChoice choice;
  choice.refinement = refinement;
  choice.steps = steps_;
  const auto hybrid = write_reference_scene(choice, folder_ + "/busy_hybrid.toml");
  choice.protocol = "all_implicit";
  const auto implicit = write_reference_scene(choice, folder_ + "/busy_implicit.toml");
  for (const int busy : {1, 2}) {
    std::vector<std::unique_ptr<BusyProcess>> beside;
    for (int i = 0; i < busy; ++i) beside.push_back(std::make_unique<BusyProcess>());
    Times& times = times_[busy];
    times.hybrid_s.push_back(run_scene(hybrid, 1, folder_ + "/run").step_s);
    times.implicit_s.push_back(run_scene(implicit, 1, folder_ + "/run").step_s);
    times.one_process_s.push_back(in_child([&] { return test::run_in_one_process(hybrid); }));
  }
}

std::vector<Row> BusyMachine::rows() const {
  std::vector<Row> rows;
  for (const auto& [busy, times] : times_) {
    const auto beside = fmt::format("{}, {} busy process{} beside", mesh_name(refinement), busy, busy == 1 ? "" : "es");
    rows.push_back({"hughes_liu / all_implicit", beside, quotients(times.hybrid_s, times.implicit_s),
                    busy == 1 ? std::optional(Level{true, 0.5}) : std::nullopt});
    rows.push_back({"hughes_liu, three processes / one", beside, quotients(times.hybrid_s, times.one_process_s), {}});
  }
  return rows;
}

}  // namespace ricochet::bench

#pragma once

#include <sys/types.h>

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "tests/support/process.hpp"
#include "tests/support/scene_file.hpp"

namespace ricochet::test {

/// A Slurm of its own: munge, slurmctld and four slurmd, whose nodes are this machine. Needs root and Debian's
/// slurm-wlm and munge. Files and sockets lie in a folder of its own, ports are free ones, and everything that was
/// started under it is gone with it.
class SlurmCluster {
 public:
  static constexpr int nodes = 4, processors = 4;

  /// Why there can be none; empty if there can.
  [[nodiscard]] static std::string obstacle();
  /// When it returns all nodes are idle. Throws std::runtime_error with the logs if they are not within 30 s.
  SlurmCluster();
  SlurmCluster(const SlurmCluster&) = delete;
  SlurmCluster& operator=(const SlurmCluster&) = delete;
  ~SlurmCluster();

  [[nodiscard]] const TemporaryFolder& folder() const { return folder_; }
  /// Number of the job; throws with what sbatch says if there is none.
  std::string submit(const std::vector<std::string>& arguments);
  /// Runs a command of Slurm; what it prints.
  std::string ask(const std::vector<std::string>& command) const;
  [[nodiscard]] std::string state_of(const std::string& job) const;  ///< "RUNNING", "COMPLETED", ...
  /// Asks every 100 ms until the answer is that.
  bool wait_for_answer(const std::vector<std::string>& command, const std::string& answer, double timeout_s) const;
  /// True if no job is waiting, running or ending any more.
  bool wait_until_empty(double timeout_s) const;
  /// All processes of a node, as if it were another machine that loses power or hangs: its slurmd, its steps, their
  /// tasks.
  void signal_node(const std::string& node, int signal) const;
  /// Processes that were started under this cluster, but for its daemons; all of them if `also_daemons`.
  [[nodiscard]] std::vector<pid_t> processes(bool also_daemons = false) const;

 private:
  void start(const std::string& name, std::vector<std::string> command);
  void write_configuration() const;
  [[nodiscard]] std::string logs() const;

  TemporaryFolder folder_, scratch_;
  std::vector<std::unique_ptr<Process>> daemons_;
};

}  // namespace ricochet::test

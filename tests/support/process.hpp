#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

/// Real processes for the tests: start, watch, kill.
namespace ricochet::test {

std::string file_text(const std::string& path);

/// A child process with its output in files; killed when it goes out of scope.
class Process {
 public:
  Process(std::vector<std::string> command, const std::string& stdout_path, const std::string& stderr_path);
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;
  ~Process();

  [[nodiscard]] pid_t pid() const { return pid_; }
  [[nodiscard]] bool running();
  /// Exit code; 128 + signal if it was killed; -1 if it still runs after the timeout.
  int wait(double timeout_s);

 private:
  void poll();

  pid_t pid_ = -1;
  bool exited_ = false;
  int code_ = -1;
};

struct Outcome {
  int code = -1;
  std::string out, error;
};

/// Runs a command to its end.
Outcome run_command(const std::vector<std::string>& command, const std::string& scratch_folder,
                    double timeout_s = 120.0);

}  // namespace ricochet::test

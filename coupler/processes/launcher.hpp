#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace ricochet::coupler {

/// A program to start.
struct LaunchRequest {
  std::string name;  ///< of the participant
  std::string executable;
  std::vector<std::string> arguments;  ///< without the program itself
  std::string log_path;                ///< takes stdout and stderr
  std::string key{};                   ///< what it can read from its file descriptor 3, that is from `key_path`
  static constexpr const char* key_path = "/dev/fd/3";
};

/// How a process ended.
struct ProcessEnd {
  std::int64_t exit_status = 0;
  int signal = 0;  ///< 0: it ended by itself
  /// "ended with exit code 3" | "was killed by signal 9 (SIGKILL)".
  [[nodiscard]] std::string text() const;
};

/// Starts, watches and stops the processes of a run, and hears the signals that ask this process to stop.
/// Everything is noticed through one file descriptor, so that it fits into the same wait as the socket.
///
/// No orphans: the standard input of a child is a pipe whose other end only this process holds, so a participant
/// started with --watch-stdin ends when this process dies, however it dies. Children run in sessions of their own, so
/// that Ctrl-C reaches them only through the coupler, in order; what they started themselves is ended with them. They
/// inherit no file but the three standard ones and their key.
class Launcher {
 public:
  Launcher();
  Launcher(const Launcher&) = delete;
  Launcher& operator=(const Launcher&) = delete;
  /// Stops whatever still runs.
  ~Launcher();

  /// Throws ParticipantError if the program cannot be started.
  void launch(const LaunchRequest& request);

  /// Readable when `poll` has something to do.
  [[nodiscard]] int file_descriptor() const;
  /// Takes note of ended processes and signals; does not wait.
  void poll();
  /// Waits until every process has ended; false if one still runs after `timeout`.
  bool wait_all(std::chrono::milliseconds timeout);
  /// The same of one.
  bool wait_for(const std::string& name, std::chrono::milliseconds timeout);
  /// Ends every process: SIGTERM, after `grace` SIGKILL; returns when all are gone.
  void stop(std::chrono::milliseconds grace);

  /// How many processes have ended and signals have come so far: tells whether a `poll` brought anything.
  [[nodiscard]] int events() const;
  [[nodiscard]] bool launched(const std::string& name) const;
  [[nodiscard]] std::int64_t process_id(const std::string& name) const;  ///< 0 if not launched here
  /// Empty while the process runs, and for a name that was not launched here.
  [[nodiscard]] std::optional<ProcessEnd> end_of(const std::string& name) const;
  [[nodiscard]] std::string log_path(const std::string& name) const;
  /// SIGINT, SIGTERM or SIGHUP that this process was sent; 0: none.
  [[nodiscard]] int interrupted_by() const;
  /// From now on the first SIGTERM only asks, as SIGUSR1 does always.
  void take_requests();
  /// SIGUSR1, or after `take_requests` SIGTERM, that came since the last call; 0: none. A SIGUSR1 that came before
  /// there was a launcher is one of them, if this process has it blocked from its beginning; without a launcher it
  /// waits.
  [[nodiscard]] int take_request();

 private:
  bool wait_until(const std::function<bool()>& over, std::chrono::milliseconds timeout);

  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The last lines of a text file that say something (not rules or blanks), each after an indent, fit for a terminal,
/// and long ones cut; empty if there are none.
[[nodiscard]] std::string last_lines(const std::string& path, std::size_t lines);

}  // namespace ricochet::coupler

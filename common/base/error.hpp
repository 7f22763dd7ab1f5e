#pragma once

#include <stdexcept>
#include <string>

/// Errors are sorted by who can mend them; each kind has its own exit code.
namespace ricochet {

enum class ExitCode : int {
  done = 0,
  config = 2,       ///< the scene or the command line is wrong: the user mends it
  unstable = 3,     ///< its numbers no longer mean anything
  participant = 4,  ///< a participant is missing, died, hung or failed by itself
  protocol = 5,     ///< a peer broke the wire or the legal order of messages
  model = 6,        ///< the run left what the model describes: the user changes the scene
  machine = 7,      ///< memory, disk, file descriptors, /proc: the machine lacks it
};

class Error : public std::runtime_error {
 public:
  Error(ExitCode code, const std::string& text) : std::runtime_error(text), code_(code) {}
  [[nodiscard]] ExitCode code() const { return code_; }

 private:
  ExitCode code_;
};

struct ConfigError : Error {
  explicit ConfigError(const std::string& text) : Error(ExitCode::config, text) {}
};
struct SolverError : Error {
  explicit SolverError(const std::string& text) : Error(ExitCode::unstable, text) {}
};
struct ParticipantError : Error {
  explicit ParticipantError(const std::string& text) : Error(ExitCode::participant, text) {}
};
struct ModelError : Error {
  explicit ModelError(const std::string& text) : Error(ExitCode::model, text) {}
};
struct ProtocolError : Error {
  explicit ProtocolError(const std::string& text) : Error(ExitCode::protocol, text) {}
};
struct MachineError : Error {
  explicit MachineError(const std::string& text) : Error(ExitCode::machine, text) {}
};

/// Throws what a failed system call means, "<what>: <cause> (errno N)": MachineError if the machine lacks something,
/// ConfigError where another path would do.
[[noreturn]] void throw_errno(int error, const std::string& what);

/// The exit code that an exception means; 1 where nobody knows. Memory and files that the system refuses are the
/// machine's fault, whatever throws.
[[nodiscard]] int exit_code_of_exception(const std::exception& error);

/// The message of the exception.
[[nodiscard]] std::string text_of(const std::exception& error);

}  // namespace ricochet

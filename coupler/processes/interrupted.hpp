#pragma once

#include <fmt/format.h>

#include <csignal>
#include <stdexcept>

namespace ricochet::coupler {

/// The user (or the system) asked this run to stop. Exit code 128 + signal, as shells count: 130 after Ctrl-C.
struct Interrupted : std::runtime_error {
  explicit Interrupted(int number)
      : std::runtime_error(fmt::format("interrupted by {}", number == SIGINT    ? "Ctrl-C"
                                                            : number == SIGTERM ? "SIGTERM"
                                                                                : "SIGHUP")),
        signal(number) {}
  [[nodiscard]] int exit_code() const { return 128 + signal; }
  int signal;
};

}  // namespace ricochet::coupler

#pragma once

namespace ricochet::coupler {

/// The `ricochet` command: run, check, stability, init, --version. Returns the exit code; throws what ended a command.
/// Unknown commands and options are ConfigErrors that name the nearest known one.
int run_command_line(int argc, const char* const* argv);

}  // namespace ricochet::coupler

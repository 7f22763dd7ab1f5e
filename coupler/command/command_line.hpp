#pragma once

namespace ricochet::coupler {

/// The `ricochet` command; its subcommands and what they take are one table in command_line.cpp, which --help lists and
/// docs/commands.md describes. Returns the exit code; throws what ended a command.
/// Unknown commands and options are ConfigErrors that name the nearest known one.
int run_command_line(int argc, const char* const* argv);

}  // namespace ricochet::coupler

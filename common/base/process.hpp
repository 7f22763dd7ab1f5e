#pragma once

#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>

/// Properties that this process has from the machine, and the form in which it shows texts by others.
namespace ricochet {

/// By which users start this program, and with which the lines begin that it prints of what went wrong.
inline constexpr const char* command_name = "ricochet";

/// First of all in every program of ours. Standard files that are closed are opened on /dev/null: else the next file
/// would take their number, and what is printed would get into it. A pipe that nobody reads and a file that may not
/// grow are errors of `write`, not signals.
void prepare_process();

/// Raises the limit of open files to `needed` if that may be; else throws MachineError with both numbers.
void require_descriptors(unsigned long needed);

/// This machine's name: by the batch system, if one started this process, else by itself.
[[nodiscard]] std::string machine_name();

/// Throws MachineError if /proc cannot be read: descriptors, programs and shared memory are found there.
void require_proc();

/// For a terminal: control characters, with which a text could take it over, and marks of direction, with which it
/// could be read as another, become '?'; lines stay lines.
[[nodiscard]] std::string printable(std::string_view text);

/// The text with each of these characters replaced by its text.
[[nodiscard]] std::string with_replaced(std::string_view text,
                                        std::initializer_list<std::pair<char, std::string_view>> by);

}  // namespace ricochet

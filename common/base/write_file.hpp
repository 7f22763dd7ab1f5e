#pragma once

#include <string>
#include <string_view>

namespace ricochet {

/// Writes a whole file under a temporary name, `path` + ".part", and renames it: readers see the old or the new one,
/// never half of it, and of a failure nothing stays. Throws MachineError if the machine is at fault (disk full), else
/// ConfigError, each with the file and the cause. `mode`: who may read and write it, as for chmod.
void write_atomically(const std::string& path, const std::string& text, unsigned mode = 0644);

/// Replaces what a file holds without any room on the disk: the text must not be longer than the file, whose rest
/// becomes blanks. False if that cannot be done.
bool write_within(const std::string& path, const std::string& text);

/// Writes all of it to an open file; 0, or the errno of what went wrong.
[[nodiscard]] int write_all(int descriptor, std::string_view text);

/// Descriptor of a file without a name that holds `text`, to be read from its beginning, and closed by the caller.
/// Throws MachineError if there is none to be had.
[[nodiscard]] int memory_file(std::string_view text);

}  // namespace ricochet

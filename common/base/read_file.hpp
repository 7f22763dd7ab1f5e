#pragma once

#include <cstdint>
#include <string>

#include "common/base/sha256.hpp"

namespace ricochet {

/// The bytes of a file that others may have put there. One that is not regular (a FIFO, a device, a folder) is refused
/// without being opened: reading it might never end. Throws ConfigError that names the file, MachineError where the
/// machine is at fault.
[[nodiscard]] std::string read_file(const std::string& path);

/// SHA-256 of the first `bytes` of such a file, so that more can be added to it. Throws ConfigError if it has fewer.
[[nodiscard]] Sha256 digest_of_file(const std::string& path, std::int64_t bytes);
/// The SHA-256 digest of all of it, 64 hexadecimal digits.
[[nodiscard]] std::string digest_of_file(const std::string& path);

}  // namespace ricochet

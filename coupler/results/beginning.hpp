#pragma once

#include <cstdint>
#include <string>

#include "common/base/sha256.hpp"

namespace ricochet::coupler {

/// The first bytes of a file that grows, and their SHA-256.
struct Beginning {
  std::int64_t bytes = 0;
  std::string sha256{};
};

/// The digest of that beginning, to go on with. Throws ConfigError that names the file if it does not begin so.
Sha256 require_beginning(const std::string& path, const Beginning& expected);

}  // namespace ricochet::coupler

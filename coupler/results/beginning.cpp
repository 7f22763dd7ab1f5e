#include "coupler/results/beginning.hpp"

#include <fmt/format.h>

#include "common/base/error.hpp"
#include "common/base/read_file.hpp"

namespace ricochet::coupler {

Sha256 require_beginning(const std::string& path, const Beginning& expected) {
  auto digest = digest_of_file(path, expected.bytes);
  const auto found = digest.hex();
  if (found == expected.sha256) return digest;
  throw ConfigError(
      fmt::format("{} is not what was written: its first {} bytes have the SHA-256 {:.12} now, they had {:.12}", path,
                  expected.bytes, found, expected.sha256));
}

}  // namespace ricochet::coupler

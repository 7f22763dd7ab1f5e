#include "common/base/sha256.hpp"

#include <fmt/format.h>

// SHA256() sets up the whole of OpenSSL first, with all its algorithms and the machine's configuration, which takes
// most of a millisecond in every process of a run; these functions do not, and OpenSSL 3 would have nobody call them.
#define OPENSSL_SUPPRESS_DEPRECATED
#include <openssl/sha.h>

#include <array>

namespace ricochet {

std::string sha256_hex(std::string_view text) {
  std::array<unsigned char, SHA256_DIGEST_LENGTH> digest{};
  SHA256_CTX context;
  SHA256_Init(&context);
  SHA256_Update(&context, text.data(), text.size());
  SHA256_Final(digest.data(), &context);
  std::string hex;
  for (const unsigned char byte : digest) hex += fmt::format("{:02x}", byte);
  return hex;
}

}  // namespace ricochet

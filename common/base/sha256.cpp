#include "common/base/sha256.hpp"

#include <fmt/format.h>

// SHA256() sets up the whole of OpenSSL first, with all its algorithms and the machine's configuration, which takes
// most of a millisecond in every process of a run; these functions do not, and OpenSSL 3 would have nobody call them.
#define OPENSSL_SUPPRESS_DEPRECATED
#include <openssl/sha.h>

#include <cstring>

namespace ricochet {
namespace {

using Digest = std::array<unsigned char, SHA256_DIGEST_LENGTH>;

std::string hex_of(const Digest& digest) {
  std::string hex;
  for (const unsigned char byte : digest) hex += fmt::format("{:02x}", byte);
  return hex;
}

/// The digest of one text behind another.
Digest digest_of(std::string_view first, std::string_view second) {
  SHA256_CTX context;
  SHA256_Init(&context);
  SHA256_Update(&context, first.data(), first.size());
  SHA256_Update(&context, second.data(), second.size());
  Digest digest{};
  SHA256_Final(digest.data(), &context);
  return digest;
}

std::string_view bytes_of(const Digest& digest) {
  return {reinterpret_cast<const char*>(digest.data()), digest.size()};
}

}  // namespace

std::string sha256_hex(std::string_view text) { return hex_of(digest_of(text, "")); }

std::string hmac_sha256_hex(std::string_view key, std::string_view text) {
  constexpr char inner_byte = 0x36, outer_byte = 0x5c;
  const auto short_key = digest_of(key, "");  // in place of a key that is longer than a block
  std::string inner(key.size() > SHA256_CBLOCK ? bytes_of(short_key) : key);
  inner.resize(SHA256_CBLOCK, '\0');
  std::string outer = inner;
  for (char& byte : inner) byte = static_cast<char>(byte ^ inner_byte);
  for (char& byte : outer) byte = static_cast<char>(byte ^ outer_byte);
  return hex_of(digest_of(outer, bytes_of(digest_of(inner, text))));
}

Sha256::Sha256() {
  static_assert(sizeof state_ == sizeof(SHA256_CTX));
  SHA256_CTX context;
  SHA256_Init(&context);
  std::memcpy(state_.data(), &context, sizeof context);
}

void Sha256::add(std::string_view bytes) {
  SHA256_CTX context;
  std::memcpy(&context, state_.data(), sizeof context);
  SHA256_Update(&context, bytes.data(), bytes.size());
  std::memcpy(state_.data(), &context, sizeof context);
}

std::string Sha256::hex() const {
  SHA256_CTX context;
  std::memcpy(&context, state_.data(), sizeof context);
  Digest digest{};
  SHA256_Final(digest.data(), &context);
  return hex_of(digest);
}

}  // namespace ricochet

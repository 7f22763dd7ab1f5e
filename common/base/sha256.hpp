#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

namespace ricochet {

/// SHA-256 of the bytes of `text` (FIPS 180-4), 64 lower-case hexadecimal digits.
[[nodiscard]] std::string sha256_hex(std::string_view text);

/// HMAC-SHA256 (RFC 2104), 64 hexadecimal digits: who does not have the key cannot make it.
[[nodiscard]] std::string hmac_sha256_hex(std::string_view key, std::string_view text);

/// SHA-256 of bytes that come piece by piece.
class Sha256 {
 public:
  Sha256();
  void add(std::string_view bytes);
  /// The digest of all that came so far; more may follow.
  [[nodiscard]] std::string hex() const;

 private:
  std::array<std::uint64_t, 14> state_{};  ///< OpenSSL's
};

}  // namespace ricochet

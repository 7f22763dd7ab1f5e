#pragma once

#include <string>

namespace ricochet {

/// 32 random bytes that this user alone can read, in `ricochet/key` of $XDG_STATE_HOME or of ~/.local/state. They are
/// made when there are none. Empty where no such file can be had: without a home folder, or if others may read it.
///
/// A text that carries a digest by this key was made by this user: hmac_sha256_hex.
[[nodiscard]] std::string user_key();

}  // namespace ricochet

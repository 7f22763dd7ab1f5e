#pragma once

#include <unistd.h>

#include <string>

namespace ricochet {

/// An abstract socket that no other test, nor another run of the tests, uses; it leaves no file.
inline std::string private_endpoint() {
  static int count = 0;
  return "ipc://@ricochet-test-" + std::to_string(getpid()) + "-" + std::to_string(++count);
}

}  // namespace ricochet

#pragma once

#include <sys/types.h>

#include <cstdint>

namespace ricochet::bench {

/// A process that opens connections to a port of this machine as fast as it can, each with garbage, with half a
/// greeting or with a frame that is too large; killed when this object goes.
class Flooder {
 public:
  explicit Flooder(std::uint16_t port);
  Flooder(const Flooder&) = delete;
  Flooder& operator=(const Flooder&) = delete;
  ~Flooder();

 private:
  pid_t pid_;
};

/// A port that somebody listens at who takes no connection: the kernel keeps the first ones and drops the others.
class OtherPort {
 public:
  OtherPort();
  OtherPort(const OtherPort&) = delete;
  OtherPort& operator=(const OtherPort&) = delete;
  ~OtherPort();
  [[nodiscard]] std::uint16_t number() const { return number_; }

 private:
  std::uint16_t number_ = 0;  // before the socket, which sets it
  int listening_;
};

/// A port of this machine that nobody listens at now.
[[nodiscard]] std::uint16_t free_port();

}  // namespace ricochet::bench

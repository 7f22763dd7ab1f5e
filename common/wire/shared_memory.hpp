#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "common/wire/ring.hpp"

namespace ricochet::wire {

/// A link between two processes of one machine: one ring for each direction, in memory without a name, which is gone
/// with the last process that holds it. The participant makes it and offers it in `hello`; the coupler opens it through
/// the participant's table of files and says in `welcome` whether it did.
class SharedMemory {
 public:
  /// Participant's end; null if this system has no memory to share.
  static std::unique_ptr<SharedMemory> make();
  /// Coupler's end of what a `hello` offers. Throws ConfigError "... cannot be opened: why": the participant runs on
  /// another machine, in another container or as another user, or it offered something else.
  static std::unique_ptr<SharedMemory> open(const std::string& path, std::int64_t key);
  SharedMemory(const SharedMemory&) = delete;
  SharedMemory& operator=(const SharedMemory&) = delete;
  ~SharedMemory();

  /// The words of `hello` on it: where it is, and the random number that tells it from everything else there.
  [[nodiscard]] std::string path() const;
  [[nodiscard]] std::int64_t key() const;

  RingSender& sender() { return *sender_; }
  RingReceiver& receiver() { return *receiver_; }
  /// Waits for bytes as `RingReceiver::wait` does, and sends what is left meanwhile.
  void wait(Deadline until);
  /// Sends what is left, as long as the receiver makes room; gives up after `linger`.
  void flush_all() noexcept;

 private:
  struct Segment;
  enum class End { participant, coupler };
  SharedMemory(int descriptor, void* address, End end);

  int descriptor_;
  Segment* segment_;
  std::unique_ptr<RingSender> sender_;
  std::unique_ptr<RingReceiver> receiver_;
};

}  // namespace ricochet::wire

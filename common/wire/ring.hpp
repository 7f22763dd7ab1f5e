#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/wire/channel.hpp"

/// Messages in one direction through memory that two processes share. One sender, one receiver, no lock.
namespace ricochet::wire {

/// The shared part: a ring of bytes. All zero is an empty ring.
struct RingMemory {
  static constexpr std::uint32_t capacity = 1U << 18;
  alignas(64) std::atomic<std::uint32_t> written;  ///< bytes so far, modulo 2^32; a futex
  std::atomic<std::uint32_t> asleep;               ///< 1: the receiver sleeps until `written` changes
  std::atomic<std::uint32_t> processor;            ///< that the sender ran on when it last sent
  alignas(64) std::atomic<std::uint32_t> read;     ///< bytes so far, modulo 2^32
  alignas(64) char bytes[capacity];
};
static_assert(std::atomic<std::uint32_t>::is_always_lock_free, "locks of the library do not work between processes");

/// Stands before each message.
struct RingHeader {
  static constexpr std::uint64_t correct_magic = 0x316d'6873'6863'6972;  // "richshm1"
  std::uint64_t magic = correct_magic;
  std::uint64_t sequence = 0;  ///< messages of this direction before it
  std::uint64_t length = 0;    ///< bytes that follow
};

/// Never waits: what does not fit goes in pieces, the rest at the next `flush`.
class RingSender {
 public:
  explicit RingSender(RingMemory& memory) : memory_(memory) {}
  /// A message in pieces, one behind the other. Throws ProtocolError if the receiver has put nonsense into the shared
  /// memory.
  void send(const std::vector<std::string_view>& pieces);
  /// Puts more of the rest; true if there is none left.
  bool flush();
  [[nodiscard]] bool has_rest() const { return rest_begin_ < rest_.size(); }

 private:
  void add(std::string_view bytes);
  std::size_t put(std::string_view bytes);
  void publish();

  RingMemory& memory_;
  std::uint32_t written_ = 0;  // the shared counters are trusted by nobody who can count himself
  std::uint32_t published_ = 0;
  std::uint64_t sequence_ = 0;
  std::string rest_;
  std::size_t rest_begin_ = 0;
};

class RingReceiver {
 public:
  explicit RingReceiver(RingMemory& memory);
  /// Takes what is there; true if a message is complete now. Throws ProtocolError, which names `sender`, if the bytes
  /// are none of a `RingSender`.
  bool receive(std::string_view sender);
  /// Largest message that is taken [bytes].
  void limit(std::size_t bytes) { limit_ = bytes; }
  /// After `receive` was true, until it is called again.
  [[nodiscard]] std::string_view message() const { return {message_.data(), message_bytes_}; }
  /// Waits until there are bytes, or until `until`: spins first if that promises to be short, then sleeps.
  void wait(Deadline until);

 private:
  [[nodiscard]] bool has_bytes() const { return memory_.written.load(std::memory_order_acquire) != read_; }
  [[nodiscard]] bool sender_runs_here() const;
  bool spin();
  void sleep(Deadline until);
  std::size_t take(char* to, std::size_t wanted, std::size_t there);
  void check_header(std::string_view sender) const;

  static constexpr unsigned least_sleeps = 4, most_sleeps = 1024;

  RingMemory& memory_;
  std::uint32_t read_ = 0;
  std::uint64_t sequence_ = 0;
  std::size_t limit_;
  RingHeader header_;
  std::size_t header_bytes_ = 0;   ///< of the header, taken so far
  std::string message_;            ///< as large as the largest so far: bytes that are overwritten need no zeros first
  std::size_t message_bytes_ = 0;  ///< of the message, taken so far
  unsigned sleeps_due_ = 0;        ///< waits that go to sleep at once, because spinning was in vain
  unsigned next_sleeps_ = least_sleeps;
};

}  // namespace ricochet::wire

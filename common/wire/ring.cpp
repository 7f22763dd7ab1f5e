#include "common/wire/ring.hpp"

#include <fmt/format.h>
#include <linux/futex.h>
#include <sched.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>

#include "common/base/error.hpp"
#include "common/wire/codec.hpp"

namespace ricochet::wire {
namespace {

/// Waking a process that sleeps takes tens of microseconds: what comes much later is not worth spinning for.
constexpr std::chrono::microseconds longest_spin{300};
constexpr int looks_between_yields = 20;

/// Bytes of a large message after which each end tells the other how far it is, so that both copy at the same time.
constexpr std::size_t at_once = 1U << 15;

constexpr std::uint32_t mask = RingMemory::capacity - 1;
static_assert((RingMemory::capacity & mask) == 0, "counters modulo 2^32 need a power of two");

void pause_processor() {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#endif
}

std::string_view bytes_of(const RingHeader& header) { return {reinterpret_cast<const char*>(&header), sizeof header}; }

}  // namespace

// ---- sender

void RingSender::send(const std::vector<std::string_view>& pieces) {
  RingHeader header;
  header.sequence = sequence_++;
  for (const auto piece : pieces) header.length += piece.size();
  flush();
  add(bytes_of(header));
  for (const auto piece : pieces) add(piece);
  publish();
}

bool RingSender::flush() {
  if (!has_rest()) return true;
  rest_begin_ += put(std::string_view(rest_).substr(rest_begin_));
  publish();
  return !has_rest();
}

/// Puts what there is room for; what there is none for waits behind what waits already.
void RingSender::add(std::string_view bytes) {
  if (has_rest()) {
    rest_.append(bytes);
    return;
  }
  while (!bytes.empty()) {
    const auto count = put(bytes.substr(0, at_once));
    bytes.remove_prefix(count);
    if (count == 0) break;
    if (written_ - published_ >= at_once) publish();
  }
  rest_.assign(bytes);
  rest_begin_ = 0;
}

/// Copies as much as there is room for; how much that was.
std::size_t RingSender::put(std::string_view bytes) {
  const std::uint32_t unread = written_ - memory_.read.load(std::memory_order_acquire);
  if (unread > RingMemory::capacity) {
    throw ProtocolError(fmt::format("the receiver corrupted the shared memory: {} bytes unread in a ring of {}", unread,
                                    RingMemory::capacity));
  }
  const std::size_t count = std::min<std::size_t>(bytes.size(), RingMemory::capacity - unread);
  const std::size_t at = written_ & mask;
  const std::size_t first = std::min(count, RingMemory::capacity - at);
  std::memcpy(memory_.bytes + at, bytes.data(), first);
  std::memcpy(memory_.bytes, bytes.data() + first, count - first);
  written_ += static_cast<std::uint32_t>(count);
  return count;
}

/// Lets the receiver see what was put. In sequential order with `RingReceiver::wait`: either it sees the bytes, or this
/// sees that it sleeps.
void RingSender::publish() {
  if (published_ == written_) return;
  published_ = written_;
  memory_.processor.store(static_cast<std::uint32_t>(sched_getcpu()), std::memory_order_relaxed);
  memory_.written.store(written_, std::memory_order_seq_cst);
  if (memory_.asleep.load(std::memory_order_seq_cst) != 0) {
    syscall(SYS_futex, &memory_.written, FUTEX_WAKE, 1, nullptr, nullptr, 0);
  }
}

// ---- receiver

RingReceiver::RingReceiver(RingMemory& memory) : memory_(memory), limit_(max_message_bytes) {}

bool RingReceiver::receive(std::string_view sender) {
  const bool complete = header_bytes_ == sizeof header_ && message_bytes_ == header_.length;
  if (complete) header_bytes_ = message_bytes_ = 0;  // it was handed over
  std::size_t there = memory_.written.load(std::memory_order_acquire) - read_;
  if (there > RingMemory::capacity) {
    throw ProtocolError(
        fmt::format("{} corrupted the shared memory: {} bytes in a ring of {}", sender, there, RingMemory::capacity));
  }
  if (header_bytes_ < sizeof header_) {
    const auto count = take(reinterpret_cast<char*>(&header_) + header_bytes_, sizeof header_ - header_bytes_, there);
    there -= count;
    header_bytes_ += count;
    if (header_bytes_ == sizeof header_) check_header(sender);
  }
  memory_.read.store(read_, std::memory_order_release);
  while (header_bytes_ == sizeof header_ && there > 0 && message_bytes_ < header_.length) {
    const std::size_t count = std::min<std::size_t>({there, header_.length - message_bytes_, at_once});
    if (message_.size() < message_bytes_ + count) message_.resize(message_bytes_ + count);
    take(message_.data() + message_bytes_, count, there);
    message_bytes_ += count;
    there -= count;
    memory_.read.store(read_, std::memory_order_release);
  }
  if (header_bytes_ < sizeof header_ || message_bytes_ < header_.length) return false;
  ++sequence_;
  return true;
}

/// Copies at most `wanted` bytes of those that are there; how many that were.
std::size_t RingReceiver::take(char* to, std::size_t wanted, std::size_t there) {
  const std::size_t count = std::min(wanted, there);
  const std::size_t at = read_ & mask;
  const std::size_t first = std::min(count, RingMemory::capacity - at);
  std::memcpy(to, memory_.bytes + at, first);
  std::memcpy(to + first, memory_.bytes, count - first);
  read_ += static_cast<std::uint32_t>(count);
  return count;
}

void RingReceiver::check_header(std::string_view sender) const {
  if (header_.magic != RingHeader::correct_magic) {
    throw ProtocolError(
        fmt::format("{} corrupted the shared memory: no message begins with {:#018x}", sender, header_.magic));
  }
  if (header_.sequence != sequence_) {
    throw ProtocolError(fmt::format("{} corrupted the shared memory: message {} where message {} was due", sender,
                                    header_.sequence, sequence_));
  }
  if (header_.length == 0 || header_.length > limit_) {
    throw ProtocolError(fmt::format("{} corrupted the shared memory: a message of {} bytes, allowed are 1 to {}",
                                    sender, header_.length, limit_));
  }
}

void RingReceiver::wait(Deadline until) {
  if (has_bytes()) return;
  if (sleeps_due_ > 0) {
    --sleeps_due_;
  } else if (!sender_runs_here() && spin()) {
    return;
  }
  sleep(until);
}

/// A receiver that spins on the sender's own processor keeps it from sending.
bool RingReceiver::sender_runs_here() const {
  return memory_.processor.load(std::memory_order_relaxed) == static_cast<std::uint32_t>(sched_getcpu());
}

/// True if bytes came. If they came too late, next waits sleep at once, twice as many each time: what is awaited takes
/// longer, or other processes need the processors, and then who has slept gets one before who has spun.
bool RingReceiver::spin() {
  const auto end = Clock::now() + longest_spin;
  do {
    for (int i = 0; i < looks_between_yields; ++i) {
      if (has_bytes()) {
        next_sleeps_ = std::max(next_sleeps_ / 2, least_sleeps);
        return true;
      }
      pause_processor();
    }
    sched_yield();
  } while (Clock::now() < end);
  sleeps_due_ = next_sleeps_;
  next_sleeps_ = std::min(2 * next_sleeps_, most_sleeps);
  return has_bytes();
}

void RingReceiver::sleep(Deadline until) {
  const auto left = std::chrono::duration_cast<std::chrono::nanoseconds>(until - Clock::now()).count();
  if (left <= 0) return;
  const timespec timeout{left / 1'000'000'000, left % 1'000'000'000};
  memory_.asleep.store(1, std::memory_order_seq_cst);
  if (memory_.written.load(std::memory_order_seq_cst) == read_) {
    syscall(SYS_futex, &memory_.written, FUTEX_WAIT, read_, &timeout, nullptr, 0);
  }
  memory_.asleep.store(0, std::memory_order_seq_cst);
}

}  // namespace ricochet::wire

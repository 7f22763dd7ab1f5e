#include "common/base/parallel.hpp"

#include <sched.h>

#include <algorithm>
#include <chrono>

namespace ricochet {
namespace {

/// Longest spinning for a number to change: about what waking a sleeper takes. After the first of it the processor is
/// offered to others, for who is waited for may be waiting for this very processor.
constexpr auto longest_spin = std::chrono::microseconds(50), longest_pause = std::chrono::microseconds(5);

void pause_processor() {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#else
  std::this_thread::yield();
#endif
}

/// Returns once `enough(value)`: spins, then sleeps until it is told of a change.
template <class Number, class Enough>
void wait_until(const std::atomic<Number>& value, const Enough& enough) {
  const auto begin = std::chrono::steady_clock::now();
  for (;;) {
    const Number seen = value.load(std::memory_order_acquire);
    if (enough(seen)) return;
    const auto waited = std::chrono::steady_clock::now() - begin;
    if (waited < longest_pause) {
      pause_processor();
    } else if (waited < longest_spin) {
      std::this_thread::yield();
    } else {
      value.wait(seen, std::memory_order_acquire);
    }
  }
}

}  // namespace

Parallel::~Parallel() {
  over_.store(true, std::memory_order_relaxed);
  round_.fetch_add(1, std::memory_order_release);
  round_.notify_all();
  for (std::thread& other : others_) other.join();
}

void Parallel::run(int parts, const void* work, Call call) {
  if (threads_ == 1 || parts <= 1) {
    for (int part = 0; part < parts; ++part) call(work, part, 0);
    return;
  }
  if (others_.empty()) {
    others_.reserve(static_cast<std::size_t>(threads_) - 1);
    for (int thread = 1; thread < threads_; ++thread)
      others_.emplace_back([this, thread] { wait_and_take_parts(thread); });
  }
  const std::uint32_t round = round_.load(std::memory_order_relaxed) + 1;
  work_.store(work, std::memory_order_relaxed);
  call_.store(call, std::memory_order_relaxed);
  parts_.store(parts, std::memory_order_relaxed);
  done_.store(0, std::memory_order_relaxed);
  ticket_.store(static_cast<std::uint64_t>(round) << 32 | static_cast<std::uint64_t>(parts), std::memory_order_release);
  round_.store(round, std::memory_order_release);
  round_.notify_all();
  take_parts(0);
  wait_until(done_, [parts](int done) { return done == parts; });
}

void Parallel::take_parts(int thread) {
  std::uint64_t ticket = ticket_.load(std::memory_order_acquire);
  for (;;) {
    const void* const work = work_.load(std::memory_order_relaxed);
    const Call call = call_.load(std::memory_order_relaxed);
    const int parts = parts_.load(std::memory_order_relaxed);
    const int left = static_cast<int>(ticket & 0xffffffffU);
    if (left == 0) return;
    if (!ticket_.compare_exchange_weak(ticket, ticket - 1, std::memory_order_acq_rel, std::memory_order_acquire))
      continue;
    call(work, parts - left, thread);
    if (done_.fetch_add(1, std::memory_order_acq_rel) + 1 == parts) done_.notify_all();
    ticket = ticket_.load(std::memory_order_acquire);
  }
}

void Parallel::wait_and_take_parts(int thread) {
  std::uint32_t seen = 0;
  for (;;) {
    wait_until(round_, [seen](std::uint32_t round) { return round != seen; });
    seen = round_.load(std::memory_order_acquire);
    if (over_.load(std::memory_order_relaxed)) return;
    take_parts(thread);
  }
}

int usable_processors() {
  cpu_set_t set;
  CPU_ZERO(&set);
  const bool known = sched_getaffinity(0, sizeof set, &set) == 0;  // refused where there are more than the set can hold
  const int processors = known ? CPU_COUNT(&set) : static_cast<int>(std::thread::hardware_concurrency());
  return std::max(processors, 1);
}

}  // namespace ricochet

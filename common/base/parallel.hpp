#pragma once

#include <atomic>
#include <cstdint>
#include <thread>
#include <type_traits>
#include <vector>

namespace ricochet {

/// Threads that compute together with the one that calls them. Which of them does what differs from call to call, so
/// parts of a work must not depend on each other; what each part computes is then the same for any number of threads.
///
/// Between two works the threads spin for some microseconds, as long as waking a thread takes, and then sleep. The
/// caller waits for the parts that others have begun, never for a thread that is still asleep: where processors are
/// busy otherwise, it does all of them by itself. One thread at a time may call.
class Parallel {
 public:
  /// `threads` >= 1, the caller's own among them. The others are started by the first work that has a part for them.
  explicit Parallel(int threads) : threads_(threads) {}
  Parallel(const Parallel&) = delete;
  Parallel& operator=(const Parallel&) = delete;
  ~Parallel();

  [[nodiscard]] int threads() const { return threads_; }
  /// work(part, thread) for each part 0 ... parts - 1, once; returns when all are done. `thread` is below threads() and
  /// no two parts at a time have the same one. It must not throw, nor call this again.
  template <class Work>
  void for_each(int parts, const Work& work) {
    static_assert(std::is_nothrow_invocable_v<const Work&, int, int>);
    run(parts, &work,
        [](const void* given, int part, int thread) { (*static_cast<const Work*>(given))(part, thread); });
  }

 private:
  using Call = void (*)(const void* work, int part, int thread);
  void run(int parts, const void* work, Call call);
  void take_parts(int thread);
  void wait_and_take_parts(int thread);

  const int threads_;
  std::vector<std::thread> others_;
  // One work is a round. Whoever takes a part takes one off those that are left in `ticket_`, which fails if somebody
  // else was faster. While some are left the caller waits, so that work, call and number that were read before belong
  // to them.
  std::atomic<const void*> work_{nullptr};
  std::atomic<Call> call_{nullptr};
  std::atomic<int> parts_{0};
  std::atomic<std::uint64_t> ticket_{0};  ///< round in the upper half, parts that are left in the lower
  std::atomic<int> done_{0};              ///< parts of this round
  std::atomic<std::uint32_t> round_{0};   ///< what sleepers look at
  std::atomic<bool> over_{false};
};

/// Processors that this process may run on.
[[nodiscard]] int usable_processors();

}  // namespace ricochet

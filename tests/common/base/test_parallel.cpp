#include <gtest/gtest.h>
#include <sched.h>

#include <array>
#include <chrono>
#include <ctime>
#include <numeric>
#include <thread>
#include <vector>

#include "common/base/parallel.hpp"

namespace ricochet {
namespace {

TEST(Parallel, DoesEveryPartOnceWhateverTheNumberOfThreads) {
  for (const int threads : {1, 2, 3, 7}) {
    Parallel parallel(threads);
    for (int parts = 0; parts < 200; ++parts) {
      std::vector<int> times(static_cast<std::size_t>(parts), 0);  // no atomics: a part is one thread's
      parallel.for_each(parts, [&](int part, int) noexcept { ++times[static_cast<std::size_t>(part)]; });
      EXPECT_EQ(times, std::vector<int>(static_cast<std::size_t>(parts), 1)) << threads << " threads";
    }
  }
}

TEST(Parallel, LetsTheNextWorkReadWhatTheLastOneWrote) {
  Parallel parallel(3);
  std::vector<long> values(64, 0), sums(64, 0);
  for (long round = 1; round <= 2000; ++round) {
    parallel.for_each(64, [&](int part, int) noexcept { values[static_cast<std::size_t>(part)] += part; });
    parallel.for_each(64, [&](int part, int) noexcept {
      sums[static_cast<std::size_t>(part)] = std::accumulate(values.begin(), values.end(), 0L);
    });
    for (const long sum : sums) ASSERT_EQ(sum, round * 2016);
  }
}

TEST(Parallel, GivesNoThreadTwoPartsAtATime) {
  constexpr int threads = 4;
  Parallel parallel(threads);
  std::array<long, threads> own{};  // no atomics: a number is one thread's
  for (int round = 0; round < 1000; ++round)
    parallel.for_each(16, [&](int, int thread) noexcept { ++own[static_cast<std::size_t>(thread)]; });
  EXPECT_EQ(std::accumulate(own.begin(), own.end(), 0L), 16000);
}

/// Threads of this process.
int threads_now() {
  int count = 0;
  std::FILE* file = std::fopen("/proc/self/status", "r");
  char line[256];
  while (file && std::fgets(line, sizeof line, file)) std::sscanf(line, "Threads: %d", &count);
  if (file) std::fclose(file);
  return count;
}

/// The system tells who waits for a thread's end a little before it counts the thread out.
bool comes_to(int threads) {
  const auto longest = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  while (threads_now() != threads && std::chrono::steady_clock::now() < longest) std::this_thread::yield();
  return threads_now() == threads;
}

TEST(Parallel, StartsThreadsForTheFirstWorkOfSeveralPartsAndEndsThem) {
  const int before = threads_now();
  {
    Parallel alone(1), idle(4), busy(4);
    alone.for_each(100, [](int, int) noexcept {});
    idle.for_each(1, [](int, int) noexcept {});
    EXPECT_EQ(threads_now(), before);
    busy.for_each(2, [](int, int) noexcept {});
    EXPECT_EQ(threads_now(), before + 3);
  }
  EXPECT_TRUE(comes_to(before));
}

double processor_s() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

TEST(Parallel, SleepsWhereThereIsNothingToDo) {
  Parallel parallel(4);
  parallel.for_each(8, [](int, int) noexcept {});
  const double before_s = processor_s();
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  EXPECT_LT(processor_s() - before_s, 0.03);  // spinning, each of the three would take 0.3 s of a processor
}

TEST(UsableProcessors, AreThoseOfTheProcessNotOfTheMachine) {
  cpu_set_t given;
  ASSERT_EQ(sched_getaffinity(0, sizeof given, &given), 0);
  EXPECT_EQ(usable_processors(), CPU_COUNT(&given));
  int first = 0;
  while (!CPU_ISSET(first, &given)) ++first;
  int found = 0;
  std::thread([&] {  // of this thread alone, so that other tests keep theirs
    cpu_set_t one;
    CPU_ZERO(&one);
    CPU_SET(first, &one);
    sched_setaffinity(0, sizeof one, &one);
    found = usable_processors();
  })
      .join();
  EXPECT_EQ(found, 1);
}

}  // namespace
}  // namespace ricochet

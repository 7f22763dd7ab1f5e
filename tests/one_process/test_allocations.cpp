// The stepping loop takes no memory from the heap: protocol, links, sessions and both solvers, in one process, where
// every allocation of the program is counted. (Not with the address sanitizer, which does the allocating then.)
#ifndef __SANITIZE_ADDRESS__
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/support/one_process.hpp"
#include "tests/support/run.hpp"

namespace {
long long allocations = 0;
}

// All of the C library's, since Eigen takes its memory there and not from `operator new`.
extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* memory, std::size_t size);
void* malloc(std::size_t size) {
  ++allocations;
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
  ++allocations;
  return __libc_calloc(count, size);
}
void* realloc(void* memory, std::size_t size) {
  ++allocations;
  return __libc_realloc(memory, size);
}
}

namespace ricochet {
namespace {

/// The reference scene; records of every window; it stays in contact.
std::string impact(const std::string& protocol, int substeps) {
  auto text = test::config_text("kim_impact");
  text = test::with_key(text, "time", "end_s", "22e-6");
  text = test::with_key(text, "output", "fields_every", "0");
  text = test::with_protocol(text, protocol);
  return substeps == 1 ? text : test::with_key(text, "coupling", "substeps", fmt::format("{}", substeps));
}

/// The allocations of a run but for its first deliveries of history rows, which let vectors reach their size.
struct Count {
  long long allocations = 0, windows = 0,
            deliveries = 0;  ///< allocations between deliveries, not by who takes the rows
  long long links = 0;
};

Count count(const std::string& text) {
  const test::TemporaryFolder folder;
  test::OneProcess run(folder.write(text));
  auto& links = run.coupling().links();
  Count result;
  result.links = static_cast<long long>(links.size());
  long long before = 0;
  int first = 8;  // those of a baseline double in length at first, and with them the buffers
  std::int64_t last_window = 0;
  run.run([&](std::int64_t window) {
    if (first > 0) {
      --first;
    } else {
      result.allocations += allocations - before;
      result.windows += window - last_window;
      ++result.deliveries;
    }
    last_window = window;
    for (auto& link : links) static_cast<void>(link.take_records());
    before = allocations;
  });
  return result;
}

class Window : public testing::TestWithParam<std::pair<const char*, int>> {};

/// A delivery gives each link's buffer away with the rows, and a long one makes the sessions' buffers grow. Nothing
/// else allocates. (The dense problems of `gravouil_combescure` and `fixed_point` do, in every window.)
TEST_P(Window, TakesNoMemory) {
  constexpr long long growth = 40;
  const auto found = count(impact(GetParam().first, GetParam().second));
  ASSERT_GT(found.windows, 100);
  EXPECT_LE(found.allocations, found.deliveries * found.links + growth)
      << "in " << found.windows << " windows and " << found.deliveries << " deliveries";
}

INSTANTIATE_TEST_SUITE_P(Protocols, Window,
                         testing::Values(std::pair{"hughes_liu", 1}, std::pair{"kim", 1}, std::pair{"kim_predicted", 1},
                                         std::pair{"belytschko_mullen", 1}, std::pair{"prakash_hjelmstad", 1},
                                         std::pair{"prakash_hjelmstad", 2}, std::pair{"all_implicit", 1},
                                         std::pair{"all_explicit", 1}),
                         [](const auto& test) { return fmt::format("{}_{}", test.param.first, test.param.second); });

}  // namespace
}  // namespace ricochet
#endif

// The stepping loop takes no memory from the heap: every allocation of this program is counted. (Not with the address
// sanitizer, which does the allocating then.)
#ifndef __SANITIZE_ADDRESS__
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <new>

#include "tests/participant/scripted_coupler.hpp"
#include "tests/support/spring_mass.hpp"

namespace {
std::atomic<long long> allocations = 0;
}

void* operator new(std::size_t size) {
  ++allocations;
  if (void* memory = std::malloc(size > 0 ? size : 1)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace ricochet::participant {
namespace {

TEST(Session, StepsWithoutAllocating) {
  SpringMass spring(100);
  InProcess run(spring, 100);
  run.coupler.history_every = 1'000'000;
  run.coupler.start();
  auto request = run.coupler.advance(1e-6);
  request.absolute_requested = true;
  wire::Message reply;
  const auto step = [&] {
    run.session.handle(request, reply);
    ++request.sequence;
    ++request.window;
  };
  for (int n = 0; n < 3; ++n) step();  // vectors reach their size
  const long long before = allocations;
  for (int n = 0; n < 100; ++n) step();
  EXPECT_EQ(allocations.load(), before);
}

}  // namespace
}  // namespace ricochet::participant
#endif

// The stepping loop takes no memory from the heap: every allocation of this program is counted. (Not with the address
// sanitizer, which does the allocating then.)
#ifndef __SANITIZE_ADDRESS__
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <new>

#include "common/wire/codec.hpp"
#include "common/wire/shared_memory.hpp"
#include "tests/common/participant/scripted_coupler.hpp"
#include "tests/support/private_endpoint.hpp"
#include "tests/support/spring_mass.hpp"

namespace {
std::atomic<long long> allocations = 0;
}

// Not inlined: GCC 12 would take the pair for a mismatch.
[[gnu::noinline]] void* operator new(std::size_t size) {
  ++allocations;
  if (void* memory = std::malloc(size > 0 ? size : 1)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace ricochet::participant {
namespace {

TEST(Session, StepsWithoutAllocating) {
  SpringMass spring(100);
  InProcess run(spring, 100);
  run.coupler.history_every = 1'000'000;
  run.coupler.start();
  auto request = run.coupler.advance(1e-6);
  request.as<wire::Advance>().absolute_requested = true;
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

/// Allocations of so many calls, after a few that let vectors reach their size.
template <class Call>
long long allocations_of(int calls, Call call) {
  for (int n = 0; n < 3; ++n) call();
  const long long before = allocations;
  for (int n = 0; n < calls; ++n) call();
  return allocations - before;
}

/// Both ends in one thread: nobody has to wait where a message fits the memory. The msgpack library allocates when it
/// decodes; nothing else does.
TEST(SharedMemory, PassesMessagesWithoutAllocating) {
  SpringMass spring(100);
  OverSocket coupler(private_endpoint(), 100);
  wire::Channel channel(coupler.listener.endpoint());
  wire::Message message;
  participant::Session(spring).hello(message);
  channel.offer_shared_memory(message.as<wire::Hello>());
  channel.send(message);
  const auto hello = coupler.hear();
  auto welcome = coupler.coupler.welcome();
  welcome.as<wire::Welcome>().shared_memory = true;
  coupler.say(welcome);
  channel.receive(message, wire::deadline_in(10), false);
  coupler.listener.share(coupler.identity(), wire::SharedMemory::open(hello.as<wire::Hello>().shared_memory_path,
                                                                      hello.as<wire::Hello>().shared_memory_key));
  const auto request = coupler.coupler.advance(1e-6);
  const auto exchange = [&] {
    coupler.say(request);
    channel.receive(message, wire::deadline_in(10), false);
    channel.send(message);
    ASSERT_EQ(coupler.hear().kind, wire::Kind::advance);
  };
  msgpack::sbuffer bytes;
  wire::encode(request, bytes);
  const auto decode = [&] { wire::decode({bytes.data(), bytes.size()}, "the test", message); };
  EXPECT_EQ(allocations_of(1000, exchange), allocations_of(2000, decode));
}

}  // namespace
}  // namespace ricochet::participant
#endif

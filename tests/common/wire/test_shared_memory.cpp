// Messages through memory that both ends share: the ring alone, the memory and who may open it, and channels over it.
#include <fcntl.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <sched.h>
#include <sys/mman.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <future>
#include <thread>

#include "common/base/error.hpp"
#include "common/wire/shared_memory.hpp"
#include "tests/common/wire/samples.hpp"
#include "tests/support/private_endpoint.hpp"

namespace ricochet::wire {
namespace {

using testing::HasSubstr;

template <class Failure = Error, class Call>
std::string error_of(Call call) {
  try {
    call();
  } catch (const Failure& error) {
    return error.what();
  }
  return "no error";
}

/// Text that differs from that of any other `n` at every length.
std::string text_of(std::size_t length, unsigned n) {
  std::string text(length, ' ');
  for (std::size_t i = 0; i < length; ++i) text[i] = static_cast<char>(i * 7 + n * 13 + (i >> 8));
  return text;
}

class Ring : public testing::Test {
 protected:
  bool receive() { return receiver_.receive("the peer"); }
  std::unique_ptr<RingMemory> memory_ = std::make_unique<RingMemory>();
  RingSender sender_{*memory_};
  RingReceiver receiver_{*memory_};
};

TEST_F(Ring, KeepsOrderAndBytesWhileItWrapsAround) {
  std::size_t bytes = 0;
  for (unsigned n = 0; bytes < 5 * std::size_t{RingMemory::capacity}; ++n) {
    const std::string first = text_of(1 + n * 37 % 9001, n), second = text_of(1 + n * 101 % 777, n + 1);
    sender_.send({first});
    sender_.send({second});
    ASSERT_TRUE(receive());
    ASSERT_EQ(receiver_.message(), first);
    ASSERT_TRUE(receive());
    ASSERT_EQ(receiver_.message(), second);
    ASSERT_FALSE(receive());
    bytes += first.size() + second.size();
  }
}

TEST_F(Ring, PassesInPiecesWhatIsLargerThanItself) {
  const std::string large = text_of(3 * RingMemory::capacity + 12345, 1), next = text_of(99, 2);
  sender_.send({large});
  sender_.send({next});  // stands behind the rest
  int pieces = 0;
  while (!receive()) {
    ++pieces;
    sender_.flush();
  }
  EXPECT_EQ(pieces, 3);
  EXPECT_TRUE(receiver_.message() == large);
  EXPECT_TRUE(receive() || (sender_.flush() && receive()));
  EXPECT_EQ(receiver_.message(), next);
  EXPECT_FALSE(sender_.has_rest());
}

TEST_F(Ring, JoinsPiecesOfAMessage) {
  const std::string head = text_of(100, 1), large = text_of(200'000, 2), rest = text_of(RingMemory::capacity, 3);
  sender_.send({head, large, head});
  ASSERT_TRUE(receive());
  EXPECT_TRUE(receiver_.message() == head + large + head);
  sender_.send({head, rest, large});
  while (!receive()) sender_.flush();
  EXPECT_TRUE(receiver_.message() == head + rest + large);
  sender_.send({head});
  ASSERT_TRUE(receive());
  EXPECT_EQ(receiver_.message(), head);
}

/// The receiver need not wait until the sender has copied the whole of a large message. Which thread runs when is
/// chance: one of many messages shows it.
TEST_F(Ring, ShowsTheBeginningOfALargeMessageBeforeItsEnd) {
  const std::string large = text_of(RingMemory::capacity / 2, 1);
  std::atomic<bool> seen = false;
  auto receiver = std::async(std::launch::async, [&] {
    const auto deadline = Clock::now() + std::chrono::seconds(20);
    while (!seen && Clock::now() < deadline) {
      const std::uint32_t before = memory_->read, written = memory_->written;
      if (written - before > 0 && written - before < large.size()) seen = true;
      receive();
    }
    seen = true;
    return Clock::now() < deadline;
  });
  while (!seen) {
    if (memory_->read == memory_->written) sender_.send({large});
  }
  EXPECT_TRUE(receiver.get());
}

TEST_F(Ring, TakesAHeaderThatComesInPieces) {
  const std::string fill = text_of(RingMemory::capacity - sizeof(RingHeader) - 5, 1), next = text_of(10, 2);
  sender_.send({fill});
  sender_.send({next});  // five bytes of its header fit
  EXPECT_TRUE(sender_.has_rest());
  ASSERT_TRUE(receive());
  EXPECT_TRUE(receiver_.message() == fill);
  EXPECT_FALSE(receive());
  EXPECT_TRUE(sender_.flush());
  ASSERT_TRUE(receive());
  EXPECT_EQ(receiver_.message(), next);
}

TEST_F(Ring, SaysWhatIsWrongWithBytesOfNobody) {
  const auto error_with = [](const RingHeader& header) {
    const auto memory = std::make_unique<RingMemory>();
    std::memcpy(memory->bytes, &header, sizeof header);
    memory->written = sizeof header;
    RingReceiver receiver(*memory);
    return error_of<ProtocolError>([&] { receiver.receive("the peer"); });
  };
  const auto magic = RingHeader::correct_magic;
  EXPECT_THAT(error_with({7, 0, 1}), HasSubstr("the peer corrupted the shared memory: no message begins with 0x00000"));
  EXPECT_THAT(error_with({magic, 3, 1}), HasSubstr("message 3 where message 0 was due"));
  EXPECT_THAT(error_with({magic, 0, 0}), HasSubstr("a message of 0 bytes"));
  EXPECT_THAT(error_with({magic, 0, std::uint64_t{1} << 40}), HasSubstr("a message of 1099511627776 bytes, allowed"));
  EXPECT_EQ(error_with({magic, 0, 1}), "no error");
}

TEST_F(Ring, DoesNotTrustCountersThatCannotBe) {
  memory_->written = RingMemory::capacity + 1;
  EXPECT_THAT(error_of<ProtocolError>([&] { receive(); }), HasSubstr("262145 bytes in a ring of 262144"));
  memory_->written = 0;
  memory_->read = 1;  // more than was ever written
  EXPECT_THAT(error_of<ProtocolError>([&] { sender_.send({"x"}); }), HasSubstr("the receiver corrupted the shared"));
  memory_->read = 0U - (RingMemory::capacity + 1);  // one byte more is unread than the ring holds
  EXPECT_THAT(error_of<ProtocolError>([&] { sender_.send({"x"}); }),
              HasSubstr("262145 bytes unread in a ring of 262144"));
}

TEST_F(Ring, CountsBeyond32Bits) {
  const std::string text = text_of(200'000, 3);
  const std::uint64_t rounds = (std::uint64_t{1} << 32) / text.size() + 10;
  for (std::uint64_t n = 0; n < rounds; ++n) {
    sender_.send({text});
    ASSERT_TRUE(receive()) << n;
  }
  EXPECT_TRUE(receiver_.message() == text);
}

/// A sender that comes at any moment of the wait, asleep or about to sleep, is noticed.
TEST_F(Ring, NoMessageIsSleptThrough) {
  constexpr int messages = 2000;
  const auto memory_back = std::make_unique<RingMemory>();
  RingSender back(*memory_back);
  RingReceiver echo(*memory_back);
  const auto take = [](RingReceiver& receiver) {
    while (!receiver.receive("the peer")) receiver.wait(deadline_in(60));  // far beyond the test's: it must be woken
  };
  std::thread other([&] {
    for (int n = 0; n < messages; ++n) {
      take(receiver_);
      std::this_thread::sleep_for(std::chrono::microseconds(n % 200));
      back.send({receiver_.message()});
    }
  });
  for (int n = 0; n < messages; ++n) {
    const std::string text = std::to_string(n);
    sender_.send({text});
    take(echo);
    ASSERT_EQ(echo.message(), text);
  }
  other.join();
}

/// Many messages of all short lengths, as fast as two threads can pass them, come in order and whole. The
/// environment variable RICOCHET_RING_MESSAGES says how many; docs/security.md has the time of 1e8.
TEST_F(Ring, KeepsOrderAndBytesOfMillions) {
  const char* asked = std::getenv("RICOCHET_RING_MESSAGES");
  const std::uint64_t messages = asked != nullptr ? std::stoull(asked) : 1'000'000;
  const auto write = [](std::uint64_t n, std::string& text) {
    text.resize(sizeof n + n % 61);
    std::memcpy(text.data(), &n, sizeof n);
    for (std::size_t i = sizeof n; i < text.size(); ++i) text[i] = static_cast<char>(n + 3 * i);
  };
  std::thread other([&] {
    std::string text;
    for (std::uint64_t n = 0; n < messages; ++n) {
      write(n, text);
      sender_.send({text});
      while (!sender_.flush()) sched_yield();
    }
  });
  std::string expected;
  std::uint64_t right = 0;
  for (std::uint64_t n = 0; n < messages; ++n) {
    while (!receive()) receiver_.wait(deadline_in(60));
    write(n, expected);
    right += receiver_.message() == expected ? 1 : 0;
  }
  other.join();
  EXPECT_EQ(right, messages);
  EXPECT_FALSE(receive());
}

// ---- the memory

double processor_seconds() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// Spinning is for answers that come at once: who waits for slow ones again and again leaves the processor to others.
TEST_F(Ring, WhoWaitsInVainSleeps) {
  sender_.send({"a"});
  ASSERT_TRUE(receive());
  memory_->processor = ~0U;  // on another processor than this one, wherever it runs
  const auto begin = Clock::now();
  const double processor_begin = processor_seconds();
  for (int n = 0; n < 300; ++n) receiver_.wait(deadline_in(0.001));
  const double waited = std::chrono::duration<double>(Clock::now() - begin).count();
  EXPECT_GE(waited, 0.3);
  EXPECT_LT(processor_seconds() - processor_begin, 0.1 * waited);
}

/// Whose sender would have to run on the same processor sleeps at once.
TEST_F(Ring, NobodySpinsOnTheSendersProcessor) {
  cpu_set_t before, one;
  ASSERT_EQ(sched_getaffinity(0, sizeof before, &before), 0);
  CPU_ZERO(&one);
  CPU_SET(sched_getcpu(), &one);
  ASSERT_EQ(sched_setaffinity(0, sizeof one, &one), 0);
  const auto processor_time_of_a_wait = [&](std::uint32_t processor) {
    RingReceiver receiver(*memory_);
    memory_->processor = processor;
    const double begin = processor_seconds();
    receiver.wait(deadline_in(0.001));
    return processor_seconds() - begin;
  };
  double here = 0, elsewhere = 0;
  for (int n = 0; n < 20; ++n) {
    here += processor_time_of_a_wait(static_cast<std::uint32_t>(sched_getcpu()));
    elsewhere += processor_time_of_a_wait(~0U);
  }
  ASSERT_EQ(sched_setaffinity(0, sizeof before, &before), 0);
  EXPECT_LT(here, 0.5 * elsewhere);
}

TEST(SharedMemory, WhatOneEndSendsTheOtherReceives) {
  const auto participant = SharedMemory::make();
  ASSERT_TRUE(participant);
  const auto coupler = SharedMemory::open(participant->path(), participant->key());
  participant->sender().send({"up"});
  coupler->sender().send({"down"});
  ASSERT_TRUE(coupler->receiver().receive("the peer"));
  ASSERT_TRUE(participant->receiver().receive("the coupler"));
  EXPECT_EQ(coupler->receiver().message(), "up");
  EXPECT_EQ(participant->receiver().message(), "down");
}

TEST(SharedMemory, OutlivesTheOtherEndAndLeavesNothing) {
  auto participant = SharedMemory::make();
  const std::string path = participant->path();
  const auto key = participant->key();
  const auto coupler = SharedMemory::open(path, key);
  participant->sender().send({"last words"});
  participant.reset();
  ASSERT_TRUE(coupler->receiver().receive("the peer"));
  EXPECT_EQ(coupler->receiver().message(), "last words");
  EXPECT_THAT(error_of<ConfigError>([&] { SharedMemory::open(path, key); }), HasSubstr("cannot be opened"));
}

std::string why_not(const std::string& path, std::int64_t key = 0) {
  return error_of<ConfigError>([&] { SharedMemory::open(path, key); });
}

std::string own_file(int descriptor) { return fmt::format("/proc/{}/fd/{}", getpid(), descriptor); }

TEST(SharedMemory, OpensNothingElse) {
  EXPECT_THAT(why_not("/dev/null"), HasSubstr("'/dev/null' cannot be opened: expected /proc/PROCESS/fd/NUMBER"));
  EXPECT_THAT(why_not("/proc/1/fd/../environ"), HasSubstr("expected /proc/PROCESS/fd/NUMBER"));
  EXPECT_THAT(why_not("/proc/999999999/fd/3"), HasSubstr("No such file"));
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  EXPECT_THAT(why_not(own_file(ends[0])), HasSubstr("it is pipe:"));
  close(ends[0]);
  close(ends[1]);
}

/// Memory with our label, without our size or without being protected from shrinking, as another release might make it.
TEST(SharedMemory, OpensNoneThatMayShrink) {
  const int small = memfd_create("ricochet", MFD_ALLOW_SEALING);
  ASSERT_EQ(fcntl(small, F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL), 0);
  EXPECT_THAT(why_not(own_file(small)), HasSubstr("the same release"));
  close(small);
  const auto sealed = SharedMemory::make();
  const int loose = memfd_create("ricochet", MFD_ALLOW_SEALING);
  ASSERT_EQ(ftruncate(loose, static_cast<off_t>(std::filesystem::file_size(sealed->path()))), 0);
  EXPECT_THAT(why_not(own_file(loose)), HasSubstr("may change"));
  close(loose);
}

/// A process number that came round, or one of another machine: the path leads somewhere, the key tells.
TEST(SharedMemory, OpensNoneOfAnotherRun) {
  const auto stale = SharedMemory::make(), mine = SharedMemory::make();
  EXPECT_NE(stale->key(), mine->key());
  for (const std::int64_t key : {stale->key(), mine->key() - 1, mine->key() + 1}) {
    EXPECT_THAT(why_not(mine->path(), key), HasSubstr("it is that of another process")) << key;
  }
}

// ---- channels

/// Coupler and participant that have said hello and welcome.
class OverSharedMemory : public testing::Test {
 protected:
  void SetUp() override {
    listener_ = std::make_unique<Listener>(private_endpoint());
    channel_ = std::make_unique<Channel>(listener_->endpoint());
    Message message = sample(Kind::hello);
    channel_->offer_shared_memory(message.as<Hello>());
    channel_->send(message);
    ASSERT_TRUE(receive(identity_, message));
    auto memory = SharedMemory::open(message.as<Hello>().shared_memory_path, message.as<Hello>().shared_memory_key);
    listener_->send(identity_, sample(Kind::welcome));
    listener_->limit(identity_, default_largest_message);
    listener_->share(identity_, std::move(memory));
    channel_->receive(message, deadline_in(10), false);
    ASSERT_TRUE(message.as<Welcome>().shared_memory);
  }
  bool receive(std::string& identity, Message& message, double timeout_s = 10.0) {
    return listener_->receive(identity, message, deadline_in(timeout_s), {}, [](std::size_t) { return true; });
  }
  void say(const Message& message) { listener_->send(identity_, message); }

  std::unique_ptr<Listener> listener_;
  std::unique_ptr<Channel> channel_;
  std::string identity_;
};

Message large_message() {
  Message message = sample(Kind::advance);
  message.as<Advance>().link_increment.resize(100'000, 3);
  auto& numbers = message.as<Advance>().link_increment.data;
  for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = 0.1 * static_cast<double>(i);
  return message;
}

TEST_F(OverSharedMemory, MessagesOfEveryKindGoThereAndBackAlsoLargeOnes) {
  auto participant = std::async(std::launch::async, [this] {
    Message message;
    for (std::size_t n = 0; n < all_kinds().size() + 2; ++n) {
      channel_->receive(message, deadline_in(10), false);
      channel_->send(message);
    }
    channel_.reset();  // after the rest of the last one
  });
  std::vector<Message> messages;
  for (const Kind kind : all_kinds()) messages.push_back(sample(kind));
  messages.insert(messages.begin() + 3, large_message());
  messages.push_back(large_message());
  for (const auto& sent : messages) {
    say(sent);
    Message message;
    std::string identity = identity_;
    ASSERT_TRUE(receive(identity, message));
    EXPECT_EQ(identity, identity_);
    expect_same(message, sent);
  }
  participant.get();
}

TEST_F(OverSharedMemory, ALargeMessageComesAlsoIfNobodyInParticularIsAwaited) {
  auto participant = std::async(std::launch::async, [this] {
    channel_->send(large_message());
    channel_.reset();
  });
  std::string nobody;
  Message message;
  ASSERT_TRUE(receive(nobody, message));
  EXPECT_EQ(nobody, identity_);
  expect_same(message, large_message());
  participant.get();
}

TEST_F(OverSharedMemory, AMessageThatNobodyReadsDelaysTheEndNoLongerThanItsLinger) {
  channel_->send(large_message());
  const auto begin = Clock::now();
  channel_.reset();
  EXPECT_GE(Clock::now() - begin, linger);
  EXPECT_LT(Clock::now() - begin, 6 * linger);
}

TEST_F(OverSharedMemory, SaysAtTheDeadlineThatTheCouplerIsSilent) {
  Message message;
  EXPECT_THAT(error_of<ParticipantError>([&] { channel_->receive(message, deadline_in(0.1), false); }),
              HasSubstr("the coupler has not answered within 0.1 s"));
  std::string identity = identity_;
  EXPECT_FALSE(receive(identity, message, 0.05));
}

TEST_F(OverSharedMemory, AParticipantNoticesThatTheCouplerIsGoneAfterItsLastWords) {
  say(sample(Kind::failure));
  listener_.reset();
  Message message;
  channel_->receive(message, deadline_in(60), false);
  EXPECT_EQ(message.kind, Kind::failure);
  EXPECT_THAT(error_of<ParticipantError>([&] { channel_->receive(message, deadline_in(60), false); }),
              HasSubstr("the coupler is gone: it closed the connection"));
}

TEST_F(OverSharedMemory, StrangersAndFilesAreHeardHoweverFastMessagesCome) {
  std::atomic<bool> over = false;
  auto participant = std::async(std::launch::async, [&] {
    Message message;
    while (!over) {
      channel_->receive(message, deadline_in(10), false);
      channel_->send(message);
    }
  });
  Channel stranger(listener_->endpoint());
  stranger.send(sample(Kind::hello));
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  ASSERT_EQ(write(ends[1], "x", 1), 1);
  const auto begin = Clock::now();
  bool heard = false, seen = false;
  const std::vector<int> pipe_end{ends[0]}, none;
  while (!(heard && seen) && Clock::now() - begin < std::chrono::seconds(10)) {
    say(sample(Kind::accept));
    for (bool answered = false; !answered;) {
      Message message;
      std::string identity = identity_;
      const auto& files = seen ? none : pipe_end;
      ASSERT_TRUE(listener_->receive(identity, message, deadline_in(10), files, [&](std::size_t) {
        char byte = 0;
        seen = read(ends[0], &byte, 1) == 1;
        return true;
      }));
      answered = identity == identity_;
      heard = heard || !answered;
    }
  }
  EXPECT_TRUE(heard);
  EXPECT_TRUE(seen);
  over = true;
  say(sample(Kind::accept));
  participant.get();
  close(ends[0]);
  close(ends[1]);
}

TEST_F(OverSharedMemory, WrongBytesOfAPeerAreAProtocolErrorOfThatPeer) {
  auto memory = SharedMemory::make();
  listener_->share("another", SharedMemory::open(memory->path(), memory->key()));
  memory->sender().send({"nonsense"});
  std::string identity = identity_;
  Message message;
  EXPECT_THAT(error_of<ProtocolError>([&] { receive(identity, message); }), HasSubstr("the peer sent"));
  EXPECT_EQ(identity, "another");
}

TEST(SharedMemoryOffer, NotOfferedButChosenIsAProtocolError) {
  Listener listener(private_endpoint());
  Channel channel(listener.endpoint());
  channel.send(sample(Kind::hello));
  std::string identity;
  Message message;
  ASSERT_TRUE(listener.receive(identity, message, deadline_in(10), {}, [](std::size_t) { return true; }));
  listener.send(identity, sample(Kind::welcome));
  EXPECT_THAT(error_of<ProtocolError>([&] { channel.receive(message, deadline_in(10), false); }),
              HasSubstr("shared memory, which 'hello' has not offered"));
}

}  // namespace
}  // namespace ricochet::wire

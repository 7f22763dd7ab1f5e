// An explicit participant with one bad habit; its name says which (`habits` below). The fault tests have it started in
// place of explicit_solver, with the same arguments. It computes what explicit_solver computes, but speaks to the
// coupler past the checks of `serve`.
#include <fcntl.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <zmq.hpp>

#include "common/base/error.hpp"
#include "common/participant/session.hpp"
#include "common/problem/problem.hpp"
#include "common/wire/codec.hpp"
#include "common/wire/shared_memory.hpp"
#include "explicit_solver/explicit_solver.hpp"

namespace ricochet {
namespace {

using wire::Kind;
using wire::Message;

/// The wire without any care, over ZeroMQ or through shared memory, as the coupler decides.
class Line {
 public:
  Line(const std::string& endpoint, const wire::ParticipantKey& key) : endpoint_(endpoint), key_(key) {
    socket_.set(zmq::sockopt::linger, 500);
    socket_.set(zmq::sockopt::curve_serverkey, key.coupler_public_key);
    socket_.set(zmq::sockopt::curve_publickey, key.own.public_key);
    socket_.set(zmq::sockopt::curve_secretkey, key.own.secret_key);
    socket_.connect(endpoint);
  }
  [[nodiscard]] const std::string& endpoint() const { return endpoint_; }
  [[nodiscard]] const wire::ParticipantKey& key() const { return key_; }
  void offer_shared_memory(Message& message) {
    message.as<wire::Hello>().shared_memory_path = memory_->path();
    message.as<wire::Hello>().shared_memory_key = memory_->key();
  }
  void say_bytes(std::string_view bytes, zmq::send_flags flags = zmq::send_flags::none) {
    if (shared_) memory_->sender().send({bytes});
    if (!shared_) socket_.send(zmq::const_buffer(bytes.data(), bytes.size()), flags);
  }
  void say(const Message& message) { say_bytes(encoded(message)); }
  [[nodiscard]] static std::string encoded(const Message& message) {
    msgpack::sbuffer buffer;
    wire::encode(message, buffer);
    return {buffer.data(), buffer.size()};
  }
  /// Adds to the count of bytes written to the coupler (docs/wire.md), without writing any.
  void claim_bytes(std::uint32_t count) {
    constexpr off_t written_at = 262'336;
    std::uint32_t written = 0;
    const int file = open(memory_->path().c_str(), O_RDWR);
    if (pread(file, &written, sizeof written, written_at) != sizeof written) throw std::runtime_error("cannot read");
    written += count;
    if (pwrite(file, &written, sizeof written, written_at) != sizeof written) throw std::runtime_error("cannot write");
    close(file);
  }
  void hear(Message& message) {
    if (shared_) {
      auto& receiver = memory_->receiver();
      while (!receiver.receive("the coupler")) receiver.wait(wire::deadline_in(1.0));
      wire::decode(receiver.message(), "the coupler", message);
      return;
    }
    zmq::message_t frame;
    if (!socket_.recv(frame)) throw std::runtime_error("no message");
    wire::decode({frame.data<char>(), frame.size()}, "the coupler", message);
    shared_ = message.kind == Kind::welcome && message.as<wire::Welcome>().shared_memory;
  }

 private:
  std::string endpoint_;
  wire::ParticipantKey key_;
  zmq::context_t context_;
  zmq::socket_t socket_{context_, zmq::socket_type::dealer};
  std::unique_ptr<wire::SharedMemory> memory_ = wire::SharedMemory::make();
  bool shared_ = false;
};

constexpr int bad_window = 40;

void say_nan(Line& line, Message message) {
  message.as<wire::Advanced>().increment.data[0] = std::numeric_limits<double>::quiet_NaN();
  line.say(message);
}

void say_short(Line& line, Message message) {
  message.as<wire::Advanced>().increment.resize(message.as<wire::Advanced>().increment.rows - 1,
                                                message.as<wire::Advanced>().increment.columns);
  line.say(message);
}

void say_other_kind(Line& line, Message message) {
  message.make<wire::Accepted>();
  line.say(message);
}

void say_twice(Line& line, Message message) {
  line.say(message);
  ++message.sequence;
  line.say(message);
}

void say_of_another_run(Line& line, Message message) {
  message.run_id = "20200101-000000-1-deadbeef";
  line.say(message);
}

void say_nonsense(Line& line, const Message&) { line.say_bytes("\xff\x00 what is this"); }

void say_two_frames(Line& line, const Message& message) {
  line.say_bytes("one", zmq::send_flags::sndmore);
  line.say(message);
}

void say_half(Line& line, const Message& message) {
  const std::string bytes = Line::encoded(message);
  line.say_bytes(bytes.substr(0, bytes.size() / 2));
}

void claim_too_much(Line& line, const Message&) { line.claim_bytes(1'000'000); }

void claim_what_is_not_there(Line& line, const Message&) { line.claim_bytes(24); }

void offer_nothing(Line& line, Message message) {
  message.as<wire::Hello>().shared_memory_path.clear();
  message.as<wire::Hello>().shared_memory_key = 0;
  line.say(message);
}

void offer_what_is_another_process(Line& line, Message message) {
  ++message.as<wire::Hello>().shared_memory_key;
  line.say(message);
}

/// The memory of a process that was killed cannot be opened any more; here it never could.
void die_after_hello(Line& line, Message message) {
  auto& hello = message.as<wire::Hello>();
  hello.shared_memory_path = "/proc/" + std::to_string(getpid()) + "/fd/100000";
  line.say(message);
  std::this_thread::sleep_for(std::chrono::milliseconds(50));  // so that the message gets away
  std::raise(SIGKILL);
}

void lose_one(Line& line, Message message) {
  ++message.sequence;
  line.say(message);
}

void say_another_version(Line& line, Message message) {
  message.version = 99;
  line.say(message);
}

void say_another_role(Line& line, Message message) {
  message.as<wire::Hello>().role = "implicit";
  line.say(message);
}

void say_another_scene(Line& line, Message message) {
  message.as<wire::Hello>().scene_sha256 = std::string(64, 'f');
  line.say(message);
}

void say_first_thing_wrong(Line& line, Message message) {
  message.make<wire::Description>();
  line.say(message);
}

/// Nonsense by the thousand of somebody with the same key, then properly.
void bring_a_flood(Line& line, const Message& message) {
  Line stranger(line.endpoint(), line.key());
  for (int i = 0; i < 50'000; ++i) stranger.say_bytes("nonsense");
  line.say(message);
}

void give_up(Line& line, Message message, ExitCode code, const std::string& why) {
  auto& failure = message.make<wire::Failure>();
  failure.error_code = static_cast<std::int64_t>(code);
  failure.error_text = why;
  line.say(message);
  usleep(100'000);  // time for the message to get out
  _exit(static_cast<int>(code));
}

void diverge(Line& line, const Message& message) { give_up(line, message, ExitCode::unstable, "it diverges"); }

void find_disk_full(Line& line, const Message& message) { give_up(line, message, ExitCode::participant, "disk full"); }

void exit_silently(Line&, const Message&) { _exit(7); }

void exit_badly_after(Line& line, const Message& message) {
  line.say(message);
  usleep(100'000);  // time for the message to get out
  _exit(9);
}

void say_transposed(Line& line, Message message) {
  std::swap(message.as<wire::Advanced>().increment.rows, message.as<wire::Advanced>().increment.columns);
  line.say(message);
}

void say_far_window(Line& line, Message message) {
  message.window = std::int64_t{1} << 62;
  line.say(message);
}

void say_no_rows(Line& line, Message message) {
  auto& records = message.as<wire::Finished>().records;
  records.resize(0, records.columns);
  line.say(message);
}

void say_far_row(Line& line, Message message) {
  message.as<wire::Advanced>().records.resize(1, message.as<wire::Advanced>().records.columns);
  message.as<wire::Advanced>().records.data[0] = 1e300;
  line.say(message);
}

void say_absolute(Line& line, Message message) {
  auto& answer = message.as<wire::Advanced>();
  answer.absolute = answer.increment;
  line.say(message);
}

void say_rates(Line& line, Message message) {
  auto& answer = message.as<wire::Advanced>();
  answer.velocity_m_s = answer.acceleration_m_s2 = answer.increment;
  line.say(message);
}

void say_departures(Line& line, Message message) {
  auto& departures = message.as<wire::Advanced>().departures;
  departures.resize(1, wire::departure_columns);
  departures.data[0] = 1;
  line.say(message);
}

void say_separated(Line& line, Message message) {
  message.as<wire::Advanced>().separated = true;
  line.say(message);
}

void say_no_absolute(Line& line, Message message) {
  message.as<wire::Advanced>().absolute.resize(0, 1);
  line.say(message);
}

void say_a_long_array(Line& line, const Message&) {
  constexpr std::size_t values = 0x11170;
  line.say_bytes(std::string("\x81\xa4kind\xdd\x00\x01\x11\x70", 11) + std::string(values, '\x01'));
}

void describe_negative_step(Line& line, Message message) {
  message.as<wire::Description>().critical_time_step_s = -1.0;
  line.say(message);
}

void describe_second_owner(Line& line, Message message) {
  message.as<wire::Description>().contact_owner = true;
  line.say(message);
}

void describe_huge_mass(Line& line, Message message) {
  message.as<wire::Description>().interface_mass_kg.data[0] = 1e300;
  line.say(message);
}

void describe_transposed(Line& line, Message message) {
  std::swap(message.as<wire::Description>().interface_mass_kg.rows,
            message.as<wire::Description>().interface_mass_kg.columns);
  line.say(message);
}

/// Small integers, a byte each, of which each takes 24 bytes when it is unpacked.
void say_small_integers(Line& line, const Message&) {
  std::string bytes = "\x81\xa4kind\xdd";
  bytes += std::string("\x00\x00\x00\x09", 4);
  for (int i = 0; i < 9; ++i) bytes += std::string("\xdd\x00\x00\x40\x00", 5) + std::string(0x4000, '\x01');
  line.say_bytes(bytes);
}

void say_too_much(Line& line, const Message&) { line.say_bytes(std::string(100'000'000, '\x01')); }

/// Lives on, connected, and takes nothing of what it is sent.
void stop_reading(Line& line, const Message& message) {
  line.say(message);
  for (;;) pause();
}

/// Text for ever, in lines of any length, with what would take a terminal over.
void print_for_ever(Line&, const Message&) {
  const std::string text = "\x1b]0;mine\x07\x1b[2J" + std::string(1 << 20, 'x');
  for (;;) std::fputs(text.c_str(), stderr);
}

void print_escapes_and_end(Line&, const Message&) {
  std::fputs((std::string(50'000'000, 'x') + "\x1b]0;mine\x07\x1b[2J\nlast words\n").c_str(), stderr);
  std::fflush(stderr);
  _exit(7);
}

struct Habit {
  Kind when;
  std::function<void(Line&, const Message&)> say;
};

const std::map<std::string, Habit> habits = {
    {"says_nan", {Kind::advanced, say_nan}},
    {"says_too_few_numbers", {Kind::advanced, say_short}},
    {"says_another_kind", {Kind::advanced, say_other_kind}},
    {"answers_twice", {Kind::advanced, say_twice}},
    {"means_another_run", {Kind::advanced, say_of_another_run}},
    {"says_nonsense", {Kind::advanced, say_nonsense}},
    {"says_two_frames", {Kind::advanced, say_two_frames}},
    {"says_half", {Kind::advanced, say_half}},
    {"loses_a_message", {Kind::advanced, lose_one}},
    {"claims_too_many_bytes", {Kind::advanced, claim_too_much}},
    {"claims_bytes_never_written", {Kind::advanced, claim_what_is_not_there}},
    {"offers_no_memory", {Kind::hello, offer_nothing}},
    {"offers_memory_of_another", {Kind::hello, offer_what_is_another_process}},
    {"dies_after_hello", {Kind::hello, die_after_hello}},
    {"diverges", {Kind::advanced, diverge}},
    {"finds_the_disk_full", {Kind::advanced, find_disk_full}},
    {"exits_silently", {Kind::advanced, exit_silently}},
    {"exits_badly_after_all", {Kind::finished, exit_badly_after}},
    {"greets_in_another_version", {Kind::hello, say_another_version}},
    {"greets_with_nonsense", {Kind::hello, say_nonsense}},
    {"greets_too_late", {Kind::hello, say_first_thing_wrong}},
    {"has_another_role", {Kind::hello, say_another_role}},
    {"read_another_scene", {Kind::hello, say_another_scene}},
    {"says_transposed", {Kind::advanced, say_transposed}},
    {"says_far_window", {Kind::advanced, say_far_window}},
    {"says_no_rows", {Kind::finished, say_no_rows}},
    {"says_far_row", {Kind::advanced, say_far_row}},
    {"says_absolute_unasked", {Kind::advanced, say_absolute}},
    {"says_rates_unasked", {Kind::advanced, say_rates}},
    {"says_records_unasked", {Kind::advanced, say_departures}},
    {"says_contact_of_others", {Kind::advanced, say_separated}},
    {"says_a_long_array", {Kind::advanced, say_a_long_array}},
    {"leaves_out_absolute", {Kind::advanced, say_no_absolute}},
    {"describes_negative_step", {Kind::description, describe_negative_step}},
    {"describes_second_owner", {Kind::description, describe_second_owner}},
    {"describes_huge_mass", {Kind::description, describe_huge_mass}},
    {"describes_transposed", {Kind::description, describe_transposed}},
    {"says_small_integers", {Kind::advanced, say_small_integers}},
    {"says_too_much", {Kind::advanced, say_too_much}},
    {"never_reads", {Kind::hello, stop_reading}},
    {"stops_reading", {Kind::advanced, stop_reading}},
    {"prints_for_ever", {Kind::advanced, print_for_ever}},
    {"prints_escapes", {Kind::advanced, print_escapes_and_end}},
    {"brings_a_flood", {Kind::hello, bring_a_flood}},
};

std::string argument(int argc, char** argv, std::string_view option) {
  for (int i = 1; i + 1 < argc; ++i) {
    if (argv[i] == option) return argv[i + 1];
  }
  throw ConfigError("no " + std::string(option));
}

void take_part(participant::Session& session, Line& line, const Habit& habit) {
  const auto say = [&](const Message& message) {
    const bool now = message.kind == habit.when && (message.kind != Kind::advanced || message.window == bad_window);
    if (now) habit.say(line, message);
    if (!now) line.say(message);
  };
  Message request, reply;
  session.hello(reply);
  line.offer_shared_memory(reply);
  say(reply);
  while (!session.over()) {
    line.hear(request);
    if (session.handle(request, reply)) say(reply);
  }
}

}  // namespace
}  // namespace ricochet

int main(int argc, char** argv) {
  using namespace ricochet;
  try {
    const std::string name = argument(argc, argv, "--name");
    auto problem = scene::build_problem(scene::load_scene(argument(argc, argv, "--scene")));
    explicit_solver::ExplicitSolver solver(std::move(problem), name);
    participant::Session session(solver);
    Line line(argument(argc, argv, "--connect"), wire::read_key(argument(argc, argv, "--key"), 0.0));
    take_part(session, line, habits.at(name));
    return 0;
  } catch (const Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return static_cast<int>(error.code());
  }
}

#include "tests/bench/exchange.hpp"

#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstddef>
#include <utility>
#include <vector>
#include <zmq.hpp>

#include "common/base/error.hpp"
#include "common/wire/codec.hpp"
#include "tests/support/places.hpp"

namespace ricochet::bench {
namespace {

constexpr int components = 2, warm_up = 200, timeout_ms = 30'000;

std::size_t encoded_bytes(wire::Message message) {
  message.run_id = "20000101T000000-00000-00000000";
  msgpack::sbuffer buffer;
  wire::encode(message, buffer);
  return buffer.size();
}

/// Bytes of the answer of a participant that moves the nodes, or of one that is moved.
std::size_t bytes_of_advanced(int nodes, bool moves) {
  wire::Message message;
  auto& answer = message.make<wire::Advanced>();
  answer.increment.resize(nodes, components);
  for (auto* rates : {&answer.velocity_m_s, &answer.acceleration_m_s2}) rates->resize(moves ? nodes : 0, components);
  return encoded_bytes(std::move(message));
}

struct Bytes {
  std::size_t down = 0, up = 0;  ///< from the coupler, to it
};

Bytes bytes_of_a_window(int nodes) {
  wire::Message advance;
  advance.make<wire::Advance>().link_increment.resize(nodes, components);
  return {2 * encoded_bytes(std::move(advance)), bytes_of_advanced(nodes, false) + bytes_of_advanced(nodes, true)};
}

/// Answers every message until an empty one, or none, comes.
void answer(const std::string& endpoint, std::size_t bytes) {
  zmq::context_t context(1);
  zmq::socket_t socket(context, zmq::socket_type::pair);
  socket.set(zmq::sockopt::rcvtimeo, timeout_ms);
  socket.connect(endpoint);
  const std::vector<std::byte> reply(bytes);
  zmq::message_t message;
  while (socket.recv(message) && message.size() > 0) socket.send(zmq::buffer(reply));
}

}  // namespace

std::string echo_participants(int nodes) {
  std::string text;
  for (const char* role : {"explicit", "implicit"}) {
    text += fmt::format(
        "[[participant]]\nname = \"{0}_{1}\"\nrole = \"{0}\"\nexecutable = \"{2}/echo_participant\"\n"
        "differing_bodies = [\"steel\", \"carbide\"]\n",
        role, nodes, test::build_folder());
    if (std::string(role) == "explicit") text += "bodies = [\"steel\", \"carbide\"]\n";
  }
  return text;
}

double ping_pong_s(int nodes, int exchanges) {
  const Bytes bytes = bytes_of_a_window(nodes);
  const std::string endpoint = fmt::format("ipc://@ricochet-bench-{}-{}", getpid(), nodes);
  const pid_t child = fork();  // before there is a context: ZeroMQ's threads do not survive a fork
  if (child < 0) throw ParticipantError("cannot start another process");
  if (child == 0) {
    answer(endpoint, bytes.up);
    _exit(0);
  }
  zmq::context_t context(1);
  zmq::socket_t socket(context, zmq::socket_type::pair);
  socket.set(zmq::sockopt::rcvtimeo, timeout_ms);
  socket.bind(endpoint);
  const std::vector<std::byte> question(bytes.down);
  zmq::message_t message;
  auto begin = std::chrono::steady_clock::now();
  for (int i = -warm_up; i < exchanges; ++i) {
    if (i == 0) begin = std::chrono::steady_clock::now();
    socket.send(zmq::buffer(question));
    if (!socket.recv(message)) throw ParticipantError("the other end of the ping-pong does not answer");
  }
  const std::chrono::duration<double> time = std::chrono::steady_clock::now() - begin;
  socket.send(zmq::buffer("", 0));
  waitpid(child, nullptr, 0);
  return time.count() / exchanges;
}

}  // namespace ricochet::bench

#pragma once

#include <string>
#include <string_view>
#include <vector>
#include <zmq.hpp>

#include "common/wire/channel.hpp"

/// The settings that both ends of a ZeroMQ connection give their sockets.
namespace ricochet::wire {

[[nodiscard]] zmq::socket_t make_socket(zmq::context_t& context, zmq::socket_type type);

/// Throws the ConfigError of an address that is none, or cannot be had; `what`: "connect to" | "listen at".
[[noreturn]] void refuse_endpoint(const std::string& endpoint, const char* what, const zmq::error_t& error);

/// zmq::poll until the deadline; false if it has passed. Signals do not end the wait.
bool poll(std::vector<zmq::pollitem_t>& items, Deadline deadline);

/// The next frame, if it is there already.
bool receive_frame(zmq::socket_t& socket, zmq::message_t& frame);

/// Decodes a message whose only frame is `payload`.
void decode_frame(zmq::socket_t& socket, zmq::message_t& payload, std::string_view sender, Message& message);

/// Throws ParticipantError if the connection takes nothing more.
void send_frame(zmq::socket_t& socket, const void* data, std::size_t size, zmq::send_flags flags);

}  // namespace ricochet::wire

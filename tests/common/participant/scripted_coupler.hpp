#pragma once

#include <functional>
#include <stdexcept>
#include <string>
#include <utility>

#include "common/participant/session.hpp"
#include "common/wire/channel.hpp"

namespace ricochet::participant {

/// The requests of a coupler, with the header filled in. How they get to the participant is the caller's affair.
class ScriptedCoupler {
 public:
  /// `ask` delivers a request and brings the answer.
  using Ask = std::function<const wire::Message&(const wire::Message&)>;
  ScriptedCoupler(Ask ask, int nodes) : ask_(std::move(ask)), nodes_(nodes) {}

  wire::Message request(wire::Kind kind) {
    wire::Message message;
    message.kind = kind;
    message.run_id = "run-1";
    message.sequence = sequence_++;
    message.window = window;
    return message;
  }
  const wire::Message& ask(const wire::Message& message) { return ask_(message); }
  const wire::Message& ask(wire::Kind kind) { return ask_(request(kind)); }

  wire::Message welcome() {
    auto message = request(wire::Kind::welcome);
    message.as<wire::Welcome>().participant = "spring";
    message.as<wire::Welcome>().timeout_s = timeout_s;
    return message;
  }
  wire::Message initialize() {
    auto message = request(wire::Kind::initialize);
    message.as<wire::Initialize>().protocol = "hughes_liu";
    message.as<wire::Initialize>().output_directory = "/results";
    message.as<wire::Initialize>().window_size_s = 0.01;
    message.as<wire::Initialize>().driven_by = driven_by;
    message.as<wire::Initialize>().interface_mass_kg.resize(nodes_, 1);
    message.as<wire::Initialize>().interface_mass_kg.data.assign(static_cast<std::size_t>(nodes_), 2.5);
    message.as<wire::Initialize>().directions.resize(1, 1);
    message.as<wire::Initialize>().directions.data = {1.0};
    message.as<wire::Initialize>().scene_position_m.resize(nodes_, 1);
    message.as<wire::Initialize>().history_every = history_every;
    message.as<wire::Initialize>().fields_every = fields_every;
    message.as<wire::Initialize>().last_window = last_window;
    return message;
  }
  wire::Message synchronise(double link = 0.0) {
    auto message = request(wire::Kind::synchronise);
    message.as<wire::Synchronise>().integration = "explicit_central";
    message.as<wire::Synchronise>().link_absolute.resize(nodes_, 1);
    for (auto& value : message.as<wire::Synchronise>().link_absolute.data) value = link;
    return message;
  }
  /// The next window, by an increment of all link inputs. `window` is the last accepted one.
  wire::Message advance(double increment, bool accept_at_once = true) {
    auto message = request(wire::Kind::advance);
    message.window = window + 1;
    message.as<wire::Advance>().link_increment.resize(nodes_, 1);
    for (auto& value : message.as<wire::Advance>().link_increment.data) value = increment;
    message.as<wire::Advance>().link_absolute.resize(0, 1);
    message.as<wire::Advance>().accept_at_once = accept_at_once;
    if (accept_at_once) ++window;
    return message;
  }
  /// From `describe` to the first window.
  void start() {
    ask(wire::Kind::describe);
    ask(initialize());
    ask(synchronise());
  }

  std::int64_t window = 0, history_every = 1, fields_every = 0, last_window = 1000;
  double timeout_s = 10.0;
  std::string driven_by = "displacement";

 private:
  Ask ask_;
  int nodes_;
  std::int64_t sequence_ = 0;
};

/// A coupler and a participant in one process, without a socket.
class InProcess {
 public:
  InProcess(Participant& participant, int nodes)
      : session(participant),
        coupler([this](const wire::Message& m) -> const wire::Message& { return deliver(m); }, nodes) {
    session.hello(reply_);
    session.handle(coupler.welcome(), reply_);
  }
  Session session;
  ScriptedCoupler coupler;

 private:
  const wire::Message& deliver(const wire::Message& message) {
    if (!session.handle(message, reply_)) throw std::logic_error("no reply");
    return reply_;
  }
  wire::Message reply_;
};

/// A coupler that listens on a socket for one participant.
class OverSocket {
 public:
  explicit OverSocket(const std::string& endpoint, int nodes = 1)
      : listener(endpoint),
        coupler([this](const wire::Message& m) -> const wire::Message& { return deliver(m); }, nodes) {}

  const wire::Message& hear(double timeout_s = 10.0) {
    const auto nothing = [](std::size_t) { return true; };
    if (!listener.receive(identity_, message_, wire::deadline_in(timeout_s), {}, nothing)) {
      throw std::runtime_error("the participant is silent");
    }
    return message_;
  }
  void say(const wire::Message& message) { listener.send(identity_, message); }
  /// Hears hello and says welcome.
  void meet() {
    hear();
    say(coupler.welcome());
  }
  [[nodiscard]] const std::string& identity() const { return identity_; }

  wire::Listener listener;
  ScriptedCoupler coupler;

 private:
  const wire::Message& deliver(const wire::Message& message) {
    say(message);
    return hear();
  }
  std::string identity_;
  wire::Message message_;
};

}  // namespace ricochet::participant

#include "common/participant/session.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>

#include "common/base/process.hpp"
#include "common/wire/codec.hpp"

namespace ricochet::participant {
namespace {

using Clock = std::chrono::steady_clock;
using wire::Kind;
using wire::Message;

double seconds(Clock::duration duration) { return std::chrono::duration<double>(duration).count(); }

ExitCode exit_code(std::int64_t code) {
  for (const auto known :
       {ExitCode::config, ExitCode::unstable, ExitCode::protocol, ExitCode::model, ExitCode::machine}) {
    if (code == static_cast<std::int64_t>(known)) return known;
  }
  return ExitCode::participant;
}

Description checked(Description d) {
  const auto require = [&d](bool holds, const std::string& what) {
    if (!holds) throw ParticipantError(fmt::format("participant '{}' describes itself wrongly: {}", d.name, what));
  };
  require(!d.name.empty(), "it has no name");
  require(d.components >= 1 && d.components <= 3,
          fmt::format("it has {} components per node, allowed are 1 to 3", d.components));
  const auto count = d.interface_body.size();
  require(d.interface_position_m.size() == count * static_cast<std::size_t>(d.components) &&
              d.interface_mass_kg.size() == count,
          fmt::format("it has {} interface nodes of {} components, but {} coordinates and {} masses", count,
                      d.components, d.interface_position_m.size(), d.interface_mass_kg.size()));
  d.record_columns.insert(d.record_columns.begin(), "window");
  if (!d.probe_columns.empty()) d.probe_columns.insert(d.probe_columns.begin(), "window");
  if (!d.axial_stress_columns.empty()) d.axial_stress_columns.insert(d.axial_stress_columns.begin(), "window");
  return d;
}

}  // namespace

void Participant::advance_substep(std::int64_t, int, const std::vector<double>&, LinkOutput&) {
  throw ParticipantError("the participant announces the capability 'single_substep', but does not implement it");
}

void Participant::reconfigure(const Setup&) {
  throw ParticipantError("the participant announces the capability 'reconfigure', but does not implement it");
}

Session::Session(Participant& participant)
    : participant_(participant),
      description_(checked(participant.describe())),
      link_(static_cast<int>(description_.interface_body.size()), description_.components),
      nodes_(static_cast<int>(description_.interface_body.size())) {
  can_repeat_ = can(Capability::repeat_window);
  moves_ = description_.role == Role::implicit_solver;
  spans_.reserve(3 * max_spans);
}

bool Session::can(Capability capability) const {
  const auto& capabilities = description_.capabilities;
  return std::find(capabilities.begin(), capabilities.end(), capability) != capabilities.end();
}

void Session::hello(Message& message) {
  auto& hello = message.make<wire::Hello>();
  hello.participant = description_.name;
  hello.role = name_of(description_.role);
  hello.solver = description_.solver;
  hello.solver_version = description_.solver_version;
  hello.scene_sha256 = description_.scene_sha256;
  hello.process_id = getpid();
  hello.machine = machine_name();
  send(message);
}

void Session::failure(ExitCode code, const std::string& text, Message& message) {
  auto& failure = message.make<wire::Failure>();
  failure.error_code = static_cast<std::int64_t>(code);
  failure.error_culprit = description_.name;
  failure.error_text = text;
  send(message);
}

void Session::progress(std::string_view doing, double share_done, Message& message) {
  auto& progress = message.make<wire::Progress>();
  progress.doing = doing;
  progress.share_done = share_done;
  send(message);
}

/// Completes a message of this end.
void Session::send(Message& message) {
  message.version = wire::protocol_version;
  message.run_id = run_id_;
  message.sequence = sequence_;
  message.window = window_;
  message.substep = substep_;
  wire::require_finite(message);
  lifecycle_.step(wire::Side::participant, message, description_.name);
  ++sequence_;
}

bool Session::handle(const Message& request, Message& reply) {
  lifecycle_.step(wire::Side::coupler, request, description_.name);
  if (request.kind == Kind::failure) {
    const auto& failure = request.as<wire::Failure>();
    throw Error(exit_code(failure.error_code), fmt::format("the coupler ended the run: {}", failure.error_text));
  }
  if (request.kind == Kind::welcome) {
    welcome(request.as<wire::Welcome>(), request.run_id);
    return false;
  }
  check_run(request);
  const auto begin = Clock::now();
  finish_window();
  answer(request, reply);
  note_time(begin);
  if (reply.kind == Kind::finished) put_times(reply.as<wire::Finished>());
  send(reply);
  return true;
}

void Session::work_ahead() {
  if (!synchronised_) return;
  const auto begin = Clock::now();
  finish_window();
  participant_.work_ahead();
  note_time(begin);
}

void Session::welcome(const wire::Welcome& request, const std::string& run_id) {
  if (request.participant != description_.name) {
    throw ProtocolError(
        fmt::format("the coupler welcomed participant '{}', this is '{}'", request.participant, description_.name));
  }
  if (!(request.timeout_s > 0)) {
    throw ProtocolError(fmt::format("the coupler set the timeout {} s, expected more than 0", request.timeout_s));
  }
  run_id_ = run_id;
  timeout_s_ = request.timeout_s;
}

void Session::check_run(const wire::Header& request) const {
  if (request.run_id == run_id_) return;
  throw ProtocolError(fmt::format("the coupler sent '{}' of run '{}', this is run '{}'", wire::name(request.kind),
                                  request.run_id, run_id_));
}

/// Everything between a request and its reply counts as computing.
void Session::note_time(Instant begin) {
  const auto end = Clock::now();
  compute_s_ += seconds(end - begin);
  if (spans_.size() >= 3 * max_spans) return;
  spans_.push_back(static_cast<double>(window_));
  spans_.push_back(seconds(begin.time_since_epoch()));
  spans_.push_back(seconds(end.time_since_epoch()));
}

void Session::answer(const Message& request, Message& reply) {
  switch (request.kind) {
    case Kind::describe: return describe(reply.make<wire::Description>());
    case Kind::initialize: return initialize(request.as<wire::Initialize>(), reply.make<wire::Initialized>());
    case Kind::synchronise: return synchronise(request.as<wire::Synchronise>(), reply.make<wire::Synchronised>());
    case Kind::reconfigure: reply.make<wire::Reconfigured>(); return reconfigure(request.as<wire::Reconfigure>());
    case Kind::advance: return advance(request, request.as<wire::Advance>(), reply.make<wire::Advanced>());
    case Kind::accept: return accept(request, request.as<wire::Accept>(), reply.make<wire::Accepted>());
    case Kind::load_state: reply.make<wire::StateLoaded>(); return load_state(request.as<wire::LoadState>());
    case Kind::read_state: return read_state(reply.make<wire::State>());
    case Kind::save_state: return save_state(reply.make<wire::SavedState>());
    case Kind::restore_state: reply.make<wire::StateRestored>(); return restore_state(request.as<wire::RestoreState>());
    default: return finish(reply.make<wire::Finished>());  // the lifecycle lets nothing else through
  }
}

void Session::put_times(wire::Finished& reply) const {
  reply.compute_s = compute_s_;
  reply.wait_s = wait_s_;
  reply.spans_s.resize(static_cast<int>(spans_.size() / 3), 3);
  reply.spans_s.data = spans_;
}

}  // namespace ricochet::participant

#include <fmt/format.h>

#include <chrono>
#include <cstdlib>
#include <new>
#include <optional>
#include <system_error>

#include "common/base/process.hpp"
#include "common/participant/participant.hpp"
#include "common/participant/session.hpp"
#include "common/wire/channel.hpp"

namespace ricochet::participant {
namespace {

/// Call in a catch block. An exception of a solver without a code of its own is a computation that went wrong, unless
/// it is the machine that refuses memory, files or the like.
Reason current_reason() {
  try {
    throw;
  } catch (const Error& error) {
    return {error.code(), error.what()};
  } catch (const std::bad_alloc&) {
    return {ExitCode::machine, "out of memory"};
  } catch (const std::system_error& error) {
    return {ExitCode::machine, error.what()};
  } catch (const std::exception& error) {
    return {ExitCode::unstable, error.what()};
  } catch (...) {
    return {ExitCode::unstable, "the solver threw something that is not a std::exception"};
  }
}

int report(const std::string& name, const Reason& reason) {
  fmt::print(stderr, "{}: error: {}\n", name, printable(reason.text));
  std::fflush(stderr);
  return static_cast<int>(reason.code);
}

std::optional<wire::ParticipantKey> key_of(const ServeOptions& options) {
  if (options.key.empty()) return std::nullopt;
  return wire::read_key(options.key, options.timeout_s);
}

constexpr double while_others_start_s = 1e8;
/// mpirun or srun in front of a program (key `launch`) starts it several times: a participant is one of these.
void require_first_process(const ServeOptions& options) {
  if (!options.watch_stdin) return;  // started by hand, perhaps beside other participants
  for (const char* variable : {"OMPI_COMM_WORLD_RANK", "PMI_RANK", "SLURM_PROCID"}) {
    const char* rank = std::getenv(variable);
    if (!rank || std::strtol(rank, nullptr, 10) <= 0) continue;
    throw ConfigError(fmt::format(
        "found process {} ({}) of those that `launch` starts taking part, allowed: process 0 alone; the others are to "
        "compute for it, without the SDK",
        rank, variable));
  }
}

/// One request after the other, until the run is over.
void converse(Session& session, wire::Channel& channel, const ServeOptions& options, wire::Message& reply) {
  wire::Message request, progress;
  session.on_progress([&](std::string_view doing, double share_done) {
    session.progress(doing, share_done, progress);
    channel.send(progress);
  });
  session.hello(reply);
  channel.offer_shared_memory(reply.as<wire::Hello>());
  channel.send(reply);
  while (!session.over()) {
    const auto begin = wire::Clock::now();
    double timeout_s = session.timeout_s() > 0 ? session.timeout_s() : options.timeout_s;
    // While another participant prepares itself, however long, only the end of the coupler ends this one.
    if (session.timeout_s() > 0 && !session.started() && options.watch_stdin) timeout_s = while_others_start_s;
    channel.receive(request, wire::deadline_in(timeout_s), options.watch_stdin);
    session.add_wait(std::chrono::duration<double>(wire::Clock::now() - begin).count());
    if (session.handle(request, reply)) channel.send(reply);
    if (!session.over()) session.work_ahead();
  }
}

void tell_coupler(Session& session, wire::Channel& channel, const Reason& reason, wire::Message& message) {
  try {
    session.failure(reason.code, reason.text, message);
    channel.send(message);
  } catch (const std::exception&) {
    // The connection may be what failed; the exit code and the line on stderr still tell.
  }
}

}  // namespace

Reason reason_in(const Session& session) {
  auto reason = current_reason();
  const bool placed = reason.text.rfind("window ", 0) == 0;
  if (session.window() > 0 && !placed) reason.text = fmt::format("window {}: {}", session.window(), reason.text);
  return reason;
}

int serve(Participant& participant, const ServeOptions& options) {
  std::string name = "participant";
  try {
    require_first_process(options);
    Session session(participant);
    name = session.name();
    wire::Channel channel(options.endpoint, key_of(options));
    wire::Message message;
    try {
      converse(session, channel, options, message);
      return static_cast<int>(ExitCode::done);
    } catch (const wire::CouplerGone&) {
      // Standard input also closes where what started this process ends it: the coupler hears from that why.
      return report(name, reason_in(session));
    } catch (...) {
      const auto reason = reason_in(session);
      if (!session.over()) tell_coupler(session, channel, reason, message);
      return report(name, reason);
    }
  } catch (...) {
    return report(name, current_reason());
  }
}

int participant_main(int argc, const char* const* argv, const MakeParticipant& make) {
  prepare_process();
  std::string name = "participant";
  try {
    auto arguments = parse_arguments(argc, argv);
    name = arguments.name;
    const auto participant = make(arguments);
    return serve(*participant, arguments.options);
  } catch (...) {
    return report(name, current_reason());
  }
}

}  // namespace ricochet::participant

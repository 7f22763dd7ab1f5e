// The errors for a peer that failed, broke the protocol or fell silent.
#include <fmt/format.h>

#include "common/base/error.hpp"
#include "common/base/process.hpp"
#include "coupler/processes/peers.hpp"

namespace ricochet::coupler {

void Peers::announce_failure(int code, const std::string& text, const std::string& culprit) {
  for (auto& peer : peers_) {
    if (peer.inside) {
      peer.inside.reset();  // it writes what the report is drawn from
      continue;
    }
    if (peer.identity.empty() || peer.lifecycle.done()) continue;
    wire::Message message;
    auto& failure = message.make<wire::Failure>();
    failure.error_code = code;
    failure.error_text = text;
    failure.error_culprit = culprit;
    message.window = peer.window;
    try {
      post(peer, message);
    } catch (const std::exception&) {
      // It may be the peer that is gone; the run already fails for a better reason.
    }
  }
}

void Peers::throw_broken(const Remote& peer, const ProtocolError& error) const {
  throw ProtocolError(fmt::format("participant '{}' {}: {}", peer.expected.name, place(peer), error.what()));
}

void Peers::throw_failure(const Remote& peer) const {
  const auto& failure = peer.inbox->as<wire::Failure>();
  const bool known = failure.error_code == static_cast<int>(ExitCode::config) ||
                     failure.error_code == static_cast<int>(ExitCode::unstable) ||
                     failure.error_code == static_cast<int>(ExitCode::protocol) ||
                     failure.error_code == static_cast<int>(ExitCode::machine);
  const auto code = known ? static_cast<ExitCode>(failure.error_code) : ExitCode::participant;
  // Its own text begins with the window, which may be a later one of several that were asked for.
  const std::string window = fmt::format("window {}: ", peer.window);
  const bool twice = peer.window > 0 && failure.error_text.rfind(window, 0) == 0;
  throw Error(code, fmt::format("participant '{}' failed {}: {}", peer.expected.name, place(peer),
                                twice ? failure.error_text.substr(window.size()) : failure.error_text));
}

void Peers::throw_silent(const Remote& peer) const {
  const double silent_s = std::chrono::duration<double>(wire::Clock::now() - peer.last_heard).count();
  const bool start = run_.start_timeout_s && starts(peer);
  throw ParticipantError(fmt::format(
      "{} has been silent for {:.1f} s {} (asked to '{}', coupling.{} = {} s{}): it hangs, "
      "is stopped, or "
      "needs a longer timeout{}",
      who(peer), silent_s, place(peer), peer.asked, start ? "start_timeout_s" : "timeout_s",
      start ? run_.start_wait_s() : run_.timeout_s,
      peer.doing.empty() ? "" : fmt::format("; the last it said: {}", printable(peer.doing)), log_tail(peer)));
}

/// With its machine, if that is another one.
std::string Peers::who(const Remote& peer) {
  const std::string machine = peer.machine.empty() ? "" : " on " + peer.machine;
  return fmt::format("participant '{}'{}", peer.expected.name, machine);
}

std::string Peers::place(const Remote& peer) const {
  if (peer.identity.empty() && !peer.inside) return "before it said hello";
  if (peer.window <= 0 && peer.lifecycle.done()) return "during start-up";
  if (peer.window <= 0) return fmt::format("during start-up ({})", peer.lifecycle.state());
  return fmt::format("in window {} (t = {:.6g} s)", peer.window, run_.clock.time_s(peer.window));
}

/// A caller that was turned away may have been meant to be this peer.
std::string Peers::refusal_text(const Remote& peer) const {
  if (!peer.refusal.empty()) return "; a peer of that name was turned away: " + peer.refusal;
  return peer.identity.empty() && !last_refusal_.empty() ? "; a peer was turned away: " + last_refusal_ : "";
}

std::string Peers::log_tail(const Remote& peer) const {
  constexpr std::size_t log_lines = 8;
  const std::string path = launcher_.log_path(peer.expected.name);
  if (path.empty()) return "";
  const std::string lines = last_lines(path, log_lines);
  return lines.empty() ? fmt::format("\n  its log {} is empty", path)
                       : fmt::format("\n  end of its log {}:\n{}", path, lines);
}

}  // namespace ricochet::coupler

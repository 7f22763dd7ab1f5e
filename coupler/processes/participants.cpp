#include "coupler/processes/participants.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <numeric>

#include "common/base/error.hpp"
#include "common/base/write_file.hpp"
#include "common/wire/codec.hpp"
#include "coupler/processes/executable.hpp"
#include "coupler/processes/run_id.hpp"
#include "coupler/watch/energy_watch.hpp"

namespace ricochet::coupler {
namespace {

void launch(const scene::Scene& scene, const scene::ParticipantSpec& participant, const std::string& executable,
            const ResultsDirectory& results, const wire::Listener& listener, Launcher& launcher, KeyFiles& keys) {
  const std::string bound = listener.endpoint();
  const bool by_hand = participant.start == scene::Start::by_hand;
  const std::string key = wire::to_text(listener.key_of(participant.name));
  const std::vector<std::string> arguments = {
      "--scene",   scene.path,
      "--name",    participant.name,
      "--connect", by_hand ? remote_endpoint(bound) : local_endpoint(bound),
      "--key",     by_hand ? keys.write(participant.name, key) : LaunchRequest::key_path};
  if (by_hand) {
    const std::string shipped =
        participant.role == scene::Role::implicit_solver ? "implicit_solver" : "explicit_solver";
    fmt::print(stderr, "participant '{}' is to be started by hand, within {} s:\n  {} {}\n", participant.name,
               scene.coupling.timeout_s, participant.executable.empty() ? shipped : participant.executable,
               fmt::join(arguments, " "));
    return;
  }
  LaunchRequest request{participant.name, executable, arguments, results.log(participant.name), key};
  request.arguments.emplace_back("--watch-stdin");
  launcher.launch(request);
}

/// What each says of itself, and that they do not contradict each other.
void check_descriptions(const std::vector<wire::Message>& descriptions) {
  std::string owner;
  for (const auto& description : descriptions) {
    const auto& name = description.participant;
    if (description.critical_time_step_s < 0.0) {
      throw ProtocolError(
          fmt::format("participant '{}' described 'critical_time_step_s' = {} s, allowed: 0 (none) or more", name,
                      description.critical_time_step_s));
    }
    if (!description.contact_owner) continue;
    if (!owner.empty()) {
      throw ProtocolError(
          fmt::format("participant '{}' described 'contact_owner' = true, and so did participant '{}': one of them "
                      "enforces the contact",
                      name, owner));
    }
    owner = name;
  }
}

}  // namespace

ProtocolSettings protocol_settings(const scene::CouplingSettings& coupling) {
  return {coupling.substeps, coupling.acceleration, coupling.relaxation, coupling.tolerance, coupling.max_iterations};
}

wire::Message initialize_request(const scene::Scene& scene, double window_size_s, std::int64_t last_window,
                                 const std::string& output_directory) {
  wire::Message request;
  request.window_size_s = window_size_s;
  request.output_directory = output_directory;
  request.protocol = scene.coupling.protocol.name;
  request.substeps = scene.coupling.substeps;
  request.history_every =
      std::gcd(static_cast<std::int64_t>(scene.output.history_every), EnergyWatch::every_of(last_window));  // for both
  request.fields_every = scene.output.fields_every;
  request.until_separated_plus_s = scene.time.until_separated_plus_s.value_or(-1.0);
  request.separation_windows = scene.coupling.separation_windows;
  request.last_window = last_window;
  request.timeout_s = scene.coupling.timeout_s;
  return request;
}

std::string role_name(scene::Role role) { return role == scene::Role::implicit_solver ? "implicit" : "explicit"; }

std::vector<std::string> find_executables(const scene::Scene& scene) {
  std::vector<std::string> paths;
  for (const auto& participant : scene.participants) {
    paths.push_back(participant.start == scene::Start::launch ? find_executable(scene, participant) : "");
  }
  return paths;
}

std::vector<ExpectedPeer> expected_peers(const scene::Scene& scene) {
  std::vector<ExpectedPeer> expected;
  for (const auto& participant : scene.participants)
    expected.push_back({participant.name, role_name(participant.role)});
  return expected;
}

std::vector<std::string> participant_names(const scene::Scene& scene) {
  std::vector<std::string> names;
  for (const auto& participant : scene.participants) names.push_back(participant.name);
  return names;
}

void require_capability(const wire::Message& description, const std::string& needed, const std::string& activity) {
  const auto& has = description.capabilities;
  if (std::find(has.begin(), has.end(), needed) != has.end()) return;
  throw ConfigError(
      fmt::format("participant '{}' ({}) cannot take part in {}: it lacks the capability \"{}\" (it has: "
                  "{}); choose another protocol or another solver",
                  description.participant, description.solver, activity, needed,
                  has.empty() ? "none" : fmt::format("{}", fmt::join(has, ", "))));
}

void check_capabilities(const scene::ProtocolTraits& protocol, const std::vector<wire::Message>& descriptions) {
  int implicit = 0;
  for (const auto& description : descriptions) {
    const bool is_implicit = description.role == "implicit";
    implicit += is_implicit ? 1 : 0;
    for (const auto& needed : is_implicit ? protocol.implicit_capabilities : protocol.explicit_capabilities) {
      require_capability(description, needed, fmt::format("protocol {}", protocol.name));
    }
  }
  if (protocol.coupled() && implicit != 1) {
    throw ConfigError(
        fmt::format("protocol {} needs exactly one implicit participant, the scene has {}", protocol.name, implicit));
  }
}

std::size_t largest_message(const scene::Problem& problem) {
  // Per node three components of a few arrays, or two numbers each of a state for displacement and velocity; history
  // rows of as many windows as a baseline computes at once.
  constexpr std::size_t least = std::size_t{1} << 22, per_node = 64 * sizeof(double),
                        per_body = 4200 * 20 * sizeof(double);
  std::size_t nodes = 0;
  for (const auto& body : problem.bodies) nodes += body.mesh.position.size();
  return std::min(wire::max_message_bytes, least + per_body * problem.bodies.size() + per_node * nodes);
}

void KeyFiles::remove() {
  std::error_code ignored;
  for (const auto& path : paths_) std::filesystem::remove(path, ignored);
  if (!paths_.empty()) std::filesystem::remove(results_.file("keys"), ignored);  // only if it is empty
  paths_.clear();
}

std::string KeyFiles::write(const std::string& participant, const std::string& text) {
  std::error_code error;
  std::filesystem::create_directories(results_.file("keys"), error);
  const auto path = results_.file("keys/" + participant + ".key");
  write_atomically(path, text, 0600);
  paths_.push_back(path);
  return path;
}

void launch_participants(const scene::Scene& scene, const std::vector<std::string>& executables,
                         const ResultsDirectory& results, const wire::Listener& listener, Launcher& launcher,
                         KeyFiles& keys) {
  for (std::size_t p = 0; p < executables.size(); ++p) {
    launch(scene, scene.participants[p], executables[p], results, listener, launcher, keys);
  }
}

std::vector<wire::Message> describe_participants(const scene::Scene& scene, Peers& peers) {
  std::vector<Peer> asked;
  for (std::size_t p = 0; p < peers.size(); ++p) {
    asked.push_back(peers.peer(p));
    wire::Message request;
    request.kind = wire::Kind::describe;
    asked.back().post(request);
  }
  std::vector<wire::Message> descriptions;
  for (std::size_t p = 0; p < peers.size(); ++p) {
    auto& description = descriptions.emplace_back(asked[p].wait());
    description.participant = peers.name(p);
    description.role = role_name(scene.participants[p].role);
    peers.limit(p, description);
  }
  check_descriptions(descriptions);
  return descriptions;
}

void check_exit_codes(const scene::Scene& scene, const Peers& peers, Launcher& launcher) {
  const double patience_s = std::min(scene.coupling.timeout_s, 10.0);
  const bool ended = launcher.wait_all(std::chrono::milliseconds(static_cast<long>(1000 * patience_s)));
  for (std::size_t p = 0; p < peers.size(); ++p) {
    const auto end = launcher.end_of(peers.name(p));
    if (!launcher.launched(peers.name(p)) || (end && end->signal == 0 && end->exit_status == 0)) continue;
    throw ParticipantError(fmt::format("participant '{}' finished its work but {}; see {}", peers.name(p),
                                       ended && end ? end->text() : "did not end by itself",
                                       launcher.log_path(peers.name(p))));
  }
}

}  // namespace ricochet::coupler

#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/scene/scene.hpp"
#include "common/wire/channel.hpp"
#include "coupler/launcher.hpp"
#include "coupler/peers.hpp"
#include "coupler/protocols/settings.hpp"
#include "coupler/results_directory.hpp"

/// The processes of a scene: found, started, described, ended. What `run` and `stability` share.
namespace ricochet::coupler {

/// What the scene says to its protocol.
[[nodiscard]] ProtocolSettings protocol_settings(const scene::Coupling& coupling);

/// What the scene says to its participants: a message of kind `initialize`, but for what is told to each one alone.
[[nodiscard]] wire::Message initialize_request(const scene::Scene& scene, double window_size_s, std::int64_t last_window,
                                               const std::string& output_directory);

/// "implicit" | "explicit".
[[nodiscard]] std::string role_name(scene::Role role);

/// Program per participant, in the scene's order; empty for one that is started by hand.
[[nodiscard]] std::vector<std::string> find_executables(const scene::Scene& scene);

/// The participants of a scene, for Peers.
[[nodiscard]] std::vector<ExpectedPeer> expected_peers(const scene::Scene& scene);

/// Starts the scene's participants, or prints what to type for those that are started by hand.
void launch_participants(const scene::Scene& scene, const std::vector<std::string>& executables,
                         const ResultsDirectory& results, const wire::Listener& listener, Launcher& launcher);

/// What every participant says of itself, in the scene's order, with `participant` and `role` filled in.
[[nodiscard]] std::vector<wire::Message> describe_participants(const scene::Scene& scene, Peers& peers);

/// Waits until the processes have ended; ParticipantError naming the first that does not, or not with exit code 0.
void check_exit_codes(const scene::Scene& scene, const Peers& peers, Launcher& launcher);

}  // namespace ricochet::coupler

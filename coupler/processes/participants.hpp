#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/problem/problem.hpp"
#include "common/wire/channel.hpp"
#include "coupler/processes/launcher.hpp"
#include "coupler/processes/peers.hpp"
#include "coupler/protocols/settings.hpp"
#include "coupler/results/results_directory.hpp"

/// The processes of a scene: found, started, described, ended. What `run` and `stability` share.
namespace ricochet::coupler {

/// What the scene says to its protocol.
[[nodiscard]] ProtocolSettings protocol_settings(const scene::CouplingSettings& coupling);

/// What the scene says to its participants: a message of kind `initialize`, but for what is told to each one alone.
[[nodiscard]] wire::Message initialize_request(const scene::Scene& scene, double window_size_s,
                                               std::int64_t last_window, const std::string& output_directory);

/// "implicit" | "explicit".
[[nodiscard]] std::string role_name(scene::Role role);

/// Program per participant, in the scene's order; empty for one that is started by hand.
[[nodiscard]] std::vector<std::string> find_executables(const scene::Scene& scene);

/// The participants of a scene, for Peers.
[[nodiscard]] std::vector<ExpectedPeer> expected_peers(const scene::Scene& scene);

/// Names of the participants, to each of which the listener gives a key.
[[nodiscard]] std::vector<std::string> participant_names(const scene::Scene& scene);

/// Largest message that participants of this scene can have to send [bytes].
[[nodiscard]] std::size_t largest_message(const scene::Problem& problem);

/// Keys for participants that are started by hand: files that only this user may read, gone with this object at the
/// latest.
class KeyFiles {
 public:
  explicit KeyFiles(const ResultsDirectory& results) : results_(results) {}
  KeyFiles(const KeyFiles&) = delete;
  KeyFiles& operator=(const KeyFiles&) = delete;
  ~KeyFiles() { remove(); }
  /// Path of the file. Throws MachineError or ConfigError if it cannot be written.
  std::string write(const std::string& participant, const std::string& text);
  /// Everybody is there.
  void remove();

 private:
  const ResultsDirectory& results_;
  std::vector<std::string> paths_;
};

/// Starts the scene's participants, or prints what to type for those that are started by hand.
void launch_participants(const scene::Scene& scene, const std::vector<std::string>& executables,
                         const ResultsDirectory& results, const wire::Listener& listener, Launcher& launcher,
                         KeyFiles& keys);

/// What every participant says of itself, in the scene's order, with `participant` and `role` filled in.
[[nodiscard]] std::vector<wire::Message> describe_participants(const scene::Scene& scene, Peers& peers);

/// ConfigError naming the participant and the capability it lacks; `activity`: what it cannot take part in.
void require_capability(const wire::Message& description, const std::string& needed, const std::string& activity);

/// Refuses a participant that lacks what the protocol needs: ConfigError naming the participant, the capability and the
/// protocol. Coupled protocols also need exactly one implicit participant.
void check_capabilities(const scene::ProtocolTraits& protocol, const std::vector<wire::Message>& descriptions);

/// Waits until the processes have ended; ParticipantError naming the first that does not, or not with exit code 0.
void check_exit_codes(const scene::Scene& scene, const Peers& peers, Launcher& launcher);

}  // namespace ricochet::coupler

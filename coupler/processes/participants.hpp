#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/check/check.hpp"
#include "common/problem/problem.hpp"
#include "coupler/processes/process_set.hpp"
#include "coupler/protocols/settings.hpp"
#include "coupler/results/results_directory.hpp"

/// The words of a scene on its processes and to its participants; `run` and `stability` share it.
namespace ricochet::coupler {

/// The settings that the scene has for its protocol.
[[nodiscard]] ProtocolSettings protocol_settings(const scene::CouplingSettings& coupling);

/// The message of the scene to its participants, but for what is told to each one alone.
[[nodiscard]] wire::Initialize initialize_request(const scene::Problem& problem, std::int64_t last_window,
                                                  const std::string& output_directory);

/// Program per participant, in the scene's order; empty for one that is started by hand. Throws if one cannot be
/// launched: find_executable, launch_prefix.
[[nodiscard]] std::vector<std::string> find_executables(const scene::Scene& scene);

/// The descriptions as the interface takes them: nodes of a foreign body are nodes of the body that it is joined to.
[[nodiscard]] std::vector<PeerDescription> joined(const scene::Problem& problem,
                                                  std::vector<PeerDescription> descriptions);

/// Names of the participants, in the scene's order.
[[nodiscard]] std::vector<std::string> participant_names(const scene::Scene& scene);

/// The processes of a scene, in its order; none is started yet. `executables`: what `find_executables` found. Logs and
/// keys lie in the results folder. Shipped solvers that are started here are told the critical step of their elements
/// that `plans` has.
[[nodiscard]] ProcessSet make_process_set(const scene::Problem& problem,
                                          const std::vector<scene::ParticipantPlan>& plans,
                                          const std::vector<std::string>& executables, const ResultsDirectory& results,
                                          const std::string& run_id);

/// n, t and, of solids, b, one a row.
[[nodiscard]] wire::Array directions_along(const Eigen::Vector3d& normal, int components);

/// ConfigError naming the participant and the capability it lacks; `activity`: what it cannot take part in.
void require_capability(const PeerDescription& description, Capability needed, const std::string& activity);

/// Refuses a scene with a contact that nobody, or the wrong one, enforces: ConfigError.
void check_contact_owner(const scene::Problem& problem, const std::vector<PeerDescription>& descriptions);

/// Refuses a step above the critical one that an explicit participant declares: ConfigError.
void check_declared_steps(const scene::Problem& problem, const std::vector<PeerDescription>& descriptions);

/// Refuses a participant that lacks what the protocol needs: ConfigError naming the participant, the capability and the
/// protocol. Coupled protocols also need exactly one implicit participant.
void check_capabilities(const scene::ProtocolTraits& protocol, const std::vector<PeerDescription>& descriptions);

}  // namespace ricochet::coupler

#include "coupler/stability/stability_point.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "common/base/error.hpp"
#include "coupler/processes/participants.hpp"
#include "coupler/processes/run_id.hpp"
#include "coupler/protocols/protocol.hpp"
#include "coupler/run/compute_scene.hpp"
#include "coupler/spectrum/window_map.hpp"

namespace ricochet::coupler {
namespace {

/// No end, no history, no fields: nobody asks for them.
wire::Message endless_request(const scene::Problem& problem, const ResultsDirectory& results) {
  constexpr auto never = std::numeric_limits<std::int64_t>::max();
  auto request = initialize_request(problem.scene, problem.window_size_s, never, results.file("fields"));
  request.history_every = std::numeric_limits<int>::max();
  request.fields_every = 0;
  request.until_separated_plus_s = -1.0;
  return request;
}

std::vector<ContactStability> measure(const scene::Problem& problem, const std::vector<std::string>& frozen_contacts,
                                      const ResultsDirectory& results, Peers& peers) {
  const auto descriptions = describe_participants(problem.scene, peers);
  const auto& traits = problem.scene.coupling.protocol;
  check_capabilities(traits, descriptions);
  for (const auto& description : descriptions) {
    require_capability(description, "load_state", "`ricochet stability`");
  }
  std::vector<Peer> asked;
  for (std::size_t p = 0; p < peers.size(); ++p) asked.push_back(peers.peer(p));
  Coupling coupling(std::move(asked), descriptions, problem.window_size_s);
  const auto protocol = make_protocol(traits.name, protocol_settings(problem.scene.coupling));
  protocol->start(coupling, endless_request(problem, results));
  std::vector<ContactStability> measured;
  for (const auto& contact : frozen_contacts) {
    measured.push_back({contact, spectral_radius(window_map(coupling, *protocol, contact))});
  }
  for (auto& link : coupling.links()) link.post_finish();
  for (auto& link : coupling.links()) link.wait_finished();
  return measured;
}

}  // namespace

std::vector<ContactStability> measure_stability(const scene::Problem& problem,
                                                const std::vector<std::string>& frozen_contacts,
                                                const ResultsDirectory& results) {
  const auto& scene = problem.scene;
  const auto executables = find_executables(scene);
  const std::string run_id = make_run_id();
  Launcher launcher;
  wire::Listener listener(listen_endpoint(scene.coupling), participant_names(scene), largest_message(problem));
  KeyFiles keys(results);
  Peers peers(listener, launcher, expected_peers(scene),
              {run_id, scene.sha256, scene.coupling.timeout_s, problem.window_size_s, scene.coupling.transport,
               scene.where("coupling.transport"), largest_message(problem)});
  try {
    launch_participants(scene, executables, results, listener, launcher, keys);
    peers.handshake();
    keys.remove();
    auto measured = measure(problem, frozen_contacts, results, peers);
    check_exit_codes(scene, peers, launcher);
    return measured;
  } catch (const std::exception& error) {
    peers.announce_failure(exit_code_of(error), error.what(), "coupler");
    launcher.stop(std::chrono::milliseconds(2000));
    throw;
  }
}

}  // namespace ricochet::coupler

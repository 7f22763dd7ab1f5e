#include "coupler/stability_point.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "common/base/error.hpp"
#include "coupler/participants.hpp"
#include "coupler/protocols/protocol.hpp"
#include "coupler/run.hpp"
#include "coupler/run_id.hpp"
#include "coupler/stability/window_map.hpp"

namespace ricochet::coupler {
namespace {

void require_load_state(const std::vector<wire::Message>& descriptions) {
  for (const auto& description : descriptions) {
    const auto& has = description.capabilities;
    if (std::find(has.begin(), has.end(), "load_state") != has.end()) continue;
    throw ConfigError(fmt::format(
        "participant '{}' cannot take part in `ricochet stability`: it lacks the capability \"load_state\" (it has: "
        "{}); choose another solver", description.participant,
        has.empty() ? "none" : fmt::format("{}", fmt::join(has, ", "))));
  }
}

wire::Message initialize_request(const scene::Problem& problem, const ResultsDirectory& results) {
  wire::Message request;
  request.window_size_s = problem.window_size_s;
  request.output_directory = results.file("fields");
  request.substeps = problem.scene.coupling.substeps;
  request.protocol = problem.scene.coupling.protocol;
  request.history_every = std::numeric_limits<int>::max();  // nobody asks for it
  request.until_separated_plus_s = -1.0;
  request.separation_windows = problem.scene.coupling.separation_windows;
  request.last_window = std::numeric_limits<std::int64_t>::max();
  return request;
}

std::vector<ContactStability> measure(const scene::Problem& problem, const std::vector<std::string>& frozen_contacts,
                                      const ResultsDirectory& results, Peers& peers) {
  const auto descriptions = describe_participants(problem.scene, peers);
  const auto& entry = find_protocol(problem.scene.coupling.protocol);
  check_capabilities(entry, descriptions);
  require_load_state(descriptions);
  InterfaceMap map(descriptions);
  std::vector<Link> links;
  for (std::size_t p = 0; p < peers.size(); ++p) links.emplace_back(peers.peer(p), descriptions[p], map.rows(p));
  Coupling coupling(std::move(links), std::move(map), problem.window_size_s);
  const auto protocol = entry.make(protocol_settings(problem.scene.coupling));
  protocol->start(coupling, initialize_request(problem, results));
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
  wire::Listener listener(listen_endpoint(scene.coupling, run_id));
  Peers peers(listener, launcher, expected_peers(scene),
              {run_id, scene.sha256, scene.coupling.timeout_s, problem.window_size_s});
  try {
    launch_participants(scene, executables, results, listener, launcher);
    peers.handshake();
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

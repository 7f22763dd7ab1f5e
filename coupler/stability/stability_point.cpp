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

/// No end, no history, no files: nobody asks for them.
wire::Initialize endless_request(const scene::Problem& problem) {
  constexpr auto never = std::numeric_limits<std::int64_t>::max();
  auto request = initialize_request(problem, never, "");
  request.history_every = std::numeric_limits<int>::max();
  request.fields_every = 0;
  request.until_separated_plus_s = -1.0;
  return request;
}

std::vector<ContactStability> measure(const scene::Problem& problem, const std::vector<FrozenContact>& frozen_contacts,
                                      ProcessSet& set) {
  set.launch();
  set.meet();
  const auto descriptions = set.describe();
  const auto& traits = problem.scene.coupling.protocol;
  check_contact_owner(problem, descriptions);
  check_capabilities(traits, descriptions);
  const char* const activity = scene::linear(problem)
                                   ? "`ricochet stability`"
                                   : "`ricochet stability`, which continues a state linearly, as no body that yields "
                                     "or turns goes on";
  for (const auto& description : descriptions) require_capability(description, Capability::load_state, activity);
  Coupling coupling(set.peers().all(), joined(problem, descriptions), problem.clock.size_s(1));
  const auto protocol = make_protocol(traits.name, protocol_settings(problem.scene.coupling));
  protocol->start(coupling, endless_request(problem));
  std::vector<ContactStability> measured;
  for (const auto contact : frozen_contacts) {
    measured.push_back({contact, spectral_radius(window_map(coupling, *protocol, contact))});
  }
  coupling.finish();
  set.check_exit_codes();
  return measured;
}

}  // namespace

std::vector<ContactStability> measure_stability(const scene::Problem& problem,
                                                const std::vector<scene::ParticipantPlan>& plans,
                                                const std::vector<FrozenContact>& frozen_contacts,
                                                const ResultsDirectory& results) {
  const auto executables = find_executables(problem.scene);
  auto set = make_process_set(problem, plans, executables, results, make_run_id());
  try {
    return measure(problem, frozen_contacts, set);
  } catch (const std::exception& error) {
    set.fail(exit_code_of(error), error.what());
    throw;
  }
}

}  // namespace ricochet::coupler

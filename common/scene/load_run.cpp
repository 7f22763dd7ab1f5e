#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <string_view>

#include "common/scene/loaders.hpp"
#include "common/scene/protocols.hpp"

/// How a scene is run: time, coupling, output.
namespace ricochet::scene {
namespace {

constexpr int most = std::numeric_limits<int>::max();

/// Slurm may start participants on any node of the allocation.
void load_transport(TableReader& table, CouplingSettings& coupling) {
  coupling.launcher = table.choice<LaunchedBy>(
      "launcher", {{"local", LaunchedBy::coupler}, {"slurm", LaunchedBy::slurm}}, coupling.launcher);
  const bool slurm = coupling.launcher == LaunchedBy::slurm;
  if (slurm) coupling.transport = Transport::tcp;
  if (slurm) coupling.address = "0.0.0.0";
  if (table.has("transport")) coupling.transport = table.named<Transport>("transport");
  const bool tcp = coupling.transport == Transport::tcp;
  if (slurm && !tcp)
    table.refuse("transport", fmt::format("\"{}\" with launcher = \"slurm\"", name_of(coupling.transport)),
                 "\"tcp\", which that takes by itself: participants may be on other nodes");
  table.only_if(tcp, "address", "transport = \"tcp\"");
  table.only_if(tcp, "port", "transport = \"tcp\"");
  coupling.address = table.text("address", coupling.address);
  coupling.port = table.integer("port", 0, 65535, coupling.port);
}

/// Keys that only some protocols know.
void load_protocol_settings(TableReader& table, CouplingSettings& coupling) {
  table.only_if(coupling.protocol.dual, "substeps",
                "a dual protocol: \"prakash_hjelmstad\" or \"gravouil_combescure\"");
  coupling.fewest_substeps = table.has("substeps") && table.open("substeps")->is_string();
  if (coupling.fewest_substeps) {
    static_cast<void>(table.word("substeps", {"fewest"}));
  } else {
    coupling.substeps = table.integer("substeps", 1, most_substeps, coupling.substeps);
  }
  for (const char* key : {"acceleration", "relaxation", "tolerance", "max_iterations"})
    table.only_if(coupling.protocol.iterated, key, "protocol = \"fixed_point\"");
  if (table.has("acceleration")) coupling.acceleration = table.word("acceleration", {"constant", "aitken", "iqn_ils"});
  coupling.relaxation = table.number("relaxation", {0.0, 1.0, false, true}, coupling.relaxation);
  coupling.tolerance = table.number("tolerance", {0.0, 1.0, false, false}, coupling.tolerance);
  coupling.max_iterations = table.integer("max_iterations", 1, 10000, coupling.max_iterations);
}

}  // namespace

namespace {

std::vector<StepChange> load_changes(TableReader& time, double end_s) {
  std::vector<StepChange> changes;
  for (auto& table : time.tables("changes", "changes")) {
    const StepChange change{table.number("from_s", above(0.0)), table.number("step_s", above(0.0))};
    if (!changes.empty() && change.from_s <= changes.back().from_s)
      table.refuse("from_s", fmt::format("{}, not later than the change before it", change.from_s),
                   "changes in ascending order of time");
    if (change.from_s >= end_s)
      table.refuse("from_s", fmt::format("{}", change.from_s), fmt::format("earlier than time.end_s = {}", end_s));
    table.finish();
    changes.push_back(change);
  }
  return changes;
}

}  // namespace

Time load_time(TableReader& table, bool has_contact) {
  Time time;
  for (const char* one : {"safety_factor", "largest_step_s"})
    for (const char* other : {"step_s", "safety_factor"})
      if (std::string_view(one) != other && table.has(one) && table.has(other))
        table.refuse(one, fmt::format("both {} and {}", other, one), "one of them");
  if (table.has("step_s")) time.step_s = table.number("step_s", above(0.0));
  if (table.has("largest_step_s")) time.step_s = time.largest_step_s = table.number("largest_step_s", above(0.0));
  time.safety_factor = table.number("safety_factor", {0.0, 1.0, false, true}, time.safety_factor);
  time.end_s = table.number("end_s", above(0.0));
  if (time.step_s && time.end_s < *time.step_s)
    table.refuse("end_s", fmt::format("{}, shorter than one step", time.end_s),
                 fmt::format("at least {} = {}", time.largest_step_s ? "largest_step_s" : "step_s", *time.step_s));
  table.only_if(!time.largest_step_s, "changes", "step_s or safety_factor: largest_step_s chooses one step");
  time.changes = load_changes(table, time.end_s);
  table.only_if(has_contact && time.step_s && !time.largest_step_s && time.changes.empty(), "flight_step_s",
                "a [contact] table and step_s, the step of windows in which bodies may touch, without changes");
  if (table.has("flight_step_s")) {
    time.flight_step_s = table.number("flight_step_s", above(0.0));
    if (!(*time.flight_step_s > *time.step_s))
      table.refuse("flight_step_s", fmt::format("{}", *time.flight_step_s),
                   fmt::format("longer than step_s = {}", *time.step_s));
  }
  table.only_if(has_contact, "until_separated_plus_s", "a [contact] table");
  if (table.has("until_separated_plus_s"))
    time.until_separated_plus_s = table.number("until_separated_plus_s", at_least(0.0));
  table.finish();
  return time;
}

CouplingSettings load_coupling(TableReader& table, bool has_contact) {
  CouplingSettings coupling;
  if (table.has("protocol")) coupling.protocol = protocol_traits(table.word("protocol", protocol_names()));
  load_protocol_settings(table, coupling);
  coupling.resynchronise_every = table.integer("resynchronise_every", 0, most, coupling.resynchronise_every);
  table.only_if(has_contact, "after_separation", "a [contact] table");
  table.only_if(has_contact, "separation_windows", "a [contact] table");
  coupling.after_separation = table.choice<AfterSeparation>(
      "after_separation",
      {{"explicit", AfterSeparation::switch_to_explicit}, {"implicit", AfterSeparation::stay_implicit}},
      coupling.after_separation);
  coupling.separation_windows = table.integer("separation_windows", 1, most, coupling.separation_windows);
  coupling.timeout_s = table.number("timeout_s", above(0.0), coupling.timeout_s);
  if (table.has("start_timeout_s")) coupling.start_timeout_s = table.number("start_timeout_s", above(0.0));
  load_transport(table, coupling);
  coupling.energy_growth_limit = table.number("energy_growth_limit", above(0.0), coupling.energy_growth_limit);
  if (table.has("energy_loss_limit")) coupling.energy_loss_limit = table.number("energy_loss_limit", above(0.0));
  coupling.outside_model = table.choice<OutsideModel>(
      "outside_model", {{"stop", OutsideModel::stop}, {"go_on", OutsideModel::go_on}}, coupling.outside_model);
  table.finish();
  return coupling;
}

Checkpointing load_checkpoint(TableReader& table) {
  Checkpointing checkpoint{.asked = true};
  checkpoint.every_windows = table.integer("every_windows", 0, most, checkpoint.every_windows);
  checkpoint.every_s = table.number("every_s", at_least(0.0), checkpoint.every_s);
  checkpoint.on_failure = table.choice<OnFailure>(
      "on_failure", {{"stop", OnFailure::stop}, {"resume", OnFailure::resume}}, checkpoint.on_failure);
  table.only_if(checkpoint.on_failure == OnFailure::resume, "attempts", "on_failure = \"resume\"");
  checkpoint.attempts = table.integer("attempts", 1, most, checkpoint.attempts);
  table.finish();
  return checkpoint;
}

void load_accuracy(TableReader& table, Scene& scene) {
  scene.accuracy = table.numbers_by_name("relative_error", {0.0, 1.0, false, false}, scene.quantities_with_bars());
  if (table.has("elements_times")) {
    auto& times = scene.elements_times;
    times =
        table.numbers("elements_times", {1.0 / Scene::most_elements_times, Scene::most_elements_times, true, true}, 0);
    std::sort(times.begin(), times.end());
    times.erase(std::unique(times.begin(), times.end()), times.end());
  }
  table.finish();
}

}  // namespace ricochet::scene

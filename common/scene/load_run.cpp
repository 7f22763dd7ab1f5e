#include <fmt/format.h>

#include <limits>

#include "common/scene/loaders.hpp"
#include "common/scene/protocols.hpp"

/// How a scene is run: time, coupling, output.
namespace ricochet::scene {
namespace {

constexpr int most = std::numeric_limits<int>::max();

void load_transport(TableReader& table, Coupling& coupling) {
  if (table.has("transport")) coupling.transport = table.word("transport", {"ipc", "tcp"});
  const bool tcp = coupling.transport == "tcp";
  table.only_if(tcp, "address", "transport = \"tcp\"");
  table.only_if(tcp, "port", "transport = \"tcp\"");
  coupling.address = table.text("address", coupling.address);
  coupling.port = table.integer("port", 0, 65535, coupling.port);
}

}  // namespace

Time load_time(TableReader& table, bool has_contact) {
  Time time;
  if (table.has("step_s") && table.has("safety_factor"))
    table.refuse("safety_factor", "both step_s and safety_factor", "one of them");
  if (table.has("step_s")) time.step_s = table.number("step_s", above(0.0));
  time.safety_factor = table.number("safety_factor", {0.0, 1.0, false, true}, time.safety_factor);
  time.end_s = table.number("end_s", above(0.0));
  if (time.step_s && time.end_s < *time.step_s)
    table.refuse("end_s", fmt::format("{}, shorter than one step", time.end_s),
                 fmt::format("at least step_s = {}", *time.step_s));
  table.only_if(has_contact, "until_separated_plus_s", "a [contact] table");
  if (table.has("until_separated_plus_s"))
    time.until_separated_plus_s = table.number("until_separated_plus_s", at_least(0.0));
  table.finish();
  return time;
}

Coupling load_coupling(TableReader& table, bool has_contact) {
  Coupling coupling;
  if (table.has("protocol")) coupling.protocol = table.word("protocol", protocol_names());
  coupling.resynchronise_every = table.integer("resynchronise_every", 0, most, coupling.resynchronise_every);
  table.only_if(has_contact, "after_separation", "a [contact] table");
  table.only_if(has_contact, "separation_windows", "a [contact] table");
  coupling.after_separation = table.choice<AfterSeparation>(
      "after_separation",
      {{"explicit", AfterSeparation::switch_to_explicit}, {"implicit", AfterSeparation::stay_implicit}},
      coupling.after_separation);
  coupling.separation_windows = table.integer("separation_windows", 1, most, coupling.separation_windows);
  coupling.timeout_s = table.number("timeout_s", above(0.0), coupling.timeout_s);
  load_transport(table, coupling);
  coupling.energy_growth_limit = table.number("energy_growth_limit", above(0.0), coupling.energy_growth_limit);
  table.finish();
  return coupling;
}

Output load_output(TableReader& table) {
  Output output;
  output.history_every = table.integer("history_every", 1, most, output.history_every);
  output.fields_every = table.integer("fields_every", 0, most, output.fields_every);
  table.finish();
  return output;
}

}  // namespace ricochet::scene

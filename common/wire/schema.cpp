// The table of all messages and their fields.
#include <type_traits>

#include "common/wire/message.hpp"

namespace ricochet::wire {
namespace {

template <class Body, class Value>
Body owner_of(Value Body::*);

/// Where `member` lies in the header, or in the body of a message of its kind.
template <auto member, class Part, class AMessage>
auto pointer_to(AMessage& message) {
  if constexpr (std::is_same_v<Part, Header>) {
    return &(message.*member);
  } else {
    return &(message.template as<Part>().*member);
  }
}

/// `Part`: whose field it is; not the struct that the member was inherited from.
template <auto member, class Part = decltype(owner_of(member))>
Field field(std::string_view name, std::string_view unit, std::string_view meaning) {
  return {name, unit, meaning,
          [](Message& message) -> FieldPointer<Writable> { return pointer_to<member, Part>(message); },
          [](const Message& message) -> FieldPointer<Readable> { return pointer_to<member, Part>(message); }};
}

std::vector<Field> joined(std::vector<Field> first, const std::vector<Field>& second,
                          const std::vector<Field>& third = {}) {
  first.insert(first.end(), second.begin(), second.end());
  first.insert(first.end(), third.begin(), third.end());
  return first;
}

template <class Body>
Field absolute_output() {
  return field<&Body::absolute, Body>(
      "absolute", "N or m",
      "link output, n x components: displacement; of who is driven by displacement, internal force");
}

template <class Body>
Field records_requested() {
  return field<&Body::records_requested, Body>("records_requested", "", "the answer is to bring the history rows");
}

template <class Body>
std::vector<Field> rates() {
  return {
      field<&Body::velocity_m_s, Body>(
          "velocity_m_s", "m/s", "of the interface nodes, n x components; 0 rows from who is driven by displacement"),
      field<&Body::acceleration_m_s2, Body>(
          "acceleration_m_s2", "m/s^2",
          "of the interface nodes, n x components; 0 rows from who is driven by displacement")};
}

template <class Body>
std::vector<Field> records() {
  return {
      field<&Body::records, Body>("records", "", "history rows not sent before, rows x record columns"),
      field<&Body::axial_stress, Body>(
          "axial_stress", "Pa", "rows not sent before, rows x axial stress columns; the first number is the window"),
      field<&Body::probes, Body>("probes", "",
                                 "rows not sent before, rows x probe columns; the first number is the window"),
      field<&Body::departures, Body>(
          "departures", "",
          "what has left the model so far, rows x 14: kind (1 strain, 2 rotation, 3 slip, 4 inverted element, 5 node "
          "off its partner, 6 penetration, 7 yield, 8 tension: docs/limits.md), index into `bodies`, last window "
          "without it, first window with it, how many looks found it, largest size (of stresses in Pa), its window, "
          "its "
          "place x, y and z, largest size in that first window, its place x, y and z; 0 rows: nothing, or not looked "
          "for"),
      field<&Body::contact_forces, Body>(
          "contact_forces", "N",
          "contact owner: rows not sent before, rows x (1 + contacts of the scene), of every accepted window from the "
          "first on: the window, then the force of each contact along its normal, the impulse over the window divided "
          "by "
          "its size; 0 rows: it does not tell")};
}

/// Outline and contact after the last accepted window; all zero, and -1 for the time, from who does not own the
/// contact.
template <class Body>
std::vector<Field> accepted_window() {
  return joined(
      records<Body>(),
      {field<&Body::outline, Body>(
           "outline", "m",
           "rows x (2 + components): index into `bodies`, node of that body's mesh, displacement, for nodes of the "
           "outlines of bodies that others could meet where no contact holds them apart; 0 rows: not asked for "
           "records, or does not tell"),
       field<&Body::pairs_closed, Body>("pairs_closed", "", "contact owner: closed contact pairs"),
       field<&Body::gap_min_m, Body>("gap_min_m", "m", "contact owner: smallest gap of all pairs"),
       field<&Body::gap_rate_min_m_s, Body>("gap_rate_min_m_s", "m/s",
                                            "contact owner: smallest rate of change of a gap"),
       field<&Body::separated, Body>("separated", "", "contact owner: the bodies are separated now"),
       field<&Body::separation_time_s, Body>("separation_time_s", "s",
                                             "contact owner: time of the last separation; < 0: none so far"),
       field<&Body::finished_early, Body>(
           "finished_early", "", "contact owner: `until_separated_plus_s` has passed, nothing more to compute")});
}

struct KindEntry {
  Kind kind;
  std::string_view name;
  std::vector<Field> fields;
};

/// The schema: in the order of `Kind`.
const std::vector<KindEntry>& schema() {
  static const std::vector<KindEntry> table{
      {Kind::hello,
       "hello",
       {field<&Hello::participant>("participant", "", "name of the participant, as in the scene"),
        field<&Hello::role>("role", "", "`explicit` or `implicit`"),
        field<&Hello::solver>("solver", "", "program that speaks"),
        field<&Hello::solver_version>("solver_version", "", "its version"),
        field<&Hello::scene_sha256>("scene_sha256", "",
                                    "SHA-256 of the scene file it read, 64 hexadecimal digits; empty: it reads none"),
        field<&Hello::process_id>("process_id", "", "its process on its machine"),
        field<&Hello::machine>(
            "machine", "",
            "name of its machine, for error texts: as the batch system calls it (`SLURMD_NODENAME`), "
            "else the host name; empty: it does not tell"),
        field<&Hello::shared_memory_path>(
            "shared_memory_path", "",
            "file of its own table that holds shared memory, `/proc/PROCESS/fd/NUMBER`; empty: it offers none"),
        field<&Hello::shared_memory_key>("shared_memory_key", "", "random number at the beginning of that memory")}},
      {Kind::welcome,
       "welcome",
       {field<&Welcome::participant>("participant", "", "name of the participant that is welcome"),
        field<&Welcome::timeout_s>("timeout_s", "s", "longest time it is to wait for the coupler from here on, > 0"),
        field<&Welcome::shared_memory>("shared_memory", "",
                                       "true: all further messages go through the memory that was offered")}},
      {Kind::describe, "describe", {}},
      {Kind::description,
       "description",
       {field<&Description::components>("components", "", "displacement components per node, 1 to 3"),
        field<&Description::bodies>("bodies", "", "bodies it has elements of"),
        field<&Description::interface_body>("interface_body", "",
                                            "n x 1, per interface node an index into `bodies`, from 0"),
        field<&Description::interface_position_m>("interface_position_m", "m",
                                                  "n x components, in the reference configuration"),
        field<&Description::interface_mass_kg>("interface_mass_kg", "kg", "n x 1, lumped mass of its own elements"),
        field<&Description::critical_time_step_s>("critical_time_step_s", "s",
                                                  "limit of its own explicit integration; 0: none needed"),
        field<&Description::capabilities>(
            "capabilities", "",
            "any of `repeat_window`, `switch_integration`, `driven_by_force`, `single_substep`, `interface_stiffness`, "
            "`load_state`, `reconfigure`, `save_state`"),
        field<&Description::record_columns>("record_columns", "",
                                            "names of the history columns; the first is `window`"),
        field<&Description::axial_stress_columns>(
            "axial_stress_columns", "",
            "names of the columns of `axial_stress`; the first is `window`, then `BODY/LOW/HIGH/SHARE` for each layer "
            "of "
            "a "
            "body in which it has elements: borders on the body's axis in m, and the share of the layer's volume that "
            "its "
            "elements fill, whose share of the layer's mean axial stress, tension positive, it tells; none: it tells "
            "none"),
        field<&Description::probe_columns>(
            "probe_columns", "",
            "names of the columns of `probes`; the first is `window`, then `COLUMN/SHARE` for each column of "
            "`probes.csv` of which it tells a share, and that share, 0 to 1; none: it tells of no probe and no gauge"),
        field<&Description::contact_owner>("contact_owner", "",
                                           "it enforces the scene's contact and reports its states")}},
      {Kind::initialize,
       "initialize",
       {field<&Initialize::protocol>("protocol", "", "coupling protocol, as in the scene"),
        field<&Initialize::output_directory>("output_directory", "",
                                             "absolute path for its result files; empty: it is to write none"),
        field<&Initialize::window_size_s>("window_size_s", "s", "size of the first windows, > 0"),
        field<&Initialize::substeps>("substeps", "",
                                     "an explicit participant driven by force takes so many steps in a window, >= 1"),
        field<&Initialize::driven_by>(
            "driven_by", "",
            "its link input: `displacement` (it answers the internal force) or `force` (it answers its motion)"),
        field<&Initialize::interface_mass_kg>("interface_mass_kg", "kg",
                                              "n x 1, the mass it integrates its interface nodes with: summed over all "
                                              "participants that share the node, or "
                                              "its own where the multipliers of a dual protocol couple"),
        field<&Initialize::interface_stiffness>("interface_stiffness", "N/m",
                                                "implicit participant: S, (n x components) x (n x components), "
                                                "symmetric; the force that acts on the shared "
                                                "nodes at the end of a window is link input + S u; 0 rows: none"),
        field<&Initialize::directions>("directions", "",
                                       "components x components: the unit vectors n, t and, of solids, b, one a row, "
                                       "along which momenta, impulses and contact forces are told"),
        field<&Initialize::scene_position_m>("scene_position_m", "m",
                                             "n x components: the scene's places of its interface nodes"),
        field<&Initialize::history_every>("history_every", "windows", "one history row each so many windows, >= 1"),
        field<&Initialize::fields_every>("fields_every", "windows", "result fields each so many windows; 0: none"),
        field<&Initialize::axial_stress_every>(
            "axial_stress_every", "windows",
            "one row of `axial_stress` each so many windows, from the start on; 0: none"),
        field<&Initialize::probes_every>("probes_every", "windows",
                                         "one row of `probes` each so many windows, from the start on; 0: none"),
        field<&Initialize::until_separated_plus_s>(
            "until_separated_plus_s", "s",
            "contact owner: the run ends this long after separation; < 0: it does not end so"),
        field<&Initialize::separation_windows>("separation_windows", "windows",
                                               "contact owner: this long open with growing gaps is separated"),
        field<&Initialize::last_window>("last_window", "", "the run ends here at the latest")}},
      {Kind::progress,
       "progress",
       {field<&Progress::doing>("doing", "", "what it is doing, for the user"),
        field<&Progress::share_done>("share_done", "", "how much of that is done, 0 to 1; < 0: nobody knows")}},
      {Kind::initialized,
       "initialized",
       {field<&Initialized::setup_s>("setup_s", "s", "wall time it took"), absolute_output<Initialized>()}},
      {Kind::synchronise,
       "synchronise",
       {field<&Synchronise::integration>("integration", "", "`implicit_newmark` or `explicit_central`, from here on"),
        field<&Synchronise::link_absolute>("link_absolute", "m or N",
                                           "link input at the present time, n x components")}},
      {Kind::synchronised, "synchronised", joined({absolute_output<Synchronised>()}, rates<Synchronised>())},
      {Kind::reconfigure,
       "reconfigure",
       {field<&Reconfigure::window_size_s>("window_size_s", "s", "size of the windows after this one, > 0"),
        field<&Reconfigure::interface_stiffness>("interface_stiffness", "N/m",
                                                 "implicit participant: S from here on, as in `initialize`")}},
      {Kind::reconfigured, "reconfigured", {}},
      {Kind::advance,
       "advance",
       {field<&Advance::windows>("windows", "",
                                 "how many windows from the header's on; more than 1 only without interface nodes"),
        field<&Advance::link_increment>("link_increment", "m or N",
                                        "change of the link input since the last accepted window, n x components"),
        field<&Advance::link_absolute>("link_absolute", "m or N",
                                       "the link input itself, n x components; 0 rows: not this time"),
        field<&Advance::accept_at_once>("accept_at_once", "", "true: the window is final; false: a trial"),
        field<&Advance::absolute_requested>("absolute_requested", "", "the answer is to bring `absolute`, too"),
        records_requested<Advance>(),
        field<&Advance::touching>("touching", "",
                                  "the contact's owner told closed pairs at the end of the last window")}},
      {Kind::advanced, "advanced",
       joined({field<&Advanced::increment>("increment", "N or m",
                                           "change of the link output since the last accepted window, n x components"),
               field<&Advanced::absolute>("absolute", "N or m",
                                          "the link output itself, n x components; 0 rows unless requested")},
              rates<Advanced>(), accepted_window<Advanced>())},
      {Kind::accept, "accept", {records_requested<Accept>()}},
      {Kind::accepted, "accepted", accepted_window<Accepted>()},
      {Kind::load_state,
       "load_state",
       {field<&LoadState::state>("state", "", "k x 1, its motion in the order and the units of its own `state`"),
        field<&LoadState::frozen_contact>(
            "frozen_contact", "",
            "`open`: no contact force; `sticking`: every pair held together at gap 0, in tension, too, with friction "
            "tangentially as well")}},
      {Kind::state_loaded, "state_loaded", {}},
      {Kind::read_state, "read_state", {}},
      {Kind::state,
       "state",
       {field<&State::state>("state", "",
                             "k x 1, its motion: with it and the link input all that the next window depends on"),
        field<&State::state_scale>(
            "state_scale", "",
            "k x 1, > 0: scaled by it the numbers are comparable, sqrt(m)/dt for a displacement, sqrt(m) for a "
            "velocity")}},
      {Kind::save_state, "save_state", {}},
      {Kind::saved_state,
       "saved_state",
       {field<&SavedState::saved>("saved", "",
                                  "all that it goes on from after the last accepted window, and rows not sent yet; "
                                  "bytes that mean something to it alone")}},
      {Kind::restore_state,
       "restore_state",
       {field<&RestoreState::saved>("saved", "",
                                    "what it said in `saved_state`, maybe in a run before: it goes on from there, to "
                                    "the same bits")}},
      {Kind::state_restored, "state_restored", {}},
      {Kind::finish, "finish", {}},
      {Kind::finished, "finished",
       joined({field<&Finished::compute_s>("compute_s", "s", "wall time spent in the solver"),
               field<&Finished::wait_s>("wait_s", "s", "wall time spent waiting for the coupler"),
               field<&Finished::largest_drift>(
                   "largest_drift", "",
                   "largest difference of accumulated and absolute link input, relative to the largest absolute value"),
               field<&Finished::spans_s>(
                   "spans_s", "s",
                   "rows x 3: window, begin and end of each time it computed, on its steady clock; the first 2000")},
              records<Finished>())},
      {Kind::failure,
       "failure",
       {field<&Failure::error_code>(
            "error_code", "", "exit code: 2 input, 3 unstable, 4 participant, 5 protocol, 6 left the model, 7 machine"),
        field<&Failure::error_culprit>("error_culprit", "", "who failed: name of a participant, or `coupler`"),
        field<&Failure::error_text>("error_text", "", "what happened, and where")}},
  };
  return table;
}

const KindEntry& entry(Kind kind) { return schema()[static_cast<std::size_t>(kind)]; }

}  // namespace

std::string_view name(Kind kind) { return entry(kind).name; }

const std::vector<Field>& header_fields() {
  static const std::vector<Field> fields{
      field<&Header::kind>("kind", "", "one of the messages below"),
      field<&Header::version>("version", "", "of this protocol; both ends must speak the same"),
      field<&Header::run_id>("run_id", "", "the run's name; empty in `hello`, whose sender learns it from `welcome`"),
      field<&Header::sequence>("sequence", "", "counts the sender's messages on this link from 0"),
      field<&Header::window>("window", "",
                             "the window it is about, at its end: where its size never changes window n ends at n x "
                             "`window_size_s`; 0: the start"),
      field<&Header::substep>(
          "substep", "",
          "`advance` and its answer: the one step within the window that it is about, from 1; 0: the whole window"),
  };
  return fields;
}

const std::vector<Field>& fields_of(Kind kind) { return entry(kind).fields; }

const std::vector<Kind>& all_kinds() {
  static const std::vector<Kind> kinds = [] {
    std::vector<Kind> all;
    for (const auto& e : schema()) all.push_back(e.kind);
    return all;
  }();
  return kinds;
}

}  // namespace ricochet::wire

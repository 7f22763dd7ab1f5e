#include "common/wire/message.hpp"

#include <algorithm>
#include <cmath>

namespace ricochet::wire {
namespace {

using M = Message;

// Fields that several kinds carry with the same meaning.
constexpr Field absolute_output{
    "absolute", &M::absolute, "N or m",
    "link output, n x components: displacement; of who is driven by displacement, internal force"};
constexpr Field velocity{"velocity_m_s", &M::velocity_m_s, "m/s",
                         "of the interface nodes, n x components; 0 rows from who is driven by displacement"};
constexpr Field acceleration{"acceleration_m_s2", &M::acceleration_m_s2, "m/s^2",
                             "of the interface nodes, n x components; 0 rows from who is driven by displacement"};
constexpr Field records{"records", &M::records, "", "history rows not sent before, rows x record columns"};
constexpr Field axial_stress{"axial_stress", &M::axial_stress, "Pa",
                             "rows not sent before, rows x axial stress columns; the first number is the window"};
constexpr Field departures{
    "departures", &M::departures, "",
    "what has left the model so far, rows x 9: kind (1 strain, 2 rotation, 3 slip, 4 inverted element, 5 "
    "node off its partner, 6 penetration: docs/limits.md), index into `bodies`, last window without it, first window "
    "with it, how many looks found it, "
    "largest size, its window, its place x and y; 0 rows: nothing, or not looked for"};
constexpr Field outline{
    "outline", &M::outline, "m",
    "rows x (2 + components): index into `bodies`, node of that body's mesh, displacement, for nodes of the outlines "
    "of bodies that others could meet without a contact; 0 rows: not asked for records, or does not tell"};
constexpr Field records_requested{"records_requested", &M::records_requested, "",
                                  "the answer is to bring the history rows"};

// Contact after the last accepted window; all zero, and -1 for the time, from who does not own the contact.
constexpr Field pairs_closed{"pairs_closed", &M::pairs_closed, "", "contact owner: closed contact pairs"};
constexpr Field gap_min{"gap_min_m", &M::gap_min_m, "m", "contact owner: smallest gap of all pairs"};
constexpr Field gap_rate_min{"gap_rate_min_m_s", &M::gap_rate_min_m_s, "m/s",
                             "contact owner: smallest rate of change of a gap"};
constexpr Field separated{"separated", &M::separated, "", "contact owner: the bodies are separated now"};
constexpr Field separation_time{"separation_time_s", &M::separation_time_s, "s",
                                "contact owner: time of the last separation; < 0: none so far"};
constexpr Field finished_early{"finished_early", &M::finished_early, "",
                               "contact owner: `until_separated_plus_s` has passed, nothing more to compute"};

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
       {{"participant", &M::participant, "", "name of the participant, as in the scene"},
        {"role", &M::role, "", "`explicit` or `implicit`"},
        {"solver", &M::solver, "", "program that speaks"},
        {"solver_version", &M::solver_version, "", "its version"},
        {"scene_sha256", &M::scene_sha256, "",
         "SHA-256 of the scene file it read, 64 hexadecimal digits; empty: it reads none"},
        {"process_id", &M::process_id, "", "its process on its machine"},
        {"shared_memory_path", &M::shared_memory_path, "",
         "file of its own table that holds shared memory, `/proc/PROCESS/fd/NUMBER`; empty: it offers none"},
        {"shared_memory_key", &M::shared_memory_key, "", "random number at the beginning of that memory"}}},
      {Kind::welcome,
       "welcome",
       {{"participant", &M::participant, "", "name of the participant that is welcome"},
        {"timeout_s", &M::timeout_s, "s", "longest time it is to wait for the coupler from here on, > 0"},
        {"shared_memory", &M::shared_memory, "", "true: all further messages go through the memory that was offered"}}},
      {Kind::describe, "describe", {}},
      {Kind::description,
       "description",
       {{"components", &M::components, "", "displacement components per node, 1 to 3"},
        {"bodies", &M::bodies, "", "bodies it has elements of"},
        {"interface_body", &M::interface_body, "", "n x 1, per interface node an index into `bodies`, from 0"},
        {"interface_position_m", &M::interface_position_m, "m", "n x components, in the reference configuration"},
        {"interface_mass_kg", &M::interface_mass_kg, "kg", "n x 1, lumped mass of its own elements"},
        {"critical_time_step_s", &M::critical_time_step_s, "s",
         "limit of its own explicit integration; 0: none needed"},
        {"capabilities", &M::capabilities, "",
         "any of `repeat_window`, `switch_integration`, `driven_by_force`, `single_substep`, `interface_stiffness`, "
         "`load_state`"},
        {"record_columns", &M::record_columns, "", "names of the history columns; the first is `window`"},
        {"axial_stress_columns", &M::axial_stress_columns, "",
         "names of the columns of `axial_stress`; the first is `window`, then `BODY/LOW/HIGH/SHARE` for each layer of "
         "a "
         "body in which it has elements: borders on the body's axis in m, and the share of the layer's volume that its "
         "elements fill, whose share of the layer's mean axial stress, tension positive, it tells; none: it tells "
         "none"},
        {"contact_owner", &M::contact_owner, "", "it enforces the scene's contact and reports its states"}}},
      {Kind::initialize,
       "initialize",
       {{"protocol", &M::protocol, "", "coupling protocol, as in the scene"},
        {"output_directory", &M::output_directory, "", "absolute path for its result files"},
        {"window_size_s", &M::window_size_s, "s", "size of one window, > 0"},
        {"substeps", &M::substeps, "", "an explicit participant driven by force takes so many steps in a window, >= 1"},
        {"driven_by", &M::driven_by, "",
         "its link input: `displacement` (it answers the internal force) or `force` (it answers its motion)"},
        {"interface_mass_kg", &M::interface_mass_kg, "kg",
         "n x 1, the mass it integrates its interface nodes with: summed over all participants that share the node, or "
         "its own where the multipliers of a dual protocol couple"},
        {"interface_stiffness", &M::interface_stiffness, "N/m",
         "implicit participant: S, (n x components) x (n x components), symmetric; the force that acts on the shared "
         "nodes at the end of a window is link input + S u; 0 rows: none"},
        {"history_every", &M::history_every, "windows", "one history row each so many windows, >= 1"},
        {"fields_every", &M::fields_every, "windows", "result fields each so many windows; 0: none"},
        {"axial_stress_every", &M::axial_stress_every, "windows",
         "one row of `axial_stress` each so many windows, from the start on; 0: none"},
        {"until_separated_plus_s", &M::until_separated_plus_s, "s",
         "contact owner: the run ends this long after separation; < 0: it does not end so"},
        {"separation_windows", &M::separation_windows, "windows",
         "contact owner: this long open with growing gaps is separated"},
        {"last_window", &M::last_window, "", "the run ends here at the latest"}}},
      {Kind::initialized, "initialized", {{"setup_s", &M::setup_s, "s", "wall time it took"}, absolute_output}},
      {Kind::synchronise,
       "synchronise",
       {{"integration", &M::integration, "", "`implicit_newmark` or `explicit_central`, from here on"},
        {"link_absolute", &M::link_absolute, "m or N", "link input at the present time, n x components"}}},
      {Kind::synchronised, "synchronised", {absolute_output, velocity, acceleration}},
      {Kind::advance,
       "advance",
       {{"windows", &M::windows, "", "how many windows from the header's on; more than 1 only without interface nodes"},
        {"link_increment", &M::link_increment, "m or N",
         "change of the link input since the last accepted window, n x components"},
        {"link_absolute", &M::link_absolute, "m or N", "the link input itself, n x components; 0 rows: not this time"},
        {"accept_at_once", &M::accept_at_once, "", "true: the window is final; false: a trial"},
        {"absolute_requested", &M::absolute_requested, "", "the answer is to bring `absolute`, too"},
        records_requested}},
      {Kind::advanced,
       "advanced",
       {{"increment", &M::increment, "N or m",
         "change of the link output since the last accepted window, n x components"},
        {"absolute", &M::absolute, "N or m", "the link output itself, n x components; 0 rows unless requested"},
        velocity,
        acceleration,
        records,
        axial_stress,
        departures,
        outline,
        pairs_closed,
        gap_min,
        gap_rate_min,
        separated,
        separation_time,
        finished_early}},
      {Kind::accept, "accept", {records_requested}},
      {Kind::accepted,
       "accepted",
       {records, axial_stress, departures, outline, pairs_closed, gap_min, gap_rate_min, separated, separation_time,
        finished_early}},
      {Kind::load_state,
       "load_state",
       {{"state", &M::state, "", "k x 1, its motion in the order and the units of its own `state`"},
        {"frozen_contact", &M::frozen_contact, "",
         "`open`: no contact force; `sticking`: every pair held together at gap 0, in tension, too, with friction "
         "tangentially as well"}}},
      {Kind::state_loaded, "state_loaded", {}},
      {Kind::read_state, "read_state", {}},
      {Kind::state,
       "state",
       {{"state", &M::state, "", "k x 1, its motion: with it and the link input all that the next window depends on"},
        {"state_scale", &M::state_scale, "",
         "k x 1, > 0: scaled by it the numbers are comparable, sqrt(m)/dt for a displacement, sqrt(m) for a "
         "velocity"}}},
      {Kind::finish, "finish", {}},
      {Kind::finished,
       "finished",
       {{"compute_s", &M::compute_s, "s", "wall time spent in the solver"},
        {"wait_s", &M::wait_s, "s", "wall time spent waiting for the coupler"},
        {"largest_drift", &M::largest_drift, "",
         "largest difference of accumulated and absolute link input, relative to the largest absolute value"},
        {"spans_s", &M::spans_s, "s",
         "rows x 3: window, begin and end of each time it computed, on its steady clock; the first 2000"},
        records,
        axial_stress,
        departures}},
      {Kind::failure,
       "failure",
       {{"error_code", &M::error_code, "",
         "exit code: 2 input, 3 unstable, 4 participant, 5 protocol, 6 left the model, 7 machine"},
        {"error_culprit", &M::error_culprit, "", "who failed: name of a participant, or `coupler`"},
        {"error_text", &M::error_text, "", "what happened, and where"}}},
  };
  return table;
}

const KindEntry& entry(Kind kind) { return schema()[static_cast<std::size_t>(kind)]; }

void reset(std::string& value, const std::string&) { value.clear(); }
void reset(std::vector<std::string>& value, const std::vector<std::string>&) { value.clear(); }
void reset(Array& value, const Array&) { value.resize(0, 0); }
template <class Number>
void reset(Number& value, Number initial) {
  value = initial;
}

}  // namespace

void Array::resize(int new_rows, int new_columns) {
  rows = new_rows;
  columns = new_columns;
  data.resize(static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns));
}

void Array::set(const std::vector<double>& values, int new_rows, int new_columns) {
  rows = new_rows;
  columns = new_columns;
  data.assign(values.begin(), values.end());
}

std::string_view name(Kind kind) { return entry(kind).name; }

bool has_role(const Message& message, Role role) { return message.role == name_of(role); }

bool has_capability(const Message& description, Capability capability) {
  const auto& has = description.capabilities;
  return std::find(has.begin(), has.end(), name_of(capability)) != has.end();
}

const std::vector<Field>& header_fields() {
  static const std::vector<Field> fields{
      {"kind", &M::kind, "", "one of the messages below"},
      {"version", &M::version, "", "of this protocol; both ends must speak the same"},
      {"run_id", &M::run_id, "", "the run's name; empty in `hello`, whose sender learns it from `welcome`"},
      {"sequence", &M::sequence, "", "counts the sender's messages on this link from 0"},
      {"window", &M::window, "",
       "the window it is about, at its end: window n ends at n x `window_size_s`; 0: the start"},
      {"substep", &M::substep, "",
       "`advance` and its answer: the one step within the window that it is about, from 1; 0: the whole window"},
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

void clear(Message& message) {
  static const Message fresh;
  const auto clear_fields = [&](const std::vector<Field>& fields) {
    for (const auto& field : fields) {
      std::visit([&](auto member) { reset(message.*member, fresh.*member); }, field.member);
    }
  };
  clear_fields(header_fields());
  for (const auto& e : schema()) clear_fields(e.fields);
}

double relative_difference(const std::vector<double>& accumulated, const std::vector<double>& absolute) {
  double difference = 0.0, scale = 0.0;
  for (std::size_t i = 0; i < absolute.size(); ++i) {
    difference = std::max(difference, std::abs(accumulated[i] - absolute[i]));
    scale = std::max(scale, std::abs(absolute[i]));
  }
  return scale > 0.0 ? difference / scale : difference;
}

}  // namespace ricochet::wire

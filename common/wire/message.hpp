#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <tuple>
#include <variant>
#include <vector>

#include "common/base/archive.hpp"
#include "common/base/vocabulary.hpp"

/// THE message schema. Everything that passes between a coupler and a participant is a `Message`: a header, and a body
/// of its kind. Name, unit and meaning of every field stand in one table, `fields_of`, that the codec, the docs and the
/// tests read.
namespace ricochet::wire {

inline constexpr std::int64_t protocol_version = 7;

/// Row-major array of doubles. On the wire {"shape": [rows, columns], "data": raw little-endian doubles}.
struct Array {
  int rows = 0;
  int columns = 0;
  std::vector<double> data;

  /// Sets the shape and `data` to rows x columns numbers (keeps the capacity); new ones are 0.
  void resize(int new_rows, int new_columns);
  /// Sets the shape and copies the numbers, rows x columns of them.
  void set(const std::vector<double>& values, int new_rows, int new_columns);
  void archive(Archive& a);
};

/// max |accumulated - absolute| / max |absolute|, by which incremental transfer has drifted; the difference itself
/// where the absolute values are all zero. Equal sizes.
[[nodiscard]] double relative_difference(const std::vector<double>& accumulated, const std::vector<double>& absolute);

/// Bytes that mean something to who wrote them. On the wire: binary data.
struct Bytes {
  std::string data;
  bool operator==(const Bytes&) const = default;
};

enum class Kind {
  hello,        ///< participant: I am ...
  welcome,      ///< coupler: you are part of run ...
  describe,     ///< coupler asks
  description,  ///< participant: interface nodes, masses, capabilities, critical time step
  initialize,   ///< coupler: window size, summed masses, output
  progress,     ///< participant: still at work on what `initialize` asks for
  initialized,  ///< participant: link values at t = 0
  synchronise,  ///< coupler: absolute link values; recompute accelerations here; integrate implicitly | explicitly from
                ///< here on
  synchronised,
  reconfigure,  ///< coupler: windows have another size from here on
  reconfigured,
  advance,  ///< coupler: link increment; compute window(s); accept at once or on request
  advanced,
  accept,  ///< coupler: the last trial window is final
  accepted,
  load_state,  ///< coupler: take this motion, without loads, with contact frozen so; `synchronise` follows
  state_loaded,
  read_state,  ///< coupler asks for the motion as `load_state` takes it
  state,
  save_state,  ///< coupler asks for all that the participant goes on from
  saved_state,
  restore_state,  ///< coupler: go on from what was saved
  state_restored,
  finish,  ///< coupler: no more windows
  finished,
  failure,  ///< either: I stop, and why
};

/// Numbers in a row of `departures`.
inline constexpr int departure_columns = 14;

struct Header {
  Kind kind = Kind::failure;
  std::int64_t version = protocol_version;
  std::string run_id;
  std::int64_t sequence = 0, window = 0, substep = 0;
};

// Arrays below have one row per interface node (n, in the participant's own order) unless said otherwise.

struct Hello {
  static constexpr Kind kind = Kind::hello;
  std::string participant, role, solver, solver_version, scene_sha256;
  std::int64_t process_id = 0;
  std::string machine;
  std::string shared_memory_path;
  std::int64_t shared_memory_key = 0;
};

struct Welcome {
  static constexpr Kind kind = Kind::welcome;
  std::string participant;
  double timeout_s = 0;
  bool shared_memory = false;
};

struct Describe {
  static constexpr Kind kind = Kind::describe;
};

struct Description {
  static constexpr Kind kind = Kind::description;
  std::int64_t components = 0;
  std::vector<std::string> bodies;
  Array interface_body;        ///< n x 1, index into `bodies`
  Array interface_position_m;  ///< n x components
  Array interface_mass_kg;     ///< n x 1: own lumped mass
  double critical_time_step_s = 0;
  std::vector<std::string> capabilities, record_columns, axial_stress_columns, probe_columns;
  bool contact_owner = false;

  /// Whether it names the capability.
  [[nodiscard]] bool has(Capability capability) const;
};

struct Initialize {
  static constexpr Kind kind = Kind::initialize;
  std::string protocol, output_directory;
  double window_size_s = 0;
  std::int64_t substeps = 1;
  std::string driven_by;
  Array interface_mass_kg;    ///< n x 1: the mass to integrate with
  Array interface_stiffness;  ///< (n x components)^2, to the implicit participant; empty: none [N/m]
  Array directions;           ///< components x components: n, t and b of the scene, one a row
  Array scene_position_m;     ///< n x components: where the scene has the interface nodes
  std::int64_t history_every = 1, fields_every = 0, axial_stress_every = 0, probes_every = 0;
  double until_separated_plus_s = 0;
  std::int64_t separation_windows = 0, last_window = 0;
};

/// Not an answer: that follows.
struct Progress {
  static constexpr Kind kind = Kind::progress;
  std::string doing;
  double share_done = -1.0;  ///< < 0: nobody knows
};

struct Initialized {
  static constexpr Kind kind = Kind::initialized;
  double setup_s = 0;
  Array absolute;
};

struct Synchronise {
  static constexpr Kind kind = Kind::synchronise;
  std::string integration;
  Array link_absolute;  ///< link input [m or N]
};

/// Motion of the interface nodes, besides the displacement.
struct Rates {
  Array velocity_m_s;       ///< who is driven by force: n x components; by displacement: 0 rows
  Array acceleration_m_s2;  ///< as velocity
};

struct Synchronised : Rates {
  static constexpr Kind kind = Kind::synchronised;
  Array absolute;  ///< link output [N or m]
};

/// Between windows; nothing moves. All else that `initialize` said holds.
struct Reconfigure {
  static constexpr Kind kind = Kind::reconfigure;
  double window_size_s = 0;
  Array interface_stiffness;  ///< as in `Initialize`
};

struct Reconfigured {
  static constexpr Kind kind = Kind::reconfigured;
};

struct Advance {
  static constexpr Kind kind = Kind::advance;
  std::int64_t windows = 1;
  Array link_increment;  ///< change of the link input since the last accepted window [m or N]
  Array link_absolute;   ///< the same, absolute; 0 rows unless resynchronising
  bool accept_at_once = false, absolute_requested = false, records_requested = false;
  bool touching = false;  ///< as the contact's owner told it of the last window
};

/// Rows that were not sent before.
struct Records {
  Array records;         ///< history, rows x record_columns
  Array axial_stress;    ///< rows x axial_stress_columns
  Array probes;          ///< rows x probe_columns
  Array departures;      ///< rows x departure_columns: kind, body, last window without, first window, looks, size, its
                         ///< window, x, y, z, size in the first look, its x, y, z
  Array contact_forces;  ///< rows x (1 + contacts): window, force of each contact [N]
};

/// State of the contact after the last accepted window, as its owner reports it.
struct ContactReport {
  std::int64_t pairs_closed = 0;
  double gap_min_m = 0, gap_rate_min_m_s = 0;
  bool separated = false;
  double separation_time_s = -1.0;  ///< < 0: none so far
  bool finished_early = false;

  bool operator==(const ContactReport&) const = default;
  void archive(Archive& a) {
    a(pairs_closed, gap_min_m, gap_rate_min_m_s, separated, separation_time_s, finished_early);
  }
};

/// The news of windows when they are final.
struct AcceptedWindow : Records, ContactReport {
  Array outline;  ///< rows x (2 + components): index into `bodies`, node of the body's mesh, displacement [m]
};

struct Advanced : Rates, AcceptedWindow {
  static constexpr Kind kind = Kind::advanced;
  Array increment;  ///< change of the link output since the last accepted window [N or m]; Delta P
  Array absolute;   ///< the same, absolute; 0 rows unless requested
};

struct Accept {
  static constexpr Kind kind = Kind::accept;
  bool records_requested = false;
};

struct Accepted : AcceptedWindow {
  static constexpr Kind kind = Kind::accepted;
};

struct LoadState {
  static constexpr Kind kind = Kind::load_state;
  Array state;  ///< k x 1: a participant's own motion
  std::string frozen_contact;
};

struct StateLoaded {
  static constexpr Kind kind = Kind::state_loaded;
};

struct ReadState {
  static constexpr Kind kind = Kind::read_state;
};

struct State {
  static constexpr Kind kind = Kind::state;
  Array state;        ///< k x 1: a participant's own motion
  Array state_scale;  ///< k x 1: what makes energies of its numbers comparable
};

struct SaveState {
  static constexpr Kind kind = Kind::save_state;
};

struct SavedState {
  static constexpr Kind kind = Kind::saved_state;
  Bytes saved;
};

struct RestoreState {
  static constexpr Kind kind = Kind::restore_state;
  Bytes saved;
};

struct StateRestored {
  static constexpr Kind kind = Kind::state_restored;
};

struct Finish {
  static constexpr Kind kind = Kind::finish;
};

struct Finished : Records {
  static constexpr Kind kind = Kind::finished;
  double compute_s = 0, wait_s = 0;
  double largest_drift = 0;
  Array spans_s;  ///< rows x 3: window, begin, end of each computing span on the steady clock
};

struct Failure {
  static constexpr Kind kind = Kind::failure;
  std::int64_t error_code = 0;
  std::string error_culprit, error_text;
};

/// A header, and room for a body of every kind, so that a message that is used again for another kind allocates
/// nothing.
struct Message : Header {
  /// Makes it a message of that kind, all of whose fields are as in a new one; vectors and strings keep their capacity.
  template <class Body>
  Body& make();
  /// Its body. Throws std::logic_error for a message of another kind.
  template <class Body>
  [[nodiscard]] const Body& as() const {
    require(Body::kind);
    return std::get<Body>(bodies_);
  }
  template <class Body>
  [[nodiscard]] Body& as() {
    require(Body::kind);
    return std::get<Body>(bodies_);
  }

 private:
  void require(Kind wanted) const {
    if (kind != wanted) refuse(wanted);
  }
  [[noreturn]] void refuse(Kind wanted) const;

  std::tuple<Hello, Welcome, Describe, Description, Initialize, Progress, Initialized, Synchronise, Synchronised,
             Reconfigure, Reconfigured, Advance, Advanced, Accept, Accepted, LoadState, StateLoaded, ReadState, State,
             SaveState, SavedState, RestoreState, StateRestored, Finish, Finished, Failure>
      bodies_;
};

[[nodiscard]] std::string_view name(Kind kind);

/// Where one field of a message is.
template <template <class> class Pointer>
using FieldPointer =
    std::variant<Pointer<Kind>, Pointer<bool>, Pointer<std::int64_t>, Pointer<double>, Pointer<std::string>,
                 Pointer<std::vector<std::string>>, Pointer<Array>, Pointer<Bytes>>;
template <class Value>
using Writable = Value*;
template <class Value>
using Readable = const Value*;

/// One field of the schema: its name on the wire, its unit and meaning (for the docs), where it lives in a message of
/// its kind.
struct Field {
  std::string_view name, unit, meaning;
  FieldPointer<Writable> (*in)(Message&);
  FieldPointer<Readable> (*of)(const Message&);
};

/// Fields of the header and of one kind, in the order in which they are encoded.
[[nodiscard]] const std::vector<Field>& header_fields();
[[nodiscard]] const std::vector<Field>& fields_of(Kind kind);
[[nodiscard]] const std::vector<Kind>& all_kinds();

/// Every field of the message's kind as in a new message; vectors and strings keep their capacity.
void clear_body(Message& message);

template <class Body>
Body& Message::make() {
  kind = Body::kind;
  clear_body(*this);
  return std::get<Body>(bodies_);
}

}  // namespace ricochet::wire

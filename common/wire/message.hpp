#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "common/base/vocabulary.hpp"

/// THE message schema. Everything that passes between a coupler and a participant is a `Message`; which fields a kind
/// carries stands in one table, `fields_of`, that the codec, the docs and the tests read.
namespace ricochet::wire {

inline constexpr std::int64_t protocol_version = 4;

/// Row-major array of doubles. On the wire {"shape": [rows, columns], "data": raw little-endian doubles}.
struct Array {
  int rows = 0;
  int columns = 0;
  std::vector<double> data;

  /// Sets the shape and `data` to rows x columns numbers (keeps the capacity); new ones are 0.
  void resize(int new_rows, int new_columns);
  /// Sets the shape and copies the numbers, rows x columns of them.
  void set(const std::vector<double>& values, int new_rows, int new_columns);
};

/// max |accumulated - absolute| / max |absolute|, by which incremental transfer has drifted; the difference itself
/// where the absolute values are all zero. Equal sizes.
[[nodiscard]] double relative_difference(const std::vector<double>& accumulated, const std::vector<double>& absolute);

enum class Kind {
  hello,        ///< participant: I am ...
  welcome,      ///< coupler: you are part of run ...
  describe,     ///< coupler asks
  description,  ///< participant: interface nodes, masses, capabilities, critical time step
  initialize,   ///< coupler: window size, summed masses, output
  initialized,  ///< participant: link values at t = 0
  synchronise,  ///< coupler: absolute link values; recompute accelerations here; integrate implicitly | explicitly from
                ///< here on
  synchronised,
  advance,  ///< coupler: link increment; compute window(s); accept at once or on request
  advanced,
  accept,  ///< coupler: the last trial window is final
  accepted,
  load_state,  ///< coupler: take this motion, without loads, with contact frozen so; `synchronise` follows
  state_loaded,
  read_state,  ///< coupler asks for the motion as `load_state` takes it
  state,
  finish,  ///< coupler: no more windows
  finished,
  failure,  ///< either: I stop, and why
};

/// Numbers in a row of `departures`.
inline constexpr int departure_columns = 9;

/// Which members a message of a kind carries says `fields_of`; what they mean, the table behind it (and docs/wire.md).
struct Message {
  // header, in every message
  Kind kind = Kind::failure;
  std::int64_t version = protocol_version;
  std::string run_id;
  std::int64_t sequence = 0, window = 0, substep = 0;

  // names and texts
  std::string participant, role, solver, solver_version, scene_sha256, output_directory, protocol, integration;
  std::string driven_by, frozen_contact, shared_memory_path, error_text, error_culprit;
  std::vector<std::string> bodies, capabilities, record_columns, axial_stress_columns;

  // numbers
  bool shared_memory = false, contact_owner = false;
  bool accept_at_once = false, absolute_requested = false, records_requested = false;
  bool separated = false, finished_early = false;
  std::int64_t process_id = 0, shared_memory_key = 0, components = 0;
  std::int64_t windows = 1, substeps = 1, history_every = 1, fields_every = 0, axial_stress_every = 0, last_window = 0;
  std::int64_t separation_windows = 0, pairs_closed = 0, error_code = 0;
  double window_size_s = 0, critical_time_step_s = 0, timeout_s = 0, until_separated_plus_s = 0;
  double gap_min_m = 0, gap_rate_min_m_s = 0, separation_time_s = 0, setup_s = 0, compute_s = 0, wait_s = 0;
  double largest_drift = 0;

  // arrays, one row per interface node (in the participant's own order) unless said otherwise
  Array interface_body;        ///< n x 1, index into `bodies`
  Array interface_position_m;  ///< n x components
  Array interface_mass_kg;  ///< n x 1: own lumped mass in `description`, the sum over all participants in `initialize`
  Array interface_stiffness;  ///< (n x components)^2, to the implicit participant; empty: none [N/m]
  Array link_increment;       ///< to a participant: change of its link input since its last accepted window [m or N]
  Array link_absolute;        ///< the same, absolute; empty (0 x components) unless resynchronising
  Array increment;  ///< from a participant: change of its link output since its last accepted window [N or m]; Delta P
  Array absolute;   ///< the same, absolute; empty unless requested
  Array velocity_m_s;        ///< who is driven by force: n x components; by displacement: empty
  Array acceleration_m_s2;   ///< as velocity
  Array state, state_scale;  ///< k x 1: a participant's own motion, and what makes energies of its numbers comparable
  Array records;             ///< history rows (rows x record_columns)
  Array axial_stress;        ///< rows x axial_stress_columns
  Array departures;  ///< rows x departure_columns: kind, body, last window without, first window, looks, size, its
                     ///< window, x, y
  Array outline;     ///< rows x (2 + components): index into `bodies`, node of the body's mesh, displacement [m]
  Array spans_s;     ///< rows x 3: window, begin, end of each computing span on the steady clock
};

[[nodiscard]] std::string_view name(Kind kind);

/// What a participant says of itself in `hello`, and in a `description` into which its role was filled.
[[nodiscard]] bool has_role(const Message& message, Role role);
/// Whether a `description` names the capability.
[[nodiscard]] bool has_capability(const Message& description, Capability capability);

/// One field of the schema: its name on the wire, where it lives, its unit and meaning (for the docs).
struct Field {
  std::string_view name;
  std::variant<Kind Message::*, bool Message::*, std::int64_t Message::*, double Message::*, std::string Message::*,
               std::vector<std::string> Message::*, Array Message::*>
      member;
  std::string_view unit;
  std::string_view meaning;
};

/// Fields of the header and of one kind, in the order in which they are encoded.
[[nodiscard]] const std::vector<Field>& header_fields();
[[nodiscard]] const std::vector<Field>& fields_of(Kind kind);
[[nodiscard]] const std::vector<Kind>& all_kinds();

/// Every member as in a new message; vectors and strings keep their capacity, so that a message can be used again
/// without allocating.
void clear(Message& message);

}  // namespace ricochet::wire

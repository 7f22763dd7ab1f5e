#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/vocabulary.hpp"
#include "common/base/window_clock.hpp"

/// The contract of a solver that takes part in a coupled run. A C++ solver implements `Participant` and calls `serve`;
/// this header needs neither Eigen nor finite elements. All vectors are row-major, with one row per interface node in
/// the order of `Description` and `components` columns. SI units.
///
/// There are two roles. An *explicit* participant takes the displacement u of its interface nodes [m] and answers the
/// internal force P = K u [N] of its own elements with stiffness K. P is positive where it resists positive motion.
/// An *implicit* participant integrates the interface nodes: it takes the sum of those internal forces [N] and
/// answers displacement [m], velocity [m/s] and acceleration [m/s^2] of its interface nodes.
/// A dual protocol drives an explicit participant *by force*: it integrates its interface nodes with its own mass M,
/// M a = f - K u + lambda, f its loads. It takes the interface multiplier lambda [N] at the end of a window (linear
/// over the window) and answers their motion. Capability "driven_by_force". Incremental transfer (Eq. 6), accumulation
/// and resynchronisation are done by `serve`: here everything is absolute.
namespace ricochet {
class Archive;
}

namespace ricochet::participant {

using ricochet::Capability, ricochet::Drive, ricochet::FrozenContact, ricochet::Integration, ricochet::Role;

struct Description {
  std::string name;
  Role role = Role::explicit_solver;
  std::string solver;  ///< e.g. "ricochet explicit_solver"
  std::string solver_version;
  std::string scene_sha256;                  ///< empty if it reads no scene
  int components = 1;                        ///< displacement components per node
  std::vector<std::string> bodies;           ///< bodies it has elements of
  std::vector<int> interface_body;           ///< per interface node, index into `bodies`
  std::vector<double> interface_position_m;  ///< nodes x components, reference configuration
  std::vector<double> interface_mass_kg;     ///< per node, own lumped mass
  double critical_time_step_s = 0;           ///< of its own explicit integration; 0: none needed
  /// A substep is one of Setup::substeps; the interface stiffness is Setup::interface_stiffness; a state is what
  /// `load_state` and `read_state` are about.
  std::vector<Capability> capabilities;
  std::vector<std::string> record_columns;  ///< names of the history quantities `record` appends
  /// "BODY/LOW/HIGH/SHARE" of what `axial_stress` appends: a layer of a body between two coordinates of its axis [m],
  /// and the share of the layer's volume that elements of this participant fill. May stay empty: it tells no axial
  /// stress.
  std::vector<std::string> axial_stress_columns;
  /// "COLUMN/SHARE" of what `probes` appends: a column of probes.csv, and the share of it that this participant tells.
  /// May stay empty: it tells of no probe and no gauge.
  std::vector<std::string> probe_columns;
  bool contact_owner = false;  ///< true: enforces the scene's contact and reports its states
};

/// Tells the coupler and its user what is being done, and which share of it is done, 0 to 1 (< 0: nobody knows).
using TellProgress = std::function<void(std::string_view doing, double share_done)>;

struct Setup {
  std::string run_id, protocol, output_directory;
  WindowClock clock;                      ///< ends and sizes Delta t of the windows so far and of the next one [s]
  int substeps = 1;                       ///< driven by force, explicit: central difference steps in a window
  Drive driven_by = Drive::displacement;  ///< implicit participants: always force
  /// Per node: mass to integrate the interface nodes with, summed over all participants (Eq. 28); the own one if the
  /// protocol is dual.
  std::vector<double> interface_mass_kg;
  /// Implicit: S, (nodes x components)^2, row-major, symmetric [N/m]; empty: none. The force of the other participants
  /// on the interface nodes at the end of a window is link input + S u, u their displacement there. Only while
  /// integrating by `implicit_newmark`.
  std::vector<double> interface_stiffness;
  /// n, t and, of solids, b, components x components, one a row: along which momenta, impulses and contact forces are
  /// told. n is that of the scene's first contact, out of its first body, or without a contact the last axis.
  std::vector<double> directions;
  /// Nodes x components, where the scene has the interface nodes: within rounding where this participant has them [m].
  std::vector<double> scene_position_m;
  int history_every = 1, fields_every = 0;  ///< windows; fields_every 0: none
  int axial_stress_every = 0;               ///< windows; 0: none
  int probes_every = 0;                     ///< windows; 0: none
  double until_separated_plus_s = -1;       ///< contact owner: finished this long after separation; < 0: never
  int separation_windows = 10;              ///< contact owner: windows with all pairs open and gaps growing = separated
  std::int64_t last_window = 0;             ///< the run ends here at the latest
  /// A long `initialize` calls this as often as it likes, by one thread at a time. The coupler takes a participant that
  /// is silent for longer than the scene's timeout for dead. Empty: nobody listens.
  TellProgress progress;
};

/// The answer of a participant at its interface nodes. Driven by displacement: `value` is the force [N]; velocity and
/// acceleration are empty. Driven by force: `value` is the displacement [m].
struct LinkOutput {
  std::vector<double> value, velocity_m_s, acceleration_m_s2;
};

struct ContactStatus {
  int pairs_closed = 0;
  double gap_min_m = 0;           ///< smallest gap of all pairs
  double gap_rate_min_m_s = 0;    ///< smallest rate of change of a gap
  bool separated = false;         ///< separated now: all pairs open, gaps growing for `separation_windows`
  double separation_time_s = -1;  ///< of the last separation; < 0: none so far
  bool finished = false;          ///< `until_separated_plus_s` has passed

  void archive(Archive& a);
};

/// How a run leaves the model of small strain, small displacement, linear elasticity and contact nodes that stay
/// opposite; see docs/limits.md. The numbers are those of the wire.
enum class DepartureKind {
  strain = 1,       ///< size: largest principal strain
  rotation = 2,     ///< [rad]
  slip = 3,         ///< of a closed pair, in lengths of an element edge
  inverted = 4,     ///< an element turned inside out: 1 - smallest Jacobian over that of the reference
  off_partner = 5,  ///< a closed pair's node past the end of the other surface, in edges
  penetration = 6,  ///< of a pair, in depths of an element
  yield = 7,        ///< von Mises stress above material.yield_stress_pa [Pa]
  tension = 8,      ///< principal stress above material.strength_pa [Pa]
};

/// Something that has left the model, so far.
struct Departure {
  DepartureKind kind = DepartureKind::strain;
  int body = 0;                                        ///< index into Description::bodies
  std::int64_t last_without = 0;                       ///< window of the last look that did not find it
  std::int64_t first = 0;                              ///< window of the first look that did
  std::int64_t looks = 0;                              ///< that found it
  double largest = 0;                                  ///< size
  std::int64_t window = 0;                             ///< of the largest
  double x_m = 0, y_m = 0, z_m = 0;                    ///< its place in the reference configuration
  double first_size = 0;                               ///< largest of the first look that found it
  double first_x_m = 0, first_y_m = 0, first_z_m = 0;  ///< its place

  void archive(Archive& a);
};

/// The place of a node, so that the coupler can find out whether another body meets it.
struct OutlineNode {
  int body = 0;  ///< index into Description::bodies
  int node = 0;  ///< of the whole body's mesh
  std::vector<double> displacement_m;
};

class Participant {
 public:
  virtual ~Participant() = default;

  /// Called once, first. Throws ConfigError if its scene or input is wrong.
  [[nodiscard]] virtual Description describe() = 0;
  /// Called once. Returns the link output at t = 0: explicit its force, implicit its displacement (velocity,
  /// acceleration may be empty here).
  virtual void initialize(const Setup& setup, LinkOutput& output) = 0;
  /// At the present time: take these absolute link values, recompute the accelerations from them, integrate by
  /// `integration` from here on. Called after `initialize` and whenever the coupler switches integration.
  virtual void synchronise(Integration integration, const std::vector<double>& link_input, LinkOutput& output) = 0;
  /// With the capability "reconfigure", between windows: `setup` is that of `initialize` but for the clock, whose
  /// windows have another size from here on, and the interface stiffness. Nothing moves; the link input in force, that
  /// of the last accepted window, stays the same force or displacement.
  virtual void reconfigure(const Setup& setup);
  /// Trial: from the last accepted state compute the window that ends at `Setup::clock.time_s(window)` with this link
  /// input (explicit: displacement at the window's end; implicit: interface force at its end).
  virtual void advance(std::int64_t window, const std::vector<double>& link_input, LinkOutput& output) = 0;
  /// Trial of one substep of that window, 1 .. Setup::substeps, each accepted before the next; `link_input`: the
  /// multiplier at its end, linear from the end of the one before. Capability "single_substep".
  virtual void advance_substep(std::int64_t window, int substep, const std::vector<double>& link_input,
                               LinkOutput& output);
  /// Before `accept` of a whole window: whether contact was closed at the end of the window before, whoever enforces
  /// it.
  virtual void note_touch(bool /*closed*/) {}
  /// Makes the last trial final.
  virtual void accept() = 0;
  /// Called after an answer has been sent, while the others are at work: do now of the next window what does not depend
  /// on its link input. Must change no result.
  virtual void work_ahead() {}
  /// Contact state after the last accepted window (contact owner only).
  [[nodiscard]] virtual ContactStatus contact_status() const { return {}; }
  /// Appends one row of history quantities of the last accepted window, in the order of `record_columns`.
  virtual void record(std::vector<double>& row) = 0;
  /// Appends, for each of `axial_stress_columns`, this participant's share of the mean axial stress of the layer after
  /// the last accepted window [Pa], tension positive: the sum over its elements of their integral, over the volume of
  /// the whole layer. Called every `axial_stress_every` accepted windows and at the start.
  virtual void axial_stress(std::vector<double>& /*row*/) {}
  /// Appends, for each of `probe_columns`, this participant's share of the value after the last accepted window: motion
  /// is a sum over nodes, of which each counts where it is integrated, strain and stress a mean over elements. Called
  /// every `probes_every` accepted windows and at the start.
  virtual void probes(std::vector<double>& /*row*/) {}
  /// Contact owner: appends the force of each contact of the scene along its normal [N], the impulse over the last
  /// accepted window divided by its size. Called for every window, whatever history rows there are. (May stay empty:
  /// the history rows stand for it then.)
  virtual void contact_forces(std::vector<double>& /*row*/) {}
  /// Everything that left the model up to the last accepted window. (May stay empty: nobody looks for it then.)
  [[nodiscard]] virtual std::vector<Departure> departures() { return {}; }
  /// After the last accepted window; which nodes is the participant's choice.
  [[nodiscard]] virtual std::vector<OutlineNode> outline() { return {}; }
  /// Called every `fields_every` accepted windows: write result fields into `output_directory`.
  virtual void write_fields(std::int64_t /*window*/) {}
  /// With the capability "load_state", for `ricochet stability`. From here on the problem is homogeneous: no loads,
  /// supports and prescribed motion at zero, contact frozen; displacements are measured from equilibrium. Takes the
  /// motion `state`, at the end of an accepted window; `synchronise` follows with the link input of that instant. Then
  /// the next window must be a linear function of `state` and link input alone.
  virtual void load_state(const std::vector<double>& state, FrozenContact contact);
  /// The motion as `load_state` takes it (displacements and velocities of what it integrates), and what makes these
  /// numbers comparable: sqrt(m)/dt for a displacement, sqrt(m) for a velocity. Appends to empty vectors.
  virtual void read_state(std::vector<double>& state, std::vector<double>& scale);
  /// With the capability "save_state", for checkpoints: all that the windows to come are computed from and what was
  /// booked so far, after an accepted window, as bytes that mean something to this participant alone.
  virtual std::string save_state();
  /// Takes what `save_state` gave, in another process too, after `initialize` and `synchronise` for the same scene and
  /// the same protocol. From here on it must answer, and record, the same bits as if it had never stopped. With the
  /// capability "load_state" the owner of the contact is asked for it after `load_state`, too, in the same process:
  /// then loads, supports, prescribed motion and contact are again what they were.
  virtual void restore_state(std::string_view bytes);
  /// Called once, last.
  virtual void finish() {}
};

struct ServeOptions {
  std::string endpoint;      ///< ipc://... or tcp://host:port
  double timeout_s = 60.0;   ///< longest wait for the coupler until it states its own
  bool watch_stdin = false;  ///< end at once when stdin closes: the launcher that holds its other end is gone
  std::string key{};         ///< file with the key by which the coupler knows this participant; empty: it asks for none
};

/// Runs a participant until the coupler says finish (returns 0) or something fails (returns the exit code of
/// base/error.hpp, after telling the coupler and printing one line to stderr). Never throws.
int serve(Participant& participant, const ServeOptions& options);

/// Command line that every participant is started with: --scene PATH --name NAME --connect ENDPOINT --key FILE
/// [--watch-stdin]. Shipped solvers are started with --critical-step SECONDS, too.
struct Arguments {
  std::string scene;  ///< empty if not given: a participant need not read it
  std::string name;   ///< of the participant in the scene
  /// Critical time step of its elements as the coupler has found it [s]; 0: it needs none. Empty: it was not told.
  std::optional<double> critical_time_step_s{};
  ServeOptions options;
};

/// Throws ConfigError naming what is unknown, lacks its value or is missing (--name, --connect).
[[nodiscard]] Arguments parse_arguments(int argc, const char* const* argv);

/// It may set the options that the participant is to be served with.
using MakeParticipant = std::function<std::unique_ptr<Participant>(Arguments&)>;

/// The main program of a participant: parses the command line, makes the participant and serves it; returns the exit
/// code. Exceptions of `make` are reported as `serve` reports it. Never throws.
int participant_main(int argc, const char* const* argv, const MakeParticipant& make);

}  // namespace ricochet::participant

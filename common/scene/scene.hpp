#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/base/vocabulary.hpp"
#include "common/scene/body.hpp"
#include "common/scene/protocols.hpp"

/// The scene file as plain structs: one struct per table, one member per key, SI units in the names.
/// `load_scene` is strict; what these structs hold has passed every check that needs no mesh.
namespace ricochet::scene {

using ricochet::Role;

struct SurfaceName {
  std::string body;
  std::string surface;
};

enum class Enforcement { multiplier, penalty };
/// How the implicit side takes the contact force of the multiplier: three momentum-exact ways.
enum class MultiplierUpdate { fully_implicit, trapezoidal_reset, massless };
enum class ImpactUpdate { none, impedance, mass };
enum class FrictionLaw { return_mapping, regularised };

/// All that is rigid and may be the second of two surfaces.
enum class Obstacle { plane, sphere, cylinder };
inline constexpr std::array<const char*, 3> obstacle_names{"rigid_plane", "rigid_sphere", "rigid_cylinder"};

struct Contact {
  std::string name;                   ///< of one of several; empty of a scene's only one
  SurfaceName first;                  ///< n points out of this surface
  std::optional<SurfaceName> second;  ///< empty: the obstacle
  Obstacle obstacle = Obstacle::plane;
  double rigid_radius_m = 0.0;        ///< of a sphere or a cylinder
  int rigid_axis = 2;                 ///< of a cylinder against a solid: the coordinate it lies along
  std::vector<double> rigid_place_m;  ///< beside its middle along the normal, empty: the origin; of a plane in it
  std::vector<double> normal;         ///< a unit vector; empty: the mean of the first surface's faces
  double initial_gap_m = 0.0;         ///< added to the distance of the two meshes along n
  double nose_radius_m = 0.0;         ///< > 0 adds r^2/(2R), r from the axis r = 0 or x = 0, of a solid from the z axis
  Enforcement enforcement = Enforcement::multiplier;
  MultiplierUpdate multiplier_update = MultiplierUpdate::trapezoidal_reset;
  double penalty_pa_m = 0.0;  ///< traction per penetration, Eq. 8-10
  ImpactUpdate impact_update = ImpactUpdate::none;
  double friction_coefficient = 0.0;
  FrictionLaw friction_law = FrictionLaw::return_mapping;
  double friction_regularisation_s_m = 1.0;  ///< xi of Eq. 15

  [[nodiscard]] std::string key() const { return name.empty() ? "contact" : "contact." + name; }
};

enum class PartitionRule { implicit_length, implicit_groups, automatic };

struct Partition {
  PartitionRule rule = PartitionRule::automatic;
  std::map<std::string, double> implicit_length_m;                  ///< per body, measured from its contact surface
  std::map<std::string, std::vector<std::string>> implicit_groups;  ///< per body
  /// Bodies whose explicit elements are their so many lowest modes: a participant of their own, reduced_solver.
  std::map<std::string, int> reduced_modes{};
};

/// From the end of the first window that reaches `from_s` on, steps are of another size.
struct StepChange {
  double from_s = 0.0, step_s = 0.0;
};

struct Time {
  std::optional<double> step_s;          ///< else safety_factor times the critical time step of what is explicit
  std::optional<double> largest_step_s;  ///< then step_s is this, or the largest that leaves explicit elements, until
                                         ///< `ricochet run` chooses
  std::vector<StepChange> changes;       ///< in ascending order of time
  std::optional<double> flight_step_s;   ///< of windows in which no contact can close
  double safety_factor = 0.9;
  double end_s = 0.0;  ///< latest end
  std::optional<double> until_separated_plus_s;

  [[nodiscard]] bool one_step() const { return changes.empty() && !flight_step_s; }
  /// Key of what makes steps of several sizes, if there is such.
  [[nodiscard]] const char* key_of_sizes() const { return flight_step_s ? "flight_step_s" : "changes"; }
};

/// The answer of a run to a body that turns by 10 degrees or strains by 10 %.
enum class OutsideModel { stop, go_on };
enum class AfterSeparation { switch_to_explicit, stay_implicit };

/// The program that starts the participants.
enum class LaunchedBy { coupler, slurm };

constexpr int most_substeps = 1000;

/// The table [coupling].
struct CouplingSettings {
  ProtocolTraits protocol = protocol_traits("hughes_liu");
  int substeps = 1;                      ///< dual protocols: explicit steps in a window, m of Delta T = m Delta t
  bool fewest_substeps = false;          ///< build_problem finds those of each participant that states none
  std::string acceleration = "iqn_ils";  ///< of fixed_point: "constant" | "aitken" | "iqn_ils"
  double relaxation = 0.5;               ///< omega of the first, or every, iteration of fixed_point
  double tolerance = 1e-10;              ///< of fixed_point: residual over the largest increment of a window
  int max_iterations = 50;
  int resynchronise_every = 100;  ///< windows between exchanges of absolute values; 0: never
  AfterSeparation after_separation = AfterSeparation::switch_to_explicit;
  int separation_windows = 10;            ///< windows with every pair open and gaps growing that count as separated
  double timeout_s = 60.0;                ///< longest wait for any peer
  std::optional<double> start_timeout_s;  ///< the same until it is initialized; empty: timeout_s
  LaunchedBy launcher = LaunchedBy::coupler;
  Transport transport = Transport::automatic;
  std::string address = "127.0.0.1";  ///< tcp: address to bind; under Slurm, unless given, "0.0.0.0": every one
  int port = 0;                       ///< tcp: 0 picks a free one
  double energy_growth_limit = 0.05;  ///< relative growth of the energy balance that stops the run
  /// Relative loss that does. Empty: 0.3 if a participant is a program of somebody else's, else any may be lost:
  /// shipped solvers and protocols lose what they are known to.
  std::optional<double> energy_loss_limit;
  OutsideModel outside_model = OutsideModel::stop;
};

enum class Start { launch, by_hand };

struct ParticipantSpec {
  std::string name;
  Role role = Role::explicit_solver;
  std::vector<std::string> bodies;  ///< explicit participants: whose explicit elements they own
  std::string executable;           ///< empty: the solver shipped with ricochet
  Start start = Start::launch;
  std::vector<std::string> groups{};  ///< explicit, one body: only those of these element groups; empty: all
  /// Words in front of program and arguments; empty: none, under Slurm those of a step.
  std::vector<std::string> launch{};
  std::optional<int> ranks{};  ///< explicit: processes that step its nodes together, by MPI; none: one, without MPI
  /// To compute with; empty: its share of the processors that it finds. Results are the same for any number.
  std::optional<int> threads{};
  /// Steps in a window: of an explicit one its own, or coupling.substeps; 0 until build_problem has found the fewest.
  int substeps = 1;
  /// Bodies of which a program of somebody else's may be another model than the scene's: nothing of it is compared with
  /// the scene's mesh, elements and density.
  std::vector<std::string> differing_bodies{};
  bool reduced = false;  ///< explicit: each of its bodies has Partition::reduced_modes

  /// A program of somebody else's, whoever starts it.
  [[nodiscard]] bool foreign() const { return !executable.empty(); }
};

/// A place of a body whose motion, strain and stress are told.
struct Probe {
  std::string name, body;
  std::vector<double> at_m;  ///< one entry per component, reference configuration
};

/// A strain gauge: mean axial strain and stress of what lies about a section of a body.
struct Gauge {
  std::string name, body, surface;  ///< surface: of its faces alone; empty: of the whole section
  double section_m = 0.0;           ///< coordinate of the body's axis in its middle
  double length_m = 0.0;            ///< along the axis; 0: the section itself
  double rise_time_s = 0.0;         ///< from 10 to 90 % of a step, by a filter of first order; 0: it sees at once
};

struct Output {
  int history_every = 1;       ///< windows per row of history.csv
  int fields_every = 0;        ///< windows per VTU snapshot; 0: none
  int axial_stress_every = 0;  ///< windows per row of axial_stress.csv; 0: none
  int probes_every = 1;        ///< windows per row of probes.csv; 0: none
  /// In place of the counts, which build_problem finds: time from row to row.
  std::optional<double> history_every_s, fields_every_s, probes_every_s;
  std::vector<Probe> probes;
  std::vector<Gauge> gauges;

  [[nodiscard]] bool wants_probes() const { return probes_every > 0 && !(probes.empty() && gauges.empty()); }
  /// Windows from row to row that participants tell of them; the filter of a gauge needs every window.
  [[nodiscard]] int probes_told_every() const;
};

/// The answer of a run to a participant that dies, hangs or is lost.
enum class OnFailure { stop, resume };

/// When a run saves all that it goes on from.
struct Checkpointing {
  bool asked = false;      ///< the scene has a table for it: at the end of a run, too
  int every_windows = 0;   ///< 0: not by windows
  double every_s = 300.0;  ///< of wall time; 0: not by time
  OnFailure on_failure = OnFailure::stop;
  int attempts = 10;  ///< on_failure = "resume": so often at most
};

struct Scene {
  std::string path;    ///< absolute path of the scene file
  std::string sha256;  ///< of its text and of the files with meshes and interface nodes that it names, hex
  Model model = Model::bar;
  std::vector<Body> bodies;
  std::vector<ForeignBody> foreign_bodies;
  std::vector<Contact> contacts;
  Partition partition;
  Time time;
  CouplingSettings coupling;
  std::vector<ParticipantSpec> participants;  ///< never empty: defaults filled in
  Output output;
  Checkpointing checkpoint;
  /// [accuracy]: relative errors that are asked of results, by their names; empty: none is. Whatever the scene leaves
  /// open of protocol, step and mesh, `ricochet run` then chooses.
  std::map<std::string, double> accuracy;
  static constexpr double most_elements_times = 64.0;
  /// [accuracy]: meshes that the choice may take, by their numbers of elements along each coordinate over those of the
  /// file; rising.
  std::vector<double> elements_times{1.0};
  /// [mass_scaling] of `all_explicit`: elements that this step is too long for are made heavier until they bear it.
  std::optional<double> mass_scaling_step_s;
  std::map<std::string, int> lines;  ///< key ("body.steel.support[0].surface") -> line of the file; 0: it says nothing

  /// "file:line: key" for the front of an error text; the line is that of the nearest enclosing key that was read, and
  /// left out where it says nothing.
  [[nodiscard]] std::string where(const std::string& key) const;
  /// The law of all contacts, which are solved together: their keys but surfaces, normal, gap, nose and friction
  /// coefficient.
  [[nodiscard]] const Contact& contact_law() const { return contacts.front(); }
  [[nodiscard]] bool massless_contact() const {
    return !contacts.empty() && contact_law().multiplier_update == MultiplierUpdate::massless;
  }
  [[nodiscard]] bool friction() const;                           ///< of any contact
  [[nodiscard]] std::vector<std::string> contact_names() const;  ///< of several; none where there is but one
  /// Names of the bodies that it meshes, and of the foreign ones after them.
  [[nodiscard]] std::vector<std::string> body_names() const;
  [[nodiscard]] bool is_foreign(const std::string& body) const;
  /// Its explicit elements are modes.
  [[nodiscard]] bool is_reduced(const std::string& body) const;
  [[nodiscard]] bool any_reduced() const;
  /// Results whose errors are estimated, docs/accuracy.md.
  [[nodiscard]] std::vector<std::string> quantities_with_bars() const;
  /// The file names one.
  [[nodiscard]] bool protocol_given() const { return lines.count("coupling.protocol") > 0; }
  /// The choice may take another mesh than the file's.
  [[nodiscard]] bool mesh_open() const { return elements_times != std::vector{1.0}; }
  /// `ricochet run` chooses the step, or protocol, step and mesh, before it starts.
  [[nodiscard]] bool leaves_open() const {
    return time.largest_step_s || (!accuracy.empty() && (mesh_open() || !(protocol_given() && time.step_s)));
  }
  [[nodiscard]] int components() const { return fem::components(model); }
  [[nodiscard]] const Body& body(const std::string& name) const;                    ///< ConfigError if unknown
  [[nodiscard]] const ParticipantSpec& participant(const std::string& name) const;  ///< ConfigError if unknown
  /// Fewest and most that an explicit participant of that body has, of any body without a name.
  struct Substeps {
    int fewest = 1, most = 1;
  };
  [[nodiscard]] Substeps substeps(const std::string& body = "") const;
};

/// Reads and checks a scene file. Throws ConfigError that shows file, line, key, what was found and what is allowed.
[[nodiscard]] Scene load_scene(const std::string& path);

}  // namespace ricochet::scene

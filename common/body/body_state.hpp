#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "common/base/archive.hpp"
#include "common/base/ledger.hpp"
#include "common/body/other_ranks.hpp"
#include "common/body/part_frame.hpp"
#include "common/body/plastic_state.hpp"
#include "common/fem/stiffness_product.hpp"
#include "common/problem/given_motion.hpp"
#include "common/problem/problem.hpp"

/// State of one body in both solvers: its part, its motion and its ledger. Vectors are per local degree of freedom.
namespace ricochet::solver {

/// A fixed or prescribed degree of freedom. Velocity and acceleration by central differences of its motion over dt,
/// which is what the central difference method itself would integrate. At t = 0 as if it had moved before as it does in
/// the first window: what begins with a velocity has it, and nobody works for it.
struct ConstrainedDof {
  int dof = 0;
  scene::GivenMotion motion{};

  [[nodiscard]] double at(double time_s) const { return motion.at(time_s); }
  [[nodiscard]] double velocity(double time_s, double dt) const {
    return time_s > 0.0 ? (at(time_s + dt) - at(time_s - dt)) / (2.0 * dt) : (at(dt) - at(0.0)) / dt;
  }
  [[nodiscard]] double acceleration(double time_s, double dt) const {
    return time_s > 0.0 ? (at(time_s + dt) - 2.0 * at(time_s) + at(time_s - dt)) / (dt * dt) : 0.0;
  }
};

/// A degree of freedom of an absorbing surface, where a dashpot stands in for more of the body: force -c (v - v_0), so
/// that a body in flight is not braked. Central difference takes it at n + 1 too,
///   M a_{n+1} = f - c (v_{n+1} - v_0),   v_{n+1} = v_{n+1/2} + dt/2 a_{n+1},
/// which is M (v_{n+3/2} - v_{n+1/2})/dt = f - c ((v_{n+3/2} + v_{n+1/2})/2 - v_0). The staggered energy then changes
/// by -dt v c v (v_0 = 0) and is positive for dt < 2/omega_max as without dashpots: the critical time step is the same.
struct Dashpot {
  int dof = 0;
  double coefficient_kg_s = 0.0;
  double initial_velocity_m_s = 0.0;  ///< v_0

  /// At a velocity [N].
  [[nodiscard]] double force(double velocity_m_s) const {
    return -coefficient_kg_s * (velocity_m_s - initial_velocity_m_s);
  }
  /// At the end of an explicit step, from v_{n+1/2} and all other forces on the mass [N].
  [[nodiscard]] double force_after_step(double half_velocity_m_s, double others_n, double mass_kg, double dt) const {
    const double a = (others_n + force(half_velocity_m_s)) / (mass_kg + 0.5 * dt * coefficient_kg_s);
    return force(half_velocity_m_s + 0.5 * dt * a);
  }
};

/// Changes of a body from window to window: its last accepted motion [m, m/s, m/s^2] and what was booked so far.
struct BodyMotion {
  Eigen::VectorXd u, v, a;
  BodyTotals totals;

  void archive(Archive& archive) { archive(u, v, a, totals); }
};

/// The work and impulses that the surroundings gave a part over one or more steps.
struct Given {
  double work_j = 0.0;
  Eigen::Vector3d impulse_n_s{0.0, 0.0, 0.0};  ///< by component
  Eigen::Vector3d angular_impulse_kg_m2_s{0.0, 0.0, 0.0};

  /// Books a mean force over a step of `dt` in which its degree of freedom moved, at `place` [m] in the middle. A call,
  /// not in line: whether a product and a sum are rounded once or twice is a compiler's choice, which must be the same
  /// wherever this is booked.
  [[gnu::noinline]] void add(double dt, double force, double moved, int component, const Eigen::Vector3d& place);
};

struct BodyState : BodyMotion {
  int body = -1;  ///< index into Problem::bodies
  std::string name;
  fem::Part part;
  fem::StiffnessProduct stiffness;     ///< of the part, for K u in the step
  std::shared_ptr<Parallel> parallel;  ///< the participant's threads, the same of all its parts
  std::vector<int> shared_nodes;       ///< local nodes shared with other participants, in the order of the interface
  std::vector<int> shared_dofs;
  std::vector<bool> integrated;  ///< per dof: this participant integrates it
  std::vector<bool> free;        ///< per dof: integrated here and not constrained
  Eigen::VectorXd mass;          ///< per dof, what this participant integrates; 0 elsewhere [kg]
  Eigen::VectorXd inverse_mass;  ///< 1/mass; 0 where constrained, not integrated or massless [1/kg]
  std::vector<ConstrainedDof> constrained;
  std::vector<Dashpot> dashpots;  ///< of a shared node: the implicit participant's
  scene::ExternalForce external;
  Eigen::Vector3d normal, tangent, binormal;  ///< directions of the momentum balance; the last of solids, else zero
  Eigen::VectorXd place;  ///< per dof, reference: of models with an angular momentum, plane strain and solids [m]
  std::vector<bool> own;  ///< of a share of a part, per local node: not another rank's; else empty
  std::shared_ptr<PlasticState> plastic;   ///< of a material that yields, in the accepted window; else null
  std::shared_ptr<const PartFrame> frame;  ///< of a part with elements whose body turns by any angle; else null
  OtherRanks* others = nullptr;            ///< of a share of a part: who steps the rest of it

  /// u, v and a of its hanging nodes become those of their carriers: fields, probes and pictures show them.
  void move_hanging();
  /// Its elements neither yield nor turn: P = K u.
  [[nodiscard]] bool linear() const { return !plastic && !frame; }
  /// The displacement that strains the elements: u, or of a part with a frame the rest of u there, which `in_frame`
  /// then holds [m].
  [[nodiscard]] const Eigen::VectorXd& straining(Eigen::VectorXd& in_frame) const;
  /// By which directions in the part's frame become those in space.
  [[nodiscard]] Eigen::Matrix3d rotation() const;
  /// Motion of the frame, which is not null, at u [m]; a share has that of the last fit, so that nobody asks the
  /// others.
  [[nodiscard]] fem::RigidMotion frame_motion() const;
  /// Sets free, mass, inverse_mass and totals.mass_kg from a mass per node (own, or summed over participants, Eq. 28).
  void set_mass(const Eigen::VectorXd& node_mass);
  /// Velocity and acceleration of the constrained dofs at a time; their displacement.
  void constrain_velocity(double time_s, double dt, Eigen::VectorXd& velocity) const;
  void constrain_acceleration(double time_s, double dt, Eigen::VectorXd& acceleration) const;
  void constrain_displacement(double time_s, Eigen::VectorXd& displacement) const;
  /// The degrees of freedom on which something outside acts, in the order in which that is booked: the constrained
  /// ones and those of dashpots or, where there is a load, all.
  [[nodiscard]] std::vector<int> booked() const;
  /// Accounts loads, dashpots, supports and prescribed motion over a window: adds 1/2 (f_n + f_{n+1}) . (u_{n+1} - u_n)
  /// to the external work and dt/2 (f_n + f_{n+1}) along n and t to the impulses. `mean_force(dof)` holds the reactions
  /// at constrained dofs and the forces of dashpots [N]; `middle(dof)`: u in the middle of the window.
  template <class MeanForce, class Increment, class Middle>
  void account_external(double dt, const MeanForce& mean_force, const Increment& increment, const Middle& middle) {
    // Summed over the window first: adding small equal terms to the totals one by one rounds them all the same way.
    Given given;
    book(mean_force, increment, middle, [&](double force, double moved, int component, const Eigen::Vector3d& at) {
      given.add(dt, force, moved, component, at);
    });
    take(given);
  }
  void take(const Given& given);
  /// Where the node of a degree of freedom is, by its displacement `u_of(dof)`; the origin of models without an angular
  /// momentum [m].
  template <class Displacement>
  [[nodiscard]] Eigen::Vector3d place_of(int dof, const Displacement& u_of) const {
    Eigen::Vector3d at = Eigen::Vector3d::Zero();
    if (place.size() == 0) return at;
    const int components = fem::components(part.mesh.model), first = dof - dof % components;
    for (int c = 0; c < components; ++c) at[c] = place[first + c] + u_of(first + c);
    return at;
  }
  /// book(force, moved, component, place) of each booked degree of freedom; of a share of a part see OtherRanks.
  template <class MeanForce, class Increment, class Middle, class Book>
  void book(const MeanForce& mean_force, const Increment& increment, const Middle& middle, const Book& book) const {
    const auto at = [&](int dof) { return place_of(dof, middle); };
    if (others != nullptr) {
      others->book(mean_force, increment, at, book);
      return;
    }
    const int components = fem::components(part.mesh.model);
    for_each_booked([&](int dof) { book(mean_force(dof), increment(dof), dof % components, at(dof)); });
  }
  /// Books the moment of an impulse on a degree of freedom, whose node is where `u_of(dof)` has it.
  template <class Displacement>
  void give_moment(int dof, double impulse_n_s, const Displacement& u_of) {
    if (place.size() == 0) return;
    const Eigen::Vector3d along = Eigen::Vector3d::Unit(dof % fem::components(part.mesh.model));
    give_angular_impulse(impulse_n_s * place_of(dof, u_of).cross(along));
  }
  /// Momentum of the integrated nodes from v, and its moment about the origin where they are.
  void update_momentum();
  void set_angular_momentum(const Eigen::Vector3d& kg_m2_s);
  /// The part of it that a stretch of nodes has.
  [[nodiscard]] Eigen::Vector3d angular_momentum_of(int first_node, int last_node) const;

 private:
  void give_angular_impulse(const Eigen::Vector3d& kg_m2_s);
  template <class Visit>
  void for_each_booked(const Visit& visit) const {
    if (external.zero()) {
      for (const auto& c : constrained) visit(c.dof);
      for (const auto& d : dashpots) visit(d.dof);
    } else {
      for (int dof = 0; dof < part.dofs(); ++dof) visit(dof);
    }
  }
};

/// Vectors by part, for the functions that take `of_part(part)`.
inline auto displacement_of(const std::vector<BodyState>& states) {
  return [&states](int part) -> const Eigen::VectorXd& { return states[static_cast<std::size_t>(part)].u; };
}
inline auto velocity_of(const std::vector<BodyState>& states) {
  return [&states](int part) -> const Eigen::VectorXd& { return states[static_cast<std::size_t>(part)].v; };
}

/// Distributes the summed interface masses of a Setup over the states' shared nodes (Eq. 28).
void take_interface_mass(const std::vector<double>& interface_mass_kg, std::vector<BodyState>& states);

/// Copies of the motions, and the motions put back.
[[nodiscard]] std::vector<BodyMotion> motions_of(const std::vector<BodyState>& states);
void restore_motions(const std::vector<BodyMotion>& motions, std::vector<BodyState>& states);

/// One state per part of the participant, at t = 0. `shared_integrated`: the implicit participant integrates its shared
/// nodes, an explicit one does not. The states point into `problem`, which must outlive them unmoved.
[[nodiscard]] std::vector<BodyState> initial_states(const scene::Problem& problem,
                                                    const scene::ParticipantSpec& participant, bool shared_integrated);
/// The state of one part, or of a share of one; `problem` as above.
[[nodiscard]] BodyState initial_state(const scene::Problem& problem, scene::ParticipantPart&& owned, scene::Role role,
                                      bool shared_integrated);
/// Gives the states of a participant the threads that it computes with.
void compute_with_threads(const scene::Scene& scene, const scene::ParticipantSpec& participant,
                          std::vector<BodyState>& states);

/// Refuses to go on with numbers that mean nothing: SolverError naming body, node, position and window.
void require_finite(const BodyState& state, const Eigen::VectorXd& u, std::int64_t window);

}  // namespace ricochet::solver

#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "common/base/window_clock.hpp"
#include "common/body/internal_force.hpp"
#include "common/contact/contact_surface.hpp"
#include "common/contact/massless_nodes.hpp"
#include "common/contact/pair_compliance.hpp"
#include "common/contact/root_problem.hpp"
#include "common/contact/sliding_rows.hpp"

/// All-explicit contact: forward-increment multiplier (Carpenter, Taylor, Katona 1991).
///
/// The contact force r of window n is the one that closes the gap at n + 1 exactly. With a diagonal mass and node pairs
/// that is one closed-form scalar per pair:
///   g_free = g(u_{n+1} without r),   r = max(0, -g_free) / (dt^2 (1/m_A + 1/m_B))
/// Friction is a return mapping: the force that would hold the pair together, clipped to the cone |t| <= mu r (Eq. 9,
/// 14), of solids radially to the circular one. All pairs are those of a root problem whose compliance is N M^-1 N^T
/// (RootProblem::sweep_from_none): where they share nodes the pairs are gone through again until no force changes.
/// Where elements step locally the force, held over the window, acts inside the small steps: M a = S N^T r - P, with S
/// of fem::LocalSteps. Then the compliance is N M^-1 S N^T, which couples pairs: unit forces find it, and Newton's
/// method the forces (RootProblem::solve). It is turned as the part turns. With the mass of the contact nodes alone a
/// contact would last 18 % too long where elements are 32 times finer.
///
/// Neither force lowers the critical time step. With enforcement "penalty", r = alpha w max(0, -g(u_n)) (Eq. 8-10)
/// does.
namespace ricochet::explicit_solver {

class ExplicitContact {
 public:
  /// `law` and `clock` must outlive it.
  ExplicitContact(const scene::Contact& law, solver::ContactSurface surface, const WindowClock& clock,
                  std::optional<solver::SlidingRows> sliding = std::nullopt);
  ExplicitContact(const scene::Contact& law, solver::ContactSurface surface, WindowClock&& clock,
                  std::optional<solver::SlidingRows> sliding = std::nullopt) = delete;

  /// Before the first window: `forces` per part, which outlive this object, say what a held force amounts to.
  void act_through(const std::vector<std::unique_ptr<solver::InternalForce>>& forces,
                   const std::vector<solver::BodyState>& states);
  /// With the law "massless": moves the masses of `states`; then r is the one that balances the contact nodes, not the
  /// one that closes the gap, and the gap at n is.
  void move_masses(std::vector<solver::BodyState>& states);
  /// Settles massless nodes at n + 1: their displacement in `u` (per part) from that of the others.
  void settle(const std::vector<solver::BodyState>& states, const std::vector<const Eigen::VectorXd*>& external,
              const std::vector<Eigen::VectorXd*>& u);
  /// At the start (n = 0): adds the contact accelerations to state.a so that u_1 = u_0 + dt v_0 + dt^2/2 a_0 does not
  /// penetrate.
  void start(std::vector<solver::BodyState>& states);
  /// Between windows: the forces that are to close the gaps at the end of the next one, which has another size now.
  void reconfigure(std::vector<solver::BodyState>& states);
  /// From here on no contact force, or every pair held at zero gap, in tension, too.
  void freeze(participant::FrozenContact frozen) { frozen_ = frozen; }
  /// Adds the contact accelerations of window n to state.a, given u_n in state.u, u_{n-1} in `u_before` and the elastic
  /// acceleration in state.a; accounts the work of the contact forces over the window that ended at n.
  void apply(std::vector<solver::BodyState>& states, const std::vector<const Eigen::VectorXd*>& u_before);

  /// Where contact forces act inside small steps they pull supports of the part there: adds the reactions.
  void add_reactions(std::size_t part, const solver::BodyState& state, Eigen::VectorXd& external) const;
  /// Once state.v is v_n: velocity of massless nodes, and the energy that closing and opening made back to the others.
  void finish(std::vector<solver::BodyState>& states, const std::vector<const Eigen::VectorXd*>& u_before);

  /// Whether forces act inside small steps of the part.
  [[nodiscard]] bool inside_small_steps() const { return !through_.empty(); }
  /// 1/2 u . (1 - S) N^T r of all parts, r the forces of the pairs and N their rows: what small steps leave out of
  /// the work of forces that press slowly [J]. u is what strains a part that turns, since S
  /// does not change a motion as a whole.
  [[nodiscard]] double unspread_j(const std::vector<solver::BodyState>& states);
  /// Contact quantities at the present displacement (principal stress and energies included). `unspread_j` joins the
  /// work of the forces.
  [[nodiscard]] const ContactRecord& report(const std::vector<solver::BodyState>& states, double unspread_j = 0.0);
  /// See participant::Participant::contact_forces.
  [[nodiscard]] solver::PressedSurface pressed(const std::vector<solver::BodyState>& states) const {
    return {&surface_, &state_.mean_forces, &states};
  }
  [[nodiscard]] std::vector<fem::ContactFields> fields(const std::vector<solver::BodyState>& states) const {
    return surface_.nodal_fields(states, state_.mean_forces);
  }
  void append_forces(std::vector<double>& row) const { surface_.append_forces(state_.mean_forces, row); }
  [[nodiscard]] int pairs_closed() const;
  [[nodiscard]] const solver::ContactSurface& surface() const { return surface_; }

  using Force = solver::PairForce;
  /// With the motion of the bodies all that the next window is computed from, and what was booked so far.
  /// Its residual is the largest last change of a force over the largest force.
  struct State : solver::ContactAccount {
    std::vector<Force> forces;        ///< r_n
    std::vector<Force> mean_forces;   ///< (r_{n-1} + r_n)/2: what changed M v from v_{n-1} to v_n, over dt
    Eigen::VectorXd static_normal_n;  ///< of massless nodes: r at n + 1
    std::optional<solver::MasslessNodes::State> massless;
    solver::SlidingRows::State sliding;
    std::vector<Eigen::Matrix3d> turns;  ///< per part, where one turns and steps locally: R of the compliance

    void archive(Archive& a) {
      ContactAccount::archive(a);
      a.any_size(forces, mean_forces);  // pairs come and go as surfaces slide
      a(static_normal_n, massless, sliding, turns);
    }
  };
  [[nodiscard]] State state() const;
  void restore(const State& state);

 private:
  [[nodiscard]] static auto before_of(const std::vector<const Eigen::VectorXd*>& u_before) {
    return [&u_before](int part) -> const Eigen::VectorXd& { return *u_before[static_cast<std::size_t>(part)]; };
  }
  [[nodiscard]] double dt() const { return clock_.size_s(); }  ///< of the window to come [s]
  [[nodiscard]] std::size_t pairs() const { return surface_.pairs.size(); }
  void make_root(const std::vector<solver::BodyState>& states);
  template <class Rate>
  void find_free_motion(const std::vector<solver::BodyState>& states, Rate rate);
  void find_known_normals(const std::vector<solver::BodyState>& states, double acting_time);
  void push(const solver::Pair& pair, const Force& force, std::vector<solver::BodyState>& states) const;
  [[nodiscard]] solver::RootProblem::Solution last_forces(double acting_time) const;
  void spread_forces();
  void note_turns();
  void add_turn(const std::vector<solver::BodyState>& states, double acting_time);
  [[nodiscard]] bool turned() const;
  [[nodiscard]] const solver::RootProblem::Solution& solution(double acting_time);
  void push_all(double share, std::vector<solver::BodyState>& states);
  [[nodiscard]] double work_inside(const std::vector<solver::BodyState>& states,
                                   const std::vector<const Eigen::VectorXd*>& u_before) const;
  /// `anew`: the rows are, or nothing acted before.
  template <class Rate>
  void find_forces(const std::vector<solver::BodyState>& states, Rate rate, double acting_time, bool anew);
  /// The work and impulse of a pair's force over a window; returns the work along the normal [J].
  double account(const solver::Pair& pair, const Force& force, std::vector<solver::BodyState>& states,
                 const std::vector<const Eigen::VectorXd*>& u_before);
  bool follow(std::vector<solver::BodyState>& states, const std::vector<const Eigen::VectorXd*>& u_before);
  /// Adds a share of the forces to the accelerations, and books what that changes of the staggered kinetic energy.
  void act(double share, std::vector<solver::BodyState>& states);
  void clip_friction(std::size_t pair, std::vector<solver::BodyState>& states);
  [[nodiscard]] double staggered_correction(const solver::Pair& pair,
                                            const std::vector<solver::BodyState>& states) const;
  [[nodiscard]] double staggered_correction(const std::vector<solver::BodyState>& states) const;

  const scene::Contact* law_;
  const WindowClock& clock_;
  std::optional<participant::FrozenContact> frozen_;
  solver::ContactSurface surface_;
  std::optional<solver::SlidingRows> sliding_;
  State state_;
  std::optional<solver::MasslessNodes> massless_;
  /// The problem of N M^-1 N^T, for impulses times the window; none: to be made for the present rows.
  std::optional<solver::RootProblem> root_;
  Eigen::VectorXd gap_free_, slip_free_, known_normal_;
  std::vector<Force> old_forces_;
  /// Per part, where a contact force acts inside small steps: what spreads it, and S N^T r of this window and the last.
  std::vector<solver::InternalForce*> through_;
  std::vector<Eigen::VectorXd> spread_, old_spread_;
  std::vector<Eigen::VectorXd> strained_;  ///< u of `unspread_j`, of parts that turn; kept so that no record allocates
  std::vector<std::vector<bool>> held_;    ///< per part and degree of freedom: constrained
  std::optional<solver::UnitResponses> responses_;
  std::vector<double> made_j_;  ///< per pair: energy made by the normal force over the window
  ContactRecord report_;        ///< kept so that no record allocates
};

}  // namespace ricochet::explicit_solver

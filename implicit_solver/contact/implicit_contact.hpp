#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "common/solver/contact_surface.hpp"
#include "common/solver/massless_nodes.hpp"
#include "common/solver/root_problem.hpp"
#include "common/solver/sliding_rows.hpp"
#include "implicit_solver/contact/near_inverse.hpp"

namespace ricochet::implicit_solver {

/// Contact of the implicit side: kinematics of the pairs, the root problem, the update of velocities and accelerations
/// on the contact surface, and the work of the contact forces.
///
/// The window's equation is A du = b + kappa dt^2/4 G^T r. kappa = 2 and r not remembered is the fully implicit law
/// (Kane et al.):
///   u_{n+1} = u_n + dt v_n + dt^2/4 (a_n + a_{n+1}) + dt^2/2 M^-1 G^T r,   v_{n+1} = v_n + dt/2 (a_n + a_{n+1}) + dt
///   M^-1 G^T r
/// with a the elastic acceleration. kappa = 1 lets r enter as any force of n + 1; afterwards velocity and acceleration
/// of every closed pair are set to a weighted mean (Eq. 25), by masses (conserves momentum) or impedances (the
/// paper's). Or the nodes have no mass along the normal: then no velocity has to jump, r balances K u at any time, and
/// the impact of a node costs nothing (MasslessNodes).
///
/// Whatever the law, a pair gets over the window the impulse (on B; the opposite on A)
///   p = dt/2 [(M a_n - q_n) + (M a*_{n+1} - q_{n+1})] + J,   J of the jump of its velocity
/// (the two brackets are the contact forces that the accelerations remember and that act at n + 1). Pairs that share
/// nodes are gone through again and again (shared_rows.cpp), and their forces are kept as numbers, since
/// nodal forces no longer tell whose they are.
/// Coulomb's law is held by impulses: the jump along the tangent (of solids a vector along tangent and binormal), of
/// slipping pairs, too, is the one that leaves |p_t| <= mu p_n and, inside that, no relative velocity. Likewise for the
/// forces that the accelerations remember.
class ImplicitContact {
 public:
  /// `problem`, for its law and materials, must outlive it.
  ImplicitContact(const scene::Problem& problem, solver::ContactSurface surface,
                  const std::vector<solver::BodyState>& states);

  /// Degrees of freedom (combined numbering: offsets[part] + local dof) the contact acts on, constrained ones left out.
  [[nodiscard]] const std::vector<int>& root_dofs() const { return root_dofs_; }
  /// Sets up the root problem from S^-1 on the root dofs.
  void prepare(const Eigen::MatrixXd& root_inverse, double dt);
  /// The same where S^-1 would be too large for a dense matrix. `solve`: S^-1 of forces on the root dofs.
  void prepare(const std::vector<solver::BodyState>& states, SolveFor solve, double dt);

  /// kappa of the class comment.
  [[nodiscard]] double kappa() const;
  /// Whether r is remembered in the acceleration (not by the fully implicit law).
  [[nodiscard]] bool remembered() const { return kappa() == 1.0; }

  /// Whether contact nodes have no mass along the normal.
  [[nodiscard]] bool massless() const;
  /// Moves the mass of every contact node along the normal inwards, if the law asks for it.
  void move_masses(std::vector<solver::BodyState>& states);

  /// Displacement of massless nodes in `u` from that of the others, `external` force given; vectors per part.
  void settle(const std::vector<solver::BodyState>& states, const std::vector<Eigen::VectorXd>& external,
              std::vector<Eigen::VectorXd>& u);
  /// Velocity of massless nodes after an explicit step: what they moved by, over its size (combined vectors).
  void set_massless_velocity(const Eigen::VectorXd& increment, Eigen::VectorXd& velocity) const;

  /// Finds the contact forces of the window that is being tried. `increment` holds the free increments at contact dofs
  /// (combined numbering); on return root_force() holds G^T r per root dof.
  void solve(const std::vector<solver::BodyState>& states, const Eigen::VectorXd& increment);
  [[nodiscard]] const Eigen::VectorXd& root_force() const { return root_force_; }
  /// Whether any of it is not zero.
  [[nodiscard]] bool any_force() const { return !root_force_.isZero(0.0); }
  /// Sets velocity and acceleration of closed pairs of the trial (combined vectors) as the law asks, and finds the
  /// impulses of all pairs. `bracket` = (M a_n - q_n) + (M a*_{n+1} - q_{n+1}) at the root dofs, the contact forces in
  /// the trapezoidal sum.
  void update_rates(const std::vector<solver::BodyState>& states, const Eigen::VectorXd& bracket,
                    const Eigen::VectorXd& increment, Eigen::VectorXd& velocity, Eigen::VectorXd& acceleration);
  /// Accounts work and impulse of the window: `jump` = M (v - v*) of update_rates, `mean_velocity` = (v + v*)/2 at the
  /// root dofs.
  void account(std::vector<solver::BodyState>& states, const Eigen::VectorXd& bracket, const Eigen::VectorXd& increment,
               const Eigen::VectorXd& jump, const Eigen::VectorXd& mean_velocity);
  void accept();
  /// Drops all contact forces (after the switch to explicit integration).
  void open();

  /// From here on no contact force, or every pair held at zero gap (and, with friction, zero slip), in tension, too.
  void freeze(participant::FrozenContact frozen) { frozen_ = frozen; }
  [[nodiscard]] bool held() const { return frozen_ == participant::FrozenContact::sticking; }
  /// Held pairs: what the law makes of velocity and elastic acceleration (combined vectors) of the present motion.
  void hold_rates(const std::vector<solver::BodyState>& states, Eigen::VectorXd& velocity,
                  Eigen::VectorXd& acceleration);

  /// With the motion of the bodies all that the next window is computed from, and what was booked so far.
  struct State : solver::ContactAccount {
    solver::RootProblem::Solution solution;     ///< forces and states of the accepted window
    std::vector<solver::PairForce> impulse;     ///< per pair, over that window [N s]
    std::vector<solver::PairForce> remembered;  ///< by the acceleration at its end [N]
    std::optional<solver::MasslessNodes::State> massless;
    solver::SlidingRows::State sliding;

    void archive(Archive& a) {
      ContactAccount::archive(a);
      a.any_size(solution, impulse, remembered);  // pairs come and go as surfaces slide
      a(massless, sliding);
    }
  };
  [[nodiscard]] State state() const;
  void restore(const State& state, const std::vector<solver::BodyState>& states);

  [[nodiscard]] const ContactRecord& report(const std::vector<solver::BodyState>& states);
  /// See participant::Participant::contact_forces.
  void append_forces(std::vector<double>& row) const { surface_.append_forces(state_.impulse, 1.0 / dt_, row); }
  [[nodiscard]] int pairs_closed() const;
  [[nodiscard]] const solver::ContactSurface& surface() const { return surface_; }

 private:
  enum Direction : std::size_t { along_normal, along_tangent, along_binormal };
  struct Mean {
    double share_a, share_b;  ///< A moves by share_a * (x_B - x_A), B by -share_b * (x_B - x_A)
  };
  [[nodiscard]] static const solver::ContactRow& row_of(const solver::Pair& pair, Direction direction) {
    return direction == along_normal ? pair.normal : direction == along_tangent ? pair.tangent : pair.binormal;
  }
  /// Directions in which a pair has a force: along the normal and, with friction, along tangent and binormal. Where any
  /// contact has friction all pairs have unknowns along them, those without it forces of zero.
  [[nodiscard]] Eigen::Index directions() const { return !friction_ ? 1 : surface_.components; }
  [[nodiscard]] Eigen::Index directions(const solver::Pair& pair) const {
    return pair.friction_coefficient > 0.0 ? surface_.components : 1;
  }
  /// Of a number per pair and direction, all normals first, those along tangent and binormal.
  [[nodiscard]] Eigen::Vector2d along_surface(std::size_t pair, const Eigen::VectorXd& values) const;
  /// Combined number of an entry's degree of freedom, and a part's stretch of a combined vector.
  [[nodiscard]] int combined(const solver::RowEntry& e) const {
    return offsets_[static_cast<std::size_t>(e.part)] + e.dof;
  }
  [[nodiscard]] auto of_part(const Eigen::VectorXd& values) const {
    return [this, &values](int part) { return values.data() + offsets_[static_cast<std::size_t>(part)]; };
  }
  [[nodiscard]] auto of_part(Eigen::VectorXd& values) const {
    return [this, &values](int part) { return values.data() + offsets_[static_cast<std::size_t>(part)]; };
  }
  [[nodiscard]] Mean mean_shares(const solver::Pair& pair, const std::vector<solver::BodyState>& states,
                                 Direction direction) const;
  void set_mean(const solver::Pair& pair, const std::vector<solver::BodyState>& states, Direction direction,
                Eigen::VectorXd& values) const;
  void push(const solver::Pair& pair, const std::vector<solver::BodyState>& states, Direction direction, double on_b,
            Eigen::VectorXd& values) const;
  [[nodiscard]] double force_on(solver::Side side, std::size_t pair, Direction direction,
                                const Eigen::VectorXd& forces) const;
  [[nodiscard]] double mean_of_sides(std::size_t pair, Direction direction, double on_a, double on_b) const;
  [[nodiscard]] double on_b(std::size_t pair, Direction direction, const Eigen::VectorXd& forces) const;
  [[nodiscard]] double mass_times(std::size_t pair, const std::vector<solver::BodyState>& states, Direction direction,
                                  const Eigen::VectorXd& rates) const;
  [[nodiscard]] bool resets() const;
  [[nodiscard]] bool by_impedance() const;
  void reset_normal(std::size_t pair, const std::vector<solver::BodyState>& states, Eigen::VectorXd& velocity,
                    Eigen::VectorXd& acceleration);
  /// What friction gives a closed pair.
  struct Friction {
    double limit = 0.0;  ///< mu times the normal impulse [N s]
    Eigen::Vector2d given{0.0, 0.0};
    bool sticks = false;
  };
  [[nodiscard]] Friction friction_impulse(const solver::Pair& pair, const Eigen::Matrix2d& inverse,
                                          const solver::PairForce& impulse, const Eigen::Vector2d& rate) const;
  [[nodiscard]] static Eigen::Vector2d remembered_friction(const solver::Pair& pair, const Friction& friction,
                                                           const Eigen::Matrix2d& inverse, double normal_n,
                                                           const Eigen::Vector2d& force, const Eigen::Vector2d& rate);
  void reset_tangent(std::size_t pair, const std::vector<solver::BodyState>& states, Eigen::VectorXd& velocity,
                     Eigen::VectorXd& acceleration);
  void clip_tangent(std::size_t pair, const std::vector<solver::BodyState>& states, Eigen::VectorXd& velocity);
  void give_back(const std::vector<solver::BodyState>& states, const Eigen::VectorXd& bracket,
                 const Eigen::VectorXd& increment, Eigen::VectorXd& velocity);
  void hold_means(const std::vector<solver::BodyState>& states, Eigen::VectorXd& velocity,
                  Eigen::VectorXd& acceleration) const;
  [[nodiscard]] static bool is_free(const solver::RowEntry& e, const std::vector<solver::BodyState>& states);
  void add_root(const solver::RowEntry& e, const std::vector<solver::BodyState>& states);
  void find_weights(const std::vector<solver::BodyState>& states);
  void start(solver::Compliance compliance, double dt);
  void set_root(solver::Compliance compliance);
  /// The compliance of few rows whose many degrees of freedom are not in the root.
  [[nodiscard]] Eigen::MatrixXd columns_of_products(Eigen::Index size) const;
  [[nodiscard]] Eigen::VectorXd bound_of_couplings(const std::vector<solver::BodyState>& states) const;
  [[nodiscard]] std::vector<NearNode> root_nodes(const std::vector<solver::BodyState>& states) const;
  [[nodiscard]] solver::Compliance::Sparse gather() const;
  [[nodiscard]] solver::Compliance compliance_of_rows() const;
  void follow(const std::vector<solver::BodyState>& states);
  void take_new_pairs(const std::vector<solver::BodyState>& states);
  [[nodiscard]] solver::PairForce trial_memory(std::size_t pair) const;
  [[nodiscard]] Eigen::VectorXd sums_of_couplings(const std::vector<solver::BodyState>& states,
                                                  Direction direction) const;
  void root_forces_of(const Eigen::VectorXd& x, Eigen::VectorXd& forces) const;
  void motion_of_pairs(const Eigen::VectorXd& motion, Eigen::VectorXd& y) const;
  void update_shared(const std::vector<solver::BodyState>& states, Eigen::VectorXd& velocity,
                     Eigen::VectorXd& acceleration);
  [[nodiscard]] double reset_shared(std::size_t pair, const std::vector<solver::BodyState>& states,
                                    Eigen::VectorXd& velocity, Eigen::VectorXd& acceleration);
  [[nodiscard]] double reset_shared_tangent(std::size_t pair, const std::vector<solver::BodyState>& states,
                                            Eigen::VectorXd& velocity, Eigen::VectorXd& acceleration);
  void account_shared(std::vector<solver::BodyState>& states, const Eigen::VectorXd& increment,
                      const Eigen::VectorXd& mean_velocity);
  void find_moved(const std::vector<solver::BodyState>& states, const Eigen::VectorXd& increment);

  const scene::Problem* problem_;  ///< materials for the impedances
  const scene::Contact* law_;
  bool friction_;  ///< of any contact
  solver::ContactSurface surface_;
  bool shared_;  ///< pairs share nodes
  std::optional<solver::SlidingRows> sliding_;
  std::optional<participant::FrozenContact> frozen_;
  std::vector<int> offsets_;
  std::vector<int> root_dofs_;
  std::vector<int> root_of_dof_;  ///< per combined number: its place in root_dofs_, or -1
  double dt_ = 0.0;
  std::optional<solver::RootProblem> root_;
  std::optional<solver::MasslessNodes> massless_;
  std::vector<double*> velocity_of_part_;
  std::vector<const Eigen::VectorXd*> external_of_part_;
  std::vector<Eigen::VectorXd*> u_of_part_;
  Eigen::VectorXd gap_free_, slip_free_, slip_velocity_, root_force_;
  State state_;
  solver::RootProblem::Solution trial_;
  /// Per pair, of the trial: impulse p [N s] and whether it sticks; the forces that the acceleration remembers [N]; of
  /// pairs that share nodes, what their velocity jumps took [N s].
  std::vector<solver::PairForce> impulse_, remembered_, jump_impulse_;
  /// Where rows are written anew in this window: the pairs of the last one, and what the acceleration remembers of
  /// them.
  std::vector<solver::Pair> old_pairs_;
  std::vector<solver::PairForce> old_remembered_;
  Eigen::MatrixXd root_inverse_;  ///< this or the next, kept where bodies slide
  solver::Compliance::Sparse near_inverse_;
  std::function<void(const Eigen::VectorXd&, Eigen::VectorXd&)> product_;  ///< by the compliance, where it is not dense
  /// Per pair, along normal, tangent and binormal, for A and B: sum of the squared coefficients of the degrees of
  /// freedom that no support holds; 1 for a node that is free.
  std::vector<std::array<std::array<double, 2>, 3>> weights_;
  std::vector<solver::PairForce> reported_;  ///< kept, like the next, so that no record allocates
  ContactRecord report_;
};

}  // namespace ricochet::implicit_solver

#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <vector>

#include "common/contact/contact_surface.hpp"
#include "common/contact/massless_nodes.hpp"
#include "common/contact/pair_compliance.hpp"
#include "common/contact/root_problem.hpp"
#include "common/contact/sliding_rows.hpp"
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
/// Forces and impulses are numbers of a pair from the first to the last. Whatever the law, a pair gets over the window
/// the impulse (on B; the opposite on A)
///   p = dt/2 (r_n + kappa r_{n+1}) + J,   r_n the force that its acceleration remembers, J the jump of its velocity
/// The jumps of all closed pairs together leave no relative velocity, and the forces that are then remembered no
/// relative acceleration but where that would take a pull: two problems of N M^-1 N^T, each gone through pair by pair
/// until nothing changes (solver::sweep), of pairs that share no nodes once.
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
  /// Sets up the root problem from S^-1 on the root dofs; again where the operator is another, at any time but during
  /// `solve`.
  void prepare(const Eigen::MatrixXd& root_inverse, double dt);
  /// Whether forces on the root dofs move so little of what is far that S^-1 has few entries, found with so many
  /// solves; by `solve` or what approximates it to 1e-16. To be known before `prepare` of this kind.
  [[nodiscard]] bool moves_what_is_near(const std::vector<solver::BodyState>& states, const SolveFor& solve,
                                        int most_solves);
  /// The same where S^-1 would be too large for a dense matrix. `solve`: S^-1 of forces on the root dofs.
  void prepare(const std::vector<solver::BodyState>& states, SolveFor solve, double dt);

  /// S is turned against that of `prepare`, by T of each part. Not during `solve`.
  void turn(const std::vector<Eigen::Matrix3d>& by, const std::vector<solver::BodyState>& states);

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
  /// (combined numbering); on return root_force() holds G^T r per root dof. `again`: they were found before in this
  /// window, for another increment, and are the first guess, so rows stay as they were then: of forces that rows which
  /// depend on each other may share in any way it finds the nearest ones, so that Newton's iteration settles.
  void solve(const std::vector<solver::BodyState>& states, const Eigen::VectorXd& increment, bool again);
  /// The forces of the present trial are known to so much: their residual times the largest normal force [N].
  [[nodiscard]] double uncertain_force() const;
  [[nodiscard]] const Eigen::VectorXd& root_force() const { return root_force_; }
  /// Whether any of it is not zero.
  [[nodiscard]] bool any_force() const { return !root_force_.isZero(0.0); }
  /// Sets velocity and acceleration of closed pairs of the trial (combined vectors) as the law asks, and finds the
  /// impulses of all pairs.
  void update_rates(const std::vector<solver::BodyState>& states, const Eigen::VectorXd& increment,
                    Eigen::VectorXd& velocity, Eigen::VectorXd& acceleration);
  /// Accounts work and impulse of the window: `mean_velocity` = (v + v*)/2 of update_rates at the root dofs.
  void account(std::vector<solver::BodyState>& states, const Eigen::VectorXd& increment,
               const Eigen::VectorXd& mean_velocity);
  void accept();
  /// Drops all contact forces (after the switch to explicit integration).
  void open();
  /// Before a window of explicit integration: rows follow the bodies, all pairs open.
  void fly(const std::vector<solver::BodyState>& states);

  /// From here on no contact force, or every pair held at zero gap (and, with friction, zero slip), in tension, too;
  /// nothing: contact as before.
  void freeze(std::optional<participant::FrozenContact> frozen) { frozen_ = frozen; }
  [[nodiscard]] bool held() const { return frozen_ == participant::FrozenContact::sticking; }
  /// Held pairs: what the law makes of velocity and elastic acceleration (combined vectors) of the present motion.
  void hold_rates(const std::vector<solver::BodyState>& states, Eigen::VectorXd& velocity,
                  Eigen::VectorXd& acceleration);

  /// With the motion of the bodies all that the next window is computed from, and what was booked so far.
  struct State : solver::ContactAccount {
    solver::RootProblem::Solution solution;      ///< forces and states of the accepted window
    std::vector<solver::PairForce> mean_forces;  ///< per pair, impulse over that window by its size [N]
    std::vector<solver::PairForce> remembered;   ///< by the acceleration at its end [N]
    /// Means by impedances are no impulses: along normal, tangent and binormal what either side gets beside them, as
    /// much as the acceleration remembers [N]. Else empty.
    std::vector<Eigen::Vector3d> uneven;
    std::optional<solver::MasslessNodes::State> massless;
    solver::SlidingRows::State sliding;

    void archive(Archive& a) {
      ContactAccount::archive(a);
      a.any_size(solution, mean_forces, remembered, uneven);  // pairs come and go as surfaces slide
      a(massless, sliding);
    }
  };
  [[nodiscard]] State state() const;
  void restore(const State& state, const std::vector<solver::BodyState>& states);

  [[nodiscard]] const ContactRecord& report(const std::vector<solver::BodyState>& states);
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

 private:
  /// The friction of a closed pair.
  struct Friction {
    double limit = 0.0;  ///< mu times the normal impulse [N s]
    Eigen::Vector2d given{0.0, 0.0};
    bool sticks = false, stays = false;  ///< no relative velocity, and no relative acceleration
  };
  /// The numbers that a window that is being tried gives each pair.
  struct Trial {
    solver::RootProblem::Solution solution;
    std::vector<solver::PairForce> impulse, jump, remembered;  ///< p and J [N s], the force at its end [N]
    std::vector<Eigen::Vector3d> uneven_jump, uneven;          ///< see State
    std::vector<Friction> friction;

    void start(std::size_t pairs, bool uneven_too);
  };
  /// Motion by forces on the rows: the rows over the root dofs, and S^-1 there, one of a dense matrix, a sparse one and
  /// products, kept where bodies slide.
  struct Response {
    solver::Compliance::Sparse rows;
    solver::Compliance::Sparse turn;  ///< T over the root dofs; empty: 1
    Eigen::MatrixXd dense;
    std::optional<NearGroups> groups;
    solver::Compliance::Sparse near;
    std::function<void(const Eigen::VectorXd&, Eigen::VectorXd&)> product;  ///< of forces of pairs
  };
  /// Where rows are written anew in this window: the pairs of the last one, and what the acceleration remembers of
  /// them.
  struct Before {
    std::vector<solver::Pair> pairs;
    std::vector<solver::PairForce> remembered;
  };
  /// At the end of the window without contact forces, and the slip's rate at its begin.
  struct FreeMotion {
    Eigen::VectorXd gap, slip, slip_velocity;
  };
  /// Forces of pairs and their motion, in the order of the root problem.
  struct Sweep {
    Eigen::VectorXd x, x_before, motion;
  };
  [[nodiscard]] const scene::Contact& law() const { return problem_->scene.contact_law(); }
  [[nodiscard]] std::size_t pairs() const { return surface_.pairs.size(); }
  [[nodiscard]] bool closed(std::size_t pair) const {
    return trial_.solution.states[pair] != solver::ContactState::open;
  }
  [[nodiscard]] Eigen::Index directions() const { return surface_.directions; }
  [[nodiscard]] int rows() const { return static_cast<int>(directions()) * static_cast<int>(pairs()); }
  [[nodiscard]] Eigen::Index unknown(std::size_t pair, Eigen::Index direction) const {
    return direction * static_cast<Eigen::Index>(pairs()) + static_cast<Eigen::Index>(pair);
  }
  /// From a number per pair and direction, those along tangent and binormal.
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
  [[nodiscard]] bool resets() const;
  [[nodiscard]] bool by_impedance() const;
  /// A mean by impedances instead of masses: the part of a relative rate by which it moves both sides, and what it
  /// makes of an impulse that the mean by masses would take.
  struct Impedance {
    double moves = 0.0, gain = 1.0;
  };
  [[nodiscard]] Impedance impedance_of(const solver::Pair& pair, const std::vector<solver::BodyState>& states,
                                       Eigen::Index direction) const;
  double move_both(const solver::Pair& pair, const std::vector<solver::BodyState>& states, Eigen::Index direction,
                   double taken, double& uneven, Eigen::VectorXd& values) const;

  // Rates (contact_rates.cpp)
  void find_inverse_mass(const std::vector<solver::BodyState>& states);
  [[nodiscard]] Eigen::Matrix2d inverse_mass_along(std::size_t pair) const;
  void begin_sweep(const std::vector<solver::PairForce>& forces, const Eigen::VectorXd& values, bool of_all = false);
  template <class Project>
  void run_sweep(const Project& project);
  void push_swept(const std::vector<solver::BodyState>& states, Eigen::VectorXd& values) const;
  void hold_means(const std::vector<solver::BodyState>& states, Eigen::VectorXd& values);
  [[nodiscard]] Friction friction_impulse(std::size_t pair, const std::vector<solver::BodyState>& states) const;
  [[nodiscard]] double friction_limit(std::size_t pair, const std::vector<solver::BodyState>& states) const;
  [[nodiscard]] Eigen::Vector2d remembered_friction(std::size_t pair, const std::vector<solver::BodyState>& states,
                                                    Friction& friction) const;
  [[nodiscard]] bool slides(std::size_t pair) const;
  void reset_velocities(const std::vector<solver::BodyState>& states, Eigen::VectorXd& velocity);
  void reset_accelerations(const std::vector<solver::BodyState>& states, Eigen::VectorXd& acceleration);
  void give_back(const std::vector<solver::BodyState>& states, const Eigen::VectorXd& increment,
                 Eigen::VectorXd& velocity);

  [[nodiscard]] static bool is_free(const solver::RowEntry& e, const std::vector<solver::BodyState>& states);
  void add_root(const solver::RowEntry& e, const std::vector<solver::BodyState>& states);
  void write_rows();
  /// Whether rows are written anew, or S^-1 is turned against them.
  [[nodiscard]] bool other_rows_come() const { return sliding_ || turns_; }
  [[nodiscard]] bool has_columns() const;
  void start(solver::Compliance compliance);
  void set_root(solver::Compliance compliance);
  void start_open();
  /// The compliance of few rows whose many degrees of freedom are not in the root.
  [[nodiscard]] Eigen::MatrixXd columns_of_products(Eigen::Index size) const;
  [[nodiscard]] Eigen::VectorXd bound_of_couplings(const std::vector<solver::BodyState>& states) const;
  [[nodiscard]] std::pair<int, int> local(int dof) const;
  [[nodiscard]] std::vector<NearNode> root_nodes(const std::vector<solver::BodyState>& states) const;
  [[nodiscard]] solver::Compliance compliance_of_rows() const;
  bool follow(const std::vector<solver::BodyState>& states);
  void take_new_pairs(const std::vector<solver::BodyState>& states);
  void find_moved(const std::vector<solver::BodyState>& states, const Eigen::VectorXd& increment);

  const scene::Problem* problem_;
  solver::ContactSurface surface_;
  std::optional<solver::SlidingRows> sliding_;
  bool turns_ = false;  ///< there are parts with a frame
  std::optional<participant::FrozenContact> frozen_;
  std::vector<int> offsets_;
  std::vector<int> root_dofs_;
  std::vector<int> root_of_dof_;  ///< per combined number: its place in root_dofs_, or -1
  double dt_ = 0.0;
  Response response_;
  std::optional<solver::RootProblem> root_;
  std::optional<solver::Compliance> inverse_mass_;  ///< N M^-1 N^T; none: to be found for the present rows
  std::optional<solver::MasslessNodes> massless_;
  FreeMotion free_;
  Eigen::VectorXd root_force_;
  State state_;
  Trial trial_;
  Before before_;
  Sweep sweep_;
  ContactRecord report_;  ///< kept so that no record allocates
};

}  // namespace ricochet::implicit_solver

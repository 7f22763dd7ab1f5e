#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/participant/participant.hpp"
#include "common/solver/axial_stress_shares.hpp"
#include "common/solver/body_state.hpp"
#include "common/solver/model_watch.hpp"
#include "common/solver/separation.hpp"
#include "common/solver/watched_outline.hpp"
#include "implicit_solver/condensed_factor.hpp"
#include "implicit_solver/contact/implicit_contact.hpp"

namespace ricochet::implicit_solver {

/// Trapezoidal rule (Newmark, beta = 1/4, gamma = 1/2) on the implicit elements, the shared nodes (with the summed
/// mass, Eq. 28) and the contact nodes, in increments (Eq. 16). With q_n = f_n - K u_n - L_n the elastic residual (L:
/// internal force of the explicit elements at the shared nodes) one window is
///   (M + dt^2/4 K) du = M (dt v_n + dt^2/4 a_n) + dt^2/4 (q_n + df - dL) + kappa dt^2/4 G^T r
///   a*_{n+1} = 4/dt^2 (du - dt v_n) - a_n,   v_{n+1} = v_n + dt/2 (a_n + a*_{n+1}),   q_{n+1} = M a*_{n+1} - kappa G^T
///   r
/// Dashpots C of absorbing surfaces put -C (v - v_0) into f at n and n + 1: M + dt/2 C + dt^2/4 K on the left, and
/// dt^2/2 C v_n on the right.
/// Where a protocol gives an interface stiffness S, L = given + S u and S joins K in the operator.
/// The operator is factored once; contact forces r come from a small dense problem (ImplicitContact, RootProblem).
///
/// After separation it can integrate explicitly (central difference, same lumped masses, no contact force) and back:
/// `synchronise` recomputes a_n = M^-1 (f - K u - L) for either.
class ImplicitSolver final : public participant::Participant {
 public:
  ImplicitSolver(scene::Problem problem, const std::string& name);

  participant::Description describe() override;
  void initialize(const participant::Setup& setup, participant::LinkOutput& output) override;
  void synchronise(participant::Integration integration, const std::vector<double>& link_input,
                   participant::LinkOutput& output) override;
  void advance(std::int64_t window, const std::vector<double>& link_input, participant::LinkOutput& output) override;
  void accept() override;
  /// The next window's right-hand side and the elimination of everything but contact and shared nodes.
  void work_ahead() override;
  [[nodiscard]] participant::ContactStatus contact_status() const override { return status_; }
  void record(std::vector<double>& row) override;
  void axial_stress(std::vector<double>& row) override { axial_stress_.append(states_, window_, row); }
  void write_fields(std::int64_t window) override;
  [[nodiscard]] std::vector<participant::Departure> departures() override { return model_watch_.departures(); }
  [[nodiscard]] std::vector<participant::OutlineNode> outline() override { return outline_.nodes(states_); }
  void finish() override { model_watch_.look(window_, states_, true); }
  void load_state(const std::vector<double>& state, participant::FrozenContact contact) override;
  void read_state(std::vector<double>& state, std::vector<double>& scale) override;

  [[nodiscard]] const std::vector<solver::BodyState>& states() const { return states_; }
  /// Largest |f - K u - L - q| over the largest |K u| that a resynchronisation has found so far.
  [[nodiscard]] double largest_drift() const { return largest_drift_; }

 private:
  /// One window as it is tried; combined numbering of all parts.
  struct Window {
    Eigen::VectorXd increment, velocity, acceleration, residual;
    Eigen::VectorXd external, link;                ///< f and L at n + 1
    Eigen::VectorXd bracket, jump, mean_velocity;  ///< work of the contact forces, see ImplicitContact::account
  };
  [[nodiscard]] auto segment(Eigen::VectorXd& combined, std::size_t part) const {
    return combined.segment(offsets_[part], states_[part].part.dofs());
  }
  [[nodiscard]] auto segment(const Eigen::VectorXd& combined, std::size_t part) const {
    return combined.segment(offsets_[part], states_[part].part.dofs());
  }
  void settle_at_start();
  void settle_massless(const Eigen::VectorXd& external);
  void factorise();
  void damp_rhs();
  [[nodiscard]] double load_on(std::size_t part, int dof, const Eigen::VectorXd& external) const;
  void external_force(double time_s, Eigen::VectorXd& external);
  void add_interface_stiffness(double scale, fem::SparseMatrix& a) const;
  void add_stiffness_force(bool of_increment, Eigen::VectorXd& link);
  void take_link(const std::vector<double>& link_input, Eigen::VectorXd& link) const;
  void put_output(const Window& window, participant::LinkOutput& output) const;
  void prepare(std::int64_t window);
  void advance_implicit(double time_s);
  void advance_explicit(double time_s);
  void solve_increment();
  void constrain_increment(double time_s);
  void find_rates();
  void find_contact_rates();
  void set_dashpot_forces();
  void constrain_rates(double time_s);
  void account();
  [[nodiscard]] double shared_staggered_energy(std::size_t part) const;
  void resynchronise_residual();
  void update_status();

  scene::Problem problem_;
  const scene::ParticipantSpec* spec_;
  std::vector<solver::BodyState> states_;
  std::vector<Eigen::Index> offsets_;
  std::vector<int> shared_dofs_;                ///< combined numbering, interface order
  fem::SparseMatrix stiffness_;                 ///< all parts, block diagonal
  Eigen::VectorXd residual_, external_, link_;  ///< q, f (with reactions) and L of the last accepted window
  Eigen::VectorXd rhs_, rhs_with_link_, root_rhs_, root_increment_, shared_x_, shared_force_;
  std::vector<std::vector<double>> dashpot_load_;  ///< per part and dashpot: other external force at n + 1 [N]
  Eigen::MatrixXd interface_stiffness_;            ///< S, in the order of shared_dofs_; empty: none
  std::vector<Eigen::VectorXd> part_external_;     ///< per part: f for the balance of massless nodes
  std::vector<Eigen::VectorXd> moved_, internal_;  ///< per part: u and K u of an explicit step or a resynchronisation
  std::optional<CondensedFactor> factor_;
  std::optional<ImplicitContact> contact_;
  /// A root dof of the contact: combined number, part, local number.
  struct Root {
    int dof;
    std::size_t part;
    int local;
  };
  std::vector<Root> roots_;
  std::vector<std::pair<int, Eigen::Index>> shared_roots_;  ///< shared dof, its place in the root
  bool link_in_root_ = true;
  std::int64_t prepared_ = -1;  ///< window that `prepare` was done for
  Window trial_;
  participant::Setup setup_;
  solver::AxialStressShares axial_stress_;
  solver::ModelWatch model_watch_;
  solver::WatchedOutline outline_;
  participant::Integration integration_ = participant::Integration::implicit_newmark;
  std::int64_t window_ = 0;
  std::vector<double> interface_work_j_, first_staggered_j_;  ///< per part
  double largest_drift_ = 0.0;
  solver::SeparationWatch separation_;
  participant::ContactStatus status_;
};

}  // namespace ricochet::implicit_solver

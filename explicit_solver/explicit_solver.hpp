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
#include "explicit_solver/explicit_contact.hpp"
#include "explicit_solver/subcycled_window.hpp"
#include "explicit_solver/wave_front.hpp"

namespace ricochet::explicit_solver {

/// Central difference method on the explicit elements of its bodies (Newmark, beta = 0, gamma = 1/2; Eq. 3-6):
///   u_{n+1} = u_n + dt v_n + dt^2/2 a_n,   a_{n+1} = M^-1 (f_{n+1} - K u_{n+1}),   v_{n+1} = v_n + dt/2 (a_n +
///   a_{n+1})
/// Stable for dt <= 2/omega_max(K_E, M). Shared nodes take the displacement the link gives; the answer is P = K u - f
/// there. As the only participant (`all_explicit`) it also enforces the contact. Driven by force (dual protocols) it
/// integrates its shared nodes, too, in one or more steps a window: SubcycledWindow. Rows that no wave has reached are
/// left out (WaveFront), to the same bits.
///
/// Kinetic energy is reported in the staggered metric 1/2 v_{n-1/2}^T M v_{n+1/2} = 1/2 (v^T M v - dt^2/4 a^T M a), in
/// which the method conserves energy exactly.
class ExplicitSolver final : public participant::Participant {
 public:
  ExplicitSolver(scene::Problem problem, const std::string& name);

  participant::Description describe() override;
  void initialize(const participant::Setup& setup, participant::LinkOutput& output) override;
  void synchronise(participant::Integration integration, const std::vector<double>& link_input,
                   participant::LinkOutput& output) override;
  void advance(std::int64_t window, const std::vector<double>& link_input, participant::LinkOutput& output) override;
  void advance_substep(std::int64_t window, int substep, const std::vector<double>& link_input,
                       participant::LinkOutput& output) override;
  void accept() override;
  /// The next window but for what the shared nodes' displacement changes; driven by force, with the multiplier held.
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
  /// Rows of K u that a step computes at present, all parts together.
  [[nodiscard]] int rows_computed() const;
  /// Computes all rows from `initialize` on: what the tests and the benchmark compare with.
  void compute_all_rows() { all_rows_ = true; }

 private:
  /// Per part: the window being tried, and what the last accepted one left.
  struct Window {
    Eigen::VectorXd u;                       ///< trial displacement; after `accept` the one before
    Eigen::VectorXd internal, internal_old;  ///< K u at n + 1 and n
    Eigen::VectorXd external, external_old;  ///< f at n + 1 and n, reactions at constrained dofs included
    // K u is formed with the shared nodes where they were; their new displacement then changes the rows next to them.
    std::vector<int> near_rows;
    fem::SparseMatrix shared_columns;             ///< K: near rows x shared dofs
    Eigen::VectorXd near_internal, shared_moved;  ///< K u in the near rows before that; by how much they have moved
    WaveFront front;
  };
  /// The only participant: it owns every element and enforces the contact.
  [[nodiscard]] bool alone() const { return problem_.scene.coupling.protocol.layout == scene::Layout::all_explicit; }
  [[nodiscard]] bool driven_by_force() const { return setup_.driven_by == participant::Drive::force; }
  [[nodiscard]] double step_s() const { return setup_.window_size_s / setup_.substeps; }
  void initialize_internal_forces();
  void settle_at_start();
  void initialize_subcycling();
  void synchronise_subcycling(const std::vector<double>& force, participant::LinkOutput& output);
  void advance_subcycling(double begin_s, int steps, const std::vector<double>& force, participant::LinkOutput& output);
  void accept_subcycling();
  void shared_motion(participant::LinkOutput& output) const;
  void take_link(const solver::BodyState& state, const std::vector<double>& link_input, std::size_t& next,
                 Eigen::VectorXd& u) const;
  void interface_force(participant::LinkOutput& output) const;
  /// What `state.v` is when accelerations are sought.
  enum class Velocity { now, half_a_step_before };
  void find_accelerations(double time_s, Velocity velocity);
  void half_a_step(std::size_t part);
  void set_shared_velocity(std::size_t part);
  void set_dashpot_forces(solver::BodyState& state, Window& window, Velocity velocity) const;
  [[nodiscard]] std::vector<int> driven_nodes(std::size_t part) const;
  void account();
  void set_shared_columns(std::size_t part);
  void predict(std::int64_t window);
  void move_shared(std::size_t part, const std::vector<double>& link_input, std::size_t& next);
  void account_interface(std::size_t part, const Eigen::VectorXd& u_old, const Eigen::VectorXd& u_new);
  void update_status();

  scene::Problem problem_;
  const scene::ParticipantSpec* spec_;
  std::vector<solver::BodyState> states_;
  std::vector<Window> windows_;
  std::vector<const Eigen::VectorXd*> u_before_, trial_external_;  ///< per part: into windows_
  std::vector<Eigen::VectorXd*> trial_u_;
  std::vector<SubcycledWindow> subcycled_;  ///< per part; driven by force only
  Eigen::VectorXd part_force_;              ///< a part's share of the link input: kept so that no window allocates
  int substep_ = 0;                         ///< of the trial; 0: whole window
  std::optional<ExplicitContact> contact_;
  participant::Setup setup_;
  solver::AxialStressShares axial_stress_;
  solver::ModelWatch model_watch_;
  solver::WatchedOutline outline_;
  std::int64_t window_ = 0;
  bool trial_ = false;  ///< window_ + 1 is predicted: the old forces are already set aside
  bool all_rows_ = false;
  bool contact_started_ = false;  ///< the contact has made the accelerations of the first window
  solver::SeparationWatch separation_;
  participant::ContactStatus status_;
};

}  // namespace ricochet::explicit_solver

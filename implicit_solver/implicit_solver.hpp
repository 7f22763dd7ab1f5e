#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/base/separation.hpp"
#include "common/body/body_state.hpp"
#include "common/body/free_motion.hpp"
#include "common/body/material_elements.hpp"
#include "common/body/plastic_elements.hpp"
#include "common/participant/participant.hpp"
#include "common/solver/reporting.hpp"
#include "implicit_solver/combined_parts.hpp"
#include "implicit_solver/contact/implicit_contact.hpp"
#include "implicit_solver/flight_window.hpp"
#include "implicit_solver/newmark_window.hpp"

namespace ricochet::implicit_solver {

/// The implicit elements, the shared nodes (with the summed mass, Eq. 28) and the contact nodes, by the trapezoidal
/// rule (NewmarkWindow) with contact; after separation by central difference without (FlightWindow), and back:
/// `synchronise` recomputes a_n = M^-1 (f - P(u) - L) for either.
class ImplicitSolver : public participant::Participant {
 public:
  /// `told_critical_step_s`: see solver::describe. `make_force`: what the elements of a part answer.
  ImplicitSolver(scene::Problem problem, const std::string& name, std::optional<double> told_critical_step_s = {},
                 const MakeForce& make_force = solver::material_elements);

  participant::Description describe() override;
  void initialize(const participant::Setup& setup, participant::LinkOutput& output) override;
  void synchronise(participant::Integration integration, const std::vector<double>& link_input,
                   participant::LinkOutput& output) override;
  void reconfigure(const participant::Setup& setup) override;
  void advance(std::int64_t window, const std::vector<double>& link_input, participant::LinkOutput& output) override;
  void note_touch(bool closed) override { reporting_.note_touch(closed); }
  void accept() override;
  /// The next window's right-hand side and the elimination of everything but contact and shared nodes.
  void work_ahead() override;
  [[nodiscard]] participant::ContactStatus contact_status() const override { return reporting_.contact_status(); }
  void record(std::vector<double>& row) override;
  void contact_forces(std::vector<double>& row) override {
    if (contact_) contact_->append_forces(row);
  }
  void axial_stress(std::vector<double>& row) override { reporting_.append_axial_stress(states_, window_, row); }
  void probes(std::vector<double>& row) override { reporting_.append_probes(states_, window_, row); }
  void write_fields(std::int64_t window) override;
  [[nodiscard]] std::vector<participant::Departure> departures() override { return reporting_.departures(); }
  [[nodiscard]] std::vector<participant::OutlineNode> outline() override { return reporting_.outline(states_); }
  void finish() override;
  void load_state(const std::vector<double>& state, participant::FrozenContact contact) override;
  void read_state(std::vector<double>& state, std::vector<double>& scale) override;
  std::string save_state() override;
  void restore_state(std::string_view bytes) override;

  /// All that the windows to come are computed from, and what was booked so far: put back, they give the same bits.
  struct State {
    std::int64_t window = 0;
    std::vector<solver::BodyMotion> bodies;
    participant::Integration integration = participant::Integration::implicit_newmark;
    WindowState forces;
    std::vector<double> interface_work_j, first_staggered_j;  ///< per part
    std::vector<std::string> elements;                        ///< per part: what its InternalForce keeps
    Eigen::VectorXd linearised_at;   ///< where the operator is from; empty of tangents that are kept
    Eigen::VectorXd last_increment;  ///< see NewmarkWindow
    std::vector<Eigen::Matrix3d> directions;
    std::optional<ImplicitContact::State> contact;
    SeparationWatch separation;

    void archive(Archive& a) {
      a(window, bodies, integration, forces, interface_work_j, first_staggered_j);
      for (auto& kept : elements) a.any_size(kept);
      a(linearised_at, last_increment, directions, contact, separation);
    }
  };
  [[nodiscard]] State state() const;
  void restore(const State& state);

 private:
  void archive(State& state, Archive& a) { a.same_size(state, reporting_); }
  void refuse_massless_nodes() const;
  void set_up_windows(participant::Heartbeat* heart);
  void take_link(const std::vector<double>& link_input, Eigen::VectorXd& link) const;
  void put_output(participant::LinkOutput& output) const;
  void account();
  [[nodiscard]] double shared_staggered_energy(std::size_t part) const;
  void resynchronise_residual();
  void update_status();

  scene::Problem problem_;
  const scene::ParticipantSpec* spec_;
  std::optional<double> told_critical_step_s_;
  std::vector<solver::BodyState> states_;
  CombinedParts parts_;
  WindowState forces_;  ///< of the last accepted window
  WindowTrial trial_;
  std::vector<Eigen::VectorXd> internal_;  ///< per part: P(u) of a resynchronisation or a row
  std::optional<ImplicitContact> contact_;
  std::optional<NewmarkWindow> newmark_;  ///< from `initialize` on
  std::optional<FlightWindow> flight_;
  participant::Setup setup_;
  solver::Reporting reporting_;
  participant::Integration integration_ = participant::Integration::implicit_newmark;
  std::int64_t window_ = 0;
  bool tried_ = false;                                        ///< a trial of the next window is not accepted yet
  std::vector<double> interface_work_j_, first_staggered_j_;  ///< per part
  std::vector<solver::Surroundings> surroundings_;            ///< that `load_state` took away; else empty
};

}  // namespace ricochet::implicit_solver

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/base/separation.hpp"
#include "common/body/body_state.hpp"
#include "common/participant/participant.hpp"
#include "common/solver/reporting.hpp"
#include "explicit_solver/material_force.hpp"
#include "explicit_solver/ranks.hpp"
#include "explicit_solver/stepping.hpp"

namespace ricochet::explicit_solver {

/// Central difference method on the explicit elements of its bodies (Newmark, beta = 0, gamma = 1/2; Eq. 3-6). Stable
/// for dt <= 2/omega_max(K_E, M). How a window goes: Stepping. Rows that no wave has reached are left out
/// (WaveFront), to the same bits. With `ranks` this process steps a share of the nodes only; what it reports is of all.
///
/// Kinetic energy is reported in the staggered metric 1/2 v_{n-1/2}^T M v_{n+1/2} = 1/2 (v^T M v - dt^2/4 a^T M a), in
/// which the method conserves energy exactly.
class ExplicitSolver : public participant::Participant {
 public:
  /// `told_critical_step_s`: see solver::describe. `ranks`: of a participant of several processes, of which this is the
  /// first; it must outlive this object. `make_force`: what the elements of a part answer.
  ExplicitSolver(scene::Problem problem, const std::string& name, std::optional<double> told_critical_step_s = {},
                 Ranks* ranks = nullptr, MakeForce make_force = material_force);

  participant::Description describe() override;
  void initialize(const participant::Setup& setup, participant::LinkOutput& output) override;
  void synchronise(participant::Integration integration, const std::vector<double>& link_input,
                   participant::LinkOutput& output) override;
  void reconfigure(const participant::Setup& setup) override;
  void advance(std::int64_t window, const std::vector<double>& link_input, participant::LinkOutput& output) override;
  void advance_substep(std::int64_t window, int substep, const std::vector<double>& link_input,
                       participant::LinkOutput& output) override;
  void note_touch(bool closed) override { reporting_.note_touch(closed); }
  void accept() override;
  /// The next window but for what the shared nodes' displacement changes; driven by force, with the multiplier held.
  void work_ahead() override;
  [[nodiscard]] participant::ContactStatus contact_status() const override { return reporting_.contact_status(); }
  void record(std::vector<double>& row) override;
  void contact_forces(std::vector<double>& row) override {
    if (const auto* c = contact()) c->append_forces(row);
  }
  void axial_stress(std::vector<double>& row) override { reporting_.append_axial_stress(reported(), window_, row); }
  void probes(std::vector<double>& row) override { reporting_.append_probes(reported(), window_, row); }
  void write_fields(std::int64_t window) override;
  [[nodiscard]] std::vector<participant::Departure> departures() override { return reporting_.departures(); }
  [[nodiscard]] std::vector<participant::OutlineNode> outline() override { return reporting_.outline(reported()); }
  void finish() override;
  void load_state(const std::vector<double>& state, participant::FrozenContact contact) override;
  void read_state(std::vector<double>& state, std::vector<double>& scale) override;
  std::string save_state() override;
  void restore_state(std::string_view bytes) override;

  /// All that the windows to come are computed from, and what was booked so far: put back, they give the same bits.
  struct State {
    std::int64_t window = 0;
    Stepping::State stepping;
    SeparationWatch separation;

    void archive(Archive& a) { a(window, stepping, separation); }
  };
  [[nodiscard]] State state() const;
  [[nodiscard]] const Stepping& stepping() const { return *stepping_; }  ///< from `initialize` on
  void restore(const State& state);

 private:
  void archive(State& state, Archive& a);
  /// The only participant: it owns every element and enforces the contact.
  [[nodiscard]] bool alone() const { return problem_.scene.coupling.protocol.layout == scene::Layout::all_explicit; }
  [[nodiscard]] bool has_contact() const { return alone() && !problem_.contacts.empty(); }
  [[nodiscard]] bool any_small_steps() const;
  [[nodiscard]] std::unique_ptr<solver::InternalForce> make_force(const solver::BodyState& state,
                                                                  const std::vector<int>& driven) const;
  [[nodiscard]] std::optional<ExplicitContact> make_contact() const;
  [[nodiscard]] ExplicitContact* contact() { return stepping_->contact(); }
  /// The bodies that this process steps: with ranks a share of each part.
  [[nodiscard]] std::vector<solver::BodyState>& stepped() { return ranks_ ? *share_ : states_; }
  [[nodiscard]] const std::vector<solver::BodyState>& stepped() const { return ranks_ ? *share_ : states_; }
  /// The whole parts, with the motion of the last accepted window.
  const std::vector<solver::BodyState>& reported();
  void tell(Order order, std::int64_t window = 0, int substep = 0);
  void take_totals();
  [[nodiscard]] double unspread_of_contact_j();
  void update_status();

  scene::Problem problem_;
  const scene::ParticipantSpec* spec_;
  std::optional<double> told_critical_step_s_;
  Ranks* ranks_;
  MakeForce make_force_;
  std::vector<solver::BodyState> states_;            ///< whole parts
  std::vector<solver::BodyState>* share_ = nullptr;  ///< of ranks, from `initialize` on: what this one steps
  double unspread_work_j_ = 0.0;                     ///< of all parts, of the present totals (InternalForce::unspread)
  std::int64_t gathered_ = -1;                       ///< of ranks: the window whose motion states_ has
  std::optional<Stepping> stepping_;                 ///< from `initialize` on
  participant::Setup setup_;
  solver::Reporting reporting_;
  std::int64_t window_ = 0;
};

}  // namespace ricochet::explicit_solver

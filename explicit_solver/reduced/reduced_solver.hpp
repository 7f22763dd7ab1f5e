#pragma once

#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "common/body/body_state.hpp"
#include "common/participant/participant.hpp"
#include "common/solver/reporting.hpp"
#include "explicit_solver/reduced/reduced_part.hpp"

namespace ricochet::explicit_solver {

/// The explicit elements of its bodies, each body as its lowest modes (`partition.reduced_modes`, ReducedPart). Moved
/// by displacement; it bears any window.
class ReducedSolver : public participant::Participant {
 public:
  /// The last argument is what solvers with a critical step are told.
  ReducedSolver(scene::Problem problem, const std::string& name, std::optional<double> = {});

  participant::Description describe() override;
  void initialize(const participant::Setup& setup, participant::LinkOutput& output) override;
  void synchronise(participant::Integration integration, const std::vector<double>& link_input,
                   participant::LinkOutput& output) override;
  void reconfigure(const participant::Setup& setup) override;
  void advance(std::int64_t window, const std::vector<double>& link_input, participant::LinkOutput& output) override;
  void note_touch(bool closed) override { reporting_.note_touch(closed); }
  void accept() override;
  [[nodiscard]] participant::ContactStatus contact_status() const override { return reporting_.contact_status(); }
  void record(std::vector<double>& row) override;
  void axial_stress(std::vector<double>& row) override { reporting_.append_axial_stress(reported(), window_, row); }
  void probes(std::vector<double>& row) override;
  void write_fields(std::int64_t window) override;
  [[nodiscard]] std::vector<participant::Departure> departures() override { return reporting_.departures(); }
  [[nodiscard]] std::vector<participant::OutlineNode> outline() override { return reporting_.outline(reported()); }
  void finish() override;
  void load_state(const std::vector<double>& state, participant::FrozenContact contact) override;
  void read_state(std::vector<double>& state, std::vector<double>& scale) override;
  std::string save_state() override;
  void restore_state(std::string_view bytes) override;

 private:
  struct State {
    std::int64_t window = 0;
    std::vector<ReducedPart::Motion> motions;
    std::vector<BodyTotals> totals;

    void archive(Archive& a) { a(window, motions, totals); }
  };
  [[nodiscard]] State state() const;
  /// With the motion of the last accepted window.
  const std::vector<solver::BodyState>& reported();
  void set_step();
  void answer(bool of_trial, participant::LinkOutput& output) const;
  template <class Take>
  void share_out(const std::vector<double>& link_input, const Take& take);

  scene::Problem problem_;
  const scene::ParticipantSpec* spec_;
  std::vector<solver::BodyState> states_;
  std::deque<ReducedPart> parts_;  ///< from `initialize` on
  std::int64_t reported_ = -1;     ///< the window whose motion states_ has
  Eigen::VectorXd moved_;          ///< u_b of a part
  participant::Setup setup_;
  solver::Reporting reporting_;
  std::int64_t window_ = 0;
};

}  // namespace ricochet::explicit_solver

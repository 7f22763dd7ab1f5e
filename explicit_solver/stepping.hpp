#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <variant>
#include <vector>

#include "common/body/body_state.hpp"
#include "common/participant/participant.hpp"
#include "explicit_solver/force_driven.hpp"
#include "explicit_solver/motion_driven.hpp"

namespace ricochet::explicit_solver {

/// The windows of the parts that one process steps. How a window goes depends on what the link gives: the shared nodes'
/// displacement (MotionDriven, which also is all-explicit with its contact) or the force on them (ForceDriven).
class Stepping {
 public:
  /// At t = 0. `contact`: enforced here; `states` must outlive this object unmoved.
  Stepping(std::vector<solver::BodyState>& states, const participant::Setup& setup,
           std::optional<ExplicitContact> contact, const MakeForce& make_force = linear_force);
  Stepping(const Stepping&) = delete;
  Stepping& operator=(const Stepping&) = delete;

  void answer(participant::LinkOutput& output) const;
  /// `window`: the accepted one here, the one to come in all others.
  void synchronise(std::int64_t window, const std::vector<double>& link_input);
  /// Between windows: the clock has another size from here on.
  void reconfigure();
  void advance(std::int64_t window, const std::vector<double>& link_input);
  void advance_substep(std::int64_t window, int substep, const std::vector<double>& link_input);
  /// Returns whether that completes a window.
  bool accept(std::int64_t window);
  void work_ahead(std::int64_t window);
  void freeze(participant::FrozenContact contact);

  /// All that the windows to come are computed from, and what was booked so far.
  struct State {
    std::vector<solver::BodyMotion> bodies;
    std::variant<MotionDriven::State, ForceDriven::State> drive;

    void archive(Archive& a) { a(bodies, drive); }
  };
  [[nodiscard]] State state() const;
  void restore(const State& state);

  [[nodiscard]] const std::vector<solver::BodyState>& states() const { return states_; }
  [[nodiscard]] const Eigen::VectorXd& internal(std::size_t part) const;  ///< P(u) [N]
  [[nodiscard]] solver::InternalForce& force(std::size_t part) const;
  [[nodiscard]] ExplicitContact* contact();

 private:
  std::vector<solver::BodyState>& states_;
  std::variant<MotionDriven, ForceDriven> drive_;
};

}  // namespace ricochet::explicit_solver

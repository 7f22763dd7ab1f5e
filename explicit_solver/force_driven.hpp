#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "common/base/window_clock.hpp"
#include "common/participant/participant.hpp"
#include "explicit_solver/explicit_contact.hpp"
#include "explicit_solver/subcycled_window.hpp"

namespace ricochet::explicit_solver {

/// Central difference on parts whose shared nodes are integrated here, too, with the mass of their own elements, and
/// are driven by the force of a dual protocol's interface multiplier, in one or more steps a window (SubcycledWindow);
/// the answer is the shared nodes' motion.
class ForceDriven {
 public:
  /// At t = 0. `states` must outlive this object unmoved.
  ForceDriven(std::vector<solver::BodyState>& states, const participant::Setup& setup, const MakeForce& make_force);

  /// Motion of the shared nodes, of the trial or of the accepted window.
  void answer(participant::LinkOutput& output) const;
  /// `window`: the accepted one here, the one to come in all others.
  void synchronise(std::int64_t window, const std::vector<double>& force);
  /// Between windows: the clock has another size from here on.
  void reconfigure();
  void advance(std::int64_t window, const std::vector<double>& force);
  void advance_substep(std::int64_t window, int substep, const std::vector<double>& force);
  /// With the multiplier held. A coupler that asks for single substeps holds none over the window.
  void work_ahead(std::int64_t window);
  /// Returns whether that completes a window.
  bool accept(std::int64_t window);

  /// With the motion of the bodies all that the next window is computed from.
  struct State {
    std::vector<SubcycledWindow::State> parts;

    void archive(Archive& a) { a(parts); }
  };
  [[nodiscard]] State state() const;
  void restore(const State& state);
  /// From here on the problem is homogeneous: what was booked of loads and reactions is gone.
  void freeze(participant::FrozenContact contact);

  [[nodiscard]] const Eigen::VectorXd& internal(std::size_t part) const { return parts_[part].internal(); }
  [[nodiscard]] solver::InternalForce& force(std::size_t part) const { return parts_[part].elements(); }
  [[nodiscard]] ExplicitContact* contact() { return nullptr; }  ///< the implicit side's

 private:
  void run(double begin_s, int steps, const std::vector<double>& force);
  [[nodiscard]] double begin_s(std::int64_t window) const { return clock_.time_s(window - 1); }
  [[nodiscard]] double step_s() const { return clock_.size_s() / substeps_; }

  std::vector<solver::BodyState>& states_;
  const WindowClock& clock_;
  int substeps_;
  std::vector<SubcycledWindow> parts_;
  Eigen::VectorXd part_force_;  ///< a part's share of the link input: kept so that no window allocates
  int substep_ = 0;             ///< of the trial; 0: whole window
};

}  // namespace ricochet::explicit_solver

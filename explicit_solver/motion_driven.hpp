#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/base/window_clock.hpp"
#include "common/body/body_state.hpp"
#include "common/participant/participant.hpp"
#include "explicit_solver/explicit_contact.hpp"
#include "explicit_solver/linear_force.hpp"

namespace ricochet::explicit_solver {

/// Central difference (common/body/central_difference.hpp) on parts whose shared nodes move as the link says; the
/// answer is P(u) - f there. Without shared nodes, as the only participant, it also enforces the contact.
///
/// Everything of a window that does not need the link is done before it: `predict` has the elements answer to what
/// their own nodes did, with the shared ones where they were (InternalForce::before_link). A trial changes no State: it
/// may be repeated with another link input, or given up.
class MotionDriven {
 public:
  /// At t = 0. `contact`: enforced here; `states` must outlive this object unmoved.
  MotionDriven(std::vector<solver::BodyState>& states, std::optional<ExplicitContact> contact, const WindowClock& clock,
               const MakeForce& make_force);

  /// P at the shared nodes, of the trial or of the accepted window; what is sent is its change, Delta P (Eq. 6).
  void answer(participant::LinkOutput& output) const;
  /// `window`: the accepted one here, the one to come in all others.
  void synchronise(std::int64_t window, const std::vector<double>& link_input);
  /// Between windows: the clock has another size from here on.
  void reconfigure();
  void advance(std::int64_t window, const std::vector<double>& link_input);
  /// Returns whether that completes a window: always.
  bool accept(std::int64_t window);
  void work_ahead(std::int64_t window);

  /// With the motion of the bodies all that the next window is computed from.
  struct State {
    struct Forces {
      Eigen::VectorXd internal, external;  ///< P(u); f, reactions included, at the end of the window [N]
      Eigen::VectorXd left_out;            ///< f - S f of a part that turns and steps locally; else empty

      void archive(Archive& a) { a(internal, external, left_out); }
    };
    std::vector<Forces> parts;
    std::vector<std::string> elements;  ///< per part: what its InternalForce keeps
    std::optional<ExplicitContact::State> contact;
    bool contact_started = false;  ///< the contact has made the accelerations of the first window

    void archive(Archive& a) {
      a(parts);
      for (auto& kept : elements) a.any_size(kept);
      a(contact, contact_started);
    }
  };
  [[nodiscard]] State state() const;
  void restore(const State& state);
  /// From here on the problem is homogeneous: what was booked of loads and reactions is gone.
  void freeze(participant::FrozenContact contact);

  [[nodiscard]] const Eigen::VectorXd& internal(std::size_t part) const { return state_.parts[part].internal; }
  [[nodiscard]] solver::InternalForce& force(std::size_t part) const { return *forces_[part]; }
  [[nodiscard]] ExplicitContact* contact() { return contact_ ? &*contact_ : nullptr; }

 private:
  /// Per part: the window being tried.
  struct Trial {
    Eigen::VectorXd u;     ///< after `accept` the accepted displacement before
    State::Forces forces;  ///< after `accept` the accepted ones before
  };
  /// The time of `state.v` when accelerations are sought.
  enum class Velocity { now, half_a_step_before };
  [[nodiscard]] double dt() const { return clock_.size_s(); }  ///< of the window to come [s]
  void settle_at_start();
  [[nodiscard]] std::vector<int> driven_nodes(std::size_t part) const;
  void predict(std::int64_t window);
  void move_shared(std::size_t part, const std::vector<double>& link_input, std::size_t& next);
  void find_accelerations(double time_s, Velocity velocity);
  void half_a_step(std::size_t part);
  void set_shared_velocity(std::size_t part);
  void account();
  void spread_loads(std::size_t part);
  void spread_load(std::size_t part);
  void account_left_out_loads(double time_s);
  [[nodiscard]] double work_of_left_out(std::size_t part, const Eigen::VectorXd& load) const;
  void account_interface(std::size_t part);
  void keep_trial_forces();

  std::vector<solver::BodyState>& states_;
  const WindowClock& clock_;
  State state_;
  std::optional<ExplicitContact> contact_;
  std::vector<std::unique_ptr<solver::InternalForce>> forces_;  ///< per part
  std::vector<Trial> trials_;
  std::vector<const Eigen::VectorXd*> u_before_, trial_external_;  ///< per part: into trials_
  std::vector<Eigen::VectorXd*> trial_u_;
  std::vector<scene::ExternalForce> left_out_loads_;  ///< per part that does not turn: f - S f; empty if that is 0
  Eigen::VectorXd left_out_load_;                     ///< of one of them, at one time
  bool loads_inside_ = false;                         ///< any of the loads acts inside small steps
  bool predicted_ = false;
  bool answered_with_trial_ = false;  ///< the last link output is of the trial
};

}  // namespace ricochet::explicit_solver

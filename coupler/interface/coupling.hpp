#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/base/window_clock.hpp"
#include "coupler/interface/link.hpp"

namespace ricochet::coupler {

/// Mass of the interface nodes that a participant integrates them with.
enum class Masses {
  summed,  ///< over all participants that share the node (Eq. 28): one motion
  own,     ///< of its own elements: a dual protocol's multipliers couple
};

/// All links of a run and the motion of the shared nodes: what the protocols are written in. Vectors are in the shared
/// numbering, row-major. Interface vectors only: no elements, no materials.
class Coupling {
 public:
  /// Peers in the scene's order of participants, with what they answered to `describe`. Throws as InterfaceMap does.
  Coupling(std::vector<Peer> peers, const std::vector<PeerDescription>& descriptions, WindowClock clock);
  Coupling(const Coupling&) = delete;
  Coupling& operator=(const Coupling&) = delete;

  /// `initialize` to everyone with the summed masses, then the first synchronisation: the start of the primal
  /// protocols. `request`: see Link::post_initialize.
  void initialize(const wire::Initialize& request);
  /// The two halves of it, for protocols that ask the explicit participants something in between. `interface_stiffness`
  /// S [N/m], shared numbering, symmetric: the force on the shared nodes then is what advance_implicit is given plus S
  /// u.
  void initialize_explicit(const wire::Initialize& request, Masses masses);
  void initialize_implicit(wire::Initialize request, Masses masses, Eigen::MatrixXd interface_stiffness = {});
  /// At the present time: the explicit participants take u_Gamma and answer their forces, the implicit one takes their
  /// sum and answers u, v, a; from here on it integrates so.
  void synchronise(Integration integration);
  /// The implicit participant alone, given the whole force [N] of the others on the shared nodes.
  void synchronise_implicit(std::vector<double> force, Integration integration = Integration::implicit_newmark);
  /// Between windows, where the clock has another size for the next one: everyone is told; nothing moves.
  void reconfigure();
  /// The two halves of it; `interface_stiffness`: as of initialize_implicit.
  void reconfigure_explicit();
  void reconfigure_implicit(Eigen::MatrixXd interface_stiffness);
  /// True while the implicit participant integrates as central difference.
  [[nodiscard]] bool all_explicit() const { return all_explicit_; }

  /// u + dt v + (1/2 - beta) dt^2 a of the shared nodes [m], from the last answer of the implicit participant.
  [[nodiscard]] const std::vector<double>& predicted(double beta);
  /// beta of the integration the implicit participant uses now.
  [[nodiscard]] double beta() const { return all_explicit_ ? 0.0 : 0.25; }
  /// Corrected displacement [m] and velocity [m/s] of the shared nodes.
  [[nodiscard]] const std::vector<double>& displacement() const { return displacement_; }
  [[nodiscard]] const std::vector<double>& velocity() const { return velocity_; }
  /// Times and sizes of windows [s], and the size of the next one.
  [[nodiscard]] const WindowClock& clock() const { return clock_; }
  [[nodiscard]] double window_size_s() const { return clock_.size_s(window() + 1); }
  /// Windows to come have this size [s]; `reconfigure` tells the participants.
  void change_window_size(double size_s) { clock_.change(window(), size_s); }
  /// Per row of a link and component, summed over all participants [kg].
  [[nodiscard]] std::vector<double> summed_mass_kg(const Link& link) const;
  /// S of initialize_implicit; empty: none [N/m].
  [[nodiscard]] const Eigen::MatrixXd& interface_stiffness() const { return interface_stiffness_; }

  /// Every explicit participant at once: all are asked before the first is awaited. Returns the sum of their internal
  /// forces at the shared nodes [N], added in the scene's order.
  const std::vector<double>& advance_explicit(const Step& step, const std::vector<double>& displacement,
                                              Acceptance acceptance);
  /// The implicit participant: internal force of all explicit elements in [N], sent as Delta P, new motion of the
  /// shared nodes out.
  void advance_implicit(const Step& step, const std::vector<double>& force,
                        Acceptance acceptance = Acceptance::at_once);
  /// force -= S u, u the present displacement of the shared nodes.
  void subtract_stiffness_force(std::vector<double>& force) const;
  /// Makes the last trial of everyone final.
  void accept(const Step& step);
  /// Participants that have no shared node.
  void advance_alone(const Step& step);

  /// Tells everyone that the last window was the last; returns their answers, in the scene's order.
  std::vector<wire::Finished> finish();

  /// Values in the shared numbering as a link's own rows; valid until the next call.
  const std::vector<double>& rows_of(const Link& link, const std::vector<double>& shared);
  /// All that the next window depends on: the motion of every participant and the absolute input of every link, in the
  /// scene's order. `load_state` also freezes the contact and takes all loads away; vectors of
  /// the size that `read_state` gives. Needs the capability "load_state" of every participant.
  void load_state(const std::vector<double>& state, FrozenContact frozen_contact);
  /// `scale`: what makes each number the root of an energy.
  void read_state(std::vector<double>& state, std::vector<double>& scale);

  /// The state of every participant after the last accepted window, in the scene's order. Needs the capability
  /// "save_state" of each.
  [[nodiscard]] std::vector<std::string> save_states();
  /// Right after the start of another run of the scene: back to where they were saved, and with `archive` this end too.
  void restore_states(const std::vector<std::string>& saved);
  void archive(Archive& a);

  [[nodiscard]] std::vector<Link>& links() { return links_; }
  [[nodiscard]] const std::vector<Link>& links() const { return links_; }
  [[nodiscard]] const InterfaceMap& map() const { return map_; }
  /// The participant that integrates the shared nodes; null in `all_explicit`.
  [[nodiscard]] const Link* implicit_link() const;
  [[nodiscard]] Link* implicit_link();
  /// Contact as its owner reports it; all zero without a contact.
  [[nodiscard]] const wire::ContactReport& contact() const;
  /// The last window that every participant has accepted.
  [[nodiscard]] std::int64_t window() const;
  [[nodiscard]] double largest_drift() const;
  /// Compares the displacements of both sides of the shared nodes; only where both integrate them, driven by force.
  /// Their velocities are tied, and what a tie of velocities leaves open adds up.
  void note_interface_drift();
  [[nodiscard]] double interface_drift_m() const { return interface_drift_m_; }  ///< largest so far

 private:
  [[nodiscard]] std::vector<double> masses_of(const Link& link, Masses masses) const;
  [[nodiscard]] Eigen::MatrixXd own_stiffness() const;
  void take_motion();
  std::vector<Link> links_;
  Link* implicit_ = nullptr;  ///< into links_; null in `all_explicit`
  InterfaceMap map_;
  WindowClock clock_;
  bool all_explicit_ = false, reconfigured_ = false;
  double interface_drift_m_ = 0.0;
  std::vector<std::size_t> state_sizes_;  ///< numbers of each participant's motion, from `read_state`
  std::vector<double> displacement_, velocity_, acceleration_, prediction_, force_, own_;
  Eigen::MatrixXd interface_stiffness_;
};

}  // namespace ricochet::coupler

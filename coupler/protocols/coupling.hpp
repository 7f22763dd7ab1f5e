#pragma once

#include <vector>

#include "coupler/protocols/link.hpp"

namespace ricochet::coupler {

/// All links of a run and the motion of the shared nodes: what the protocols are written in. Vectors are in the shared
/// numbering, row-major. Interface vectors only: no elements, no materials.
class Coupling {
 public:
  /// Links in the scene's order of participants.
  Coupling(std::vector<Link> links, InterfaceMap map, double window_size_s);
  Coupling(const Coupling&) = delete;
  Coupling& operator=(const Coupling&) = delete;

  /// `initialize` to everyone, then the first synchronisation. `request`: see Link::post_initialize.
  void initialize(const wire::Message& request);
  /// At the present time: the explicit participants take u_Gamma and answer their forces, the implicit one takes their
  /// sum and answers u, v, a; from here on it integrates by `integration` ("implicit_newmark" | "explicit_central").
  void synchronise(const std::string& integration);
  /// True while the implicit participant integrates as central difference.
  [[nodiscard]] bool all_explicit() const { return all_explicit_; }

  /// u + dt v + (1/2 - beta) dt^2 a of the shared nodes [m], from the last answer of the implicit participant.
  [[nodiscard]] const std::vector<double>& predicted(double beta);
  /// beta of the integration the implicit participant uses now.
  [[nodiscard]] double beta() const { return all_explicit_ ? 0.0 : 0.25; }
  /// Corrected displacement of the shared nodes [m].
  [[nodiscard]] const std::vector<double>& displacement() const { return displacement_; }

  /// Every explicit participant at once: all are asked before the first is awaited. Returns the sum of their internal
  /// forces at the shared nodes [N], added in the scene's order.
  const std::vector<double>& advance_explicit(const Step& step, const std::vector<double>& displacement,
                                              Acceptance acceptance);
  /// The implicit participant: internal force of all explicit elements in [N], new motion of the shared nodes out.
  void advance_implicit(const Step& step, const std::vector<double>& force);
  /// Participants that have no shared node.
  void advance_alone(const Step& step);

  [[nodiscard]] std::vector<Link>& links() { return links_; }
  [[nodiscard]] const std::vector<Link>& links() const { return links_; }
  [[nodiscard]] const InterfaceMap& map() const { return map_; }
  /// The participant that integrates the shared nodes; null in `all_explicit`.
  [[nodiscard]] const Link* implicit_link() const;
  /// Contact as its owner reports it; all zero without a contact.
  [[nodiscard]] const ContactReport& contact() const;
  /// The last window that every participant has accepted.
  [[nodiscard]] std::int64_t window() const;
  [[nodiscard]] double largest_drift() const;

 private:
  void take_motion();
  std::vector<Link> links_;
  Link* implicit_ = nullptr;  ///< into links_; null in `all_explicit`
  InterfaceMap map_;
  double window_size_s_;
  bool all_explicit_ = false;
  std::vector<double> displacement_, velocity_, acceleration_, prediction_, force_;
};

}  // namespace ricochet::coupler

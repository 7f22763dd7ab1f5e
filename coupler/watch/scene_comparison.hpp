#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "common/problem/problem.hpp"
#include "coupler/interface/link.hpp"

namespace ricochet::coupler {

/// Some participant may have another model of that body: `differing_bodies`.
[[nodiscard]] bool may_differ(const scene::Scene& scene, const std::string& body);

/// Holds the scene's own mesh, elements and densities of a participant against what a program of somebody else's
/// declares and answers in its place. It finds out other masses, other places, another order of the nodes, another
/// stiffness, force of another sign, and substeps that are not taken, before the first window. (FirstWindows finds
/// what time brings to light.)
///
/// Numbers may differ by 1e-3: other quadrature and rounding pass, one percent does not. A body that the scene lists
/// under `differing_bodies` of any participant is left out but for its places; of a foreign one there is nothing to
/// compare with but the places where it is joined and, if the scene gives it, its whole mass. Vectors are in the rows
/// of the participant's interface. Every refusal is a ConfigError that names participant, body and node, what was
/// found, what was expected, and a cause if trying it explains all numbers.
class SceneComparison {
 public:
  /// It describes as many rows as it should, of bodies that it has and with the scene's components. Others
  /// are refused by InterfaceMap.
  [[nodiscard]] static bool possible(const scene::Problem& problem, const PeerDescription& description);
  /// `description`, which must be possible, of a participant of the scene, with its name and role filled in.
  SceneComparison(const scene::Problem& problem, const PeerDescription& description);

  /// Places and own masses of the interface nodes.
  void check_description() const;
  /// Per row the place of the scene's node, n x components [m].
  [[nodiscard]] std::vector<double> scene_places() const;

  /// A change of the link input that is tried, of displacement [m] or force [N]; no two rows are alike.
  [[nodiscard]] std::vector<double> probe(Drive drive) const;
  /// P = K u at the interface after that change of displacement [N]; `change`: of the answer.
  void check_stiffness(const std::vector<double>& probe, const std::vector<double>& change) const;
  /// Driven by force: velocity at the end of a window whose link input rises linearly by the probe, by central
  /// differences in so many steps [m/s].
  void check_window(const std::vector<double>& probe, const std::vector<double>& change, int substeps) const;
  /// For an implicit participant: acceleration -M^-1 L of nodes without contact, at the present time [m/s^2].
  void check_acceleration(const std::vector<double>& probe, const std::vector<double>& change) const;
  /// Has all of that asked of a participant that is synchronised, and leaves it as it was.
  void try_link(Link& link, int substeps) const;

  /// The first row of history: mass and momentum of each body that it tells of.
  void check_first_row(const std::vector<double>& row, Drive drive) const;

 private:
  struct Node {
    int part = -1;   ///< index into `parts_`
    int local = -1;  ///< node of that part
  };
  using Response = std::vector<double>;
  /// Answer of the scene's own elements to a change of link input.
  template <class Respond>
  void compare(const std::string& quantity, const char* unit, const std::vector<double>& probe,
               const std::vector<double>& change, const Respond& respond) const;
  [[nodiscard]] Response internal_force(const std::vector<double>& probe) const;
  [[nodiscard]] Response velocity(const std::vector<double>& probe, int substeps) const;
  [[nodiscard]] Response acceleration(const std::vector<double>& probe) const;
  /// A node of the scene and how far it is.
  struct Near {
    Node node;
    Eigen::Vector3d place_m = Eigen::Vector3d::Zero();
    double distance_m = HUGE_VAL;
  };
  template <class Respond>
  [[nodiscard]] std::string arrangement_cause(const std::vector<double>& found, const std::vector<std::size_t>& rows,
                                              const std::vector<double>& probe, const Respond& respond) const;
  void check_place(std::size_t row) const;
  void check_all_are_there() const;
  void check_whole_mass(const scene::ForeignBody& body, const std::vector<double>& row, Drive drive) const;
  [[nodiscard]] std::vector<std::size_t> rows_of(const std::string& body) const;
  [[nodiscard]] Eigen::Vector3d place_of(std::size_t row) const;
  void check_masses() const;
  void check_masses_of(std::size_t part, const std::vector<std::size_t>& rows) const;
  void check_body(std::size_t part, const std::string& quantity, double found, double expected, double scale,
                  const char* unit) const;
  /// The nearest of the nodes of a body that it shares.
  [[nodiscard]] Near nearest(const std::string& body, const Eigen::Vector3d& x) const;
  [[nodiscard]] const std::string& body_of(std::size_t row) const;
  [[nodiscard]] bool left_out(std::size_t row) const;
  /// By a support, or by the contact; or its mass, summed with that of a foreign body, is not known.
  [[nodiscard]] bool held(std::size_t row, int component) const;
  [[nodiscard]] bool integrates(std::size_t part, int local, Drive drive) const;
  [[nodiscard]] std::string place_text(const Eigen::Vector3d& x) const;
  [[nodiscard]] std::string where(std::size_t row) const;
  [[nodiscard]] std::string advice(int body) const;

  const scene::Problem& problem_;
  PeerDescription description_;
  std::vector<scene::ParticipantPart> parts_;
  std::vector<Eigen::VectorXd> integrated_mass_kg_;  ///< per part and node: own, or summed over participants
  std::vector<std::vector<int>> contact_nodes_;      ///< per part, of an implicit participant: nodes of the whole body
  std::vector<Node> nodes_;                          ///< per interface node
  std::vector<std::string> axes_;                    ///< "x", "y"
  std::size_t components_;
  double place_tolerance_m_;
};

}  // namespace ricochet::coupler

#pragma once

#include <array>
#include <string>
#include <vector>

#include "common/problem/problem.hpp"

/// Whether bodies overlap where no contact holds them apart.
namespace ricochet::scene {

/// Nodes and faces of a mesh that belong to one element only.
struct Outline {
  std::vector<int> nodes;                     ///< of the mesh, ascending
  std::vector<std::array<int, 2>> edges;      ///< in two dimensions; indices into `nodes`
  std::vector<std::array<int, 3>> triangles;  ///< of a solid, quadrilaterals cut in two; likewise
};
[[nodiscard]] Outline outline_of(const fem::Mesh& mesh);

struct BodyPair {
  int first = 0, second = 0;  ///< indices into Problem::bodies, first < second
};
/// All pairs of bodies but those of a contact.
[[nodiscard]] std::vector<BodyPair> pairs_without_contact(const Problem& problem);
/// The contacts of bodies that turn or slide along each other, or of which one reaches out beyond its surface: what
/// lies beside their surfaces may meet, too. None of bodies with a contact with a nose, which the mesh does not have,
/// or with contacts of different initial gaps.
[[nodiscard]] std::vector<const ContactGeometry*> contacts_to_watch(const Problem& problem);

class Columns;
class RigidShape;

/// A body where it has got to. Bars and meshes that repeat across are intervals along the axis.
class Shape {
 public:
  Shape() = default;
  explicit Shape(const BodyProblem& body);

  [[nodiscard]] const Outline& outline() const { return outline_; }
  /// Moves it to its reference plus these displacements of the outline's nodes [m].
  void move(const std::vector<Eigen::Vector3d>& displacement);
  [[nodiscard]] const Eigen::Vector3d& low() const { return low_; }  ///< of the box around it [m]
  [[nodiscard]] const Eigen::Vector3d& high() const { return high_; }
  /// Bodies along this coordinate have ends that others can pass.
  [[nodiscard]] bool counts(int axis) const { return axis >= first_axis_ && axis <= last_axis_; }
  /// Smallest extent of that box that counts [m].
  [[nodiscard]] double thickness() const;
  [[nodiscard]] double shortest_edge() const { return shortest_edge_m_; }

  struct Overlap {
    double depth_m = 0.0;  ///< 0: none
    Eigen::Vector3d place{0.0, 0.0, 0.0};
  };
  /// Largest depth at which a node or the middle of an edge (of a solid: of a triangle) of either lies within the
  /// other; none where it is known to be no more than `tolerance_m`.
  [[nodiscard]] Overlap overlap(const Shape& other, double tolerance_m = 0.0) const;
  /// The place of a node that lies deepest in what is rigid [m].
  [[nodiscard]] const Eigen::Vector3d& deepest(const RigidShape& rigid) const;

 private:
  [[nodiscard]] bool boxes_meet(const Shape& other) const;
  /// The place that is furthest along a direction [m].
  [[nodiscard]] const Eigen::Vector3d& furthest(const Eigen::Vector3d& direction) const;
  [[nodiscard]] bool plane_between(const Shape& other, double tolerance_m) const;
  /// How deep a place lies within, in the plane; <= 0 outside.
  [[nodiscard]] double depth(const Eigen::Vector3d& place) const;
  /// The same of a solid; 0 where it is less than `tolerance_m`.
  [[nodiscard]] double depth_in_solid(const Columns& columns, const Eigen::Vector3d& place, double tolerance_m) const;
  void add_points_within(const Shape& other, double tolerance_m, Overlap& worst) const;

  Outline outline_;
  int first_axis_ = 0, last_axis_ = 1;  ///< coordinates that count
  std::vector<Eigen::Vector3d> reference_, x_;
  Eigen::Vector3d low_{0.0, 0.0, 0.0}, high_{0.0, 0.0, 0.0};
  double shortest_edge_m_ = 0.0;
};

/// A rigid plane, sphere or cylinder that has a contact.
class RigidShape {
 public:
  RigidShape(const Contact& contact, const ContactGeometry& geometry, const fem::Mesh& mesh_a);

  /// How deep a place lies within; negative outside [m].
  [[nodiscard]] double depth_m(const Eigen::Vector3d& place) const;

 private:
  double radius_m_ = 0.0;  ///< 0: a plane
  /// A plane's normal, a cylinder's axis; zero of a sphere.
  Eigen::Vector3d direction_;
  Eigen::Vector3d place_m_;  ///< in the plane; the middle of what is round
};

/// Depth of an overlap from which on it is one, and no round-off or rim of bodies that touch [m].
[[nodiscard]] double overlap_tolerance(const Shape& a, const Shape& b);
/// The same of bodies with a contact, which holds nodes of smooth surfaces apart, and not all that is between them.
[[nodiscard]] double overlap_tolerance(const Shape& a, const Shape& b, const Contact& law,
                                       const ContactGeometry& contact);

}  // namespace ricochet::scene

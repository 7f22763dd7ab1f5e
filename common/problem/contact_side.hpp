#pragma once

#include <Eigen/Core>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "common/problem/build.hpp"

/// One side of a contact: which nodes a surface has, their areas and normals, and where it lies. Internal to
/// common/problem.
namespace ricochet::scene {

inline constexpr double flat_tolerance = 1e-6;  ///< of the shortest edge; also of a unit normal
/// Chords of curved surfaces may cut each other by this share of the shortest edge.
inline constexpr double chord_tolerance = 0.05;
inline constexpr double patch_angle = std::numbers::pi / 4.0;

/// The contact that is being built: for the texts of errors and the keys of the contact.
struct ContactContext {
  const Scene& scene;
  const Contact& contact;

  [[nodiscard]] std::string key(const char* of) const { return contact.key() + "." + of; }
  [[noreturn]] void refuse(const std::string& found, const std::string& allowed) const;  ///< a ConfigError
};

/// Nodes sorted along the surface, their tributary areas, and where the surface lies.
struct ContactSide {
  std::string name;
  const BodyProblem* body = nullptr;
  std::vector<int> nodes;
  std::vector<double> area_m2;
  Eigen::Vector3d normal{0.0, 0.0, 0.0};  ///< outward, the mean of a curved surface
  Eigen::Vector3d point{0.0, 0.0, 0.0};   ///< farthest out along it
  double shortest_edge_m = std::numeric_limits<double>::infinity();
  bool flat = true;

  [[nodiscard]] const Eigen::Vector3d& position(std::size_t i) const { return body->mesh.position[at(nodes[i])]; }
  [[nodiscard]] const std::vector<fem::Face>& faces() const {
    return body->mesh.surfaces.at(name.substr(name.find('.') + 1));
  }
};

/// `normal`: of a curved surface or a placed plane, if it is given; `of_all_ways`: of one whose normals cancel, as
/// those of a whole circle do, that is refused without.
[[nodiscard]] ContactSide make_side(const ContactContext& context, const std::vector<BodyProblem>& bodies,
                                    const SurfaceName& name, const std::vector<double>& normal,
                                    const std::optional<Eigen::Vector3d>& of_all_ways = std::nullopt);

/// Whether a contact is with a rigid plane that has a place and a normal of its own.
[[nodiscard]] bool with_placed_plane(const Contact& contact);

/// A place on a side, for the texts of errors.
[[nodiscard]] std::string place_on(const ContactSide& side, const Eigen::Vector3d& x);

/// Areas as face_area has them. A surface is cut where two faces turn by more than `patch_angle` against each other;
/// each piece has normals of its own: those of a sphere where its corners lie on one (Max 1999), at its rim from the
/// nodes inside, on a plane of symmetry, which holds the node, and on an axis in it.
[[nodiscard]] std::vector<surface::SurfaceFace> faces_of(const ContactSide& side);

/// Displacement along the normal at t = 0.
[[nodiscard]] double initial_motion(const ContactSide& side, int node, const Eigen::Vector3d& normal);
[[nodiscard]] bool held_along(const ContactSide& side, int node, const Eigen::Vector3d& normal);

/// The vector of these components, of which there are at most three; the others are 0.
[[nodiscard]] Eigen::Vector3d in_space(const std::vector<double>& components);
/// Initial velocity of the second body against the first [m/s]; `b` is null for what is rigid and rests.
[[nodiscard]] Eigen::Vector3d closing_velocity(const Scene& scene, const ContactSide& a, const ContactSide* b);
/// Something moves the bodies across `normal`, along each other, from the start, or may. `b` is null for what is rigid.
[[nodiscard]] bool may_slide(const Scene& scene, const ContactSide& a, const ContactSide* b,
                             const Eigen::Vector3d& normal);

}  // namespace ricochet::scene

#include "common/problem/drawn_obstacles.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace ricochet::scene {
namespace {

using Eigen::Vector3d;

constexpr int segments = 48;

/// Where the pairs of a contact lie.
struct Reach {
  Vector3d middle{0.0, 0.0, 0.0};
  double half_m = 0.0;  ///< half of what an obstacle in their way is drawn with
  double farthest_radius_m = 0.0;
};

/// A hanging node has no place of its own.
Vector3d own_place(const Problem& problem, const ContactGeometry& contact, const ContactPair& pair) {
  Vector3d place(0.0, 0.0, 0.0);
  for (const auto& node : own_nodes(pair))
    place += node.weight * problem.bodies[fem::at(contact.body_a)].mesh.position[fem::at(node.node)];
  return place;
}

Reach reach_of(const Problem& problem, const ContactGeometry& contact) {
  Eigen::AlignedBox3d surface, body;
  for (const auto& pair : contact.pairs) surface.extend(own_place(problem, contact, pair));
  for (const auto& x : problem.bodies[fem::at(contact.body_a)].mesh.position) body.extend(x);
  const double whole_m = body.sizes().maxCoeff();
  return {surface.center(), 0.6 * std::max(surface.sizes().maxCoeff(), 0.2 * whole_m), surface.max()[0]};
}

class Drawing {
 public:
  Drawing(const Problem& problem, std::size_t contact)
      : geometry_(problem.contacts[contact]),
        contact_(problem.scene.contacts[contact]),
        model_(problem.scene.model),
        reach_(reach_of(problem, geometry_)) {
    const auto& pair = geometry_.pairs.front();
    plane_m_ = own_place(problem, geometry_, pair).dot(normal()) + pair.gap0_m;
    for (const auto& other : geometry_.pairs)
      plane_m_ = std::min(plane_m_, own_place(problem, geometry_, other).dot(normal()) + other.gap0_m);
    const double own_strip_m = std::sqrt(problem.bodies[fem::at(geometry_.body_a)].section.measure);
    drawn_.strip_m = model_ == Model::bar ? 3.0 * own_strip_m : 0.0;
  }

  DrawnObstacle draw() {
    const char* const what = !geometry_.round                        ? "rigid plane"
                             : contact_.obstacle == Obstacle::sphere ? "rigid sphere"
                                                                     : "rigid cylinder";
    drawn_.name = contact_.name.empty() ? what : fmt::format("{} of {}", what, contact_.name);
    if (model_ == Model::bar) {
      add(plane_m_ * normal());
      add((plane_m_ + thickness_m()) * normal());
      drawn_.cells.push_back({0, 1, -1, -1});
    } else if (!geometry_.round) {
      model_ == Model::solid ? draw_slab() : draw_plate();
    } else if (model_ != Model::solid) {
      draw_arc();
    } else {
      contact_.obstacle == Obstacle::sphere ? draw_cap() : draw_shell();
    }
    return std::move(drawn_);
  }

 private:
  [[nodiscard]] const Vector3d& normal() const { return geometry_.normal; }
  [[nodiscard]] double thickness_m() const { return 0.1 * reach_.half_m; }
  [[nodiscard]] Vector3d along() const { return tangent_of(normal()); }

  int add(Vector3d x) {
    if (model_ == Model::axisymmetric) x[0] = std::max(x[0], 0.0);
    drawn_.place.push_back(x);
    return static_cast<int>(drawn_.place.size()) - 1;
  }
  /// Quadrilaterals between two rows of nodes that begin at these.
  void join(int row, int next, int count) {
    for (int i = 0; i < count; ++i) drawn_.cells.push_back({row + i, row + i + 1, next + i + 1, next + i});
  }

  /// The place of the plane that is nearest to the middle of the surface.
  [[nodiscard]] Vector3d foot() const { return reach_.middle + (plane_m_ - reach_.middle.dot(normal())) * normal(); }

  void draw_plate() {
    Vector3d from = foot() - reach_.half_m * along(), to = foot() + reach_.half_m * along();
    if (model_ == Model::axisymmetric) {  // a disc about the axis
      for (Vector3d* end : {&from, &to}) (*end)[0] = end->x() > reach_.middle[0] ? 1.2 * reach_.farthest_radius_m : 0.0;
    }
    for (const double depth_m : {0.0, thickness_m()}) {
      add(from + depth_m * normal());
      add(to + depth_m * normal());
    }
    join(0, 2, 1);
  }

  void draw_slab() {
    const Vector3d t = reach_.half_m * along(), b = normal().cross(t);
    for (const double depth_m : {0.0, thickness_m()}) {
      const Vector3d middle = foot() + depth_m * normal();
      for (const Vector3d& corner : {Vector3d(-t - b), Vector3d(t - b), Vector3d(t + b), Vector3d(-t + b)})
        add(middle + corner);
    }
    drawn_.cells = {{0, 1, 2, 3}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
  }

  /// Half of the angle that is drawn, a little less than half of the round.
  [[nodiscard]] double half_angle() const {
    return std::min(0.999 * std::numbers::pi, 1.2 * reach_.half_m / contact_.rigid_radius_m);
  }

  void draw_arc() {
    const double radius_m = contact_.rigid_radius_m, inner_m = radius_m - std::min(0.5 * radius_m, thickness_m());
    const bool half = model_ == Model::axisymmetric;
    const Vector3d middle = geometry_.middle_m, across = (half && along()[0] < 0.0 ? -1.0 : 1.0) * along();
    for (const double r_m : {radius_m, inner_m}) {
      for (int i = 0; i <= segments; ++i) {
        const double share = static_cast<double>(i) / segments,
                     angle = half_angle() * (half ? share : 2.0 * share - 1.0);
        add(middle + r_m * (-std::cos(angle) * normal() + std::sin(angle) * across));
      }
    }
    join(0, segments + 1, segments);
  }

  void draw_cap() {
    const Vector3d middle = geometry_.middle_m, t = along(), b = normal().cross(t);
    const double radius_m = contact_.rigid_radius_m;
    constexpr int rings = segments / 2;
    const int pole = add(middle - radius_m * normal());
    for (int ring = 1; ring <= rings; ++ring) {
      const double polar = half_angle() * ring / rings;
      const int row = static_cast<int>(drawn_.place.size());
      for (int i = 0; i < segments; ++i) {
        const double azimuth = 2.0 * std::numbers::pi * i / segments;
        add(middle + radius_m * (-std::cos(polar) * normal() +
                                 std::sin(polar) * (std::cos(azimuth) * t + std::sin(azimuth) * b)));
      }
      for (int i = 0; i < segments; ++i) {
        const int next = (i + 1) % segments;
        if (ring == 1)
          drawn_.cells.push_back({pole, row + i, row + next, -1});
        else
          drawn_.cells.push_back({row - segments + i, row - segments + next, row + next, row + i});
      }
    }
  }

  void draw_shell() {
    const Vector3d axis = Vector3d::Unit(contact_.rigid_axis), across = axis.cross(normal());
    Vector3d middle = geometry_.middle_m;
    middle[contact_.rigid_axis] = reach_.middle[contact_.rigid_axis];
    for (const double side : {-1.0, 1.0}) {
      for (int i = 0; i <= segments; ++i) {
        const double angle = half_angle() * (2.0 * i / segments - 1.0);
        add(middle + side * reach_.half_m * axis +
            contact_.rigid_radius_m * (-std::cos(angle) * normal() + std::sin(angle) * across));
      }
    }
    join(0, segments + 1, segments);
  }

  const ContactGeometry& geometry_;
  const Contact& contact_;
  Model model_;
  Reach reach_;
  double plane_m_ = 0.0;  ///< of the plane along the normal
  DrawnObstacle drawn_{};
};

}  // namespace

std::vector<DrawnObstacle> drawn_obstacles(const Problem& problem) {
  std::vector<DrawnObstacle> drawn;
  for (std::size_t i = 0; i < problem.contacts.size(); ++i) {
    const auto& contact = problem.contacts[i];
    if (contact.body_b < 0 && contact.body_a >= 0 && !contact.pairs.empty())
      drawn.push_back(Drawing(problem, i).draw());
  }
  return drawn;
}

}  // namespace ricochet::scene

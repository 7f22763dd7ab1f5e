#include "common/problem/rigid_obstacle.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "common/base/error.hpp"
#include "common/problem/contact_pairs.hpp"

namespace ricochet::scene {
namespace {

/// Each node's distance is measured along the plane's normal.
std::vector<ContactPair> placed_plane_pairs(const ContactContext& context, const ContactSide& side) {
  const Eigen::Vector3d place = in_space(context.contact.rigid_place_m);
  std::vector<ContactPair> pairs;
  for (std::size_t i = 0; i < side.nodes.size(); ++i) {
    pairs.push_back({.node_a = side.nodes[i], .b = {}, .normal = side.normal, .area_m2 = side.area_m2[i]});
    const double gap_m = (place - side.position(i)).dot(side.normal);
    if (gap_m < -flat_tolerance * side.shortest_edge_m)
      context.refuse(fmt::format("a node of \"{}\" {:.6g} m behind the rigid plane, at {}", side.name, -gap_m,
                                 place_on(side, side.position(i))),
                     "a plane in front of all of them: another rigid_place_m or normal");
    complete(context.contact, side.body->mesh, std::max(gap_m, 0.0), pairs.back());
  }
  return pairs;
}

std::vector<ContactPair> plane_pairs(const ContactContext& context, const ContactSide& side) {
  std::vector<ContactPair> pairs;
  for (std::size_t i = 0; i < side.nodes.size(); ++i) {
    pairs.push_back({.node_a = side.nodes[i], .b = {}, .normal = side.normal, .area_m2 = side.area_m2[i]});
    const double apart_m = side.flat ? 0.0 : (side.point - side.position(i)).dot(side.normal);
    complete(context.contact, side.body->mesh, apart_m + context.contact.initial_gap_m, pairs.back());
  }
  return pairs;
}

/// A direction along which a cylinder goes on; of a sphere zero.
Eigen::Vector3d axis_of(const ContactContext& context, const ContactSide& side) {
  const Contact& contact = context.contact;
  if (contact.obstacle == Obstacle::sphere) return Eigen::Vector3d::Zero();
  const bool solid = context.scene.model == Model::solid;
  const Eigen::Vector3d axis = Eigen::Vector3d::Unit(solid ? contact.rigid_axis : 2);
  if (std::abs(axis.dot(side.normal)) > flat_tolerance)
    throw ConfigError(
        fmt::format("{}: found an axis that is not along surface \"{}\"; allowed: a cylinder that lies on it",
                    context.scene.where(context.key("rigid_axis")), side.name));
  return axis;
}

/// From a node to the middle of the obstacle as long as that is at rigid_place_m itself.
struct WayToMiddle {
  double rise_m = 0.0;                     ///< along the normal
  Eigen::Vector3d along_m{0.0, 0.0, 0.0};  ///< along the surface
  double depth_m = 0.0;                    ///< how far the obstacle reaches back from its middle towards the node
};

/// None where the node misses the obstacle on its way along the normal.
std::optional<WayToMiddle> way_to_middle(const ContactContext& context, const ContactSide& side, std::size_t node,
                                         const Eigen::Vector3d& axis) {
  const Eigen::Vector3d place = in_space(context.contact.rigid_place_m);
  Eigen::Vector3d way = place - fem::nearest_image(side.body->mesh, side.position(node), place);
  way -= axis.dot(way) * axis;
  WayToMiddle found{side.normal.dot(way), {}, 0.0};
  found.along_m = way - found.rise_m * side.normal;
  const double radius_m = context.contact.rigid_radius_m, square = radius_m * radius_m - found.along_m.squaredNorm();
  if (!(square > 0.0)) return std::nullopt;
  found.depth_m = std::sqrt(square);
  return found;
}

/// The obstacle is moved along the surface's normal to where it touches. There each node has the normal to its nearest
/// place on the obstacle, and the distance to it; the initial gap lifts the obstacle off along the surface's normal.
void set_round_pairs(const ContactContext& context, const ContactSide& side, ContactGeometry& geometry) {
  const Contact& contact = context.contact;
  const Eigen::Vector3d axis = axis_of(context, side);
  std::vector<std::optional<WayToMiddle>> ways;
  double lift_m = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < side.nodes.size(); ++i) {
    ways.push_back(way_to_middle(context, side, i, axis));
    if (ways.back()) lift_m = std::max(lift_m, ways.back()->depth_m - ways.back()->rise_m);
  }
  std::vector<ContactPair>& pairs = geometry.pairs;
  for (std::size_t i = 0; i < side.nodes.size(); ++i) {
    if (!ways[i]) continue;
    const Eigen::Vector3d to_middle = ways[i]->along_m + (ways[i]->rise_m + lift_m) * side.normal;
    const double far_m = to_middle.norm();
    pairs.push_back({.node_a = side.nodes[i], .b = {}, .normal = to_middle / far_m, .area_m2 = side.area_m2[i]});
    ContactPair& pair = pairs.back();
    pair.distance_m = side.position(i)[0];
    pair.gap0_m = far_m - contact.rigid_radius_m + contact.initial_gap_m * pair.normal.dot(side.normal);
    geometry.middle_m = side.position(i) + to_middle + contact.initial_gap_m * side.normal;
  }
  if (pairs.empty())
    context.refuse(fmt::format("no node of surface \"{}\" within {:.6g} m, the radius, of the middle of the obstacle",
                               side.name, contact.rigid_radius_m),
                   "an obstacle in the way of the surface: another rigid_place_m or a finer mesh");
}

/// A pair keeps its place on the obstacle.
void refuse_sliding(const ContactContext& context, const ContactSide& side) {
  if (context.scene.model == Model::axisymmetric || !may_slide(context.scene, side, nullptr, side.normal)) return;
  context.refuse(fmt::format("body \"{}\", which may slide along a rigid sphere or cylinder by its initial velocity, "
                             "gravity, a traction, a prescribed displacement or large_rotation",
                             side.body->name),
                 "motion and loads along the contact normal there; a rigid plane, or a body with a curved surface");
}

}  // namespace

void set_rigid_pairs(const ContactContext& context, const ContactSide& side, ContactGeometry& geometry) {
  geometry.round = context.contact.obstacle != Obstacle::plane;
  if (!geometry.round) {
    geometry.pairs =
        with_placed_plane(context.contact) ? placed_plane_pairs(context, side) : plane_pairs(context, side);
    return;
  }
  require_matching(context, {fmt::format("those of \"{}\" against what is round", side.name)});
  refuse_sliding(context, side);
  set_round_pairs(context, side, geometry);
}

}  // namespace ricochet::scene

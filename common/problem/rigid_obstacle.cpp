#include "common/problem/rigid_obstacle.hpp"

#include "common/problem/contact_pairs.hpp"

namespace ricochet::scene {

std::vector<ContactPair> rigid_pairs(const ContactContext& context, const ContactSide& side) {
  std::vector<ContactPair> pairs;
  for (std::size_t i = 0; i < side.nodes.size(); ++i) {
    pairs.push_back({.node_a = side.nodes[i], .b = {}, .normal = side.normal, .area_m2 = side.area_m2[i]});
    const double apart_m = side.flat ? 0.0 : (side.point - side.position(i)).dot(side.normal);
    complete(context.contact, side.body->mesh, apart_m, pairs.back());
  }
  return pairs;
}

}  // namespace ricochet::scene

#include "common/contact/contact_rows.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>

#include "common/base/error.hpp"

namespace ricochet::solver {
namespace {

/// A node of one of the parts, and its share in its side.
struct PartNode {
  int part, node;
  Side side;
  double weight;
};

PartNode find_node(const std::vector<PartNodes>& parts, int body, int body_node, Side side, double weight) {
  for (std::size_t p = 0; p < parts.size(); ++p) {
    if (parts[p].body != body) continue;
    const auto& nodes = *parts[p].body_node;
    const auto found = std::lower_bound(nodes.begin(), nodes.end(), body_node);
    if (found != nodes.end() && *found == body_node)
      return {static_cast<int>(p), static_cast<int>(found - nodes.begin()), side, weight};
  }
  throw ConfigError("contact node " + std::to_string(body_node) + " belongs to no part of the contact's owner");
}

ContactRow row_of_nodes(const std::vector<PartNode>& nodes, const Eigen::Vector3d& direction, int components) {
  ContactRow row;
  for (int c = 0; c < components; ++c) {
    if (direction[c] == 0.0) continue;
    for (const auto& n : nodes) {
      row.entries.push_back(
          {n.part, n.node * components + c, n.weight * (n.side == Side::b ? direction[c] : -direction[c]), n.side});
    }
  }
  return row;
}

/// Columns n, t, b.
Eigen::Matrix3d axes_of(const Eigen::Vector3d& normal) {
  const Eigen::Vector3d tangent = scene::tangent_of(normal);
  Eigen::Matrix3d axes;
  axes << normal, tangent, normal.cross(tangent);
  return axes;
}

/// The first surface's node lies on a plane of symmetry, where a support holds it along `direction`, and so does the
/// second surface: it ends there, held as well. The row of the whole bodies has as much of it beyond the plane, which
/// slips the other way: along `direction` nothing slips and there is no friction.
bool ends_at_symmetry(const scene::Problem& problem, const scene::ContactGeometry& geometry,
                      const scene::ContactPair& pair, const Eigen::Vector3d& direction) {
  constexpr double tolerance = 1e-9;
  Eigen::Index c = 0;
  if (pair.b.size() < 2 || direction.cwiseAbs().maxCoeff(&c) < 1.0 - tolerance) return false;
  const auto held = [&](int body, int node) {
    return scene::is_still(problem.bodies[static_cast<std::size_t>(body)],
                           node * problem.scene.components() + static_cast<int>(c));
  };
  const auto place = [&](int body, int node) {
    return problem.bodies[static_cast<std::size_t>(body)].mesh.position[static_cast<std::size_t>(node)][c];
  };
  if (!held(geometry.body_a, pair.node_a)) return false;
  const double plane = place(geometry.body_a, pair.node_a);
  double low = 0.0, high = 0.0;
  for (const auto& [node, weight] : pair.b) {
    low = std::min(low, place(geometry.body_b, node) - plane);
    high = std::max(high, place(geometry.body_b, node) - plane);
  }
  const double near = tolerance * (high - low);
  return std::min(high, -low) <= near && std::any_of(pair.b.begin(), pair.b.end(), [&](const auto& b) {
           return held(geometry.body_b, b.node) && std::abs(place(geometry.body_b, b.node) - plane) <= near;
         });
}

Turn turn_of(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  if (from == to) return {};
  return {true, axes_of(to).transpose() * axes_of(from)};
}

/// The force that acts on B in the scene's directions, on the body that the scene names second: that may be A.
Turn turn_to_named(const scene::ContactGeometry& geometry, const Eigen::Vector3d& from) {
  Turn turn = turn_of(from, geometry.named_normal);
  if (geometry.second_named_first) turn = {true, -axes_of(geometry.named_normal).transpose() * axes_of(from)};
  return turn;
}

}  // namespace

Pair pair_of(const scene::Problem& problem, std::size_t contact, const scene::ContactPair& pair,
             const std::vector<PartNodes>& parts) {
  const auto& geometry = problem.contacts[contact];
  const int components = problem.scene.components();
  const Eigen::Vector3d tangent = scene::tangent_of(pair.normal);
  const Eigen::Vector3d binormal = components == 3 ? pair.normal.cross(tangent) : Eigen::Vector3d::Zero();
  std::vector<PartNode> nodes;
  for (const auto& [node, weight] : pair.b) nodes.push_back(find_node(parts, geometry.body_b, node, Side::b, weight));
  for (const auto& [node, weight] : scene::own_nodes(pair))
    nodes.push_back(find_node(parts, geometry.body_a, node, Side::a, weight));
  Turn to_contact = turn_to_named(geometry, pair.normal);
  if (problem.scene.model == scene::Model::axisymmetric) to_contact.matrix(1, 0) = 0.0;
  const auto along = [&](const Eigen::Vector3d& direction) {
    return ends_at_symmetry(problem, geometry, pair, direction) ? ContactRow{}
                                                                : row_of_nodes(nodes, direction, components);
  };
  return {.normal = row_of_nodes(nodes, pair.normal, components),
          .tangent = along(tangent),
          .binormal = along(binormal),
          .gap0_m = pair.gap0_m,
          .area_m2 = pair.area_m2,
          .friction_coefficient = problem.scene.contacts[contact].friction_coefficient,
          .contact = contact,
          .node_a = pair.node_a,
          .patch = pair.patch,
          .to_contact = to_contact,
          .to_momentum = turn_of(pair.normal, scene::momentum_normal(problem))};
}

std::vector<Pair> contact_rows(const scene::Problem& problem, const std::vector<PartNodes>& parts) {
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < problem.contacts.size(); ++i) {
    for (const auto& pair : problem.contacts[i].pairs) pairs.push_back(pair_of(problem, i, pair, parts));
  }
  return pairs;
}

std::vector<Pair> contact_rows(const scene::Problem& problem, const std::vector<BodyState>& states) {
  std::vector<PartNodes> nodes;
  for (const auto& state : states) nodes.push_back({state.body, &state.part.body_node});
  return contact_rows(problem, nodes);
}

double ContactRow::inverse_mass(const std::vector<BodyState>& states) const {
  return inverse_mass_of(Side::a, states) + inverse_mass_of(Side::b, states);
}

double ContactRow::inverse_mass_of(Side side, const std::vector<BodyState>& states) const {
  double sum = 0.0;
  for (const auto& e : entries) {
    if (e.side != side) continue;
    sum += e.coefficient * e.coefficient * states[static_cast<std::size_t>(e.part)].inverse_mass[e.dof];
  }
  return sum;
}

Eigen::Matrix2d Pair::inverse_mass_along(const std::vector<BodyState>& states) const {
  Eigen::Matrix2d inverse = Eigen::Matrix2d::Zero();
  inverse(0, 0) = tangent.inverse_mass(states);
  inverse(1, 1) = binormal.inverse_mass(states);
  return inverse;
}

bool ContactRow::has(Side side) const { return part_of(side) >= 0; }

int ContactRow::part_of(Side side) const {
  for (const auto& e : entries) {
    if (e.side == side) return e.part;
  }
  return -1;
}

namespace {

void take_from_supports(const ContactRow& row, double given_n_s, std::vector<BodyState>& states) {
  if (given_n_s == 0.0) return;
  for (const auto& e : row.entries) {
    auto& state = states[static_cast<std::size_t>(e.part)];
    if (state.free[static_cast<std::size_t>(e.dof)]) continue;
    const double on_support = e.coefficient * given_n_s;
    const int c = e.dof % fem::components(state.part.mesh.model);
    state.totals.impulse_n_kg_m_s -= state.normal[c] * on_support;
    state.totals.impulse_t_kg_m_s -= state.tangent[c] * on_support;
    state.totals.impulse_b_kg_m_s -= state.binormal[c] * on_support;
  }
}

}  // namespace

void book_without_moments(const Pair& pair, double normal_n_s, const Eigen::Vector2d& tangential_n_s,
                          std::vector<BodyState>& states, ContactImpulses& impulses) {
  impulses[pair.contact].of_normal += pair.to_contact(normal_n_s, Eigen::Vector2d::Zero());
  impulses[pair.contact].of_friction += pair.to_contact(0.0, tangential_n_s);
  take_from_supports(pair.normal, normal_n_s, states);
  take_from_supports(pair.tangent, tangential_n_s[0], states);
  take_from_supports(pair.binormal, tangential_n_s[1], states);
  if (pair.normal.has(Side::b)) return;
  auto& state = states[static_cast<std::size_t>(pair.normal.part_of(Side::a))];
  const Eigen::Vector3d given = pair.to_momentum(normal_n_s, tangential_n_s);
  state.totals.impulse_n_kg_m_s -= given[0];
  state.totals.impulse_t_kg_m_s -= given[1];
  state.totals.impulse_b_kg_m_s -= given[2];
}

}  // namespace ricochet::solver

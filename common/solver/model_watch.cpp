#include "common/solver/model_watch.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

#include "common/solver/element_motion.hpp"

namespace ricochet::solver {
namespace {

using Kind = participant::DepartureKind;

/// Share of an edge up to which a gap is no gap.
constexpr double closed_share = 1e-6;
/// Nodes that move against each other by less than this share of the shortest edge cannot invert an element.
constexpr double safe_share = 0.2;

/// Per node of a solid's surface its shortest edge there [m].
std::map<int, double> shortest_edges(const fem::Mesh& mesh, const std::string& surface) {
  std::map<int, double> shortest;
  for (const fem::Face& face : mesh.surfaces.at(surface)) {
    for (std::size_t i = 0; i < face.size(); ++i) {
      const int a = face[i], b = face[(i + 1) % face.size()];
      const double length = (mesh.position[fem::at(b)] - mesh.position[fem::at(a)]).norm();
      for (const int node : {a, b}) {
        const auto entry = shortest.insert({node, length}).first;
        entry->second = std::min(entry->second, length);
      }
    }
  }
  return shortest;
}

/// Per node the smallest extent along the normal of the elements there [m].
std::vector<double> depths(const fem::Mesh& mesh, const Eigen::Vector3d& normal) {
  std::vector<double> depth_m(mesh.position.size(), std::numeric_limits<double>::infinity());
  for (int e = 0; e < static_cast<int>(mesh.elements.size()); ++e) {
    const double own_m = fem::extent_along(fem::element_geometry(mesh, e), normal);
    for (const int node : mesh.elements[fem::at(e)]) {
      depth_m[static_cast<std::size_t>(node)] = std::min(depth_m[static_cast<std::size_t>(node)], own_m);
    }
  }
  return depth_m;
}

}  // namespace

ModelWatch::ModelWatch(const scene::Problem& problem, const std::vector<BodyState>& states,
                       const ContactSurface* surface, bool windows_are_cheap)
    : surface_(surface),
      stress_(states),
      stress_every_(windows_are_cheap && problem.scene.model != scene::Model::bar ? stress_every : 1) {
  prepare_elements(states);
  if (!surface_) return;
  rows_ = surface_->pairs;
  prepare_pairs(problem);
}

void ModelWatch::prepare_elements(const std::vector<BodyState>& states) {
  for (const auto& state : states) {
    auto& elements = elements_.emplace_back();
    const auto& mesh = state.part.mesh;
    for (int e = 0; e < static_cast<int>(mesh.elements.size()); ++e) {
      const fem::ElementGeometry geometry = fem::element_geometry(mesh, e);
      Element element;
      element.shortest_edge_m = fem::edge_lengths(geometry).shortest;
      element.inverse_diagonals = inverse_diagonals(geometry);
      elements.push_back(element);
    }
  }
}

void ModelWatch::prepare_pairs(const scene::Problem& problem) {
  for (std::size_t i = 0; i < problem.contacts.size(); ++i) {
    const auto& named = problem.scene.contacts[i];
    prepare_pairs(problem, problem.contacts[i],
                  problem.contacts[i].second_named_first ? named.second->surface : named.first.surface);
  }
}

void ModelWatch::prepare_pairs(const scene::Problem& problem, const scene::ContactGeometry& contact,
                               const std::string& first_surface) {
  const auto& body_a = problem.bodies[static_cast<std::size_t>(contact.body_a)];
  const Eigen::Vector3d tangent = scene::tangent_of(contact.normal), binormal = contact.normal.cross(tangent);
  Stretch& stretch = stretches_.emplace_back();
  stretch.begin = pairs_.size();
  stretch.places_differ = contact.body_b >= 0 || contact.round;
  stretch.follows = contact.sliding != nullptr;
  for (const auto& pair : contact.pairs) {
    const auto& x = body_a.mesh.position[static_cast<std::size_t>(pair.node_a)];
    pairs_.push_back({{tangent.dot(x), binormal.dot(x)},
                      std::numeric_limits<double>::infinity(),
                      std::numeric_limits<double>::infinity(),
                      x});
  }
  stretch.end = pairs_.size();
  set_ends(body_a.mesh, contact, first_surface, stretch);
  for (const bool first : {true, false}) {
    const int body = first ? contact.body_a : contact.body_b;
    if (body < 0) continue;
    const auto depth_m = depths(problem.bodies[static_cast<std::size_t>(body)].mesh, contact.normal);
    for (std::size_t i = stretch.begin; i < stretch.end; ++i) {
      const auto take = [&](int node) {
        pairs_[i].depth_m = std::min(pairs_[i].depth_m, depth_m[static_cast<std::size_t>(node)]);
      };
      const auto& pair = contact.pairs[i - stretch.begin];
      if (first) take(pair.node_a);
      for (const auto& opposite : pair.b) {
        if (!first) take(opposite.node);
      }
    }
  }
  for (std::size_t i = stretch.begin; i < stretch.end; ++i) {
    if (!std::isfinite(pairs_[i].edge_m)) pairs_[i].edge_m = pairs_[i].depth_m;  // the one pair of two bars
  }
}

/// And the edges beside each pair.
void ModelWatch::set_ends(const fem::Mesh& mesh, const scene::ContactGeometry& contact,
                          const std::string& first_surface, Stretch& stretch) {
  const int directions = surface_->components - 1;
  const bool ended = contact.body_b >= 0 && contact.matching && mesh.period_m == 0.0;
  std::vector<std::size_t> order(stretch.end - stretch.begin);
  std::iota(order.begin(), order.end(), stretch.begin);
  for (std::size_t k = 0; k < static_cast<std::size_t>(directions); ++k) {
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t i, std::size_t j) { return pairs_[i].along_m[k] < pairs_[j].along_m[k]; });
    if (ended) stretch.ends.push_back({order.front(), order.back()});
  }
  if (directions == 0) return;
  const auto edges = shortest_edges(mesh, first_surface);
  for (std::size_t i = stretch.begin; i < stretch.end; ++i)
    pairs_[i].edge_m = edges.at(contact.pairs[i - stretch.begin].node_a);
}

void ModelWatch::look(std::int64_t window, const std::vector<BodyState>& states,
                      const std::vector<BodyState>& of_surface, bool last) {
  if ((stress_due(window) || (last && stress_.watches())) && window != last_stress_look_)
    look_at_stress(window, states);
  const bool now = (window % every == 0 || last) && window != last_look_;
  if (elements_.empty() || (!now && window == last_window_)) return;
  const std::int64_t before = slipped_ ? last_window_ : last_look_;
  if (now) look_at_elements(window, states);
  if (now && surface_) look_at_pairs(window, of_surface);
  // A damaged checkpoint may say so of a part without a surface.
  if (slipped_ && surface_) look_at_slipped(before, window, of_surface);
  if (now) last_look_ = window;
  last_window_ = window;
}

template <int dimension>
void ModelWatch::look_at_element(const Element& element, const fem::Element& nodes, const Displacements& u,
                                 const Eigen::Vector3d& place, Worst& strain, Worst& rotation) const {
  using Matrix = Eigen::Matrix<double, dimension, dimension>;
  const auto diagonals = fem::traits(nodes.kind).diagonals;
  Matrix differences;
  for (int c = 0; c < dimension; ++c) {
    const auto& [from, to] = diagonals[fem::at(c)];
    differences.col(c) = (u[fem::at(to)] - u[fem::at(from)]).template head<dimension>();
  }
  const Matrix inverse = element.inverse_diagonals.template topLeftCorner<dimension, dimension>();
  const Matrix gradient = differences * inverse;
  // No principal strain and no rotation is larger than the gradient: nearly every element is done with here.
  if (gradient.squaredNorm() <= strain_limit * strain_limit) return;
  strain.take(principal_strain(gradient), place);
  rotation.take(rotation_angle(gradient), place);
}

void ModelWatch::look_at_elements(std::int64_t window, const std::vector<BodyState>& states) {
  for (std::size_t p = 0; p < states.size(); ++p) {
    const auto& state = states[p];
    const auto& mesh = state.part.mesh;
    const int components = fem::components(mesh.model);
    Eigen::VectorXd in_frame;
    const Eigen::VectorXd& straining = state.straining(in_frame);
    Worst strain, rotation, inverted;
    for (std::size_t e = 0; e < elements_[p].size(); ++e) {
      const auto& element = elements_[p][e];
      const auto& nodes = mesh.elements[e];
      const Eigen::Vector3d& place = mesh.position[static_cast<std::size_t>(nodes[0])];
      if (components == 1) {
        const double stretch = (straining[nodes[1]] - straining[nodes[0]]) * element.inverse_diagonals(0, 0);
        strain.take(std::abs(stretch), place);
        if (stretch <= -1.0) inverted.take(-stretch, place);
        continue;
      }
      Displacements u;
      for (std::size_t i = 0; i < nodes.size(); ++i) {
        u[i].setZero();
        for (int c = 0; c < components; ++c) u[i][c] = straining[nodes[i] * components + c];
      }
      if (components == 2) look_at_element<2>(element, nodes, u, place, strain, rotation);
      if (components == 3) look_at_element<3>(element, nodes, u, place, strain, rotation);
      if (mesh.model == fem::Model::axisymmetric) strain.take(std::abs(hoop_strain(mesh, nodes, u)), place);
      double moved = 0.0;
      for (std::size_t i = 1; i < nodes.size(); ++i) moved = std::max(moved, (u[i] - u[0]).squaredNorm());
      if (moved <= safe_share * safe_share * element.shortest_edge_m * element.shortest_edge_m) continue;
      const double ratio = smallest_jacobian_ratio(fem::element_geometry(mesh, static_cast<int>(e)), u);
      if (ratio <= 0.0) inverted.take(1.0 - ratio, place);
    }
    const int part = static_cast<int>(p);
    if (strain.size > strain_limit) report(Kind::strain, part, last_look_, window, strain);
    if (rotation.size > rotation_limit) report(Kind::rotation, part, last_look_, window, rotation);
    if (inverted.size > 0.0) report(Kind::inverted, part, last_look_, window, inverted);
  }
}

void ModelWatch::look_at_stress(std::int64_t window, const std::vector<BodyState>& states) {
  for (std::size_t p = 0; p < states.size(); ++p) {
    const auto [yield, tension] = stress_.look(p, states[p]);
    const int part = static_cast<int>(p);
    if (yield.size > 0.0) report(Kind::yield, part, last_stress_look_, window, yield);
    if (tension.size > 0.0) report(Kind::tension, part, last_stress_look_, window, tension);
  }
  last_stress_look_ = window;
}

/// Looks at contacts whose pairs change, against the smallest depth at the pairs of the start.
void ModelWatch::look_at_following(const std::vector<BodyState>& states, Worst& penetration) const {
  for (std::size_t contact = 0; contact < stretches_.size(); ++contact) {
    const Stretch& stretch = stretches_[contact];
    if (!stretch.follows) continue;
    const auto begin = pairs_.begin() + static_cast<std::ptrdiff_t>(stretch.begin),
               end = pairs_.begin() + static_cast<std::ptrdiff_t>(stretch.end);
    const auto shallow =
        std::min_element(begin, end, [](const PairPlace& p, const PairPlace& q) { return p.depth_m < q.depth_m; });
    for (const auto& pair : surface_->pairs) {
      if (pair.contact == contact) penetration.take(-pair.gap(displacement_of(states)) / shallow->depth_m, shallow->x);
    }
  }
}

void ModelWatch::look_at_pairs(std::int64_t window, const std::vector<BodyState>& states) {
  Worst penetration;
  slipped_ = false;
  look_at_following(states, penetration);
  for (const auto& stretch : stretches_) {
    for (std::size_t i = stretch.begin; !stretch.follows && i < stretch.end; ++i) {
      const double gap_m = rows_[i].gap(displacement_of(states));
      penetration.take(-gap_m / pairs_[i].depth_m, pairs_[i].x);
      if (!stretch.places_differ || surface_->components == 1) continue;
      slipped_ = slipped_ || slip(i, states) > 0.5 * slip_limit;
    }
  }
  const int part = rows_.front().normal.part_of(Side::a);
  if (penetration.size > penetration_limit) report(Kind::penetration, part, last_look_, window, penetration);
}

/// The slip of a pair's nodes against each other, in edges.
double ModelWatch::slip(std::size_t pair, const std::vector<BodyState>& states) const {
  const double along = rows_[pair].tangent.times(displacement_of(states));
  const double across = rows_[pair].binormal.times(displacement_of(states));
  return std::hypot(along, across) / pairs_[pair].edge_m;
}

/// Where a node of a pair has got to, along the tangent or n x t [m].
double ModelWatch::along(std::size_t direction, std::size_t pair, Side side,
                         const std::vector<BodyState>& states) const {
  const auto& rows = rows_[pair];
  const ContactRow& row = direction == 0 ? rows.tangent : rows.binormal;
  return pairs_[pair].along_m[direction] + row.of(side, displacement_of(states));
}

/// How far a node of a pair is past the ends of the other surface; < 0 between them [m].
double ModelWatch::past_end(std::size_t pair, const std::vector<Ends>& ends,
                            const std::vector<BodyState>& states) const {
  double past_m = -std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < ends.size(); ++k) {
    const auto [low, high] = ends[k];
    const double a = along(k, pair, Side::a, states), b = along(k, pair, Side::b, states);
    past_m = std::max({past_m, along(k, low, Side::b, states) - a, a - along(k, high, Side::b, states),
                       along(k, low, Side::a, states) - b, b - along(k, high, Side::a, states)});
  }
  return past_m;
}

void ModelWatch::look_at_slipped(std::int64_t before, std::int64_t window, const std::vector<BodyState>& states) {
  Worst slipped, past;
  for (const auto& stretch : stretches_) {
    for (std::size_t i = stretch.begin; stretch.places_differ && !stretch.follows && i < stretch.end; ++i) {
      if (rows_[i].gap(displacement_of(states)) > closed_share * pairs_[i].edge_m) continue;
      slipped.take(slip(i, states), pairs_[i].x);
      past.take(past_end(i, stretch.ends, states) / pairs_[i].edge_m, pairs_[i].x);
    }
  }
  const int part = rows_.front().normal.part_of(Side::a);
  if (slipped.size > slip_limit) report(Kind::slip, part, before, window, slipped);
  if (past.size >= off_limit) report(Kind::off_partner, part, before, window, past);
}

void ModelWatch::report(Kind kind, int part, std::int64_t last_without, std::int64_t window, const Worst& worst) {
  auto found = std::find_if(found_.begin(), found_.end(),
                            [&](const participant::Departure& d) { return d.kind == kind && d.body == part; });
  if (found == found_.end()) {
    found_.push_back({.kind = kind, .body = part, .last_without = last_without, .first = window});
    found = found_.end() - 1;
    found->first_size = worst.size;
    found->first_x_m = worst.place[0];
    found->first_y_m = worst.place[1];
    found->first_z_m = worst.place[2];
  }
  ++found->looks;
  if (worst.size <= found->largest) return;
  found->largest = worst.size;
  found->window = window;
  found->x_m = worst.place[0];
  found->y_m = worst.place[1];
  found->z_m = worst.place[2];
}

}  // namespace ricochet::solver

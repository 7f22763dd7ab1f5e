#include "common/solver/model_watch.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

namespace ricochet::solver {
namespace {

using Kind = participant::DepartureKind;

/// Share of an edge up to which a gap is no gap.
constexpr double closed_share = 1e-6;
/// Nodes that move against each other by less than this share of the shortest edge cannot invert an element.
constexpr double safe_share = 0.2;

using Displacements = std::array<Eigen::Vector2d, fem::Element::most_nodes>;  // of an element's nodes

/// Smallest Jacobian at a corner of a moved element over that of the reference.
double smallest_jacobian_ratio(const fem::ElementGeometry& element, const Displacements& u) {
  const auto& kind = fem::traits(element.kind);
  fem::ElementCoordinates moved = element.x;
  for (Eigen::Index i = 0; i < moved.rows(); ++i) moved.row(i) += u[static_cast<std::size_t>(i)].transpose();
  double smallest = std::numeric_limits<double>::infinity();
  for (const auto& corner : kind.corner)
    smallest = std::min(smallest, kind.jacobian(moved, corner) / kind.jacobian(element.x, corner));
  return smallest;
}

/// Largest |principal value| of the symmetric part of a displacement gradient.
double principal_strain(const Eigen::Matrix2d& gradient) {
  const double mean = 0.5 * (gradient(0, 0) + gradient(1, 1)), difference = 0.5 * (gradient(0, 0) - gradient(1, 1));
  return std::abs(mean) + std::hypot(difference, 0.5 * (gradient(0, 1) + gradient(1, 0)));
}

/// u_r / r at an element's middle.
double hoop_strain(const fem::Mesh& mesh, const fem::Element& nodes, const Displacements& u) {
  double u_r = 0.0, r = 0.0;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    u_r += u[i][0];
    r += mesh.position[static_cast<std::size_t>(nodes[i])][0];
  }
  return u_r / r;
}

/// Per node the smallest extent along the normal of the elements there [m].
std::vector<double> depths(const fem::Mesh& mesh, const Eigen::Vector2d& normal) {
  std::vector<double> depth_m(mesh.position.size(), std::numeric_limits<double>::infinity());
  for (int e = 0; e < static_cast<int>(mesh.elements.size()); ++e) {
    const Eigen::VectorXd along = fem::element_geometry(mesh, e).x * normal;
    const double own_m = along.maxCoeff() - along.minCoeff();
    for (const int node : mesh.elements[fem::at(e)]) {
      depth_m[static_cast<std::size_t>(node)] = std::min(depth_m[static_cast<std::size_t>(node)], own_m);
    }
  }
  return depth_m;
}

}  // namespace

ModelWatch::ModelWatch(const scene::Problem& problem, const std::vector<BodyState>& states,
                       const ContactSurface* surface)
    : surface_(surface) {
  prepare_elements(states);
  if (surface_) prepare_pairs(problem);
}

void ModelWatch::prepare_elements(const std::vector<BodyState>& states) {
  for (const auto& state : states) {
    auto& elements = elements_.emplace_back();
    const auto& mesh = state.part.mesh;
    for (int e = 0; e < static_cast<int>(mesh.elements.size()); ++e) {
      const fem::ElementGeometry geometry = fem::element_geometry(mesh, e);
      Element element;
      element.shortest_edge_m = fem::edge_lengths(geometry).shortest;
      Eigen::Matrix2d diagonals = Eigen::Matrix2d::Identity();
      Eigen::Index column = 0;
      for (const auto& [a, b] : fem::traits(geometry.kind).diagonals)
        diagonals.col(column++) = (geometry.x.row(b) - geometry.x.row(a)).transpose();
      element.inverse_diagonals = diagonals.inverse();
      elements.push_back(element);
    }
  }
}

void ModelWatch::prepare_pairs(const scene::Problem& problem) {
  const auto& contact = problem.contact;
  const auto& body_a = problem.bodies[static_cast<std::size_t>(contact.body_a)];
  two_bodies_ = contact.body_b >= 0;
  ended_ = two_bodies_ && body_a.mesh.period_m == 0.0 && surface_->components == 2;
  const Eigen::Vector2d tangent(-contact.normal[1], contact.normal[0]);
  std::vector<std::size_t> order;
  for (const auto& pair : contact.pairs) {
    const auto& x = body_a.mesh.position[static_cast<std::size_t>(pair.node_a)];
    order.push_back(pairs_.size());
    pairs_.push_back(
        {tangent.dot(x), std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(), x});
  }
  std::sort(order.begin(), order.end(),
            [&](std::size_t i, std::size_t j) { return pairs_[i].along_m < pairs_[j].along_m; });
  ends_ = {order.front(), order.back()};
  for (std::size_t k = 1; k < order.size(); ++k) {
    auto &low = pairs_[order[k - 1]], &high = pairs_[order[k]];
    const double edge_m = high.along_m - low.along_m;
    low.edge_m = std::min(low.edge_m, edge_m);
    high.edge_m = std::min(high.edge_m, edge_m);
  }
  for (const bool first : {true, false}) {
    const int body = first ? contact.body_a : contact.body_b;
    if (body < 0) continue;
    const auto depth_m = depths(problem.bodies[static_cast<std::size_t>(body)].mesh, contact.normal);
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
      const auto take = [&](int node) {
        pairs_[i].depth_m = std::min(pairs_[i].depth_m, depth_m[static_cast<std::size_t>(node)]);
      };
      if (first) take(contact.pairs[i].node_a);
      for (const auto& opposite : contact.pairs[i].b) {
        if (!first) take(opposite.node);
      }
    }
  }
  for (auto& pair : pairs_) {
    if (!std::isfinite(pair.edge_m)) pair.edge_m = pair.depth_m;  // the one pair of two bars
  }
}

void ModelWatch::look(std::int64_t window, const std::vector<BodyState>& states, bool last) {
  const bool due = (window % every == 0 || last) && window != last_look_;
  if (elements_.empty() || (!due && window == last_window_)) return;
  const std::int64_t before = slipped_ ? last_window_ : last_look_;
  if (due) look_at_elements(window, states);
  if (due && surface_) look_at_pairs(window, states);
  if (slipped_) look_at_slipped(before, window, states);
  if (due) last_look_ = window;
  last_window_ = window;
}

void ModelWatch::look_at_elements(std::int64_t window, const std::vector<BodyState>& states) {
  for (std::size_t p = 0; p < states.size(); ++p) {
    const auto& state = states[p];
    const auto& mesh = state.part.mesh;
    const int components = fem::components(mesh.model);
    Worst strain, rotation, inverted;
    for (std::size_t e = 0; e < elements_[p].size(); ++e) {
      const auto& element = elements_[p][e];
      const auto& nodes = mesh.elements[e];
      const Eigen::Vector2d& place = mesh.position[static_cast<std::size_t>(nodes[0])];
      if (components == 1) {
        const double stretch = (state.u[nodes[1]] - state.u[nodes[0]]) * element.inverse_diagonals(0, 0);
        strain.take(std::abs(stretch), place);
        if (stretch <= -1.0) inverted.take(-stretch, place);
        continue;
      }
      Displacements u;
      for (std::size_t i = 0; i < nodes.size(); ++i) u[i] = state.u.segment<2>(2 * nodes[i]);
      const auto diagonals = fem::traits(nodes.kind).diagonals;
      Eigen::Matrix2d differences;
      for (int c = 0; c < 2; ++c)
        differences.col(c) = u[fem::at(diagonals[fem::at(c)][1])] - u[fem::at(diagonals[fem::at(c)][0])];
      const Eigen::Matrix2d gradient = differences * element.inverse_diagonals;
      // No principal strain and no rotation is larger than the gradient: nearly every element is done with here.
      if (gradient.squaredNorm() > strain_limit * strain_limit) {
        strain.take(principal_strain(gradient), place);
        rotation.take(std::abs(std::atan2(gradient(1, 0) - gradient(0, 1), 2.0 + gradient.trace())), place);
      }
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

void ModelWatch::look_at_pairs(std::int64_t window, const std::vector<BodyState>& states) {
  Worst penetration;
  slipped_ = false;
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    const double gap_m = surface_->pairs[i].gap(displacement_of(states));
    penetration.take(-gap_m / pairs_[i].depth_m, pairs_[i].x);
    if (!two_bodies_ || surface_->components == 1) continue;
    slipped_ = slipped_ || slip(i, states) > 0.5 * slip_limit;
  }
  const int part = surface_->pairs.front().normal.part_of(Side::a);
  if (penetration.size > penetration_limit) report(Kind::penetration, part, last_look_, window, penetration);
}

/// Of a pair's nodes against each other, in edges.
double ModelWatch::slip(std::size_t pair, const std::vector<BodyState>& states) const {
  return std::abs(surface_->pairs[pair].tangent.times(displacement_of(states))) / pairs_[pair].edge_m;
}

/// Where a node of a pair has got to, along the tangent [m].
double ModelWatch::along(std::size_t pair, Side side, const std::vector<BodyState>& states) const {
  return pairs_[pair].along_m + surface_->pairs[pair].tangent.of(side, displacement_of(states));
}

void ModelWatch::look_at_slipped(std::int64_t before, std::int64_t window, const std::vector<BodyState>& states) {
  Worst slipped, past;
  const auto& pairs = surface_->pairs;
  const auto low = ends_[0], high = ends_[1];
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    if (pairs[i].gap(displacement_of(states)) > closed_share * pairs_[i].edge_m) continue;
    slipped.take(slip(i, states), pairs_[i].x);
    if (!ended_) continue;
    const double a = along(i, Side::a, states), b = along(i, Side::b, states);
    const double past_m = std::max({along(low, Side::b, states) - a, a - along(high, Side::b, states),
                                    along(low, Side::a, states) - b, b - along(high, Side::a, states)});
    past.take(past_m / pairs_[i].edge_m, pairs_[i].x);
  }
  const int part = pairs.front().normal.part_of(Side::a);
  if (slipped.size > slip_limit) report(Kind::slip, part, before, window, slipped);
  if (past.size >= off_limit) report(Kind::off_partner, part, before, window, past);
}

void ModelWatch::report(Kind kind, int part, std::int64_t last_without, std::int64_t window, const Worst& worst) {
  auto found = std::find_if(found_.begin(), found_.end(),
                            [&](const participant::Departure& d) { return d.kind == kind && d.body == part; });
  if (found == found_.end()) {
    found_.push_back({.kind = kind, .body = part, .last_without = last_without, .first = window});
    found = found_.end() - 1;
  }
  ++found->looks;
  if (worst.size <= found->largest) return;
  found->largest = worst.size;
  found->window = window;
  found->x_m = worst.place[0];
  found->y_m = worst.place[1];
}

}  // namespace ricochet::solver

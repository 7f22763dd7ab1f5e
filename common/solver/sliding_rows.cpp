#include "common/solver/sliding_rows.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "common/solver/blocks.hpp"

namespace ricochet::solver {
namespace {

/// Shifts that differ by less of an edge are the same.
constexpr double same_share = 1e-12;

double shortest_edge(const std::vector<scene::SurfaceFace>& faces) {
  double shortest = std::numeric_limits<double>::infinity();
  for (const auto& face : faces) {
    for (std::size_t i = 0; i < face.node.size(); ++i)
      shortest = std::min(shortest, (face.x[(i + 1) % face.node.size()] - face.x[i]).norm());
  }
  return shortest;
}

/// 1 per component, 0 where a support holds some of the body's contact surface.
Eigen::Vector3d moves(const scene::Problem& problem, const scene::ContactGeometry& geometry, int body) {
  const auto& of = problem.bodies[static_cast<std::size_t>(body)];
  const int components = problem.scene.components();
  Eigen::Vector3d moves = Eigen::Vector3d::Ones();
  for (const int node : scene::contact_nodes(geometry, body)) {
    for (int c = 0; c < components; ++c) {
      const auto dof = static_cast<std::size_t>(node * components + c);
      if (of.fixed_dof[dof] && of.prescribed_index[dof] < 0) moves[c] = 0.0;
    }
  }
  return moves;
}

}  // namespace

SlidingRows::SlidingRows(const scene::Problem& problem, const std::vector<BodyState>& states) : problem_(&problem) {
  for (const auto& state : states) parts_.push_back({state.body, &state.part.body_node});
  for (std::size_t i = 0; i < problem.contacts.size(); ++i) {
    const auto& geometry = problem.contacts[i];
    if (!geometry.sliding) continue;
    contacts_.push_back({i,
                         shortest_edge(geometry.sliding->first),
                         moves(problem, geometry, geometry.body_a),
                         moves(problem, geometry, geometry.body_b),
                         {}});
  }
}

bool SlidingRows::slipped(const Sliding& sliding, const std::vector<BodyState>& states, double ahead_s,
                          const std::vector<Pair>& pairs) const {
  const auto u = displacement_of(states);
  const auto v = velocity_of(states);
  return std::any_of(pairs.begin(), pairs.end(), [&](const Pair& pair) {
    const Eigen::Vector2d slip = pair.slip(u) + ahead_s * pair.slip(v);
    return pair.contact == sliding.contact && slip.norm() > start_share * sliding.edge_m;
  });
}

Moments block_moments(const BodyState& state, double ahead_s, int block) {
  const int components = fem::components(state.part.mesh.model), rows = block_nodes * components;
  Moments moments;
  for (int dof = block * rows; dof < std::min((block + 1) * rows, state.part.dofs()); ++dof) {
    moments.moved_kg_m[dof % components] += state.mass[dof] * (state.u[dof] + ahead_s * state.v[dof]);
    moments.mass_kg[dof % components] += state.mass[dof];
  }
  return moments;
}

Eigen::Vector3d SlidingRows::mean_motion(int body, const std::vector<BodyState>& states, double ahead_s) const {
  Moments sum;
  for (const auto& state : states) {
    if (state.body != body) continue;
    if (state.others != nullptr) {
      sum.add(state.others->moments());  // at u: the explicit side never asks ahead
      continue;
    }
    for (int block = 0; block < blocks_of(state.part.nodes()); ++block) sum.add(block_moments(state, ahead_s, block));
  }
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (int c = 0; c < 3; ++c) mean[c] = sum.mass_kg[c] > 0.0 ? sum.moved_kg_m[c] / sum.mass_kg[c] : 0.0;
  return mean;
}

bool SlidingRows::follow(const std::vector<BodyState>& states, double ahead_s, std::vector<Pair>& pairs) {
  bool moved = false;
  for (auto& sliding : contacts_) {
    sliding.slide.follows = sliding.slide.follows || slipped(sliding, states, ahead_s, pairs);
    if (!sliding.slide.follows) continue;
    const auto& geometry = problem_->contacts[sliding.contact];
    Eigen::Vector3d shift = sliding.moves_b.cwiseProduct(mean_motion(geometry.body_b, states, ahead_s));
    shift -= sliding.moves_a.cwiseProduct(mean_motion(geometry.body_a, states, ahead_s));
    shift -= shift.dot(geometry.normal) * geometry.normal;
    if ((shift - sliding.slide.shift_m).norm() <= same_share * sliding.edge_m) continue;
    sliding.slide.shift_m = shift;
    moved = true;
  }
  if (moved) write(pairs);
  return moved;
}

/// Pairs of contacts that do not follow stay as they are.
void SlidingRows::write(std::vector<Pair>& pairs) const {
  std::vector<Pair> written;
  for (std::size_t i = 0; i < problem_->contacts.size(); ++i) {
    const auto sliding =
        std::find_if(contacts_.begin(), contacts_.end(), [i](const Sliding& s) { return s.contact == i; });
    if (sliding == contacts_.end() || !sliding->slide.follows) {
      std::copy_if(pairs.begin(), pairs.end(), std::back_inserter(written),
                   [i](const Pair& p) { return p.contact == i; });
      continue;
    }
    for (const auto& pair : scene::slid_pairs(*problem_, i, sliding->slide.shift_m))
      written.push_back(pair_of(*problem_, i, pair, parts_));
  }
  pairs = std::move(written);
}

SlidingRows::State SlidingRows::state() const {
  State state;
  for (const auto& sliding : contacts_) state.push_back(sliding.slide);
  return state;
}

bool SlidingRows::restore(const State& state, std::vector<Pair>& pairs) {
  bool any_follows = false, any_stops = false;
  for (std::size_t i = 0; i < state.size(); ++i) {
    any_follows = any_follows || state[i].follows;
    any_stops = any_stops || (contacts_[i].slide.follows && !state[i].follows);
    contacts_[i].slide = state[i];
  }
  if (any_stops) pairs = contact_rows(*problem_, parts_);  // as before anything slid
  if (any_follows) write(pairs);
  return any_follows || any_stops;
}

std::vector<int> same_pairs(const std::vector<Pair>& from, const std::vector<Pair>& to) {
  std::map<std::pair<std::size_t, int>, int> known;
  for (std::size_t i = 0; i < from.size(); ++i) known[{from[i].contact, from[i].node_a}] = static_cast<int>(i);
  std::vector<int> same;
  for (const auto& pair : to) {
    const auto found = known.find({pair.contact, pair.node_a});
    same.push_back(found == known.end() ? -1 : found->second);
  }
  return same;
}

}  // namespace ricochet::solver

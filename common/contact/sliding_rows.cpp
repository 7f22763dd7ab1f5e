#include "common/contact/sliding_rows.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "common/body/blocks.hpp"

namespace ricochet::solver {
namespace {

/// Shares of an edge: bodies that are apart by more sleep, and wake when they may be so near.
constexpr double asleep_share = 1.0, awake_share = 0.5;
/// Share of their distance, as the rows have it, that open pairs may move before they are written anew.
constexpr double open_share = 0.25;

Eigen::Vector3d across(const Eigen::Vector3d& moved, const Eigen::Vector3d& normal) {
  return moved - moved.dot(normal) * normal;
}

/// The most that a pair's gap differs, by strain and rotation, from that of bodies which move as a whole: the second by
/// `moved_m` and, where they turn, by that.
double deformed_m(const std::vector<BodyState>& states, std::size_t contact, const Eigen::Vector3d& moved_m,
                  const fem::RigidMotion& turn_a, const fem::RigidMotion& turn_b, const std::vector<Pair>& pairs) {
  double most = 0.0;
  for (const Pair& pair : pairs) {
    if (pair.contact != contact) continue;
    double closed = pair.normal.times(displacement_of(states));
    for (const auto& e : pair.normal.entries) {
      const auto& mesh = states[static_cast<std::size_t>(e.part)].part.mesh;
      const int components = fem::components(mesh.model);
      const Eigen::Vector3d& place = mesh.position[static_cast<std::size_t>(e.dof / components)];
      const Eigen::Vector3d moved =
          e.side == Side::b ? Eigen::Vector3d(moved_m + turn_b.displacement(place)) : turn_a.displacement(place);
      closed -= e.coefficient * moved[e.dof % components];
    }
    most = std::max(most, std::abs(closed));
  }
  return most;
}

double least_gap_m(const std::vector<BodyState>& states, std::size_t contact, const std::vector<Pair>& pairs) {
  double least = std::numeric_limits<double>::infinity();
  for (const Pair& pair : pairs)
    if (pair.contact == contact) least = std::min(least, pair.gap(displacement_of(states)));
  return std::isfinite(least) ? least : 0.0;
}

/// 1 per component, 0 where a support holds some of the body's contact surface.
Eigen::Vector3d moves(const scene::Problem& problem, const scene::ContactGeometry& geometry, int body) {
  const auto& of = problem.bodies[static_cast<std::size_t>(body)];
  const int components = problem.scene.components();
  Eigen::Vector3d moves = Eigen::Vector3d::Ones();
  for (const int node : scene::contact_nodes(geometry, body)) {
    for (int c = 0; c < components; ++c) {
      if (scene::is_still(of, node * components + c)) moves[c] = 0.0;
    }
  }
  return moves;
}

/// visit(state, node, mass) of all nodes of a body that have a mass here.
template <class Visit>
void for_each_node(int body, const std::vector<BodyState>& states, const Visit& visit) {
  for (const auto& state : states) {
    if (state.body != body) continue;
    const int components = fem::components(state.part.mesh.model);
    for (int node = 0; node < state.part.nodes(); ++node) {
      const double node_kg = state.mass[node * components];
      if (node_kg > 0.0) visit(state, node, node_kg);
    }
  }
}

/// Centre of the mass that the body has here, at the start [m]; with ranks of all of it.
Eigen::Vector3d centre_of(int body, const std::vector<BodyState>& states) {
  for (const auto& state : states)
    if (state.body == body && state.others != nullptr) return state.frame->whole().centre_m;
  double mass_kg = 0.0;
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  for_each_node(body, states, [&](const BodyState& state, int node, double node_kg) {
    mass_kg += node_kg;
    centre_m += node_kg * state.part.mesh.position[fem::at(node)];
  });
  return centre_m / mass_kg;
}

fem::RigidMotion about(const Eigen::Vector3d& centre_m, const Eigen::Matrix3d& turn) {
  return {turn, centre_m, centre_m};
}

/// R of a body, with the displacement u + ahead_s v.
template <int components>
Eigen::Matrix3d turn_of(const Eigen::Vector3d& centre_m, int body, const std::vector<BodyState>& states,
                        double ahead_s) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const auto& state : states) {
    if (state.body != body) continue;
    if (state.others != nullptr) {
      sum += state.others->moments().turned_kg_m2;  // at u: the explicit side never asks ahead
      continue;
    }
    for (int block = 0; block < blocks_of(state.part.nodes()); ++block)
      sum += block_turn(state, centre_m, ahead_s, block);
  }
  const Eigen::Matrix<double, components, components> h = sum.topLeftCorner<components, components>();
  return rotation_of(h);
}

}  // namespace

SlidingRows::SlidingRows(const scene::Problem& problem, const std::vector<BodyState>& states) : problem_(&problem) {
  for (const auto& state : states) parts_.push_back({state.body, &state.part.body_node});
  for (std::size_t i = 0; i < problem.contacts.size(); ++i) {
    const auto& geometry = problem.contacts[i];
    if (!geometry.sliding) continue;
    contacts_.push_back({i,
                         moves(problem, geometry, geometry.body_a),
                         moves(problem, geometry, geometry.body_b),
                         turning_of(geometry, geometry.body_a, states),
                         turning_of(geometry, geometry.body_b, states),
                         {.shift_m = geometry.shift_m, .normal = geometry.touch_normal}});
  }
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

SlidingRows::Turning SlidingRows::turning_of(const scene::ContactGeometry& geometry, int body,
                                             const std::vector<BodyState>& states) const {
  Turning turning;
  turning.turns = problem_->scene.bodies[static_cast<std::size_t>(body)].large_rotation;
  if (!turning.turns) return turning;
  turning.centre_m = centre_of(body, states);
  const auto& mesh = problem_->bodies[static_cast<std::size_t>(body)].mesh;
  std::vector<int> nodes = scene::contact_nodes(geometry, body);
  if (mesh.rigid_nodes > 0) {  // they lie within its surface
    nodes.resize(mesh.position.size());
    std::iota(nodes.begin(), nodes.end(), 0);
  }
  for (const int node : nodes)
    turning.reach_m = std::max(turning.reach_m, (mesh.position[fem::at(node)] - turning.centre_m).norm());
  return turning;
}

SlidingRows::Pose SlidingRows::pose(const Sliding& sliding, const std::vector<BodyState>& states,
                                    double ahead_s) const {
  const auto& geometry = problem_->contacts[sliding.contact];
  const auto turn_of_body = [&](const Turning& turning, int body) -> Eigen::Matrix3d {
    if (!turning.turns) return Eigen::Matrix3d::Identity();
    return problem_->scene.components() == 2 ? turn_of<2>(turning.centre_m, body, states, ahead_s)
                                             : turn_of<3>(turning.centre_m, body, states, ahead_s);
  };
  Pose pose{geometry.lifted_m, turn_of_body(sliding.turning_a, geometry.body_a),
            turn_of_body(sliding.turning_b, geometry.body_b)};
  pose.place_m += sliding.moves_b.cwiseProduct(mean_motion(geometry.body_b, states, ahead_s));
  pose.place_m -= sliding.moves_a.cwiseProduct(mean_motion(geometry.body_a, states, ahead_s));
  return pose;
}

bool SlidingRows::stays(const Sliding& sliding, const Pose& pose, const std::vector<BodyState>& states,
                        const std::vector<Pair>& pairs) const {
  const auto& geometry = problem_->contacts[sliding.contact];
  const Slide& slide = sliding.slide;
  const auto turned = [](const Turning& turning, const Eigen::Matrix3d& from, const Eigen::Matrix3d& to) {
    return turning.turns ? turning.reach_m * (to - from).norm() / std::numbers::sqrt2 : 0.0;  // 2 sin(angle/2)
  };
  const double turned_m = turned(sliding.turning_a, slide.turn_a, pose.turn_a) +
                          turned(sliding.turning_b, slide.turn_b, pose.turn_b),
               least_m = slide_share * geometry.sliding->edge_m;
  if (!slide.asleep && across(pose.place_m - slide.shift_m, slide.normal).norm() + turned_m <= least_m) return true;
  const double moved_m = (pose.place_m - slide.place_m).norm() + turned_m;
  if (moved_m >= slide.free_m) return false;
  const double deformed =
      deformed_m(states, sliding.contact, pose.place_m - geometry.lifted_m,
                 about(sliding.turning_a.centre_m, pose.turn_a), about(sliding.turning_b.centre_m, pose.turn_b), pairs);
  return moved_m + deformed < slide.free_m;
}

/// The surfaces as the slide has them turned.
void SlidingRows::turn(Sliding& sliding) const {
  if (!sliding.turning_a.turns && !sliding.turning_b.turns) return;
  sliding.turned = scene::turned_surfaces(*problem_->contacts[sliding.contact].sliding,
                                          about(sliding.turning_a.centre_m, sliding.slide.turn_a),
                                          about(sliding.turning_b.centre_m, sliding.slide.turn_b));
}

/// To rows for the place, where pairs are open by `gap_m` at least.
void SlidingRows::move(Sliding& sliding, const Pose& pose, double gap_m) const {
  const auto& geometry = problem_->contacts[sliding.contact];
  const Eigen::Vector3d& place_m = pose.place_m;
  Slide& slide = sliding.slide;
  slide.turn_a = pose.turn_a;
  slide.turn_b = pose.turn_b;
  turn(sliding);
  const surface::ContactMesh& mesh = sliding.turned ? sliding.turned->mesh : *geometry.sliding;
  const double edge_m = mesh.edge_m, apart_m = mesh.second.apart_m(mesh.first, place_m);
  const Eigen::Vector3d moved = across(place_m - slide.shift_m, slide.normal);
  sliding.changed = slide.follows = true;
  slide.place_m = place_m;
  slide.asleep = apart_m > asleep_share * edge_m;
  if (slide.asleep) {
    slide.shift_m = place_m;
    slide.free_m = apart_m - awake_share * edge_m;
    return;
  }
  slide.free_m = open_share * std::clamp(gap_m, 0.0, edge_m);
  const double least_m = slide_share * edge_m;
  Eigen::Vector3d ahead = Eigen::Vector3d::Zero();
  const double moved_m = moved.norm();  // of a body that turns alone, round-off
  if (slide.free_m < least_m && moved_m < 1.5 * least_m) ahead = 0.5 * std::min(1.0, least_m / moved_m) * moved;
  slide.shift_m = (geometry.flat ? place_m : Eigen::Vector3d(slide.shift_m + moved)) + ahead;
  if (geometry.flat) return;
  if (const auto touch = surface::touching(mesh, slide.shift_m, Eigen::Vector3d::Zero())) {
    slide.shift_m = touch->shift_m;
    slide.normal = touch->normal;
  }
}

bool SlidingRows::follow(const std::vector<BodyState>& states, double ahead_s, double middle_s,
                         const std::vector<PairForce>& forces, std::vector<Pair>& pairs) {
  bool moved = false;
  for (auto& sliding : contacts_) {
    const Pose now = pose(sliding, states, ahead_s);
    if (stays(sliding, now, states, pairs)) continue;
    move(sliding, now, least_gap_m(states, sliding.contact, pairs));
    moved = true;
  }
  if (!moved) return false;
  const std::vector<Pair> before = pairs;
  write(pairs);
  balance(before, forces, states, middle_s, pairs);
  offset(pairs);
  return true;
}

/// Pairs of contacts that have not changed stay as they are.
void SlidingRows::write(std::vector<Pair>& pairs) {
  std::vector<Pair> written;
  for (std::size_t i = 0; i < problem_->contacts.size(); ++i) {
    const auto sliding =
        std::find_if(contacts_.begin(), contacts_.end(), [i](const Sliding& s) { return s.contact == i; });
    if (sliding == contacts_.end() || !sliding->changed) {
      std::copy_if(pairs.begin(), pairs.end(), std::back_inserter(written),
                   [i](const Pair& p) { return p.contact == i; });
      continue;
    }
    const auto* turned = sliding->turned ? &*sliding->turned : nullptr;
    for (const auto& pair : scene::slid_pairs(*problem_, i, sliding->slide.shift_m, turned))
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
    turn(contacts_[i]);
    contacts_[i].changed = state[i].follows;
  }
  if (any_stops) pairs = contact_rows(*problem_, parts_);  // as before anything slid
  if (any_follows) {
    write(pairs);
    offset(pairs);
  }
  return any_follows || any_stops;
}

}  // namespace ricochet::solver

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <numeric>

#include "common/base/error.hpp"
#include "common/fem/hanging_nodes.hpp"
#include "common/problem/build.hpp"
#include "common/problem/critical_step.hpp"
#include "common/problem/given_motion.hpp"

namespace ricochet::scene {
namespace {

std::string node_text(const BodyProblem& body, int node) {
  return fmt::format("node {} of \"{}\" at {}", node, body.name,
                     fem::place_text(body.mesh.model, body.mesh.position[at(node)]));
}

/// Names the holder of each dof, for the error text.
using Holders = std::vector<std::string>;

void fix_axis(BodyProblem& body, Holders& holders) {
  if (body.section.model != Model::axisymmetric) return;
  double radius = 0.0;
  for (const Eigen::Vector3d& x : body.mesh.position) radius = std::max(radius, x[0]);
  for (int node = 0; node < static_cast<int>(body.mesh.position.size()); ++node) {
    if (body.mesh.position[at(node)][0] > 1e-12 * radius) continue;
    body.fixed_dof[at(node * 2)] = true;
    holders[at(node * 2)] = "the axis r = 0";
  }
}

/// Nodes that a support or a prescribed motion of a surface holds: of a rigid body those that carry all of it.
std::vector<int> held_nodes(const fem::Mesh& mesh, const std::string& surface) {
  if (mesh.rigid_nodes == 0) return fem::surface_nodes(mesh, surface);
  std::vector<int> nodes(at(mesh.rigid_nodes));
  std::iota(nodes.begin(), nodes.end(), static_cast<int>(mesh.position.size()) - mesh.rigid_nodes);
  return nodes;
}

/// The node at a place, which the support names.
void name_point(const Scene& scene, const std::string& key, const Support& support, BodyProblem& body) {
  constexpr double near = 1e-6;  // of the body's diagonal: the place of a node as somebody wrote it down
  Eigen::Vector3d place = Eigen::Vector3d::Zero(), low = body.mesh.position.front(), high = low;
  for (std::size_t c = 0; c < support.at_m.size(); ++c) place[static_cast<Eigen::Index>(c)] = support.at_m[c];
  std::vector<bool> hangs(body.mesh.position.size(), false);  // is held by its carriers alone
  for (const fem::HangingNode& hanging : body.mesh.hanging) hangs[at(hanging.node)] = true;
  int nearest = -1;
  for (int node = 0; node < static_cast<int>(body.mesh.position.size()); ++node) {
    const Eigen::Vector3d& x = body.mesh.position[at(node)];
    const double away =
        nearest < 0 ? std::numeric_limits<double>::infinity() : (body.mesh.position[at(nearest)] - place).norm();
    if (!hangs[at(node)] && (x - place).norm() < away) nearest = node;
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  if ((body.mesh.position[at(nearest)] - place).norm() > near * (high - low).norm())
    throw ConfigError(fmt::format("{}: found no node at {}; allowed: the place of a node, the nearest is {}",
                                  scene.where(key + ".at_m"), fem::place_text(body.mesh.model, place),
                                  node_text(body, nearest)));
  body.mesh.points[support.surface] = nearest;
}

void fix_supports(const Scene& scene, const Body& spec, BodyProblem& body, Holders& holders) {
  const int components = scene.components();
  for (std::size_t i = 0; i < spec.supports.size(); ++i) {
    const std::string key = fmt::format("body.{}.support[{}]", spec.name, i);
    if (spec.supports[i].at_m.empty())
      require_surface(scene, key + ".surface", body.mesh, spec.supports[i].surface);
    else
      name_point(scene, key, spec.supports[i], body);
    for (const int node : held_nodes(body.mesh, spec.supports[i].surface)) {
      for (const int c : spec.supports[i].components) {
        body.fixed_dof[at(node * components + c)] = true;
        holders[at(node * components + c)] = key;
      }
    }
  }
}

/// Displacements first: a turn may stand beside those of its nodes, which move its axis.
void prescribe(const Scene& scene, const Body& spec, BodyProblem& body, Holders& holders) {
  const int components = scene.components();
  const auto refuse = [&](const std::string& key, int node, int dof) {
    throw ConfigError(
        fmt::format("{}: found {} held by {} already; allowed: one support, or one prescribed displacement for each "
                    "component of a node and one turn",
                    scene.where(key), node_text(body, node), holders[at(dof)]));
  };
  for (const bool turns : {false, true}) {
    for (std::size_t i = 0; i < spec.prescribed.size(); ++i) {
      const PrescribedMotion& prescribed = spec.prescribed[i];
      if (prescribed.turn.has_value() != turns) continue;
      const std::string key = fmt::format("body.{}.prescribed[{}]", spec.name, i);
      require_surface(scene, key + ".surface", body.mesh, prescribed.surface);
      for (const int node : held_nodes(body.mesh, prescribed.surface)) {
        for (int c = 0; c < components; ++c) {
          const int dof = node * components + c;
          if (!turns && c != prescribed.component) continue;
          const bool turned = body.turned_by[at(node)] >= 0;
          if (body.fixed_dof[at(dof)] && (!turns || turned || body.prescribed_index[at(dof)] < 0))
            refuse(key, node, dof);
          body.fixed_dof[at(dof)] = true;
          holders[at(dof)] = key;
          if (turns) continue;
          body.prescribed_displacement_m[dof] = prescribed.displacement_m;
          body.prescribed_index[at(dof)] = static_cast<int>(i);
        }
        if (turns) body.turned_by[at(node)] = static_cast<int>(i);
      }
    }
  }
}

/// Nobody integrates a hanging node. A surface of larger elements that has one has its carriers, too: held there, it is
/// held by them. Where a tie ends at a support, nodes beside it may carry the node as well; it is held itself then, so
/// that no reaction comes to lie on those.
void hold_hanging(const Scene& scene, const Body& spec, BodyProblem& body, const Holders& holders) {
  const int components = scene.components();
  const std::vector<bool> held = body.fixed_dof;
  for (fem::HangingNode& hanging : body.mesh.hanging) {
    for (int c = 0; c < components; ++c) {
      const int dof = hanging.node * components + c;
      const bool by_carriers = std::all_of(hanging.carriers.begin(), hanging.carriers.end(), [&](const auto& carrier) {
        return held[at(carrier.node * components + c)];
      });
      if (held[at(dof)] && !by_carriers) {
        if (spec.large_rotation)
          throw ConfigError(fmt::format(
              "{}: found {}, which hangs by a tie on nodes that are not held, of a body that turns; allowed: a "
              "support away from ties, or no large_rotation",
              scene.where(holders[at(dof)]), node_text(body, hanging.node)));
        hanging.held |= 1U << c;
        continue;
      }
      body.fixed_dof[at(dof)] = true;
      body.prescribed_displacement_m[dof] = 0.0;
      body.prescribed_index[at(dof)] = -1;
    }
    if (hanging.held == 0) body.turned_by[at(hanging.node)] = -1;
  }
}

}  // namespace

GivenMotion given_motion(const Body& spec, const BodyProblem& body, int dof) {
  const int components = fem::components(body.section.model), node = dof / components;
  GivenMotion motion{body.prescribed_displacement_m[dof]};
  if (const int along = body.prescribed_index[at(dof)]; along >= 0)
    motion.along = &spec.prescribed[at(along)].amplitude;
  if (const int by = body.turned_by[at(node)]; by >= 0) {
    const PrescribedMotion& prescribed = spec.prescribed[at(by)];
    const Eigen::Vector3d turn(prescribed.turn->turn_rad.data()), about(prescribed.turn->about_m.data());
    const Eigen::Vector3d n = turn.normalized(), across = n.cross(body.mesh.position[at(node)] - about);
    const Eigen::Index c = dof % components;
    motion.across_m = across[c];
    motion.inward_m = n.cross(across)[c];
    motion.angle_rad = turn.norm();
    motion.turn = &prescribed.amplitude;
  }
  return motion;
}

void set_constraints(const Scene& scene, const Body& spec, BodyProblem& body) {
  const std::size_t dofs = body.mesh.position.size() * at(scene.components());
  body.fixed_dof.assign(dofs, false);
  body.prescribed_index.assign(dofs, -1);
  body.turned_by.assign(body.mesh.position.size(), -1);
  body.prescribed_displacement_m = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(dofs));
  Holders holders(dofs);
  fix_axis(body, holders);
  fix_supports(scene, spec, body, holders);
  prescribe(scene, spec, body, holders);
  hold_hanging(scene, spec, body, holders);
}

namespace {

/// The velocities of a spin about the centre of mass: w x (X - X_c).
std::vector<Eigen::Vector3d> spin_velocity(const Body& spec, const BodyProblem& body) {
  std::vector<Eigen::Vector3d> velocity(body.mesh.position.size(), Eigen::Vector3d::Zero());
  const Eigen::Vector3d spin(spec.initial_angular_velocity_rad_s.data());
  if (spin.isZero(0.0)) return velocity;
  const Eigen::VectorXd mass = body_lumped_mass(body);
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (std::size_t node = 0; node < velocity.size(); ++node)
    centre += mass[static_cast<Eigen::Index>(node)] * body.mesh.position[node];
  centre /= mass.sum();
  for (std::size_t node = 0; node < velocity.size(); ++node)
    velocity[node] = spin.cross(body.mesh.position[node] - centre);
  return velocity;
}

}  // namespace

void set_initial_state(const Scene& scene, const Body& spec, BodyProblem& body) {
  const int components = scene.components();
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Eigen::Vector3d& x : body.mesh.position) {
    low = std::min(low, fem::axis_coordinate(scene.model, x));
    high = std::max(high, fem::axis_coordinate(scene.model, x));
  }
  const auto dofs = static_cast<Eigen::Index>(body.fixed_dof.size());
  body.initial_displacement_m.resize(dofs);
  body.initial_velocity_m_s.resize(dofs);
  const std::vector<Eigen::Vector3d> spin = spin_velocity(spec, body);
  for (int dof = 0; dof < static_cast<int>(dofs); ++dof) {
    const int node = dof / components;
    const auto c = at(dof % components);
    const double part = (fem::axis_coordinate(scene.model, body.mesh.position[at(node)]) - low) / (high - low);
    const double start = spec.initial_displacement_start_m[c], end = spec.initial_displacement_end_m[c];
    const double initial = start + part * (end - start);
    const double round_off = 1e-12 * std::max(std::abs(start), std::abs(end));
    const fem::HangingNode* hanging = fem::hanging_at(body.mesh, node);
    const bool hangs = hanging != nullptr && hanging->hangs(dof % components);
    if (is_still(body, dof) && !hangs && std::abs(initial) > round_off)
      throw ConfigError(fmt::format("{}: found {} m at {}, which is held; allowed: 0 on supports and on the axis r = 0",
                                    scene.where("body." + spec.name + ".initial_displacement_m"), initial,
                                    node_text(body, node)));
    body.initial_displacement_m[dof] = initial;
    if (body.fixed_dof[at(dof)]) body.initial_displacement_m[dof] = 0.0;
    if (body.fixed_dof[at(dof)] && !is_still(body, dof))
      body.initial_displacement_m[dof] = given_motion(spec, body, dof).at(0.0);
    const double moves = spec.initial_velocity_m_s[c] + spin[at(node)][static_cast<Eigen::Index>(c)];
    body.initial_velocity_m_s[dof] = body.fixed_dof[at(dof)] ? 0.0 : moves;
  }
  fem::follow(body.mesh.hanging, components, body.initial_displacement_m);
  fem::follow(body.mesh.hanging, components, body.initial_velocity_m_s);
}

}  // namespace ricochet::scene

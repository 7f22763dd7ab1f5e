// Bodies that move as one: all nodes hang on few.
#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "common/base/error.hpp"
#include "common/problem/build.hpp"
#include "common/problem/critical_step.hpp"

namespace ricochet::scene {
namespace {

/// Components in which nothing holds the body, or all if it is told how to turn.
std::vector<int> free_components(const Scene& scene, const Body& spec) {
  std::vector<bool> held(at(scene.components()), false);
  if (scene.model == Model::axisymmetric) held[0] = true;
  for (const Support& support : spec.supports)
    for (const int c : support.components) held[at(c)] = true;
  for (const PrescribedMotion& prescribed : spec.prescribed) held[at(prescribed.component)] = true;
  if (spec.told_to_turn()) held.assign(held.size(), false);
  std::vector<int> free;
  for (int c = 0; c < scene.components(); ++c)
    if (!held[at(c)]) free.push_back(c);
  return free;
}

/// Corners of a regular simplex about 0, a column each, with sum t t^T = (n + 1) I.
Eigen::MatrixXd simplex(Eigen::Index dimensions) {
  Eigen::MatrixXd corners(dimensions, dimensions + 1);
  if (dimensions == 1) corners << -1.0, 1.0;
  if (dimensions == 2)
    corners << std::sqrt(2.0), -std::sqrt(0.5), -std::sqrt(0.5), 0.0, std::sqrt(1.5), -std::sqrt(1.5);
  if (dimensions == 3) corners << 1.0, 1.0, -1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0, -1.0, 1.0;
  return corners;
}

struct MassMoments {
  double mass_kg = 0.0;
  Eigen::Vector3d first_kg_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second_kg_m2 = Eigen::Matrix3d::Zero();  ///< sum of m x x^T
};

/// Nodal masses have the centre of an element, and a second moment about it that is too large by a factor: n + 2 of a
/// simplex in n dimensions, 3 of what is a product of lengths, exactly if its opposite sides are parallel.
MassMoments mass_moments(const BodyProblem& body) {
  MassMoments sum;
  for (int e = 0; e < static_cast<int>(body.mesh.elements.size()); ++e) {
    const fem::Element& element = body.mesh.elements[at(e)];
    const fem::ElementGeometry geometry = fem::element_geometry(body.mesh, e);
    const Eigen::VectorXd mass = fem::element_lumped_mass(body.section, fem::material_of(body, e), geometry);
    MassMoments of;
    for (Eigen::Index i = 0; i < mass.size(); ++i) {
      const Eigen::Vector3d& x = body.mesh.position[at(element[at(static_cast<int>(i))])];
      of.mass_kg += mass[i];
      of.first_kg_m += mass[i] * x;
      of.second_kg_m2 += mass[i] * x * x.transpose();
    }
    const Eigen::Matrix3d of_centre = of.first_kg_m * of.first_kg_m.transpose() / of.mass_kg;
    const Eigen::Index dimensions = body.section.model == Model::bar ? 1 : fem::components(body.section.model);
    const double factor = mass.size() == dimensions + 1 ? static_cast<double>(dimensions) + 2.0 : 3.0;
    sum.mass_kg += of.mass_kg;
    sum.first_kg_m += of.first_kg_m;
    sum.second_kg_m2 += of_centre + (of.second_kg_m2 - of_centre) / factor;
  }
  return sum;
}

}  // namespace

void make_rigid(const Scene& scene, const Body& spec, BodyProblem& body) {
  for (const ForeignBody& foreign : scene.foreign_bodies)
    if (foreign.joined_to == spec.name)
      throw ConfigError(fmt::format("{}: found a body that foreign body \"{}\" is joined to; allowed: one that is not",
                                    scene.where("body." + spec.name + ".rigid"), foreign.name));
  const std::vector<int> free = free_components(scene, spec);
  const auto dimensions = static_cast<Eigen::Index>(free.size());
  const MassMoments moments = mass_moments(body);
  Eigen::Vector3d centre = moments.first_kg_m / moments.mass_kg;
  if (scene.model == Model::axisymmetric) centre[0] = 0.0;
  const Eigen::Matrix3d about = moments.second_kg_m2 / moments.mass_kg - centre * centre.transpose();
  Eigen::MatrixXd root = about(free, free), inverse_root = root;
  if (dimensions > 0) {
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(root);
    root = solver.operatorSqrt();
    inverse_root = solver.operatorInverseSqrt();
  }
  const Eigen::MatrixXd corners = simplex(dimensions);
  const int own = static_cast<int>(body.mesh.position.size());
  body.mesh.rigid_nodes = static_cast<int>(dimensions) + 1;
  for (int node = 0; node < own; ++node) {
    const Eigen::VectorXd arm = (body.mesh.position[at(node)] - centre)(free);
    const Eigen::VectorXd share = corners.transpose() * (inverse_root * arm);
    fem::HangingNode& hanging = body.mesh.hanging.emplace_back();
    hanging.node = node;
    for (int i = 0; i <= dimensions; ++i)
      hanging.carriers.push_back({own + i, (1.0 + share[i]) / (static_cast<double>(dimensions) + 1.0)});
  }
  for (int i = 0; i <= dimensions; ++i) {
    Eigen::Vector3d place = centre;
    place(free) += root * corners.col(i);
    body.mesh.position.push_back(place);
  }
}

void stiffen_rigid(Problem& problem) {
  constexpr double longer = 2.0;  // than the step of the finest element, which bounds that of its body from below
  const auto is_rigid = [](const BodyProblem& body) { return body.mesh.rigid_nodes > 0; };
  if (std::none_of(problem.bodies.begin(), problem.bodies.end(), is_rigid)) return;  // the rest assembles all others
  double finest_s = std::numeric_limits<double>::infinity();
  for (const BodyProblem& body : problem.bodies)
    if (!is_rigid(body))
      finest_s = std::min(finest_s, element_bound_time_step(body, std::vector<bool>(body.mesh.elements.size(), true)));
  for (BodyProblem& body : problem.bodies) {
    if (!is_rigid(body)) continue;
    const double own_s = critical_time_step(body, std::vector<bool>(body.mesh.elements.size(), true), true, 0.0);
    const double factor = std::isfinite(own_s) ? std::pow(own_s / (longer * finest_s), 2) : 1.0;
    if (!(factor > 1.0)) continue;
    body.material.youngs_modulus_pa *= factor;
    for (fem::Material& material : body.mesh.materials) material.youngs_modulus_pa *= factor;
  }
}

}  // namespace ricochet::scene

#include "coupler/watch/conserved.hpp"

#include "coupler/results/history_file.hpp"

namespace ricochet::coupler {

Conserved conserved_by(const scene::Problem& problem) {
  Conserved conserved;
  const Eigen::Vector3d normal = scene::momentum_normal(problem);
  if (problem.scene.model == scene::Model::axisymmetric)
    conserved.directions = {{normal[1], normal[0]}};  // t = (-n_y, n_x)
  if (problem.scene.model == scene::Model::solid) conserved.directions.push_back({.b = 1});
  if (angular_components(problem) == 0) return conserved;
  Eigen::Vector3d low = problem.bodies.front().mesh.position.front(), high = low;
  for (const auto& body : problem.bodies) {
    for (const auto& x : body.mesh.position) {
      low = low.cwiseMin(x);
      high = high.cwiseMax(x);
    }
  }
  conserved.arm_m = 0.5 * (high - low).norm();
  return conserved;
}

}  // namespace ricochet::coupler

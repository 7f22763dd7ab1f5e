#include "common/solver/probe_shares.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "common/fem/hanging_nodes.hpp"

namespace ricochet::solver {
namespace {

int local_node(const fem::Part& part, int body_node) {
  const auto found = std::lower_bound(part.body_node.begin(), part.body_node.end(), body_node);
  return found != part.body_node.end() && *found == body_node ? static_cast<int>(found - part.body_node.begin()) : -1;
}

/// -1: another participant's.
int local_element(const fem::Part& part, int body_element) {
  const auto found = std::find(part.body_element.begin(), part.body_element.end(), body_element);
  return found == part.body_element.end() ? -1 : static_cast<int>(found - part.body_element.begin());
}

/// Stress of an element at a point as a matrix: its columns are the stresses of unit displacements.
Eigen::MatrixXd stress_operator(const scene::BodyProblem& body, const scene::StrainPoint& point) {
  const auto element = fem::element_geometry(body.mesh, point.element);
  const Eigen::Index dofs = element.x.rows() * fem::components(body.mesh.model);
  Eigen::MatrixXd stress;
  for (Eigen::Index dof = 0; dof < dofs; ++dof) {
    const fem::ElementVector unit = Eigen::VectorXd::Unit(dofs, dof);
    const Eigen::VectorXd column =
        fem::element_stress(body.section, fem::material_of(body, point.element), element, unit, point.at);
    if (dof == 0) stress.resize(column.size(), dofs);
    stress.col(dof) = column;
  }
  return stress;
}

/// Strains of the tensor, then stresses.
Eigen::MatrixXd strain_and_stress(const scene::BodyProblem& body, const scene::StrainPoint& point) {
  const Eigen::MatrixXd stress = stress_operator(body, point);
  Eigen::MatrixXd strain =
      fem::elasticity(body.section.model, fem::material_of(body, point.element)).partialPivLu().solve(stress);
  for (Eigen::Index shear = 3; shear < strain.rows(); ++shear) strain.row(shear) *= 0.5;  // from 2 e_xy
  Eigen::MatrixXd both(2 * stress.rows(), stress.cols());
  both << strain, stress;
  return both;
}

}  // namespace

ProbeShares::ProbeShares(const scene::Problem& problem, const std::vector<BodyState>& states) {
  const auto names = scene::probe_columns(problem.scene);
  auto first = names.begin();
  for (const auto& place : scene::measured_places(problem)) {
    const auto of_another = [&](const std::string& name) { return name.substr(0, name.find('.')) != place.name; };
    const auto last = std::find_if(first, names.end(), of_another);
    add(problem, place, states, {first, last});
    first = last;
  }
}

void ProbeShares::add_motion(const scene::BodyProblem& body, const scene::StrainPoint& point, std::size_t part,
                             const BodyState& state, Told& told, double& share) {
  const auto& element = body.mesh.elements[fem::at(point.element)];
  const auto values = fem::shape_values(element.kind, point.at);
  const int components = fem::components(body.mesh.model);
  Motion motion{part, {}};
  std::vector<fem::WeightedNode> nodes;
  for (std::size_t i = 0; i < element.size(); ++i) nodes.push_back({element[i], values[static_cast<Eigen::Index>(i)]});
  for (const auto& [body_node, weight] : body.mesh.hanging.empty() ? nodes : fem::carried(body.mesh, nodes)) {
    const int node = local_node(state.part, body_node);
    if (node < 0 || !state.integrated[fem::at(node * components)]) continue;
    motion.nodes.emplace_back(node, weight);
    share += weight;
  }
  if (!motion.nodes.empty()) told.motion.push_back(std::move(motion));
}

void ProbeShares::add_plastic(const std::vector<scene::StrainPoint>& points, const BodyState& state,
                              Strained& strained) {
  if (!state.plastic) return;
  for (const auto& point : points) strained.plastic.emplace_back(local_element(state.part, point.element), point.share);
}

/// The element that holds the probe.
void ProbeShares::add_strain_of_probe(const scene::BodyProblem& body, const scene::StrainPoint& point, std::size_t part,
                                      const BodyState& state, Told& told) {
  const int components = fem::components(body.mesh.model);
  Strained strained{part, {}, strain_and_stress(body, point), true};
  for (const int node : body.mesh.elements[fem::at(point.element)]) {
    for (int c = 0; c < components; ++c) strained.dofs.push_back(local_node(state.part, node) * components + c);
  }
  add_plastic({point}, state, strained);
  told.strains.push_back(std::move(strained));
}

/// All elements of the part together: the mean is one sum over the nodes of all.
void ProbeShares::add_strain_of_gauge(const scene::BodyProblem& body, const std::vector<scene::StrainPoint>& points,
                                      std::size_t part, const BodyState& state, Told& told) {
  const int components = fem::components(body.mesh.model);
  std::map<int, Eigen::Vector2d> shares;
  for (const auto& point : points) {
    const Eigen::MatrixXd rows = strain_and_stress(body, point);
    const Eigen::Index axial = components - 1;  // the axis is the last coordinate
    Eigen::Index column = 0;
    for (const int node : body.mesh.elements[fem::at(point.element)]) {
      for (int c = 0; c < components; ++c, ++column) {
        const Eigen::Vector2d share(rows(axial, column), rows(rows.rows() / 2 + axial, column));
        shares.try_emplace(local_node(state.part, node) * components + c, Eigen::Vector2d::Zero()).first->second +=
            point.share * share;
      }
    }
  }
  Strained strained{part, {}, Eigen::MatrixXd(2, static_cast<Eigen::Index>(shares.size())), false};
  for (const auto& [dof, share] : shares) {
    strained.rows.col(static_cast<Eigen::Index>(strained.dofs.size())) = share;
    strained.dofs.push_back(dof);
  }
  add_plastic(points, state, strained);
  told.strains.push_back(std::move(strained));
}

void ProbeShares::add(const scene::Problem& problem, const scene::MeasuredPlace& place,
                      const std::vector<BodyState>& states, const std::vector<std::string>& names) {
  const auto& body = problem.bodies[fem::at(place.body)];
  Told told;
  double motion_share = 0.0, strain_share = 0.0;
  for (std::size_t part = 0; part < states.size(); ++part) {
    const auto& state = states[part];
    if (state.body != place.body) continue;
    if (!place.gauge) add_motion(body, place.points.front(), part, state, told, motion_share);
    std::vector<scene::StrainPoint> own;
    for (const auto& point : place.points) {
      if (local_element(state.part, point.element) >= 0) own.push_back(point);
    }
    for (const auto& point : own) strain_share += point.share;
    if (own.empty()) continue;
    if (place.gauge) {
      add_strain_of_gauge(body, own, part, state, told);
    } else {
      add_strain_of_probe(body, own.front(), part, state, told);
    }
  }
  const auto motions = place.gauge ? std::size_t{0} : fem::at(3 * problem.scene.components());
  for (std::size_t i = 0; i < names.size(); ++i) {
    const bool tells = i < motions ? !told.motion.empty() : !told.strains.empty();
    if (tells) columns_.push_back(fmt::format("{}/{:.9g}", names[i], i < motions ? motion_share : strain_share));
  }
  if (!told.motion.empty() || !told.strains.empty()) told_.push_back(std::move(told));
}

std::vector<int> ProbeShares::dofs_of(std::size_t part, int components) const {
  std::set<int> dofs;
  for (const auto& told : told_) {
    for (const auto& motion : told.motion) {
      for (const auto& [node, share] : motion.nodes)
        for (int c = 0; motion.part == part && c < components; ++c) dofs.insert(node * components + c);
    }
    for (const auto& strained : told.strains)
      if (strained.part == part) dofs.insert(strained.dofs.begin(), strained.dofs.end());
  }
  return {dofs.begin(), dofs.end()};
}

Eigen::VectorXd ProbeShares::values_of(const Strained& strained, const BodyState& state) {
  Eigen::VectorXd in_frame, u(static_cast<Eigen::Index>(strained.dofs.size()));
  const Eigen::VectorXd& straining = state.straining(in_frame);
  for (Eigen::Index i = 0; i < u.size(); ++i) u[i] = straining[strained.dofs[static_cast<std::size_t>(i)]];
  Eigen::VectorXd values = strained.rows * u;
  const auto stresses = values.size() / 2;
  const int axial = fem::components(state.part.mesh.model) - 1;
  for (const auto& [element, share] : strained.plastic) {
    const fem::StressVector less = share * state.plastic->stress_of(element);
    if (strained.probe) {
      values.tail(stresses) -= less;
    } else {
      values[stresses] -= less[axial];
    }
  }
  if (!strained.probe) return values;
  if (state.frame) {
    const Eigen::Matrix3d rotation = state.rotation();
    values.head(stresses) = fem::turned(fem::StressVector(values.head(stresses)), rotation);
    values.tail(stresses) = fem::turned(fem::StressVector(values.tail(stresses)), rotation);
  }
  const fem::StressVector stress = values.tail(stresses);
  const bool heats = state.plastic && state.plastic->heats();
  values.conservativeResize(values.size() + (strained.plastic.empty() ? 1 : heats ? 3 : 2));
  values[2 * stresses] = fem::von_mises_stress(state.part.mesh.model, stress);
  for (const auto& plastic : strained.plastic) {
    values[2 * stresses + 1] = state.plastic->equivalent_of(plastic.first);
    if (heats) values[2 * stresses + 2] = state.plastic->temperature_of(plastic.first);
  }
  return values;
}

void ProbeShares::append(const std::vector<BodyState>& states, std::int64_t window, std::vector<double>& row) const {
  for (const auto& told : told_) {
    for (const auto& motion : told.motion) {
      const auto& state = states[motion.part];
      require_finite(state, state.u, window);
      const int components = fem::components(state.part.mesh.model);
      for (const auto* vector : {&state.u, &state.v, &state.a}) {
        for (int c = 0; c < components; ++c) {
          double sum = 0.0;
          for (const auto& [node, share] : motion.nodes) sum += share * (*vector)[node * components + c];
          row.push_back(sum);
        }
      }
    }
    for (const auto& strained : told.strains) {
      const auto& state = states[strained.part];
      require_finite(state, state.u, window);
      const Eigen::VectorXd values = values_of(strained, state);
      row.insert(row.end(), values.begin(), values.end());
    }
  }
}

}  // namespace ricochet::solver

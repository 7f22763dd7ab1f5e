#include "common/solver/stress_watch.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "common/fem/element.hpp"

namespace ricochet::solver {
namespace {

bool has_limit(const fem::Material& material) {
  return std::isfinite(material.yield_stress_pa) || std::isfinite(material.strength_pa);
}

Eigen::Vector3d middle(const fem::Mesh& mesh, int element) {
  const auto x = fem::element_geometry(mesh, element).x;
  Eigen::Vector3d place = Eigen::Vector3d::Zero();
  place.head(x.cols()) = x.colwise().mean().transpose();
  return place;
}

template <int dimension>
Eigen::Matrix3d inverse_of(const fem::ElementGeometry& geometry) {
  Displacements places;
  for (Eigen::Index i = 0; i < geometry.x.rows(); ++i) {
    places[static_cast<std::size_t>(i)].setZero();
    places[static_cast<std::size_t>(i)].head(geometry.x.cols()) = geometry.x.row(i).transpose();
  }
  Eigen::Matrix3d inverse = Eigen::Matrix3d::Identity();
  inverse.topLeftCorner<dimension, dimension>() = middle_differences<dimension>(geometry.kind, places).inverse();
  return inverse;
}

Eigen::Matrix3d inverse_of(const fem::ElementGeometry& geometry) {
  switch (fem::traits(geometry.kind).dimension) {
    case 1: return inverse_of<1>(geometry);
    case 2: return inverse_of<2>(geometry);
    default: return inverse_of<3>(geometry);
  }
}

double largest_principal_stress(const BodyState& state, const Eigen::VectorXd& u, int element) {
  const auto& part = state.part;
  const auto geometry = fem::element_geometry(part.mesh, element);
  fem::StressVector stress =
      fem::element_stress(part.section, fem::material_of(part, element), geometry,
                          fem::element_displacement(part.mesh, element, u), fem::traits(geometry.kind).centre);
  if (state.plastic) stress -= state.plastic->stress_of(element);
  return fem::principal_stresses(part.mesh.model, stress)[0];
}

/// A tensor in the order of fem::StressVector off the strains; `third` is the one across a plane.
template <int dimension>
void take_off(const fem::StressVector& strain, Eigen::Matrix<double, dimension, dimension>& gradient, double& third) {
  gradient.diagonal() -= strain.head<dimension>();
  if constexpr (dimension == 2) third -= strain[2];
  constexpr int pairs[3][2] = {{0, 1}, {1, 2}, {2, 0}};
  for (int row = 3; row < strain.size(); ++row) {
    const auto& [c, d] = pairs[row - 3];
    gradient(c, d) -= 2.0 * strain[row];
  }
}

/// The size of one stress [Pa^2, Pa].
struct Size {
  double von_mises_squared, tension_at_most;
};

/// The limits of a material, and what is compared with them.
struct Limits {
  double yield_squared, strength, young, lambda, mu;

  explicit Limits(const fem::Material& m)
      : yield_squared(m.yield_stress_pa * m.yield_stress_pa),
        strength(m.strength_pa),
        young(m.youngs_modulus_pa),
        lambda(young * m.poisson_ratio / ((1.0 + m.poisson_ratio) * (1.0 - 2.0 * m.poisson_ratio))),
        mu(young / (2.0 * (1.0 + m.poisson_ratio))) {}

  [[nodiscard]] Size size(const Eigen::Matrix<double, 1, 1>& gradient, double) const {
    const double axial = young * gradient(0, 0);
    return {axial * axial, axial};
  }
  /// With J_2 of the strain: (von Mises)^2 = 3 (2 mu)^2 J_2, and no principal stress is above the mean by more than two
  /// thirds of von Mises', so that nearly every element needs no more.
  template <int dimension>
  [[nodiscard]] Size size(const Eigen::Matrix<double, dimension, dimension>& gradient, double hoop) const {
    Eigen::Vector3d direct(0.0, 0.0, hoop);
    direct.template head<dimension>() = gradient.diagonal();
    const double trace = direct.sum();
    double j2 = 0.5 * (direct.array() - trace / 3.0).square().sum();
    for (int i = 0; i < dimension; ++i) {
      for (int j = 0; j < i; ++j) j2 += 0.25 * (gradient(i, j) + gradient(j, i)) * (gradient(i, j) + gradient(j, i));
    }
    const double von_mises_squared = 12.0 * mu * mu * j2;
    return {von_mises_squared, (lambda + 2.0 / 3.0 * mu) * trace + 2.0 / 3.0 * std::sqrt(von_mises_squared)};
  }
};

}  // namespace

StressWatch::StressWatch(const std::vector<BodyState>& states) {
  for (const auto& state : states) {
    auto& inverse = inverse_.emplace_back();
    const auto materials = fem::materials_of(state.part);
    if (std::none_of(materials.begin(), materials.end(), [](const auto* own) { return has_limit(*own); })) continue;
    watches_ = true;
    const auto& mesh = state.part.mesh;
    inverse.reserve(mesh.elements.size());
    for (int e = 0; e < static_cast<int>(mesh.elements.size()); ++e)
      inverse.push_back(inverse_of(fem::element_geometry(mesh, e)));
  }
}

StressWatch::Passed StressWatch::look(std::size_t part, const BodyState& state) const {
  Passed passed;
  if (inverse_[part].empty()) return passed;
  switch (fem::components(state.part.mesh.model)) {
    case 1: look<1>(part, state, passed); break;
    case 2: look<2>(part, state, passed); break;
    default: look<3>(part, state, passed);
  }
  return passed;
}

template <int dimension>
void StressWatch::look(std::size_t part, const BodyState& state, Passed& passed) const {
  const auto& mesh = state.part.mesh;
  std::vector<Limits> limits_of{Limits(state.part.material)};
  for (const auto& material : mesh.materials) limits_of.emplace_back(material);
  Eigen::VectorXd in_frame;
  const Eigen::VectorXd& straining = state.straining(in_frame);
  for (std::size_t e = 0; e < mesh.elements.size(); ++e) {
    const auto& nodes = mesh.elements[e];
    Displacements u;
    for (std::size_t i = 0; i < nodes.size(); ++i)
      u[i].template head<dimension>() = straining.template segment<dimension>(nodes[i] * dimension);
    Eigen::Matrix<double, dimension, dimension> gradient =
        middle_differences<dimension>(nodes.kind, u) * inverse_[part][e].template topLeftCorner<dimension, dimension>();
    double hoop = mesh.model == fem::Model::axisymmetric ? hoop_strain(mesh, nodes, u) : 0.0;
    if (state.plastic) take_off(state.plastic->strain_of(static_cast<int>(e)), gradient, hoop);
    const Limits& limits = limits_of[fem::at(1 + fem::material_index(mesh, static_cast<int>(e)))];
    const Size size = limits.size(gradient, hoop);
    if (size.von_mises_squared > limits.yield_squared)
      passed.yield.take(std::sqrt(size.von_mises_squared / limits.yield_squared), std::sqrt(size.von_mises_squared),
                        middle(mesh, static_cast<int>(e)));
    if (size.tension_at_most <= limits.strength) continue;
    const double tension = largest_principal_stress(state, straining, static_cast<int>(e));
    if (tension > limits.strength)
      passed.tension.take(tension / limits.strength, tension, middle(mesh, static_cast<int>(e)));
  }
}

}  // namespace ricochet::solver

#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <optional>

#include "common/fem/plasticity.hpp"

/// Small-strain elasticity and plasticity in three dimensions and in three reduced models. Node-major degrees
/// of freedom: dof = node * components + c.
namespace ricochet::fem {

enum class Model { bar, plane_strain, axisymmetric, solid };
/// As the key `model` of a scene has them.
constexpr std::array<const char*, 4> model_names{"bar", "plane_strain", "axisymmetric", "solid"};
constexpr const char* model_name(Model model) { return model_names[static_cast<std::size_t>(model)]; }

struct Material {
  double youngs_modulus_pa = 0.0;
  double poisson_ratio = 0.0;
  double density_kg_m3 = 0.0;
  /// Up to which the body is what its elements are, linear elastic: von Mises stress and principal tension [Pa].
  double yield_stress_pa = std::numeric_limits<double>::infinity();
  double strength_pa = std::numeric_limits<double>::infinity();
  std::optional<Plasticity> plasticity = std::nullopt;  ///< none: elastic
};

/// Factor that turns the two-dimensional (or line) integral of a model into a volume: cross section [m^2] of a bar,
/// thickness [m] in plane strain, 2 pi in axisymmetry (the integrand there holds r), 1 for a solid. All forces and
/// masses are totals.
struct Section {
  Model model = Model::bar;
  double measure = 1.0;
};

/// Displacement components of a node, and the dimension of the elements.
constexpr int components(Model model) {
  if (model == Model::bar) return 1;
  return model == Model::solid ? 3 : 2;
}
constexpr int stress_components(Model model) {
  if (model == Model::bar) return 1;
  return model == Model::solid ? 6 : 4;
}

}  // namespace ricochet::fem

#pragma once

/// Small-strain linear elasticity in three reduced models. Node-major degrees of freedom: dof = node * components + c.
namespace ricochet::fem {

enum class Model { bar, plane_strain, axisymmetric };

struct Material {
  double youngs_modulus_pa = 0.0;
  double poisson_ratio = 0.0;
  double density_kg_m3 = 0.0;
};

/// Factor that turns the two-dimensional (or line) integral of a model into a volume: cross section [m^2] of a bar,
/// thickness [m] in plane strain, 2 pi in axisymmetry (the integrand there holds r). All forces and masses are totals.
struct Section {
  Model model = Model::bar;
  double measure = 1.0;
};

/// Displacement components of a node, and the dimension of the elements.
constexpr int components(Model model) { return model == Model::bar ? 1 : 2; }
constexpr int stress_components(Model model) { return model == Model::bar ? 1 : 4; }

}  // namespace ricochet::fem

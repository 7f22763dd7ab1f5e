#include <gtest/gtest.h>

#include <Eigen/SparseCholesky>

#include "tests/common/fem/sample_elements.hpp"

namespace ricochet::fem {
namespace {

// Lame's thick cylinder under inner pressure p, plane strain along z:
//   u_r = p a^2/(E (b^2 - a^2)) ((1 + nu)(1 - 2 nu) r + (1 + nu) b^2/r),  s_rr, s_tt = p a^2/(b^2 - a^2) (1 -+ b^2/r^2)
constexpr double inner = 0.01, outer = 0.02, pressure = 50e6;

double exact_displacement(double r) {
  const double e = sample::steel.youngs_modulus_pa, nu = sample::steel.poisson_ratio;
  return pressure * inner * inner / (e * (outer * outer - inner * inner)) *
         ((1.0 + nu) * (1.0 - 2.0 * nu) * r + (1.0 + nu) * outer * outer / r);
}

struct Errors {
  double displacement = 0.0;
  double stress = 0.0;
};

Eigen::VectorXd solve(const Part& part, const Eigen::VectorXd& force) {
  Eigen::SparseMatrix<double> stiffness = part.stiffness;
  Eigen::VectorXd load = force;
  for (int node = 0; node < part.nodes(); ++node) {  // u_z = 0 on every node: plane strain, and no rigid motion
    const int dof = 2 * node + 1;
    stiffness.prune([dof](Eigen::Index i, Eigen::Index j, double) { return i == j || (i != dof && j != dof); });
    load[dof] = 0.0;
  }
  return Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(stiffness).solve(load);
}

/// A distorted mesh, so that the order is not a gift of its regularity.
Errors thick_cylinder(int count) {
  Mesh mesh = quadrilateral_mesh(Model::axisymmetric, graded_coordinates(inner, outer - inner, count, 1.5),
                                 graded_coordinates(0.0, 0.005, count / 2, 1.0));
  for (Eigen::Vector3d& x : mesh.position) {
    x[0] += 0.06 * (x[0] - inner) * (outer - x[0]) / (outer - inner) * std::sin(x[1] / 0.005 * 3.0);
  }
  const Part part = sample::whole_part(mesh, sample::section(Model::axisymmetric));
  const Eigen::VectorXd u = solve(part, traction_force(part, "inner", {pressure, 0.0}));
  Errors errors;
  for (int node = 0; node < part.nodes(); ++node) {
    const double exact = exact_displacement(part.mesh.position[static_cast<std::size_t>(node)][0]);
    errors.displacement = std::max(errors.displacement, std::abs(u[2 * node] / exact - 1.0));
  }
  for (int e = 0; e < static_cast<int>(part.mesh.elements.size()); ++e) {
    const ElementGeometry element = element_geometry(part.mesh, e);
    const ElementCoordinates& x = element.x;
    const StressVector stress = element_stress(part.section, part.material, element,
                                               element_displacement(part.mesh, e, u), NaturalPoint::Zero());
    const double ratio = outer / x.col(0).mean();
    const double factor = pressure * inner * inner / (outer * outer - inner * inner);
    errors.stress = std::max({errors.stress, std::abs(stress[0] - factor * (1.0 - ratio * ratio)) / pressure,
                              std::abs(stress[2] - factor * (1.0 + ratio * ratio)) / pressure});
  }
  return errors;
}

TEST(ThickCylinder, ConvergesWithOrderTwoToLamesSolution) {
  const Errors coarse = thick_cylinder(8), medium = thick_cylinder(16), fine = thick_cylinder(32);
  EXPECT_NEAR(std::log2(medium.displacement / fine.displacement), 2.0, 0.15);
  EXPECT_NEAR(std::log2(coarse.displacement / medium.displacement), 2.0, 0.3);
  EXPECT_GT(std::log2(medium.stress / fine.stress), 1.5);  // largest error; the element centres nearly superconverge
  EXPECT_LT(fine.displacement, 5e-4);
  EXPECT_LT(fine.stress, 2e-3);
}

}  // namespace
}  // namespace ricochet::fem

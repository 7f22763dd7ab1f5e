#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "tests/common/fem/sample_elements.hpp"

namespace ricochet::fem {
namespace {

using sample::steel;

/// A model and the kinds of element that mesh it.
struct Meshed {
  Model model;
  std::string kinds;
};

Mesh mesh_of(const Meshed& meshed) {
  const Mesh mesh = sample::distorted_mesh(meshed.model);
  if (meshed.kinds == "tetrahedra") return sample::tetrahedra_of(mesh);
  if (meshed.kinds == "triangles") return sample::triangulated(mesh);
  return meshed.kinds == "both" ? sample::triangulated(mesh, false) : mesh;
}

class EveryModel : public testing::TestWithParam<Meshed> {
 protected:
  const Model model_ = GetParam().model;
  const Section section_ = sample::section(model_);
  const Part part_ = sample::whole_part(mesh_of(GetParam()), section_);
};

INSTANTIATE_TEST_SUITE_P(Models, EveryModel,
                         testing::Values(Meshed{Model::bar, "bars"}, Meshed{Model::plane_strain, "quadrilaterals"},
                                         Meshed{Model::axisymmetric, "quadrilaterals"},
                                         Meshed{Model::plane_strain, "triangles"},
                                         Meshed{Model::axisymmetric, "triangles"}, Meshed{Model::plane_strain, "both"},
                                         Meshed{Model::axisymmetric, "both"}, Meshed{Model::solid, "hexahedra"},
                                         Meshed{Model::solid, "tetrahedra"}),
                         [](const auto& tested) {
                           return sample::name(tested.param.model) + "_" + tested.param.kinds;
                         });

/// Points of an element, its corners among them.
std::vector<NaturalPoint> points_of(ElementKind kind) {
  const ElementTraits& traits_of_kind = traits(kind);
  std::vector<NaturalPoint> points(traits_of_kind.corner.begin(), traits_of_kind.corner.end());
  points.push_back(traits_of_kind.centre);
  points.push_back(0.3 * points[0] + 0.7 * traits_of_kind.centre);
  return points;
}

/// Linear displacement that each model can hold exactly (axisymmetric: no u_r at r = 0, no shear that varies).
Eigen::Vector3d linear_displacement(Model model, const Eigen::Vector3d& x) {
  if (model == Model::axisymmetric) return {1e-3 * x[0], -4e-4 * x[1] + 2e-5, 0.0};
  return {1e-3 * x[0] + 3e-4 * x[1] + 2e-4 * x[2] + 1e-5, -2e-4 * x[0] - 4e-4 * x[1] + 5e-4 * x[2] + 2e-5,
          -6e-4 * x[0] + 1e-4 * x[1] + 7e-4 * x[2]};
}

StressVector exact_stress(Model model) {
  if (model == Model::bar) return StressVector::Constant(1, steel.youngs_modulus_pa * 1e-3);
  if (model == Model::solid) {
    Eigen::Matrix<double, 6, 1> strain;
    strain << 1e-3, -4e-4, 7e-4, 1e-4, 6e-4, -4e-4;
    return elasticity(model, steel) * strain;
  }
  const Eigen::Vector4d strain =
      model == Model::axisymmetric ? Eigen::Vector4d(1e-3, -4e-4, 1e-3, 0.0) : Eigen::Vector4d(1e-3, -4e-4, 0.0, 1e-4);
  return elasticity(model, steel) * strain;
}

TEST_P(EveryModel, PatchTestGivesTheExactStressEverywhere) {
  const Eigen::VectorXd u = sample::nodal(part_.mesh, [&](const auto& x) { return linear_displacement(model_, x); });
  const StressVector expected = exact_stress(model_);
  for (int e = 0; e < static_cast<int>(part_.mesh.elements.size()); ++e) {
    const ElementGeometry element = element_geometry(part_.mesh, e);
    for (const NaturalPoint& at : points_of(element.kind)) {
      const StressVector stress = element_stress(section_, steel, element, element_displacement(part_.mesh, e, u), at);
      EXPECT_LT(sample::relative_error(stress, expected), model_ == Model::bar ? 1e-11 : 1e-10)
          << "element " << e << " at " << at.transpose();
    }
  }
}

TEST_P(EveryModel, PatchTestLeavesInnerNodesInEquilibrium) {
  const Eigen::VectorXd u = sample::nodal(part_.mesh, [&](const auto& x) { return linear_displacement(model_, x); });
  const Eigen::VectorXd force = part_.stiffness * u;
  const int dofs_per_node = components(model_);
  const double low = model_ == Model::bar ? 0.0 : 0.01;
  int inner = 0;
  for (int i = 0; i < part_.dofs(); ++i) {
    const Eigen::Vector3d& x = part_.mesh.position[static_cast<std::size_t>(i / dofs_per_node)];
    if (model_ == Model::solid && (x[1] < 1e-6 || x[1] > 0.02 - 1e-6)) continue;
    const double along = axis_coordinate(model_, x);
    if (along < low + 1e-6 || along > 0.05 - 1e-6) continue;
    if (model_ != Model::bar && (x[0] < 1e-6 || x[0] > 0.03 - 1e-6)) continue;
    ++inner;
    EXPECT_LT(std::abs(force[i]), (model_ == Model::bar ? 1e-11 : 1e-10) * force.norm()) << "dof " << i;
  }
  EXPECT_GE(inner, 3);
}

TEST_P(EveryModel, RigidMotionGivesNoForce) {
  const double scale = part_.stiffness.coeffs().abs().maxCoeff();
  std::vector<std::function<Eigen::Vector3d(const Eigen::Vector3d&)>> motions;
  const bool turns = model_ == Model::plane_strain || model_ == Model::solid;
  if (model_ != Model::axisymmetric) motions.push_back([](const auto&) { return Eigen::Vector3d(1.0, 0.0, 0.0); });
  if (model_ != Model::bar) motions.push_back([](const auto&) { return Eigen::Vector3d(0.0, 1.0, 0.0); });
  if (turns) motions.push_back([](const auto& x) { return Eigen::Vector3d(-x[1], x[0], 0.0); });
  if (model_ == Model::solid) {
    motions.push_back([](const auto&) { return Eigen::Vector3d(0.0, 0.0, 1.0); });
    motions.push_back([](const auto& x) { return Eigen::Vector3d(0.0, -x[2], x[1]); });
    motions.push_back([](const auto& x) { return Eigen::Vector3d(x[2], 0.0, -x[0]); });
  }
  for (const auto& motion : motions) {
    const Eigen::VectorXd u = sample::nodal(part_.mesh, motion);
    EXPECT_LT((part_.stiffness * u).norm(), (model_ == Model::bar ? 1e-13 : 2e-11) * scale * u.norm());
  }
}

TEST_P(EveryModel, StiffnessHasTheRankOfItsStrainsAndNoNegativeEigenvalue) {
  const ElementMatrix stiffness = element_stiffness(section_, steel, element_geometry(part_.mesh, 1));
  EXPECT_EQ(stiffness, stiffness.transpose());
  const Eigen::VectorXd values = Eigen::SelfAdjointEigenSolver<ElementMatrix>(stiffness).eigenvalues();
  const int rigid_motions = model_ == Model::solid ? 6 : model_ == Model::plane_strain ? 3 : 1;
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    if (i < rigid_motions) {
      EXPECT_LT(std::abs(values[i]), 1e-12 * values[values.size() - 1]);
    } else {
      EXPECT_GT(values[i], 1e-4 * values[values.size() - 1]);
    }
  }
}

/// The modes of a hexahedron do no work with the stress that they leave, so that here, too, W = 1/2 stress . strain.
double strain_energy_of_solid(const Section& section, const ElementGeometry& element, const ElementVector& u) {
  const Eigen::Matrix<double, 6, 6> compliance = elasticity(section.model, steel).inverse();
  const bool hexahedron = element.kind == ElementKind::hexahedron;
  double energy = 0.0;
  for (const NaturalPoint& corner : traits(element.kind).corner) {
    const NaturalPoint at = hexahedron ? NaturalPoint(corner / std::sqrt(3.0)) : NaturalPoint::Constant(0.25);
    const Eigen::Matrix<double, 6, 1> stress = element_stress(section, steel, element, u, at);
    const double weight = hexahedron ? 1.0 : 1.0 / 24.0;
    energy += 0.5 * stress.dot(compliance * stress) * weight * traits(element.kind).jacobian(element.x, at);
  }
  return energy;
}

/// W(u) of one element from stresses alone, without the stiffness.
double strain_energy(const Section& section, const ElementGeometry& element, const ElementVector& u) {
  const ElementCoordinates& x = element.x;
  if (element.kind == ElementKind::bar) {
    const double stress = element_stress(section, steel, element, u, {0.0, 0.0, 0.0})[0];
    return 0.5 * stress * stress / steel.youngs_modulus_pa * section.measure * (x(1, 0) - x(0, 0));
  }
  if (section.model == Model::solid) return strain_energy_of_solid(section, element, u);
  const Eigen::Matrix4d compliance = elasticity(section.model, steel).inverse();
  const bool triangle = element.kind == ElementKind::triangle;
  const double gauss = 1.0 / std::sqrt(3.0), third = 1.0 / 6.0;  // the rules the elements are defined with
  const std::vector<NaturalPoint> points =
      triangle ? std::vector<NaturalPoint>{{third, third, 0.0}, {4.0 * third, third, 0.0}, {third, 4.0 * third, 0.0}}
               : std::vector<NaturalPoint>{
                     {-gauss, -gauss, 0.0}, {gauss, -gauss, 0.0}, {gauss, gauss, 0.0}, {-gauss, gauss, 0.0}};
  double energy = 0.0;
  for (const NaturalPoint& at : points) {
    const Eigen::Vector4d stress = element_stress(section, steel, element, u, at);
    double radius = 0.0;
    for (int i = 0; i < x.rows(); ++i) {
      const NaturalPoint& corner = traits(element.kind).corner[static_cast<std::size_t>(i)];
      const double bilinear = 0.25 * (1.0 + corner[0] * at[0]) * (1.0 + corner[1] * at[1]);
      const double linear = i == 0 ? 1.0 - at[0] - at[1] : at[i - 1 > 0 ? 1 : 0];
      radius += (triangle ? linear : bilinear) * x(i, 0);
    }
    const double factor = section.model == Model::axisymmetric ? radius : 1.0, weight = triangle ? third : 1.0;
    energy += 0.5 * stress.dot(compliance * stress) * section.measure * factor * weight *
              traits(element.kind).jacobian(x, at);
  }
  return energy;
}

TEST_P(EveryModel, ForcesAreTheDerivativesOfTheStrainEnergy) {
  for (int e = 0; e < static_cast<int>(part_.mesh.elements.size()); ++e) {
    const ElementGeometry element = element_geometry(part_.mesh, e);
    const int size = static_cast<int>(element.x.rows()) * components(model_);
    ElementVector u(size);
    for (int i = 0; i < size; ++i) u[i] = 1e-5 * std::sin(2.0 * i + e + 0.4);
    const ElementVector force = element_stiffness(section_, steel, element) * u;
    for (int i = 0; i < size; ++i) {
      const ElementVector step = 1e-6 * ElementVector::Unit(size, i);
      const double slope =
          (strain_energy(section_, element, u + step) - strain_energy(section_, element, u - step)) / 2e-6;
      EXPECT_NEAR(force[i], slope, (model_ == Model::solid ? 1e-7 : 1e-8) * force.norm())
          << "element " << e << ", dof " << i;
    }
    const double round_off = model_ == Model::bar ? 1e-12 : 1e-10;  // places are rounded to 1e-11 (matrix_places)
    EXPECT_NEAR(0.5 * u.dot(force), strain_energy(section_, element, u), round_off * std::abs(u.dot(force)));
  }
}

// The integrands N_i r det J are cubic in each natural coordinate, so 2x2 Gauss points take them exactly: the mass of
// the body of revolution of straight-sided quadrilaterals is exact, however distorted they are inside. The triangle's
// rule takes its N_i r exactly.
TEST_P(EveryModel, LumpedMassIsPositiveAndSumsToDensityTimesVolume) {
  const double length = model_ == Model::bar ? 0.05 : 0.04;
  double area = section_.measure;
  if (model_ == Model::plane_strain) area *= 0.03;
  if (model_ == Model::solid) area = 0.03 * 0.02;
  if (model_ == Model::axisymmetric) area = std::numbers::pi * 0.03 * 0.03;
  EXPECT_NEAR(part_.lumped_mass.sum(), 7850.0 * area * length,
              (model_ == Model::solid ? 1e-10 : 1e-12) * 7850.0 * area * length);
  EXPECT_GT(part_.lumped_mass.minCoeff(), 0.0);
}

TEST(LumpedMass, OfAConicalFrustumIsExact) {
  ElementGeometry quadrilateral{ElementKind::quadrilateral, ElementCoordinates(4, 2)};
  quadrilateral.x << 0.0, 0.0, 0.04, 0.0, 0.01, 0.03, 0.0, 0.03;
  const double volume = std::numbers::pi * 0.03 / 3.0 * (0.04 * 0.04 + 0.04 * 0.01 + 0.01 * 0.01);
  EXPECT_NEAR(element_volume(sample::section(Model::axisymmetric), quadrilateral).sum(), volume, 1e-13 * volume);
}

// A cone with its node on the axis: m_i = 2 pi rho integral of N_i r dA with r = R N_1 is 2 pi rho R A/6 for the rim
// and half of that for the others.
TEST(LumpedMass, OfAConeIsExactAtEachNode) {
  ElementGeometry cone{ElementKind::triangle, ElementCoordinates(3, 2)};
  cone.x << 0.0, 0.0, 0.03, 0.0, 0.0, 0.04;
  const double rim = 2.0 * std::numbers::pi * 0.03 * (0.5 * 0.03 * 0.04) / 6.0;
  const Eigen::VectorXd volume = element_volume(sample::section(Model::axisymmetric), cone);
  EXPECT_NEAR(volume[0], 0.5 * rim, 1e-13 * rim);
  EXPECT_NEAR(volume[1], rim, 1e-13 * rim);
  EXPECT_NEAR(volume[2], 0.5 * rim, 1e-13 * rim);
}

TEST(HoopStrain, TakesItsLimitOnTheAxis) {
  ElementGeometry x{ElementKind::quadrilateral, ElementCoordinates(4, 2)};
  x.x << 0.0, 0.0, 0.02, 0.001, 0.021, 0.02, 0.0, 0.018;
  ElementVector u(8);
  u << 0.0, 1e-5, 3e-5, 0.0, 2e-5, 1e-5, 0.0, -1e-5;
  const Section axisymmetric = sample::section(Model::axisymmetric);
  const StressVector on_axis = element_stress(axisymmetric, steel, x, u, {-1.0, 0.2, 0.0});
  const StressVector beside = element_stress(axisymmetric, steel, x, u, {-1.0 + 1e-6, 0.2, 0.0});
  EXPECT_NEAR(on_axis[0], on_axis[2], 1e-9 * std::abs(on_axis[0])) << "e_rr = e_tt on the axis";
  EXPECT_LT(sample::relative_error(beside, on_axis), 1e-5);
}

TEST(ElementFrequency, OfABarIsTwiceTheWaveSpeedOverItsLength) {
  ElementGeometry x{ElementKind::bar, ElementCoordinates(2, 2)};
  x.x << 0.3, 0.0, 0.325, 0.0;
  const double c = longitudinal_wave_speed(Model::bar, steel);
  const double frequency = std::sqrt(element_max_frequency_squared(sample::section(Model::bar), steel, x));
  EXPECT_NEAR(frequency, 2.0 * c / 0.025, 1e-12 * frequency);
}

TEST(ElementFrequency, IsAboveALimitExactlyIfTheEigenvalueIs) {
  ElementGeometry x{ElementKind::quadrilateral, ElementCoordinates(4, 2)};
  x.x << 0.01, 0.0, 0.013, 0.001, 0.0125, 0.002, 0.0095, 0.0015;
  for (const Model model : {Model::plane_strain, Model::axisymmetric}) {
    const Section section = sample::section(model);
    const double frequency_squared = element_max_frequency_squared(section, steel, x);
    for (const double share : {1e-3, 0.5, 0.999, 1.001, 2.0, 1e3}) {
      EXPECT_EQ(element_frequency_squared_above(section, steel, x, share * frequency_squared), share < 1.0) << share;
    }
  }
}

TEST(EdgeArea, IsExactInEveryModel) {
  EXPECT_EQ(edge_area(sample::section(Model::bar), {0.1, 0.0}, {0.1, 0.0}), Eigen::Vector2d(2.5e-4, 0.0));
  const Eigen::Vector2d a(0.01, 0.02), b(0.04, 0.06);
  const Eigen::Vector2d plane = edge_area(sample::section(Model::plane_strain), a, b);
  EXPECT_NEAR(plane[0], 0.5 * 0.03 * 0.05, 1e-15);
  EXPECT_NEAR(plane[1], plane[0], 1e-18);
  // Mantle of a frustum; the share of each node against Simpson's rule, which is exact for r N.
  const Eigen::Vector2d cone = edge_area(sample::section(Model::axisymmetric), a, b);
  EXPECT_NEAR(cone.sum(), std::numbers::pi * (0.01 + 0.04) * 0.05, 1e-15);
  EXPECT_NEAR(cone[0], 2.0 * std::numbers::pi * 0.05 / 6.0 * (0.01 + 4.0 * 0.5 * 0.025), 1e-15);
}

}  // namespace
}  // namespace ricochet::fem

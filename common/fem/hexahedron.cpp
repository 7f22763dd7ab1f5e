#include "common/fem/hexahedron.hpp"

#include <Eigen/Cholesky>

#include "common/fem/mean_volume_strain.hpp"
#include "common/fem/solid.hpp"

namespace ricochet::fem {
namespace {

struct Trilinear {
  static constexpr int nodes = 8;
  static constexpr double g = 0.57735026918962576451;  // 1/sqrt(3)
  static constexpr SolidPoint points[8] = {{-g, -g, -g, 1.0}, {g, -g, -g, 1.0}, {g, g, -g, 1.0}, {-g, g, -g, 1.0},
                                           {-g, -g, g, 1.0},  {g, -g, g, 1.0},  {g, g, g, 1.0},  {-g, g, g, 1.0}};

  static Eigen::Matrix<double, 8, 1> at(const NaturalPoint& p) {
    Eigen::Matrix<double, 8, 1> shape;
    for (Eigen::Index i = 0; i < 8; ++i) {
      const NaturalPoint& corner = traits(ElementKind::hexahedron).corner[static_cast<std::size_t>(i)];
      shape[i] = 0.125 * (1.0 + corner[0] * p[0]) * (1.0 + corner[1] * p[1]) * (1.0 + corner[2] * p[2]);
    }
    return shape;
  }
  static Eigen::Matrix<double, 8, 3> natural_gradient(const NaturalPoint& p) {
    Eigen::Matrix<double, 8, 3> gradient;
    for (Eigen::Index i = 0; i < 8; ++i) {
      const NaturalPoint& corner = traits(ElementKind::hexahedron).corner[static_cast<std::size_t>(i)];
      const Eigen::Array3d factor = 1.0 + corner.array() * p.array();
      gradient.row(i) << 0.125 * corner[0] * factor[1] * factor[2], 0.125 * corner[1] * factor[2] * factor[0],
          0.125 * corner[2] * factor[0] * factor[1];
    }
    return gradient;
  }
};

using Hexahedron = Solid<Trilinear>;
constexpr int modes = 12, dofs = 24;
using ModeStrains = Eigen::Matrix<double, 6, modes>;
using Elasticity = Eigen::Matrix<double, 6, 6>;

/// e of the twelve modes at a point of quadrature.
ModeStrains mode_strains(const Eigen::Matrix3d& middle, double determinant, const NaturalPoint& p) {
  const Eigen::Matrix3d to_middle = middle.inverse().transpose();  // row k: gradient of xi_k
  const double scale = middle.determinant() / determinant;
  const Eigen::Matrix3d gradient = scale * (p.asDiagonal() * to_middle);
  ModeStrains e = ModeStrains::Zero();
  e.leftCols<9>() = Hexahedron::strains(gradient);
  for (int k = 0; k < 3; ++k) e.block<3, 1>(0, 9 + k).setConstant(scale * p[k] * p[(k + 1) % 3]);
  return e;
}

/// K_uu, K_ua and K_aa of displacements u and modes a.
struct Blocks {
  Eigen::Matrix<double, dofs, dofs> uu = Eigen::Matrix<double, dofs, dofs>::Zero();
  Eigen::Matrix<double, dofs, modes> ua = Eigen::Matrix<double, dofs, modes>::Zero();
  Eigen::Matrix<double, modes, modes> aa = Eigen::Matrix<double, modes, modes>::Zero();
};

Blocks blocks(const Elasticity& d, const Hexahedron::Coordinates& x) {
  const Eigen::Matrix3d middle = Hexahedron::jacobian_matrix(x, NaturalPoint::Zero());
  Blocks sum;
  for (const SolidPoint& q : Trilinear::points) {
    const double determinant = Hexahedron::jacobian_matrix(x, q.natural()).determinant();
    const Hexahedron::StrainOperator b = Hexahedron::strain_operator(x, q.natural());
    const ModeStrains e = mode_strains(middle, determinant, q.natural());
    const double volume = q.weight * determinant;
    const Hexahedron::StrainOperator stress = volume * (d * b);
    const ModeStrains mode_stress = volume * (d * e);
    sum.uu.noalias() += b.transpose() * stress;
    sum.ua.noalias() += b.transpose() * mode_stress;
    sum.aa.noalias() += e.transpose() * mode_stress;
  }
  return sum;
}

Eigen::Matrix<double, 1, dofs> mean_volume_strain(const Hexahedron::Coordinates& x) {
  Eigen::Matrix<double, 1, dofs> sum = Eigen::Matrix<double, 1, dofs>::Zero();
  double volume = 0.0;
  for (const SolidPoint& q : Trilinear::points) {
    const double own = q.weight * Hexahedron::jacobian_matrix(x, q.natural()).determinant();
    sum += own * volume_strain(Hexahedron::strain_operator(x, q.natural()));
    volume += own;
  }
  return sum / volume;
}

/// By B-bar, without modes.
ElementMatrix yielding_stiffness(const Elasticity& d, const Hexahedron::Coordinates& x) {
  const Eigen::Matrix<double, 1, dofs> mean = mean_volume_strain(x);
  Eigen::Matrix<double, dofs, dofs> sum = Eigen::Matrix<double, dofs, dofs>::Zero();
  for (const SolidPoint& q : Trilinear::points) {
    Hexahedron::StrainOperator b = Hexahedron::strain_operator(x, q.natural());
    take_volume_strain(mean, b);
    const Hexahedron::StrainOperator stress =
        q.weight * Hexahedron::jacobian_matrix(x, q.natural()).determinant() * (d * b);
    sum.noalias() += b.transpose() * stress;
  }
  return 0.5 * (sum + sum.transpose());
}

}  // namespace

ElementMatrix hexahedron_stiffness(const Section& section, const Material& material, const ElementCoordinates& x) {
  if (material.plasticity) return yielding_stiffness(elasticity(section.model, material), Hexahedron::places(x));
  const Blocks k = blocks(elasticity(section.model, material), Hexahedron::places(x));
  const Eigen::Matrix<double, modes, dofs> follow = k.aa.ldlt().solve(k.ua.transpose());
  const Eigen::Matrix<double, dofs, dofs> stiffness = k.uu - k.ua * follow;
  return 0.5 * (stiffness + stiffness.transpose());
}

Eigen::VectorXd hexahedron_volume(const Section&, const ElementCoordinates& x) {
  return Hexahedron::volume(Hexahedron::places(x));
}

StressVector hexahedron_stress(const Section& section, const Material& material, const ElementCoordinates& x,
                               const ElementVector& u, const NaturalPoint& at) {
  const Hexahedron::Coordinates places = Hexahedron::places(x);
  const Elasticity d = elasticity(section.model, material);
  Eigen::Matrix<double, dofs, 1> displacement;
  for (int i = 0; i < dofs; ++i) displacement[i] = u[i];
  Hexahedron::StrainOperator b = Hexahedron::strain_operator(places, at);
  if (material.plasticity) take_volume_strain(mean_volume_strain(places), b);
  Voigt strain = b * displacement;
  if (!material.plasticity && !at.isZero(0.0)) {  // in the middle the modes have no strain
    const Blocks k = blocks(d, places);
    const Eigen::Matrix<double, modes, 1> a = -k.aa.ldlt().solve(k.ua.transpose() * displacement);
    strain += mode_strains(Hexahedron::jacobian_matrix(places, NaturalPoint::Zero()),
                           Hexahedron::jacobian_matrix(places, at).determinant(), at) *
              a;
  }
  StressVector stress(6);
  for (int i = 0; i < 6; ++i) stress[i] = d.row(i).dot(strain);
  return stress;
}

std::vector<ElementPoint> hexahedron_points(const Section&, const ElementCoordinates& x) {
  const Hexahedron::Coordinates places = Hexahedron::places(x);
  std::vector<ElementPoint> points;
  for (const SolidPoint& q : Trilinear::points) {
    const Eigen::Matrix3d jacobian = Hexahedron::jacobian_matrix(places, q.natural());
    points.push_back(
        {Trilinear::natural_gradient(q.natural()) * jacobian.inverse().transpose(), q.weight * jacobian.determinant()});
  }
  return points;
}

double hexahedron_jacobian(const ElementCoordinates& x, const NaturalPoint& at) { return Hexahedron::jacobian(x, at); }

}  // namespace ricochet::fem

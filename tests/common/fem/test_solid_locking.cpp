#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>
#include <cstdio>

#include "tests/common/fem/sample_elements.hpp"

/// Solids against exact solutions: a beam under end moments and a thick sphere under inner pressure, up to nu = 0.499.
/// Prints the table of docs/limits.md.
namespace ricochet::fem {
namespace {

constexpr double youngs_modulus = 1.0, stiff = 1e9;

using Matrix = Eigen::SparseMatrix<double>;

/// u of K u = f with n . u = 0 on the nodes held by `hold`, by stiff springs.
Eigen::VectorXd displacement(const Part& part, const Eigen::VectorXd& force,
                             const std::function<std::vector<Eigen::Vector3d>(const Eigen::Vector3d&)>& hold) {
  Matrix k = part.stiffness;
  for (int node = 0; node < part.nodes(); ++node) {
    for (const Eigen::Vector3d& n : hold(part.mesh.position[at(node)])) {
      for (int i = 0; i < 9; ++i) k.coeffRef(3 * node + i / 3, 3 * node + i % 3) += stiff * n[i / 3] * n[i % 3];
    }
  }
  return Eigen::SimplicialLDLT<Matrix>(k).solve(force);
}

/// A beam of 10 x 1 x 1 along z, bent by end tractions x: work M^2 L/(E I), whatever nu is, since its sides are free.
double bending(bool tetrahedra, double poisson_ratio, int through_height) {
  Mesh mesh = block_mesh(graded_coordinates(-0.5, 1.0, through_height, 1.0),
                         graded_coordinates(-0.5, 1.0, std::max(1, through_height / 2), 1.0),
                         graded_coordinates(0.0, 10.0, 10 * through_height, 1.0));
  if (tetrahedra) mesh = sample::tetrahedra_of(mesh);
  const Part part = sample::whole_part(mesh, {Model::solid, 1.0}, {youngs_modulus, poisson_ratio, 1.0});
  Eigen::VectorXd force = Eigen::VectorXd::Zero(part.dofs());
  for (const auto& [surface, sign] : {std::pair{"start", -1.0}, std::pair{"end", 1.0}}) {
    for (const Face& face : part.mesh.surfaces.at(surface)) {
      // integral of N_i x dA: exact for rectangles and triangles
      const FaceArea area = face_area(part.section, part.mesh, face);
      double sum = 0.0;
      for (const int node : face) sum += part.mesh.position[at(node)][0];
      for (std::size_t i = 0; i < face.size(); ++i) {
        const double x = part.mesh.position[at(face[i])][0], mean = sum / static_cast<double>(face.size());
        force[3 * face[i] + 2] += sign * area[i] * (mean + (x - mean) / (face.size() == 4 ? 3.0 : 4.0));
      }
    }
  }
  const Eigen::VectorXd u = displacement(part, force, [](const Eigen::Vector3d& x) {
    std::vector<Eigen::Vector3d> held;  // rigid motions, at three corners, and along the axis at a fourth
    const bool start = x[2] == 0.0, end = x[2] == 10.0, low = x[0] == -0.5 && x[1] == -0.5;
    if (start && low) held = {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}};
    if (end && low) held = {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}};
    if (start && x[0] == -0.5 && x[1] == 0.5) held = {{1.0, 0.0, 0.0}};
    return held;
  });
  return force.dot(u) / (10.0 / 12.0);
}

/// The 24th part of a sphere, r = 1 to 2, between planes of symmetry, under inner pressure p = 1:
///   u_r = p a^3/(E (b^3 - a^3)) ((1 - 2 nu) r + (1 + nu) b^3/(2 r^2)).
struct Sphere {
  Part part;
  Eigen::VectorXd force, u;
  double nu;

  Sphere(bool tetrahedra, double poisson_ratio, int through_wall) : nu(poisson_ratio) {
    Mesh mesh =
        block_mesh(graded_coordinates(0.0, 1.0, through_wall, 1.0), graded_coordinates(0.0, 1.0, through_wall, 1.0),
                   graded_coordinates(1.0, 1.0, through_wall, 1.0));
    for (Eigen::Vector3d& x : mesh.position) {
      const double a = std::tan(0.25 * std::numbers::pi * x[0]), b = std::tan(0.25 * std::numbers::pi * x[1]);
      x = x[2] * Eigen::Vector3d(a, b, 1.0).normalized();
    }
    if (tetrahedra) mesh = sample::tetrahedra_of(mesh);
    check_mesh(mesh, "sphere");
    part = sample::whole_part(mesh, {Model::solid, 1.0}, {youngs_modulus, nu, 1.0});
    force = Eigen::VectorXd::Zero(part.dofs());
    for (const Face& face : part.mesh.surfaces.at("start")) {
      const FaceArea area = face_area(part.section, part.mesh, face);
      const Eigen::Vector3d inwards = face_normal(part.mesh, face);
      for (std::size_t i = 0; i < face.size(); ++i) force.segment<3>(3 * face[i]) -= area[i] * inwards;
    }
    u = displacement(part, force, [](const Eigen::Vector3d& x) {
      std::vector<Eigen::Vector3d> held;
      const double half = std::sqrt(0.5);
      if (std::abs(x[0]) < 1e-9) held.emplace_back(1.0, 0.0, 0.0);
      if (std::abs(x[1]) < 1e-9) held.emplace_back(0.0, 1.0, 0.0);
      if (std::abs(x[0] - x[2]) < 1e-9) held.emplace_back(half, 0.0, -half);
      if (std::abs(x[1] - x[2]) < 1e-9) held.emplace_back(0.0, half, -half);
      return held;
    });
  }
  [[nodiscard]] double exact(double r) const {
    return 1.0 / (7.0 * youngs_modulus) * ((1.0 - 2.0 * nu) * r + (1.0 + nu) * 8.0 / (2.0 * r * r));
  }
  [[nodiscard]] double work() const { return force.dot(u) / (4.0 * std::numbers::pi / 24.0 * exact(1.0)); }
  /// Root of the mean square of the error of the displacement at the nodes, over the largest displacement.
  [[nodiscard]] double error() const {
    double sum = 0.0;
    for (int node = 0; node < part.nodes(); ++node) {
      const Eigen::Vector3d& x = part.mesh.position[at(node)];
      sum += (u.segment<3>(3 * node) - exact(x.norm()) * x.normalized()).squaredNorm();
    }
    return std::sqrt(sum / part.nodes()) / exact(1.0);
  }
};

double pressure(bool tetrahedra, double poisson_ratio, int through_wall) {
  return Sphere(tetrahedra, poisson_ratio, through_wall).work();
}

struct Row {
  const char* body;
  double (*share)(bool tetrahedra, double poisson_ratio, int elements);
  double poisson_ratio;
  int elements;
  double hexahedra, tetrahedra;  ///< as docs/limits.md has them
};

TEST(SolidLocking, IsAsTheTableOfLimitsHasIt) {
  constexpr Row rows[] = {
      {"beam, elements through the height", bending, 0.3, 1, 1.0, 0.225},
      {"beam, elements through the height", bending, 0.3, 4, 1.0, 0.798},
      {"beam, elements through the height", bending, 0.499, 4, 1.0, 0.091},
      {"thick sphere, elements through the wall", pressure, 0.3, 8, 0.989, 0.978},
      {"thick sphere, elements through the wall", pressure, 0.49, 8, 0.986, 0.883},
      {"thick sphere, elements through the wall", pressure, 0.499, 8, 0.986, 0.79},
  };
  for (const Row& row : rows) {
    const double hexahedra = row.share(false, row.poisson_ratio, row.elements);
    const double tetrahedra = row.share(true, row.poisson_ratio, row.elements);
    std::printf("| %s: %d | %g | %.3f | %.3f |\n", row.body, row.elements, row.poisson_ratio, hexahedra, tetrahedra);
    EXPECT_NEAR(hexahedra, row.hexahedra, 6e-4);
    EXPECT_NEAR(tetrahedra, row.tetrahedra, 6e-4);
  }
}

TEST(SolidOrder, IsTwoInDisplacement) {
  for (const bool tetrahedra : {false, true}) {
    for (const double nu : {0.3, 0.499}) {
      const double coarse = Sphere(tetrahedra, nu, 4).error(), fine = Sphere(tetrahedra, nu, 8).error();
      std::printf("%s, nu = %g: error %.2e and %.2e, order %.2f\n", tetrahedra ? "tetrahedra" : "hexahedra", nu, coarse,
                  fine, std::log2(coarse / fine));
      if (tetrahedra && nu > 0.49) continue;  // they lock
      EXPECT_GT(std::log2(coarse / fine), tetrahedra ? 1.7 : 1.8);
    }
  }
}

}  // namespace
}  // namespace ricochet::fem

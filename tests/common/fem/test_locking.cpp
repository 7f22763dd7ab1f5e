#include <gtest/gtest.h>

#include <Eigen/SparseCholesky>
#include <cstdio>

#include "tests/common/fem/sample_elements.hpp"

/// How much stiffer elements are than the bodies they mesh: the work of the loads over that of the exact solution, 1
/// for an exact element. Prints the table of docs/limits.md.
namespace ricochet::fem {
namespace {

constexpr double youngs_modulus = 1.0;

/// f . K^-1 f with the listed dofs held.
double work(const Part& part, const Eigen::VectorXd& force, const std::vector<int>& held) {
  Eigen::SparseMatrix<double> k = part.stiffness;
  Eigen::VectorXd f = force;
  for (const int dof : held) {
    k.coeffRef(dof, dof) = 1e12 * youngs_modulus;
    f[dof] = 0.0;
  }
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(k);
  return f.dot(factor.solve(f));
}

/// A beam of height 1 and length 10 in plane strain, bent by end tractions y: the beam's ends turn by M L/(E' I),
/// E' = E/(1 - nu^2), and stay plane.
double bending(bool triangles, double poisson_ratio, int through_height) {
  Mesh mesh = quadrilateral_mesh(Model::plane_strain, graded_coordinates(0.0, 10.0, 10 * through_height, 1.0),
                                 graded_coordinates(-0.5, 1.0, through_height, 1.0));
  if (triangles) mesh = sample::triangulated(mesh);
  const Part part = sample::whole_part(mesh, {Model::plane_strain, 1.0}, {youngs_modulus, poisson_ratio, 1.0});
  Eigen::VectorXd force = Eigen::VectorXd::Zero(part.dofs());
  for (const auto& [surface, sign] : {std::pair{"inner", -1.0}, std::pair{"outer", 1.0}}) {
    for (const Face& edge : part.mesh.surfaces.at(surface)) {
      const int a = edge[0], b = edge[1];
      const double ya = part.mesh.position[at(a)][1], yb = part.mesh.position[at(b)][1], length = std::abs(yb - ya);
      force[2 * a] += sign * length * (2.0 * ya + yb) / 6.0;
      force[2 * b] += sign * length * (ya + 2.0 * yb) / 6.0;
    }
  }
  const int last = 10 * through_height;  // two nodes of the lower edge hold the rigid motions
  const double inertia = 1.0 / 12.0, moment = inertia;
  const double exact = moment * moment * 10.0 * (1.0 - poisson_ratio * poisson_ratio) / (youngs_modulus * inertia);
  return work(part, force, {0, 1, 2 * last + 1}) / exact;
}

/// A thick cylinder, r = 1 to 2, its ends held, under internal pressure p = 1: 2 pi r_i h p u(r_i) by Lame,
/// u = (1 + nu) p r_i^2/(E (r_o^2 - r_i^2)) ((1 - 2 nu) r + r_o^2/r).
double pressure(bool triangles, double poisson_ratio, int through_wall) {
  Mesh mesh = quadrilateral_mesh(Model::axisymmetric, graded_coordinates(1.0, 1.0, through_wall, 1.0),
                                 graded_coordinates(0.0, 0.5, std::max(1, through_wall / 2), 1.0));
  if (triangles) mesh = sample::triangulated(mesh);
  const Part part =
      sample::whole_part(mesh, sample::section(Model::axisymmetric), {youngs_modulus, poisson_ratio, 1.0});
  std::vector<int> held;
  for (const char* end : {"start", "end"}) {
    for (const int node : surface_nodes(part.mesh, end)) held.push_back(2 * node + 1);
  }
  const double displacement = (1.0 + poisson_ratio) / (3.0 * youngs_modulus) * (1.0 - 2.0 * poisson_ratio + 4.0);
  return work(part, traction_force(part, "inner", {1.0, 0.0}), held) / (2.0 * std::numbers::pi * 0.5 * displacement);
}

struct Row {
  const char* body;
  double (*share)(bool triangles, double poisson_ratio, int elements);
  double poisson_ratio;
  int elements;
  double quadrilaterals, triangles;  ///< as docs/limits.md has them
};

TEST(Locking, IsAsTheTableOfLimitsHasIt) {
  constexpr Row rows[] = {
      {"beam, elements through the height", bending, 0.3, 1, 0.635, 0.221},
      {"beam, elements through the height", bending, 0.3, 4, 0.965, 0.813},
      {"beam, elements through the height", bending, 0.499, 4, 0.118, 0.089},
      {"thick cylinder, elements through the wall", pressure, 0.3, 8, 0.997, 0.998},
      {"thick cylinder, elements through the wall", pressure, 0.49, 8, 0.961, 0.969},
      {"thick cylinder, elements through the wall", pressure, 0.499, 8, 0.712, 0.792},
  };
  for (const Row& row : rows) {
    const double quadrilaterals = row.share(false, row.poisson_ratio, row.elements);
    const double triangles = row.share(true, row.poisson_ratio, row.elements);
    std::printf("| %s: %d | %g | %.3f | %.3f |\n", row.body, row.elements, row.poisson_ratio, quadrilaterals,
                triangles);
    EXPECT_NEAR(quadrilaterals, row.quadrilaterals, 6e-4);
    EXPECT_NEAR(triangles, row.triangles, 6e-4);
  }
}

TEST(Locking, GoesAwayWithTheSizeOfTheElements) {
  for (const bool triangles : {false, true}) {
    const double coarse = 1.0 - bending(triangles, 0.3, 4), fine = 1.0 - bending(triangles, 0.3, 8);
    EXPECT_GT(std::log2(coarse / fine), 1.7);
  }
}

}  // namespace
}  // namespace ricochet::fem

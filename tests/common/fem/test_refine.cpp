// Elements divided in a box of a mesh, and the nodes that hang on larger ones.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/base/error.hpp"
#include "common/fem/hanging_nodes.hpp"
#include "common/fem/part.hpp"
#include "common/fem/refine.hpp"

namespace ricochet::fem {
namespace {

using testing::HasSubstr;

constexpr Material refined_steel{.youngs_modulus_pa = 200e9, .poisson_ratio = 0.3, .density_kg_m3 = 7800.0};
constexpr double beyond = std::numeric_limits<double>::infinity();

RefinedBox box_of(const Eigen::Vector3d& from, const Eigen::Vector3d& to, int ratio) { return {from, to, ratio}; }

Mesh plate_grid() {
  return quadrilateral_mesh(Model::plane_strain, graded_coordinates(0.0, 4.0, 4, 1.0),
                            graded_coordinates(0.0, 3.0, 3, 1.0));
}
Mesh block_grid() {
  const auto along = graded_coordinates(0.0, 3.0, 3, 1.0);
  return block_mesh(along, along, along);
}
/// With sides that are neither straight nor parallel.
Mesh distorted(Mesh mesh) {
  for (auto& x : mesh.position) {
    const Eigen::Vector3d was = x;
    x[0] += 0.08 * std::sin(2.0 * was[1]) + 0.05 * was[1];
    x[1] += 0.07 * std::cos(1.5 * was[0]);
    if (mesh.model == Model::solid) x[2] += 0.05 * was[0] - 0.03 * was[1];
  }
  return mesh;
}
/// The rows of the plate cut in two.
Mesh of_triangles(const Mesh& mesh) {
  Mesh cut = mesh;
  cut.elements.clear();
  for (const Element& e : mesh.elements) {
    cut.elements.push_back({ElementKind::triangle, {e[0], e[1], e[2]}});
    cut.elements.push_back({ElementKind::triangle, {e[0], e[2], e[3]}});
  }
  return cut;
}

Part assembled_whole(const Mesh& mesh) {
  std::vector<int> all;
  for (int e = 0; e < static_cast<int>(mesh.elements.size()); ++e) all.push_back(e);
  return extract_part(mesh, "body", {mesh.model, 1.0}, refined_steel, all);
}

double volume(const Mesh& mesh) {
  double sum = 0.0;
  for (int e = 0; e < static_cast<int>(mesh.elements.size()); ++e)
    sum += element_volume({mesh.model, 1.0}, element_geometry(mesh, e)).sum();
  return sum;
}

TEST(Refine, DividesTheElementsOfTheBoxAlone) {
  Mesh mesh = plate_grid();
  mesh.element_groups["low"] = {0, 1, 2, 3};
  refine(mesh, box_of({1.0, 0.0, 0.0}, {2.0, 1.0, 0.0}, 3));
  EXPECT_EQ(mesh.elements.size(), 11U + 9U);
  EXPECT_EQ(mesh.position.size(), 20U + 12U);
  EXPECT_EQ(mesh.element_groups["low"].size(), 3U + 9U);
  EXPECT_EQ(mesh.surfaces["start"].size(), 3U + 3U);
  EXPECT_EQ(mesh.surfaces["end"].size(), 4U);
  EXPECT_THAT(mesh.refined_surfaces, testing::ElementsAre("start"));
  EXPECT_EQ(mesh.hanging.size(), 6U) << "two on each edge but the free one";
  EXPECT_NEAR(volume(mesh), 12.0, 1e-14);
  check_mesh(mesh, "body");
  for (const HangingNode& hanging : mesh.hanging) {
    Eigen::Vector3d x = Eigen::Vector3d::Zero();
    for (const auto& [node, weight] : hanging.carriers) {
      EXPECT_EQ(hanging_at(mesh, node), nullptr);
      x += weight * mesh.position[at(node)];
    }
    EXPECT_LT((x - mesh.position[at(hanging.node)]).norm(), 1e-15);
  }
}

/// On an edge of larger elements two nodes carry, on a face four.
TEST(Refine, HangsNodesOfSolidsOnEdgesAndFaces) {
  Mesh mesh = block_grid();
  refine(mesh, box_of({1.0, 1.0, 1.0}, {2.0, 2.0, 2.0}, 2));
  const auto carried_by = [&](std::size_t count) {
    return std::count_if(mesh.hanging.begin(), mesh.hanging.end(),
                         [&](const HangingNode& hanging) { return hanging.carriers.size() == count; });
  };
  EXPECT_EQ(carried_by(2), 12);
  EXPECT_EQ(carried_by(4), 6);
  EXPECT_EQ(mesh.position.size(), 64U + 19U);
  EXPECT_NEAR(volume(mesh), 27.0, 1e-13);
}

TEST(Refine, OfAllElementsIsTheFinerMesh) {
  const auto sorted_places = [](const Mesh& mesh) {
    auto places = mesh.position;
    std::sort(places.begin(), places.end(), [](const auto& a, const auto& b) {
      return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end(),
                                          [](double x, double y) { return x < y - 1e-9; });
    });
    return places;
  };
  Mesh divided = block_grid();
  refine(divided, box_of({-beyond, -beyond, -beyond}, {beyond, beyond, beyond}, 2));
  const auto along = graded_coordinates(0.0, 3.0, 6, 1.0);
  const Mesh finer = block_mesh(along, along, along);
  EXPECT_TRUE(divided.hanging.empty());
  const auto places = sorted_places(divided), expected = sorted_places(finer);
  ASSERT_EQ(places.size(), expected.size());
  for (std::size_t i = 0; i < places.size(); ++i) EXPECT_LT((places[i] - expected[i]).norm(), 1e-14);
  for (const auto& [name, faces] : finer.surfaces) EXPECT_EQ(divided.surfaces[name].size(), faces.size()) << name;
  EXPECT_NEAR(assembled_whole(divided).stiffness.norm() / assembled_whole(finer).stiffness.norm(), 1.0, 1e-12);
}

/// A mesh, its elements' name, and the box in its middle that is divided.
struct Divided {
  const char* name;
  Mesh mesh;
  RefinedBox within;
};

class DividedMeshes : public testing::TestWithParam<int> {
 protected:
  static Divided of(int which) {
    const Eigen::Vector3d from(0.9, 0.9, 0.9), to(3.2, 2.2, 2.2);
    switch (which) {
      case 0: return {"quadrilaterals", distorted(plate_grid()), box_of(from, to, 3)};
      case 1: return {"triangles", distorted(of_triangles(plate_grid())), box_of(from, to, 2)};
      case 2: return {"hexahedra", distorted(block_grid()), box_of(from, to, 2)};
      default:
        return {"axisymmetric",
                quadrilateral_mesh(Model::axisymmetric, graded_coordinates(0.0, 4.0, 4, 1.5),
                                   graded_coordinates(0.0, 3.0, 3, 1.0)),
                box_of({-1.0, 0.0, 0.0}, {2.0, 1.5, 0.0}, 4)};
    }
  }
};

/// The patch test: a motion that is linear in the place strains all elements evenly, and none of the inner nodes is
/// pushed. Hanging nodes, which follow, are where the motion has them.
TEST_P(DividedMeshes, AreInBalanceUnderAnEvenStrain) {
  auto [name, mesh, within] = of(GetParam());
  SCOPED_TRACE(name);
  refine(mesh, within);
  ASSERT_FALSE(mesh.hanging.empty());
  const Part part = assembled_whole(mesh);
  const int n = components(mesh.model);
  Eigen::Matrix3d gradient;
  gradient << 1e-3, -4e-4, 2e-4, 3e-4, -2e-3, 5e-4, 1e-4, -6e-4, 7e-4;
  if (mesh.model == Model::axisymmetric) gradient << 1e-3, 0.0, 0.0, 0.0, -2e-3, 0.0, 0.0, 0.0, 0.0;
  Eigen::VectorXd u(part.dofs());
  for (int dof = 0; dof < u.size(); ++dof) u[dof] = (gradient * mesh.position[at(dof / n)])[dof % n] + 0.1;
  if (mesh.model == Model::axisymmetric)
    for (int dof = 0; dof < u.size(); dof += 2) u[dof] -= 0.1;
  Eigen::VectorXd follows = u;
  follow(part.mesh.hanging, n, follows);
  EXPECT_LT((follows - u).norm(), 1e-13);
  const Eigen::VectorXd force = part.stiffness * u;
  std::vector<bool> outside(mesh.position.size(), false);
  for (const auto& [surface, faces] : mesh.surfaces)
    for (const Face& face : faces)
      for (const int node : face) outside[at(node)] = true;
  double inner = 0.0;
  for (int dof = 0; dof < force.size(); ++dof)
    if (!outside[at(dof / n)]) inner = std::max(inner, std::abs(force[dof]));
  EXPECT_LT(inner, 1e-10 * force.cwiseAbs().maxCoeff());
}

/// Sums and first moments of the mass stay; no frequency is above that of the elements alone.
TEST_P(DividedMeshes, KeepTheirMassAndTheBoundOfTheirElements) {
  auto [name, mesh, within] = of(GetParam());
  SCOPED_TRACE(name);
  refine(mesh, within);
  const Part part = assembled_whole(mesh);
  double mass = 0.0;
  Eigen::Vector3d moment = Eigen::Vector3d::Zero(), of_elements = moment;
  for (int e = 0; e < static_cast<int>(mesh.elements.size()); ++e) {
    const Eigen::VectorXd own = element_lumped_mass(part.section, refined_steel, element_geometry(mesh, e));
    mass += own.sum();
    for (int i = 0; i < own.size(); ++i) of_elements += own[i] * mesh.position[at(mesh.elements[at(e)][at(i)])];
  }
  for (int node = 0; node < part.nodes(); ++node) moment += part.lumped_mass[node] * mesh.position[at(node)];
  EXPECT_NEAR(part.lumped_mass.sum() / mass, 1.0, 1e-14);
  EXPECT_LT((moment - of_elements).norm(), 1e-13 * of_elements.norm());
  std::vector<bool> held(static_cast<std::size_t>(part.dofs()), false);
  for (const HangingNode& hanging : mesh.hanging) {
    EXPECT_EQ(part.lumped_mass[hanging.node], 0.0);
    for (int c = 0; c < components(mesh.model); ++c) held[at(hanging.node * components(mesh.model) + c)] = true;
  }
  const double step_s =
      2.0 / std::sqrt(max_frequency_squared(part.stiffness, part.lumped_mass, components(mesh.model), held));
  EXPECT_GE(step_s, element_critical_time_step(part));
  EXPECT_LT(step_s, 3.0 * element_critical_time_step(part));
}

/// A traction does the same work on whatever size its faces have.
TEST_P(DividedMeshes, TakeTheSameForceAndMomentOfATraction) {
  auto [name, mesh, within] = of(GetParam());
  SCOPED_TRACE(name);
  const std::vector<double> traction(at(components(mesh.model)), 3e6);
  const auto sums = [&](const Mesh& of) {
    const Part part = assembled_whole(of);
    const Eigen::VectorXd force = traction_force(part, "start", traction);
    Eigen::Vector3d sum(0.0, 0.0, 0.0);
    for (int node = 0; node < part.nodes(); ++node)
      sum +=
          force[node * components(of.model)] * Eigen::Vector3d(1.0, of.position[at(node)][0], of.position[at(node)][1]);
    return sum;
  };
  const bool round = mesh.model == Model::axisymmetric;
  const Eigen::Vector3d before = sums(mesh);
  within.from_m = Eigen::Vector3d::Constant(-1.0);
  refine(mesh, within);
  const Eigen::Vector3d after = sums(mesh);
  // Bilinear edges and faces that are not flat have another area when they are cut; these are flat or straight.
  EXPECT_NEAR(after[0] / before[0], 1.0, mesh.model == Model::solid ? 2e-3 : 1e-12);
  if (!round && mesh.model != Model::solid) {
    EXPECT_LT((after - before).norm(), 1e-12 * before.norm());
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, DividedMeshes, testing::Range(0, 4));

TEST(Refine, GoesOnWithinABoxThatLeavesALayer) {
  Mesh mesh = plate_grid();
  refine(mesh, box_of({1.0, 0.0, 0.0}, {3.0, 2.0, 0.0}, 4));
  refine(mesh, box_of({1.5, 0.0, 0.0}, {2.5, 1.0, 0.0}, 4));
  for (const HangingNode& hanging : mesh.hanging)
    for (const auto& carrier : hanging.carriers) EXPECT_EQ(hanging_at(mesh, carrier.node), nullptr);
  const Part part = assembled_whole(mesh);
  Eigen::VectorXd u(part.dofs());
  for (int dof = 0; dof < u.size(); ++dof) u[dof] = dof % 2 == 0 ? mesh.position[at(dof / 2)][1] : 0.0;
  const Eigen::VectorXd force = part.stiffness * u;
  EXPECT_NEAR(force.dot(u) / (refined_steel.youngs_modulus_pa / 2.6 * 12.0), 1.0, 1e-12)
      << "G gamma^2 V of a pure shear";
}

/// An element that repeats across the period of the mesh keeps its new nodes within one.
TEST(Refine, CutsElementsAcrossThePeriod) {
  Mesh mesh;
  mesh.model = Model::plane_strain;
  mesh.period_m = 3.0;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) mesh.position.emplace_back(column, row, 0.0);
  for (int row = 0; row < 2; ++row)
    for (int column = 0; column < 3; ++column)
      mesh.elements.push_back(
          {ElementKind::quadrilateral,
           {row * 3 + column, row * 3 + (column + 1) % 3, row * 3 + 3 + (column + 1) % 3, row * 3 + 3 + column}});
  refine(mesh, box_of({-beyond, 0.0, 0.0}, {beyond, 1.0, 0.0}, 2));
  EXPECT_EQ(mesh.hanging.size(), 3U);
  EXPECT_NEAR(volume(mesh), 6.0, 1e-14);
  for (const auto& x : mesh.position) {
    EXPECT_GE(x[0], 0.0);
    EXPECT_LT(x[0], 3.0);
  }
}

std::string refusal_of(Mesh mesh, const std::vector<RefinedBox>& boxes) {
  try {
    for (const RefinedBox& of : boxes) refine(mesh, of);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "none";
}

TEST(Refine, RefusesWhatItCannotDivide) {
  const RefinedBox left = box_of({0.0, 0.0, 0.0}, {2.0, 3.0, 0.0}, 2);
  EXPECT_THAT(refusal_of(plate_grid(), {box_of({5.0, 0.0, 0.0}, {6.0, 1.0, 0.0}, 2)}),
              HasSubstr("found no element whose middle lies in the box"));
  EXPECT_THAT(refusal_of(plate_grid(), {left, left}), HasSubstr("beside elements of another size"));
  EXPECT_THAT(refusal_of(plate_grid(), {left, box_of({2.0, 0.0, 0.0}, {3.0, 3.0, 0.0}, 2)}),
              HasSubstr("a whole layer of elements between two changes of size"));
  EXPECT_THAT(refusal_of(block_grid(), {box_of({0.0, 0.0, 0.0}, {3.0, 3.0, 3.0}, 64)}),
              HasSubstr("found 7077888 elements"));
  Mesh tetrahedra;
  tetrahedra.model = Model::solid;
  tetrahedra.position = {{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}};
  tetrahedra.elements = {{ElementKind::tetrahedron, {0, 1, 2, 3}}};
  EXPECT_THAT(refusal_of(tetrahedra, {box_of({0.0, 0.0, 0.0}, {1.0, 1.0, 1.0}, 2)}),
              HasSubstr("found a tetrahedron at"));
}

/// The large face and the small ones on it lie inside the body; the faces of the boundary do not.
TEST(FacesBetweenSizes, AreThoseOnTheChangeOfSize) {
  for (const bool solid : {false, true}) {
    Mesh mesh = solid ? block_grid() : plate_grid();
    refine(mesh, box_of({-1.0, -1.0, -1.0}, {2.0, 2.0, 2.0}, 4));
    const FacesBetweenSizes inside(mesh);
    int found = 0;
    for (const Element& element : mesh.elements) {
      for (Face face : traits(element.kind).faces) {
        for (int& node : face) node = element[at(node)];
        if (inside.has(face)) ++found;
      }
    }
    EXPECT_EQ(found, solid ? 3 * 4 * (1 + 16) : 4 * (1 + 4));
    for (const auto& [name, faces] : mesh.surfaces)
      for (const Face& face : faces) EXPECT_FALSE(inside.has(face)) << name;
  }
}

}  // namespace
}  // namespace ricochet::fem

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "common/surface/mortar.hpp"

namespace ricochet::surface {
namespace {

/// Edges between these places along x, facing up (down), nodes numbered along them from `first` on, of unit thickness.
std::vector<SurfaceFace> line(const std::vector<double>& places, bool up, int first = 0) {
  std::vector<SurfaceFace> edges;
  for (int i = 0; i + 1 < static_cast<int>(places.size()); ++i) {
    const auto at = static_cast<std::size_t>(i);
    SurfaceFace edge{{first + i, first + i + 1}, {}, {1.0, 1.0}, Eigen::Vector3d(0.0, up ? 1.0 : -1.0, 0.0)};
    edge.x[0] = {places[at], 0.0, 0.0};
    edge.x[1] = {places[at + 1], 0.0, 0.0};
    edges.push_back(edge);
  }
  return edges;
}

std::vector<MortarRow> rows_of(const std::vector<SurfaceFace>& first, const std::vector<SurfaceFace>& second,
                               double period_m = 0.0, const Eigen::Vector3d& shift_m = Eigen::Vector3d::Zero()) {
  return OppositeFaces(second, {period_m, 0.0}).rows(first, shift_m);
}

std::vector<double> even(int elements, double low, double high) {
  std::vector<double> places;
  for (int i = 0; i <= elements; ++i) places.push_back(low + (high - low) * i / elements);
  return places;
}

/// The value that a row interpolates of a function of the place, from its values at the nodes of the other surface.
template <class F>
double opposite(const MortarRow& row, const std::vector<double>& places, const F& f) {
  double sum = 0.0;
  for (const auto& [node, weight] : row.opposite) sum += weight * f(places[static_cast<std::size_t>(node)]);
  return sum;
}

TEST(Mortar, OfMatchingMeshesIsThePairsOfNodes) {
  const std::vector<double> places{0.0, 0.2, 0.3, 0.7, 1.0};
  const auto rows = rows_of(line(places, true), line(places, false));
  ASSERT_EQ(rows.size(), 5U);
  const double areas[] = {0.1, 0.15, 0.25, 0.35, 0.15};
  for (std::size_t j = 0; j < rows.size(); ++j) {
    EXPECT_NEAR(rows[j].area_m2, areas[j], 1e-15);
    for (const auto& [node, weight] : rows[j].opposite)
      EXPECT_NEAR(weight, node == static_cast<int>(j) ? 1.0 : 0.0, 1e-13) << j;
  }
}

/// Weights that sum to one and to the place of their node: a rigid motion has no gap rate, forces have no moment.
TEST(Mortar, KeepsForcesAndMomentsInBalanceOnAnyMeshes) {
  const std::vector<std::vector<double>> meshes = {even(2, 0.0, 1.0),          even(3, 0.0, 1.0),   even(7, 0.0, 1.0),
                                                   {0.0, 0.01, 0.5, 0.6, 1.0}, even(4, -0.35, 1.2), even(3, 0.3, 2.0)};
  for (const auto& first : meshes) {
    for (const auto& second : meshes) {
      double area = 0.0;
      for (const auto& row : rows_of(line(first, true), line(second, false))) {
        area += row.area_m2;
        EXPECT_NEAR(opposite(row, second, [](double) { return 1.0; }), 1.0, 1e-12);
        EXPECT_NEAR(opposite(row, second, [](double x) { return x; }), first[static_cast<std::size_t>(row.node)],
                    1e-11);
      }
      const double overlap = std::min(first.back(), second.back()) - std::max(first.front(), second.front());
      EXPECT_NEAR(area, overlap, 1e-13);
    }
  }
}

/// The patch test: multipliers of a constant pressure are on the second surface what the pressure itself would be.
TEST(Mortar, HandsAConstantPressureOverToRoundOff) {
  const auto first = even(2, 0.0, 1.0), second = even(3, 0.0, 1.0);
  std::map<int, double> force;
  for (const auto& row : rows_of(line(first, true), line(second, false))) {
    for (const auto& [node, weight] : row.opposite) force[node] += row.area_m2 * weight;
  }
  for (const auto& [node, value] : force) EXPECT_NEAR(value, node == 0 || node == 3 ? 1.0 / 6.0 : 1.0 / 3.0, 1e-15);
}

/// The dual basis takes nothing of a neighbour: integral psi_j phi_k = 0 of nodes of the same surface.
TEST(Mortar, IsExactForFunctionsOfTheFirstSurface) {
  const auto coarse = even(3, 0.0, 1.0);
  const auto fine = even(12, 0.0, 1.0);  // holds every function of the coarse mesh
  for (const auto& row : rows_of(line(coarse, true), line(fine, false))) {
    for (int k = 0; k < 4; ++k) {
      const auto hat = [&](double x) { return std::max(0.0, 1.0 - std::abs(3.0 * x - k)); };
      EXPECT_NEAR(opposite(row, fine, hat), row.node == k ? 1.0 : 0.0, 1e-13);
    }
  }
}

TEST(Mortar, WeighsByTheCircumference) {
  auto first = line(even(2, 0.0, 1.0), true), second = line(even(3, 0.0, 1.0), false);
  for (auto* edges : {&first, &second}) {
    for (auto& edge : *edges) edge.measure = {2 * M_PI * edge.x[0][0], 2 * M_PI * edge.x[1][0]};
  }
  const auto rows = rows_of(first, second);
  double area = 0.0;
  for (const auto& row : rows) area += row.area_m2;
  EXPECT_NEAR(area, M_PI, 1e-14);
  // integral over 0..h of (1 - r/h) r dr times 2 pi = pi h^2 / 3
  EXPECT_NEAR(rows[0].area_m2, M_PI * 0.25 / 3.0, 1e-15);
}

/// Nodes 0 and 4 of the first, and 0 and 3 of the second surface are one where the line repeats.
TEST(Mortar, GoesOnWhereTheLineRepeats) {
  auto first = line(even(4, 0.0, 1.0), true), second = line(even(3, 0.1, 1.1), false);
  first.back().node = {3, 0};
  second.back().node = {2, 0};
  const auto rows = rows_of(first, second, 1.0);
  ASSERT_EQ(rows.size(), 4U);
  for (const auto& row : rows) {
    EXPECT_NEAR(row.area_m2, 0.25, 1e-14);
    double sum = 0.0;
    for (const auto& entry : row.opposite) sum += entry.weight;
    EXPECT_NEAR(sum, 1.0, 1e-13);
  }
}

TEST(Mortar, LeavesOutWhatLiesOppositeNothing) {
  EXPECT_TRUE(rows_of(line(even(2, 0.0, 1.0), true), line(even(2, 1.5, 2.0), false)).empty());
  const auto rows = rows_of(line(even(4, 0.0, 1.0), true), line(even(3, 0.0, 0.4), false));
  ASSERT_EQ(rows.size(), 3U) << "nodes at 0, 0.25 and 0.5, whose edge hangs over";
  EXPECT_EQ(rows.back().node, 2);
}

/// A surface that slid has the rows of one that always was there.
TEST(Mortar, FollowsASurfaceThatMoved) {
  const auto first = even(5, 0.0, 1.0), second = even(7, -0.4, 1.1);
  const double shift = 0.31;
  auto moved = second;
  for (double& x : moved) x += shift;
  const auto expected = rows_of(line(first, true), line(moved, false));
  const auto found = rows_of(line(first, true), line(second, false), 0.0, {shift, 0.0, 0.0});
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t j = 0; j < found.size(); ++j) {
    EXPECT_NEAR(found[j].area_m2, expected[j].area_m2, 1e-14);
    ASSERT_EQ(found[j].opposite.size(), expected[j].opposite.size());
    for (std::size_t k = 0; k < found[j].opposite.size(); ++k)
      EXPECT_NEAR(found[j].opposite[k].weight, expected[j].opposite[k].weight, 1e-12);
  }
}

/// Also by more than a period.
TEST(Mortar, FollowsASurfaceThatRepeats) {
  auto first = line(even(4, 0.0, 1.0), true), second = line(even(3, 0.1, 1.1), false);
  first.back().node = {3, 0};
  second.back().node = {2, 0};
  const auto expected = rows_of(first, second, 1.0, {0.2, 0.0, 0.0}),
             found = rows_of(first, second, 1.0, {7.2, 0.0, 0.0});
  ASSERT_EQ(found.size(), 4U);
  for (std::size_t j = 0; j < found.size(); ++j) {
    EXPECT_NEAR(found[j].area_m2, 0.25, 1e-13);
    ASSERT_EQ(found[j].opposite.size(), expected[j].opposite.size());
    for (std::size_t k = 0; k < found[j].opposite.size(); ++k)
      EXPECT_NEAR(found[j].opposite[k].weight, expected[j].opposite[k].weight, 1e-12);
  }
}

/// A square [0, 1]^2 at z = 0 of cells x cells quadrilaterals or twice as many triangles, turned by an angle about its
/// middle, facing up (down). Inner nodes may be moved so that no cell is a parallelogram.
std::vector<SurfaceFace> square(int cells, bool triangles, double angle, bool up, double moved = 0.0) {
  const int row = cells + 1;
  const auto place = [&](int i, int j) {
    const bool inner = i > 0 && i < cells && j > 0 && j < cells;
    const double x = (i + (inner ? moved * ((i + 2 * j) % 3 - 1) : 0.0)) / cells - 0.5,
                 y = (j + (inner ? moved * ((2 * i + j) % 3 - 1) : 0.0)) / cells - 0.5;
    return Eigen::Vector3d(std::cos(angle) * x - std::sin(angle) * y, std::sin(angle) * x + std::cos(angle) * y, 0.0);
  };
  std::vector<SurfaceFace> faces;
  const auto add = [&](std::vector<std::array<int, 2>> corners) {
    if (!up) std::reverse(corners.begin(), corners.end());
    SurfaceFace face{{}, {}, {1.0, 1.0, 1.0, 1.0}, Eigen::Vector3d(0.0, 0.0, up ? 1.0 : -1.0)};
    for (const auto& [i, j] : corners) {
      face.x[face.node.size()] = place(i, j);
      face.node.push_back(j * row + i);
    }
    faces.push_back(face);
  };
  for (int j = 0; j < cells; ++j) {
    for (int i = 0; i < cells; ++i) {
      if (triangles) {
        add({{i, j}, {i + 1, j}, {i + 1, j + 1}});
        add({{i, j}, {i + 1, j + 1}, {i, j + 1}});
      } else {
        add({{i, j}, {i + 1, j}, {i + 1, j + 1}, {i, j + 1}});
      }
    }
  }
  return faces;
}

std::map<int, Eigen::Vector3d> places_of(const std::vector<SurfaceFace>& faces) {
  std::map<int, Eigen::Vector3d> places;
  for (const auto& face : faces) {
    for (std::size_t i = 0; i < face.node.size(); ++i) places[face.node[i]] = face.x[i];
  }
  return places;
}

/// The force that a constant pressure of 1 gives each node of a surface.
std::map<int, double> nodal_areas(const std::vector<SurfaceFace>& faces) {
  std::map<int, double> areas;
  for (const auto& row : OppositeFaces(square(1, false, 0.0, false), {0.0, 0.0}).rows(faces, {0.0, 0.0, 0.0}))
    areas[row.node] = row.area_m2;
  return areas;
}

/// Balances are exact on any faces, the patch test on triangles and parallelograms: shape functions of other
/// quadrilaterals are no polynomials of the place, which leaves the error of the quadrature.
TEST(MortarOfFaces, KeepsForcesAndMomentsInBalanceAndHandsAPressureOver) {
  for (const int which : {0, 1, 2, 3, 4}) {
    const bool of_triangles = which % 2 == 1, on_triangles = which >= 2, moved = which == 4;
    const double quadrature = moved ? 1e-4 : 1e-12;
    const auto first = square(2, of_triangles, 0.0, true, moved ? 0.2 : 0.0),
               second = square(3, on_triangles && !moved, 0.0, false, moved ? 0.2 : 0.0);
    const auto places = places_of(first), others = places_of(second);
    double area = 0.0;
    std::map<int, double> force;
    for (const auto& row : OppositeFaces(second, {0.0, 0.0}).rows(first, {0.0, 0.0, 0.0})) {
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      double weights = 0.0;
      for (const auto& [node, weight] : row.opposite) {
        sum += weight * others.at(node);
        weights += weight;
        force[node] += weight * row.area_m2;
      }
      EXPECT_NEAR(weights, 1.0, 1e-12);
      EXPECT_NEAR((sum - places.at(row.node)).norm(), 0.0, 1e-12);
      area += row.area_m2;
    }
    EXPECT_NEAR(area, 1.0, 1e-12) << which;
    auto up = second;  // seen from the other side
    for (auto& face : up) {
      std::reverse(face.node.begin(), face.node.end());
      std::reverse(face.x.begin(), face.x.begin() + static_cast<std::ptrdiff_t>(face.node.size()));
      face.normal *= -1.0;
    }
    for (const auto& [node, expected] : nodal_areas(up)) EXPECT_NEAR(force.at(node), expected, quadrature) << node;
  }
}

/// The smaller surface lies on a part of the larger one, turned by 30 degrees.
TEST(MortarOfFaces, IsInBalanceWhereSurfacesLieAcross) {
  const auto first = square(4, false, M_PI / 6.0, true);
  auto second = square(3, true, 0.0, false);
  for (auto& face : second) {
    for (auto& x : face.x) x *= 3.0;
  }
  const auto places = places_of(first), others = places_of(second);
  const Eigen::Vector3d shift(0.11, -0.07, 0.0);
  const auto rows = OppositeFaces(second, {0.0, 0.0}).rows(first, shift);
  ASSERT_EQ(rows.size(), 25U);
  for (const auto& row : rows) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const auto& [node, weight] : row.opposite) sum += weight * (others.at(node) + shift);
    EXPECT_NEAR((sum - places.at(row.node)).norm(), 0.0, 1e-12);
  }
}

/// Edges along a circle of radius 1 m about (0, `side`), out to 0.6 rad to either side of the origin.
std::vector<SurfaceFace> arc(int edges, double side, bool smooth = false) {
  std::vector<SurfaceFace> faces;
  const auto place = [&](int i) {
    const double angle = 0.6 * (2.0 * i / edges - 1.0);
    return Eigen::Vector3d(std::sin(angle), side * (1.0 - std::cos(angle)), 0.0);
  };
  for (int i = 0; i < edges; ++i) {
    SurfaceFace face{{i, i + 1}, {place(i), place(i + 1)}, {1.0, 1.0}, {}};
    if (side < 0.0) face = {{i + 1, i}, {place(i + 1), place(i)}, {1.0, 1.0}, {}};
    const Eigen::Vector3d along = (face.x[1] - face.x[0]).normalized();
    face.normal = {along[1], -along[0], 0.0};  // the body to the left
    for (std::size_t k = 0; smooth && k < 2; ++k) face.node_normal[k] = face.x[k] - Eigen::Vector3d(0.0, side, 0.0);
    faces.push_back(face);
  }
  return faces;
}

/// Two circles of edges that touch at the lowest point of the upper one: weights keep sums and, as the chords lie as
/// close as they do, moments.
TEST(Mortar, OfCurvedSurfacesKeepsMomentsWhereTheyTouch) {
  const auto lower = arc(40, -1.0), upper = arc(27, 1.0);
  ASSERT_GT(lower[20].normal[1], 0.9);
  ASSERT_LT(upper[13].normal[1], -0.9);
  const auto places = places_of(lower), others = places_of(upper);
  for (const auto& row : OppositeFaces(upper, {0.0, 0.0}).rows(lower, {0.0, 0.0, 0.0})) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double weights = 0.0;
    for (const auto& [node, weight] : row.opposite) {
      sum += weight * others.at(node);
      weights += weight;
    }
    EXPECT_NEAR(weights, 1.0, 1e-12);
    if (std::abs(places.at(row.node)[0]) < 0.02) {
      EXPECT_NEAR(sum[0], places.at(row.node)[0], 2e-5) << "of an edge of 0.03";
    }
  }
}

/// The same search among all faces at every move.
std::optional<Touch> touching_among_all(const ContactMesh& mesh, Eigen::Vector3d shift_m,
                                        const Eigen::Vector3d& along) {
  std::optional<Touch> touch;
  for (int i = 0; i < 20; ++i) {
    const std::vector<MortarRow> rows = mesh.rows(shift_m);
    const auto least = std::min_element(rows.begin(), rows.end(),
                                        [](const MortarRow& x, const MortarRow& y) { return x.gap_m < y.gap_m; });
    if (least == rows.end()) return std::nullopt;
    if (!touch) touch = Touch{shift_m, least->normal, least->gap_m};
    touch->normal = least->normal;
    if (std::abs(least->gap_m) <= 1e-10 * mesh.edge_m) break;
    shift_m -= least->gap_m * (along.isZero(0.0) ? least->normal : Eigen::Vector3d(along / along.dot(least->normal)));
  }
  touch->shift_m = shift_m;
  return touch;
}

/// From places apart and overlapping, straight and aside, along the normal and along one direction.
TEST(Touching, LooksNearTheLeastGapAndFindsWhatAllFacesHave) {
  for (const bool smooth : {true, false}) {
    const ContactMesh mesh{arc(200, -1.0, smooth), OppositeFaces(arc(137, 1.0, smooth), {0.0, 0.0}), 1.2 / 200, 0.5};
    for (const double up_m : {1e-4, 0.003, 0.05, 0.3, -0.002}) {
      for (const double aside_m : {0.0, 0.0013, -0.11, 0.25}) {
        for (const Eigen::Vector3d& along : {Eigen::Vector3d(0.0, 0.0, 0.0), Eigen::Vector3d(0.0, 1.0, 0.0)}) {
          const Eigen::Vector3d shift_m(aside_m, up_m, 0.0);
          const auto found = touching(mesh, shift_m, along), expected = touching_among_all(mesh, shift_m, along);
          ASSERT_EQ(found.has_value(), expected.has_value()) << up_m << ' ' << aside_m;
          if (!found) continue;
          EXPECT_LT((found->shift_m - expected->shift_m).norm(), 1e-11) << up_m << ' ' << aside_m;
          EXPECT_LT((found->normal - expected->normal).norm(), 1e-9) << up_m << ' ' << aside_m;
          EXPECT_EQ(found->gap_m, expected->gap_m) << up_m << ' ' << aside_m;
        }
      }
    }
  }
}

}  // namespace
}  // namespace ricochet::surface

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "common/problem/mortar.hpp"

namespace ricochet::scene {
namespace {

/// Edges between these places, nodes numbered along them from `first` on, of unit thickness.
std::vector<SurfaceEdge> line(const std::vector<double>& places, int first = 0) {
  std::vector<SurfaceEdge> edges;
  for (int i = 0; i + 1 < static_cast<int>(places.size()); ++i) {
    const auto at = static_cast<std::size_t>(i);
    edges.push_back({{first + i, first + i + 1}, {places[at], places[at + 1]}, {1.0, 1.0}});
  }
  return edges;
}

std::vector<double> even(int elements, double low, double high) {
  std::vector<double> places;
  for (int i = 0; i <= elements; ++i) places.push_back(low + (high - low) * i / elements);
  return places;
}

/// What a row interpolates of a function of the place, from its values at the nodes of the other surface.
template <class F>
double opposite(const MortarRow& row, const std::vector<double>& places, const F& f) {
  double sum = 0.0;
  for (const auto& [node, weight] : row.opposite) sum += weight * f(places[static_cast<std::size_t>(node)]);
  return sum;
}

TEST(Mortar, OfMatchingMeshesIsThePairsOfNodes) {
  const auto edges = line({0.0, 0.2, 0.3, 0.7, 1.0});
  const auto rows = mortar_rows(edges, edges, 0.0);
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
      for (const auto& row : mortar_rows(line(first), line(second), 0.0)) {
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
  for (const auto& row : mortar_rows(line(first), line(second), 0.0)) {
    for (const auto& [node, weight] : row.opposite) force[node] += row.area_m2 * weight;
  }
  for (const auto& [node, value] : force) EXPECT_NEAR(value, node == 0 || node == 3 ? 1.0 / 6.0 : 1.0 / 3.0, 1e-15);
}

/// The dual basis takes nothing of a neighbour: integral psi_j phi_k = 0 of nodes of the same surface.
TEST(Mortar, IsExactForFunctionsOfTheFirstSurface) {
  const auto coarse = even(3, 0.0, 1.0);
  const auto fine = even(12, 0.0, 1.0);  // holds every function of the coarse mesh
  for (const auto& row : mortar_rows(line(coarse), line(fine), 0.0)) {
    for (int k = 0; k < 4; ++k) {
      const auto hat = [&](double x) { return std::max(0.0, 1.0 - std::abs(3.0 * x - k)); };
      EXPECT_NEAR(opposite(row, fine, hat), row.node == k ? 1.0 : 0.0, 1e-13);
    }
  }
}

TEST(Mortar, WeighsByTheCircumference) {
  auto first = line(even(2, 0.0, 1.0)), second = line(even(3, 0.0, 1.0));
  for (auto* edges : {&first, &second}) {
    for (auto& edge : *edges) edge.measure = {2 * M_PI * edge.along_m[0], 2 * M_PI * edge.along_m[1]};
  }
  const auto rows = mortar_rows(first, second, 0.0);
  double area = 0.0;
  for (const auto& row : rows) area += row.area_m2;
  EXPECT_NEAR(area, M_PI, 1e-14);
  // integral over 0..h of (1 - r/h) r dr times 2 pi = pi h^2 / 3
  EXPECT_NEAR(rows[0].area_m2, M_PI * 0.25 / 3.0, 1e-15);
}

/// Nodes 0 and 4 of the first, and 0 and 3 of the second surface are one where the line repeats.
TEST(Mortar, GoesOnWhereTheLineRepeats) {
  auto first = line(even(4, 0.0, 1.0)), second = line(even(3, 0.1, 1.1));
  first.back().node[1] = 0;
  second.back().node[1] = 0;
  const auto rows = mortar_rows(first, second, 1.0);
  ASSERT_EQ(rows.size(), 4U);
  for (const auto& row : rows) {
    EXPECT_NEAR(row.area_m2, 0.25, 1e-14);
    double sum = 0.0;
    for (const auto& entry : row.opposite) sum += entry.weight;
    EXPECT_NEAR(sum, 1.0, 1e-13);
  }
}

TEST(Mortar, LeavesOutWhatLiesOppositeNothing) {
  EXPECT_TRUE(mortar_rows(line(even(2, 0.0, 1.0)), line(even(2, 1.5, 2.0)), 0.0).empty());
  const auto rows = mortar_rows(line(even(4, 0.0, 1.0)), line(even(3, 0.0, 0.4)), 0.0);
  ASSERT_EQ(rows.size(), 3U) << "nodes at 0, 0.25 and 0.5, whose edge hangs over";
  EXPECT_EQ(rows.back().node, 2);
}

}  // namespace
}  // namespace ricochet::scene

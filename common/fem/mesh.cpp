#include "common/fem/mesh.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "common/base/error.hpp"
#include "common/base/names.hpp"

namespace ricochet::fem {

std::vector<double> graded_coordinates(double start, double length, int count, double grading) {
  if (count < 1 || !(length > 0.0) || !(grading > 0.0) || !std::isfinite(start + length + grading)) {
    throw ConfigError(
        fmt::format("graded coordinates: {} elements over {} m from {} m with grading {}; needed are at "
                    "least one element, a positive length and a positive grading",
                    count, length, start, grading));
  }
  // Sizes h q^i, q^(count-1) = grading; their partial sums are (q^i - 1)/(q^count - 1) of the length.
  const double log_ratio = count > 1 ? std::log(grading) / (count - 1) : 0.0;
  std::vector<double> coordinates(static_cast<std::size_t>(count) + 1, start);
  for (int i = 1; i < count; ++i) {
    const double fraction =
        log_ratio == 0.0 ? static_cast<double>(i) / count : std::expm1(i * log_ratio) / std::expm1(count * log_ratio);
    coordinates[static_cast<std::size_t>(i)] = start + length * fraction;
  }
  coordinates.back() = start + length;
  return coordinates;
}

Mesh bar_mesh(const std::vector<double>& along) {
  Mesh mesh;
  mesh.model = Model::bar;
  for (const double x : along) mesh.position.emplace_back(x, 0.0);
  const int last = static_cast<int>(along.size()) - 1;
  for (int i = 0; i < last; ++i) mesh.elements.push_back({ElementKind::bar, {i, i + 1}});
  mesh.surfaces["start"] = {{0, 0}};
  mesh.surfaces["end"] = {{last, last}};
  return mesh;
}

Mesh quadrilateral_mesh(Model model, const std::vector<double>& across, const std::vector<double>& along) {
  Mesh mesh;
  mesh.model = model;
  const int columns = static_cast<int>(across.size()) - 1;
  const int rows = static_cast<int>(along.size()) - 1;
  // The short direction is numbered first, which keeps the matrix band narrow.
  const auto node = [columns](int i, int j) { return j * (columns + 1) + i; };
  for (const double y : along) {
    for (const double x : across) mesh.position.emplace_back(x, y);
  }
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      mesh.elements.push_back(
          {ElementKind::quadrilateral, {node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)}});
    }
  }
  for (int i = 0; i < columns; ++i) {
    mesh.surfaces["start"].push_back({node(i, 0), node(i + 1, 0)});
    mesh.surfaces["end"].push_back({node(i + 1, rows), node(i, rows)});
  }
  for (int j = 0; j < rows; ++j) {
    mesh.surfaces["inner"].push_back({node(0, j + 1), node(0, j)});
    mesh.surfaces["outer"].push_back({node(columns, j), node(columns, j + 1)});
  }
  return mesh;
}

std::vector<int> surface_nodes(const Mesh& mesh, const std::string& surface) {
  const auto found = mesh.surfaces.find(surface);
  if (found == mesh.surfaces.end()) {
    std::vector<std::string> known;
    for (const auto& [name, edges] : mesh.surfaces) known.push_back(name);
    throw ConfigError(fmt::format("no surface \"{}\"; the mesh has: {}{}", surface,
                                  known.empty() ? "none" : fmt::format("{}", fmt::join(known, ", ")),
                                  did_you_mean(surface, known)));
  }
  std::vector<int> nodes;
  for (const auto& edge : found->second) nodes.insert(nodes.end(), edge.begin(), edge.end());
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  std::stable_sort(nodes.begin(), nodes.end(), [&](int a, int b) {
    const Eigen::Vector2d& xa = mesh.position[static_cast<std::size_t>(a)];
    const Eigen::Vector2d& xb = mesh.position[static_cast<std::size_t>(b)];
    return xa[0] != xb[0] ? xa[0] < xb[0] : xa[1] < xb[1];
  });
  return nodes;
}

}  // namespace ricochet::fem

#include "common/fem/mesh.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <tuple>

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
  for (const double x : along) mesh.position.emplace_back(x, 0.0, 0.0);
  const int last = static_cast<int>(along.size()) - 1;
  for (int i = 0; i < last; ++i) mesh.elements.push_back({ElementKind::bar, {i, i + 1}});
  mesh.surfaces["start"] = {Face{0}};
  mesh.surfaces["end"] = {Face{last}};
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
    for (const double x : across) mesh.position.emplace_back(x, y, 0.0);
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

namespace {

/// The faces of a block's hexahedra that end it, by the place of each in its element's list of faces.
void add_faces_of_block(Mesh& mesh, const Eigen::Vector3i& place, const Eigen::Vector3i& count) {
  struct End {
    const char* surface;
    std::size_t face;  ///< of hexahedra, in element_kind.cpp
    bool here;
  };
  const Element& element = mesh.elements.back();
  for (const auto& [surface, face, here] : {End{"start", 0, place[2] == 0}, End{"end", 1, place[2] == count[2] - 1},
                                            End{"front", 2, place[1] == 0}, End{"outer", 3, place[0] == count[0] - 1},
                                            End{"back", 4, place[1] == count[1] - 1}, End{"inner", 5, place[0] == 0}}) {
    if (!here) continue;
    Face own = traits(element.kind).faces[face];
    for (int& node : own) node = element[at(node)];
    mesh.surfaces[surface].push_back(own);
  }
}

}  // namespace

Mesh block_mesh(const std::vector<double>& x, const std::vector<double>& y, const std::vector<double>& z) {
  Mesh mesh;
  mesh.model = Model::solid;
  const Eigen::Vector3i count(static_cast<int>(x.size()) - 1, static_cast<int>(y.size()) - 1,
                              static_cast<int>(z.size()) - 1);
  for (const double zk : z) {
    for (const double yj : y) {
      for (const double xi : x) mesh.position.emplace_back(xi, yj, zk);
    }
  }
  const int row = count[0] + 1, layer = row * (count[1] + 1);
  for (int k = 0; k < count[2]; ++k) {
    for (int j = 0; j < count[1]; ++j) {
      for (int i = 0; i < count[0]; ++i) {
        const int n = k * layer + j * row + i, above = n + layer;
        mesh.elements.push_back({ElementKind::hexahedron,
                                 {n, n + 1, n + row + 1, n + row, above, above + 1, above + row + 1, above + row}});
        add_faces_of_block(mesh, {i, j, k}, count);
      }
    }
  }
  return mesh;
}

std::string place_text(Model model, const Eigen::Vector3d& x) {
  if (model == Model::solid) return fmt::format("({:.6g}, {:.6g}, {:.6g}) m", x[0], x[1], x[2]);
  return fmt::format("({:.6g}, {:.6g}) m", x[0], x[1]);
}

std::vector<int> surface_nodes(const Mesh& mesh, const std::string& surface) {
  if (const auto point = mesh.points.find(surface); point != mesh.points.end()) return {point->second};
  const auto found = mesh.surfaces.find(surface);
  if (found == mesh.surfaces.end()) {
    std::vector<std::string> known;
    for (const auto& [name, faces] : mesh.surfaces) known.push_back(name);
    throw ConfigError(fmt::format("no surface \"{}\"; the mesh has: {}{}", surface,
                                  known.empty() ? "none" : fmt::format("{}", fmt::join(known, ", ")),
                                  did_you_mean(surface, known)));
  }
  std::vector<int> nodes;
  for (const Face& face : found->second) nodes.insert(nodes.end(), face.begin(), face.end());
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  std::stable_sort(nodes.begin(), nodes.end(), [&](int a, int b) {
    const Eigen::Vector3d& xa = mesh.position[static_cast<std::size_t>(a)];
    const Eigen::Vector3d& xb = mesh.position[static_cast<std::size_t>(b)];
    return std::tie(xa[0], xa[1], xa[2]) < std::tie(xb[0], xb[1], xb[2]);
  });
  return nodes;
}

}  // namespace ricochet::fem

#include "common/fem/seen_cells.hpp"

#include <algorithm>
#include <utility>

#include "common/fem/hanging_nodes.hpp"

namespace ricochet::fem {
namespace {

/// A cell in the nodes of the mesh, and its element.
struct SeenCell {
  std::array<int, 4> nodes;
  int element = 0;
};

/// A face of a solid, with its element: equal sorted nodes make two of them one face inside the body.
struct SolidFace {
  Face sorted, face;
  int element = 0;
};

/// Faces that belong to one element alone, element by element.
std::vector<SolidFace> surface_of(const Mesh& mesh) {
  std::vector<SolidFace> faces;
  for (int e = 0; e < static_cast<int>(mesh.elements.size()); ++e) {
    const auto& element = mesh.elements[at(e)];
    for (const auto& local : traits(element.kind).faces) {
      Face face = local;
      for (int& node : face) node = element[at(node)];
      faces.push_back({sorted(face), face, e});
    }
  }
  std::sort(faces.begin(), faces.end(), [](const SolidFace& a, const SolidFace& b) {
    return std::pair(a.sorted, a.element) < std::pair(b.sorted, b.element);
  });
  const FacesBetweenSizes inside(mesh);
  std::vector<SolidFace> surface;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const bool twin_before = i > 0 && faces[i - 1].sorted == faces[i].sorted;
    const bool twin_after = i + 1 < faces.size() && faces[i + 1].sorted == faces[i].sorted;
    if (!twin_before && !twin_after && !inside.has(faces[i].face)) surface.push_back(faces[i]);
  }
  return surface;
}

std::vector<SeenCell> cells_of(const Mesh& mesh) {
  std::vector<SeenCell> cells;
  const auto add = [&cells](const auto& nodes, int element) {
    cells.push_back({{-1, -1, -1, -1}, element});
    std::copy(nodes.begin(), nodes.end(), cells.back().nodes.begin());
  };
  if (mesh.model == Model::solid) {
    for (const auto& face : surface_of(mesh)) add(face.face, face.element);
  } else {
    for (int e = 0; e < static_cast<int>(mesh.elements.size()); ++e) add(mesh.elements[at(e)], e);
  }
  return cells;
}

}  // namespace

SeenCells seen_cells(const Mesh& mesh) {
  SeenCells seen;
  std::array<std::vector<int>, 2> number;  // of the nodes, of their images: index in the picture
  for (auto& of : number) of.assign(mesh.position.size(), -1);
  for (const auto& cell : cells_of(mesh)) {
    seen.cells.push_back({-1, -1, -1, -1});
    seen.element.push_back(cell.element);
    for (std::size_t i = 0; i < 4 && cell.nodes[i] >= 0; ++i) {
      const auto node = at(cell.nodes[i]);
      const Eigen::Vector3d x = nearest_image(mesh, mesh.position[node], mesh.position[at(cell.nodes[0])]);
      const bool image = x[0] != mesh.position[node][0];
      int& index = number[image ? 1 : 0][node];
      if (index < 0) {
        index = static_cast<int>(seen.node.size());
        seen.node.push_back(cell.nodes[i]);
        seen.image.push_back(image);
        seen.position_m.push_back(x);
      }
      seen.cells.back()[i] = index;
    }
  }
  return seen;
}

}  // namespace ricochet::fem

#include "common/fem/seen_cells.hpp"

#include <algorithm>

#include "common/fem/boundary.hpp"

namespace ricochet::fem {
namespace {

/// A cell in the nodes of the mesh, and its element.
struct SeenCell {
  std::array<int, 4> nodes;
  int element = 0;
};

std::vector<SeenCell> cells_of(const Mesh& mesh) {
  std::vector<SeenCell> cells;
  const auto add = [&cells](const auto& nodes, int element) {
    cells.push_back({{-1, -1, -1, -1}, element});
    std::copy(nodes.begin(), nodes.end(), cells.back().nodes.begin());
  };
  if (mesh.model == Model::solid) {
    for (const auto& face : boundary_faces(mesh)) add(face.face, face.element);
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

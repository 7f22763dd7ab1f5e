#include "common/fem/boundary.hpp"

#include <algorithm>

#include "common/fem/hanging_nodes.hpp"

namespace ricochet::fem {
namespace {

/// Equal sorted nodes make two of them one face inside the body.
struct SortedFace {
  Face sorted, face;
  int element = 0;
};

}  // namespace

std::vector<BoundaryFace> boundary_faces(const Mesh& mesh) {
  std::vector<SortedFace> all;
  for (int e = 0; e < static_cast<int>(mesh.elements.size()); ++e) {
    const auto& element = mesh.elements[at(e)];
    for (Face face : traits(element.kind).faces) {
      for (int& node : face) node = element[at(node)];
      all.push_back({sorted(face), face, e});
    }
  }
  std::sort(all.begin(), all.end(), [](const SortedFace& a, const SortedFace& b) { return a.sorted < b.sorted; });
  const FacesBetweenSizes inside(mesh);
  std::vector<BoundaryFace> faces;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const bool twin_before = i > 0 && all[i - 1].sorted == all[i].sorted;
    const bool twin_after = i + 1 < all.size() && all[i + 1].sorted == all[i].sorted;
    if (!twin_before && !twin_after && !inside.has(all[i].face)) faces.push_back({all[i].face, all[i].element});
  }
  return faces;
}

}  // namespace ricochet::fem

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "common/surface/face_plane.hpp"
#include "common/surface/mortar.hpp"

namespace ricochet::surface {
namespace {

/// Those faces of the first surface alone that may hold the row with the least gap, as the second surface is moved.
class NearFaces {
 public:
  explicit NearFaces(const ContactMesh& mesh) : mesh_(mesh) {}

  /// The rows that may have the least gap.
  [[nodiscard]] std::vector<MortarRow> rows(const Eigen::Vector3d& shift_m) const {
    if (all()) return mesh_.rows(shift_m);
    std::vector<MortarRow> rows = mesh_.second.rows(faces_, shift_m, mesh_.first_share, mesh_.edges_touch);
    rows.erase(std::remove_if(rows.begin(), rows.end(), [this](const MortarRow& row) { return !may_touch(row.node); }),
               rows.end());
    return rows;
  }
  /// The second surface moves by so much from where `rows` have the gap `least_m`. That changes no gap by more, and so
  /// none that is larger by twice as much, and an edge, becomes the least.
  void move(const std::vector<MortarRow>& rows, double least_m, double moved_m) {
    if (mesh_.edges_touch && mesh_.second.has_edges()) return;  // an edge may meet any face
    const double reach_m = least_m + 2.0 * moved_m + mesh_.edge_m;
    if (others_m_ < reach_m) {
      others_m_ = std::numeric_limits<double>::infinity();
      nodes_.clear();
      faces_.clear();
      return;
    }
    others_m_ = reach_m - moved_m;
    nodes_.clear();
    for (const MortarRow& row : rows)
      if (row.gap_m <= reach_m) nodes_.push_back(row.node);
    std::sort(nodes_.begin(), nodes_.end());
    std::vector<SurfaceFace> faces;
    for (const SurfaceFace& face : all() ? mesh_.first : faces_)
      if (std::any_of(face.node.begin(), face.node.end(), [this](int node) { return may_touch(node); }))
        faces.push_back(face);
    faces_ = std::move(faces);
  }

 private:
  [[nodiscard]] bool all() const { return faces_.empty(); }
  [[nodiscard]] bool may_touch(int node) const { return std::binary_search(nodes_.begin(), nodes_.end(), node); }

  const ContactMesh& mesh_;
  std::vector<SurfaceFace> faces_;                             ///< empty: all
  std::vector<int> nodes_;                                     ///< ascending
  double others_m_ = std::numeric_limits<double>::infinity();  ///< gaps of all other nodes are larger
};

}  // namespace

std::optional<Touch> touching(const ContactMesh& mesh, const Eigen::Vector3d& shift_m, const Eigen::Vector3d& along) {
  constexpr int most_moves = 20;
  constexpr double touched = 1e-10;  // of an edge
  std::optional<Touch> touch;
  NearFaces near(mesh);
  Eigen::Vector3d shift = shift_m;
  for (int i = 0; i < most_moves; ++i) {
    const std::vector<MortarRow> rows = near.rows(shift);
    const auto least = std::min_element(rows.begin(), rows.end(),
                                        [](const MortarRow& x, const MortarRow& y) { return x.gap_m < y.gap_m; });
    if (least == rows.end()) return std::nullopt;
    if (!touch) touch = Touch{shift, least->normal, least->gap_m};
    touch->normal = least->normal;
    const double along_normal = along.dot(least->normal);
    if (std::abs(least->gap_m) <= touched * mesh.edge_m || (!along.isZero(0.0) && along_normal < least_facing)) break;
    const Eigen::Vector3d move =
        least->gap_m * (along.isZero(0.0) ? least->normal : Eigen::Vector3d(along / along_normal));
    near.move(rows, least->gap_m, move.norm());
    shift -= move;
  }
  touch->shift_m = shift;
  return touch;
}

}  // namespace ricochet::surface

#include "common/fem/refine.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <utility>

#include "common/base/error.hpp"
#include "common/fem/element.hpp"
#include "common/fem/hanging_nodes.hpp"
#include "common/fem/part.hpp"

namespace ricochet::fem {
namespace {

/// A place in an element by the corners that it lies between, ascending: its shares of them in whole numbers without a
/// common divisor, which are the same seen from every element that has it.
using Shares = std::vector<std::pair<int, long long>>;
/// Whole coordinates of a place in an element, 0 ... ratio in each direction.
using Steps = std::array<int, 3>;
/// A part of an element, and its corners as places in that element.
using Corners = std::vector<Steps>;

/// The parts of a bar, a quadrilateral or a hexahedron.
std::vector<Corners> tensor_parts(const ElementTraits& kind, int ratio) {
  const auto along = [&](int direction) { return direction < kind.dimension ? ratio : 1; };
  std::vector<Corners> parts;
  for (int k = 0; k < along(2); ++k) {
    for (int j = 0; j < along(1); ++j) {
      for (int i = 0; i < along(0); ++i) {
        Corners& corners = parts.emplace_back();
        for (const NaturalPoint& at_corner : kind.corner) {
          Steps steps{i, j, k};
          for (int d = 0; d < kind.dimension; ++d) steps[static_cast<std::size_t>(d)] += at_corner[d] > 0.0 ? 1 : 0;
          corners.push_back(steps);
        }
      }
    }
  }
  return parts;
}

/// Those of a triangle: rows of such as it and such as it turned by 180 degrees.
std::vector<Corners> triangle_parts(int ratio) {
  std::vector<Corners> parts;
  for (int j = 0; j < ratio; ++j) {
    for (int i = 0; i + j < ratio; ++i) {
      parts.push_back({{i, j, 0}, {i + 1, j, 0}, {i, j + 1, 0}});
      if (i + j + 1 < ratio) parts.push_back({{i + 1, j, 0}, {i + 1, j + 1, 0}, {i, j + 1, 0}});
    }
  }
  return parts;
}

Shares shares_of(const Element& element, const Steps& steps, int ratio) {
  const ElementTraits& kind = traits(element.kind);
  Shares shares;
  for (std::size_t corner = 0; corner < element.size(); ++corner) {
    long long share = 1;
    if (element.kind == ElementKind::triangle) {
      share = corner == 0 ? ratio - steps[0] - steps[1] : steps[corner - 1];
    } else {
      for (int d = 0; d < kind.dimension; ++d) {
        const int step = steps[static_cast<std::size_t>(d)];
        share *= kind.corner[corner][d] > 0.0 ? step : ratio - step;
      }
    }
    if (share > 0) shares.emplace_back(element[corner], share);
  }
  std::sort(shares.begin(), shares.end());
  long long divisor = 0;
  for (const auto& [node, share] : shares) divisor = std::gcd(divisor, share);
  for (auto& [node, share] : shares) share /= divisor;
  return shares;
}

std::vector<WeightedNode> weights_of(const Shares& shares) {
  const double all = static_cast<double>(std::accumulate(
      shares.begin(), shares.end(), 0LL, [](long long sum, const auto& of) { return sum + of.second; }));
  std::vector<WeightedNode> weights;
  for (const auto& [node, share] : shares) weights.push_back({node, static_cast<double>(share) / all});
  return weights;
}

/// Corners of an edge or a face, ascending.
using Border = std::vector<int>;

Border border_of(const Shares& shares) {
  Border border;
  for (const auto& [node, share] : shares) border.push_back(node);
  return border;
}

/// visit(border) of its edges and faces.
template <class Visit>
void for_each_border(const Element& element, const Visit& visit) {
  const auto visit_one = [&](const auto& local) {
    Border border;
    for (const int node : local) border.push_back(element[at(node)]);
    std::sort(border.begin(), border.end());
    visit(border);
  };
  for (const NodePair& edge : traits(element.kind).edges) visit_one(edge);
  for (const Face& face : traits(element.kind).faces) visit_one(face);
}

/// Edges and faces of the elements that are not divided.
std::set<Border> kept_borders(const Mesh& mesh, const std::vector<bool>& divided) {
  std::vector<bool> near(mesh.position.size(), false);
  for (std::size_t e = 0; e < divided.size(); ++e) {
    for (const int node : mesh.elements[e]) near[at(node)] = near[at(node)] || divided[e];
  }
  std::set<Border> borders;
  for (std::size_t e = 0; e < divided.size(); ++e) {
    const Element& element = mesh.elements[e];
    if (divided[e] || std::none_of(element.begin(), element.end(), [&](int node) { return near[at(node)]; })) continue;
    for_each_border(element, [&](const Border& border) { borders.insert(border); });
  }
  return borders;
}

class Refinement {
 public:
  Refinement(Mesh& mesh, const RefinedBox& box, const std::vector<bool>& divided)
      : mesh_(mesh), ratio_(box.ratio), divided_(divided), kept_(kept_borders(mesh, divided)) {}

  void divide() {
    std::vector<Element> elements;
    std::vector<std::pair<int, int>> parts_of;  // per old element: first and end of its parts
    for (std::size_t e = 0; e < divided_.size(); ++e) {
      const int first = static_cast<int>(elements.size());
      if (divided_[e]) {
        divide(mesh_.elements[e], elements);
      } else {
        elements.push_back(mesh_.elements[e]);
      }
      parts_of.emplace_back(first, static_cast<int>(elements.size()));
    }
    for (auto& [name, group] : mesh_.element_groups) {
      std::vector<int> parts;
      for (const int e : group)
        for (int part = parts_of[at(e)].first; part < parts_of[at(e)].second; ++part) parts.push_back(part);
      group = std::move(parts);
    }
    mesh_.elements = std::move(elements);
    divide_surfaces();
    number_row_by_row(parts_of);
  }

 private:
  void divide(const Element& element, std::vector<Element>& parts) {
    const ElementTraits& kind = traits(element.kind);
    const auto corners_of_parts =
        element.kind == ElementKind::triangle ? triangle_parts(ratio_) : tensor_parts(kind, ratio_);
    for (const Corners& corners : corners_of_parts) {
      Element& part = parts.emplace_back(Element{element.kind, {}});
      std::vector<Border> border;
      for (std::size_t i = 0; i < corners.size(); ++i) {
        const Shares shares = shares_of(element, corners[i], ratio_);
        part.node[i] = node_at(shares, element[0]);
        border.push_back(border_of(shares));
      }
      if (kind.dimension == 1) continue;  // its ends stay what they are
      for (const Face& whole : kind.faces) take_faces_on(element, whole, part, border);
    }
  }

  int node_at(const Shares& shares, int first) {
    if (shares.size() == 1) return shares[0].first;
    const auto [place, is_new] = new_nodes_.emplace(shares, static_cast<int>(mesh_.position.size()));
    if (!is_new) return place->second;
    const std::vector<WeightedNode> weights = weights_of(shares);
    Eigen::Vector3d x = Eigen::Vector3d::Zero();
    for (const auto& [node, weight] : weights)
      x += weight * nearest_image(mesh_, mesh_.position[at(node)], mesh_.position[at(first)]);
    const Eigen::Vector2d period(mesh_.period_m, mesh_.period_wide_m);
    for (Eigen::Index c = 0; c < 2; ++c) {
      if (period[c] > 0.0 && x[c] >= period[c]) x[c] -= period[c];
    }
    mesh_.position.push_back(x);
    if (kept_.contains(border_of(shares))) mesh_.hanging.push_back({place->second, weights});
    return place->second;
  }

  /// The faces of a part that lie on a face of the element.
  void take_faces_on(const Element& element, const Face& whole, const Element& part,
                     const std::vector<Border>& border) {
    Face large{};
    for (const int local : whole) large.push_back(element[at(local)]);
    const auto on_it = [&](int corner) {
      return std::all_of(border[at(corner)].begin(), border[at(corner)].end(),
                         [&](int node) { return std::find(large.begin(), large.end(), node) != large.end(); });
    };
    for (const Face& local : traits(element.kind).faces) {
      if (!std::all_of(local.begin(), local.end(), on_it)) continue;
      Face face{};
      for (const int corner : local) face.push_back(part[at(corner)]);
      parts_of_face_[from_smallest(large)].push_back(face);
    }
  }

  void divide_surfaces() {
    for (auto& [name, faces] : mesh_.surfaces) {
      std::vector<Face> parts;
      for (const Face& face : faces) {
        const auto found = parts_of_face_.find(from_smallest(face));
        if (found == parts_of_face_.end()) {
          parts.push_back(face);
          continue;
        }
        parts.insert(parts.end(), found->second.begin(), found->second.end());
        if (face.size() > 1 && std::find(mesh_.refined_surfaces.begin(), mesh_.refined_surfaces.end(), name) ==
                                   mesh_.refined_surfaces.end())
          mesh_.refined_surfaces.push_back(name);
      }
      faces = std::move(parts);
    }
  }

  /// The nodes of the parts come last, in the order of their places, the first coordinate fastest: a structured mesh
  /// then has the same neighbours for most of them as far apart, of which products with K live.
  void number_row_by_row(const std::vector<std::pair<int, int>>& parts_of) {
    std::vector<bool> of_part(mesh_.position.size(), false);
    double edge_m = std::numeric_limits<double>::infinity();
    for (std::size_t e = 0; e < divided_.size(); ++e) {
      if (!divided_[e]) continue;
      for (int part = parts_of[e].first; part < parts_of[e].second; ++part)
        for (const int node : mesh_.elements[at(part)]) of_part[at(node)] = true;
      edge_m = std::min(edge_m, edge_lengths(element_geometry(mesh_, parts_of[e].first)).shortest);
    }
    const double same_m = 1e-3 * edge_m;
    std::vector<std::pair<std::array<double, 4>, int>> order;
    for (int node = 0; node < static_cast<int>(mesh_.position.size()); ++node) {
      const Eigen::Vector3d row = (mesh_.position[at(node)] / same_m).array().round();
      if (of_part[at(node)]) {
        order.push_back({{1.0, row[2], row[1], row[0]}, node});
      } else {
        order.push_back({{0.0, 0.0, 0.0, 0.0}, node});
      }
    }
    std::sort(order.begin(), order.end());
    std::vector<int> number(order.size());
    std::vector<Eigen::Vector3d> position;
    for (const auto& [place, node] : order) {
      number[at(node)] = static_cast<int>(position.size());
      position.push_back(mesh_.position[at(node)]);
    }
    mesh_.position = std::move(position);
    const auto renumber = [&](auto& nodes) {
      for (int& node : nodes) node = number[at(node)];
    };
    for (Element& element : mesh_.elements) renumber(element);
    for (auto& [name, faces] : mesh_.surfaces)
      for (Face& face : faces) renumber(face);
    for (HangingNode& hanging : mesh_.hanging) {
      hanging.node = number[at(hanging.node)];
      for (auto& carrier : hanging.carriers) carrier.node = number[at(carrier.node)];
    }
    std::sort(mesh_.hanging.begin(), mesh_.hanging.end(),
              [](const HangingNode& a, const HangingNode& b) { return a.node < b.node; });
  }

  Mesh& mesh_;
  int ratio_;
  const std::vector<bool>& divided_;
  std::set<Border> kept_;
  std::map<Shares, int> new_nodes_;
  std::map<Face, std::vector<Face>> parts_of_face_;
};

/// Edges and faces that nodes hang on.
std::set<Border> carrying_borders(const Mesh& mesh) {
  std::set<Border> borders;
  for (const HangingNode& hanging : mesh.hanging) {
    Border border;
    for (const auto& carrier : hanging.carriers) border.push_back(carrier.node);
    borders.insert(border);
  }
  return borders;
}

Eigen::Vector3d middle_of(const Mesh& mesh, const Element& element) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const int node : element) sum += nearest_image(mesh, mesh.position[at(node)], mesh.position[at(element[0])]);
  return sum / static_cast<double>(element.size());
}

std::vector<bool> elements_in(const Mesh& mesh, const RefinedBox& box) {
  std::vector<bool> inside;
  const std::set<Border> carrying = carrying_borders(mesh);
  const auto hangs = [&](int node) { return hanging_at(mesh, node) != nullptr; };
  for (const Element& element : mesh.elements) {
    const Eigen::Vector3d middle = middle_of(mesh, element);
    bool in = true;
    for (int c = 0; c < components(mesh.model); ++c) in = in && middle[c] >= box.from_m[c] && middle[c] <= box.to_m[c];
    inside.push_back(in);
    if (!in) continue;
    const std::string place = place_text(mesh.model, middle);
    if (element.kind == ElementKind::tetrahedron)
      throw ConfigError(fmt::format(
          "found a tetrahedron at {}; allowed: boxes of hexahedra, quadrilaterals, triangles or bars", place));
    bool beside = std::any_of(element.begin(), element.end(), hangs);
    for_each_border(element, [&](const Border& border) { beside = beside || carrying.contains(border); });
    if (beside)
      throw ConfigError(fmt::format(
          "found the element at {} beside elements of another size, which an earlier box has made; allowed: "
          "a whole layer of elements between two changes of size",
          place));
  }
  return inside;
}

}  // namespace

void refine(Mesh& mesh, const RefinedBox& box) {
  const std::vector<bool> divided = elements_in(mesh, box);
  double elements = 0.0;
  for (std::size_t e = 0; e < divided.size(); ++e)
    elements += divided[e] ? std::pow(box.ratio, traits(mesh.elements[e].kind).dimension) : 1.0;
  if (elements == static_cast<double>(divided.size()))
    throw ConfigError("found no element whose middle lies in the box; allowed: a box with some");
  if (elements > most_elements)
    throw ConfigError(fmt::format("found {:.0f} elements; allowed: at most {} in a body", elements, most_elements));
  Refinement(mesh, box, divided).divide();
}

}  // namespace ricochet::fem

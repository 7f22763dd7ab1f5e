#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "common/base/error.hpp"
#include "common/base/names.hpp"
#include "common/fem/gmsh_file.hpp"
#include "common/fem/mesh.hpp"
#include "common/fem/mesh_check.hpp"
#include "common/fem/part.hpp"

namespace ricochet::fem {
namespace {

using Edge = std::array<int, 2>;

[[noreturn]] void fail(const GmshFile& file, const GmshElement& element, const std::string& what) {
  throw ConfigError(fmt::format("{}:{}: element {} {}", file.path, element.line, element.tag, what));
}

/// Names of the physical groups an element belongs to.
std::vector<std::string> group_names(const GmshFile& file, const GmshElement& element) {
  std::vector<std::string> names;
  for (const int tag : file.entity_groups.at(element.entity)) {
    const auto named = file.group_name.find({element.entity.first, tag});
    if (named != file.group_name.end()) names.push_back(named->second);
  }
  return names;
}

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

void require_group(const GmshFile& file, int dimension, const std::string& body) {
  const char* kinds[] = {"point", "curve", "surface", "volume"};
  std::vector<std::string> known;
  std::string elsewhere;
  for (const auto& [key, name] : file.group_name) {
    if (key.first == dimension) known.push_back(name);
    if (key.first != dimension && name == body) elsewhere = fmt::format(" (it is a physical {})", kinds[at(key.first)]);
  }
  if (contains(known, body)) return;
  const std::string list = known.empty() ? "none" : fmt::format("{}", fmt::join(known, ", "));
  throw ConfigError(fmt::format("{}: no physical {} \"{}\"{}; the file has: {}{}", file.path, kinds[at(dimension)],
                                body, elsewhere, list, did_you_mean(body, known)));
}

std::vector<const GmshElement*> elements_of(const GmshFile& file, int dimension, const std::string& body) {
  require_group(file, dimension, body);
  std::vector<const GmshElement*> kept;
  for (const GmshElement& element : file.elements) {
    if (element.entity.first != dimension) continue;
    if (file.entity_groups.at(element.entity).empty()) {
      fail(file, element, fmt::format("in entity {} belongs to no physical group", element.entity.second));
    }
    if (contains(group_names(file, element), body)) kept.push_back(&element);
  }
  if (kept.empty()) throw ConfigError(fmt::format("{}: physical group \"{}\" has no elements", file.path, body));
  return kept;
}

Eigen::Vector2d plane_position(const GmshFile& file, GmshTag tag, Model model) {
  const Eigen::Vector3d& x = file.nodes.at(tag);
  const int first_unused = model == Model::bar ? 1 : 2;
  for (int c = first_unused; c < 3; ++c) {
    if (x[c] == 0.0) continue;
    throw ConfigError(fmt::format("{}: node {} has {} = {:.6g} m; {}", file.path, tag, "xyz"[c], x[c],
                                  model == Model::bar ? "bars lie on the x axis" : "the mesh must lie in z = 0"));
  }
  return x.head<2>();
}

/// Nodes in ascending order of their tags.
std::map<GmshTag, int> take_nodes(const GmshFile& file, const std::vector<const GmshElement*>& kept, Mesh& mesh) {
  std::map<GmshTag, int> local;
  for (const GmshElement* element : kept) {
    for (int i = 0; i < traits(*kind_of_gmsh_type(element->type)).nodes; ++i) local[element->nodes[at(i)]] = 0;
  }
  double largest = 0.0;
  for (auto& [tag, index] : local) {
    index = static_cast<int>(mesh.position.size());
    mesh.position.push_back(plane_position(file, tag, mesh.model));
    largest = std::max(largest, std::abs(mesh.position.back()[0]));
  }
  if (mesh.model != Model::axisymmetric) return local;
  // Gmsh leaves points of the axis at r = 1e-19 or so; what is meant is the axis.
  for (Eigen::Vector2d& x : mesh.position) {
    if (std::abs(x[0]) <= 1e-9 * largest) x[0] = 0.0;
  }
  return local;
}

/// Of a polygon, positive if its corners run counter-clockwise.
double signed_area(const ElementCoordinates& x) {
  double twice = 0.0;
  for (Eigen::Index i = 2; i < x.rows(); ++i) {
    const Eigen::RowVector2d a = x.row(i - 1) - x.row(0), b = x.row(i) - x.row(0);
    twice += a[0] * b[1] - a[1] * b[0];
  }
  return 0.5 * twice;
}

/// Elements, turned to run counter-clockwise (bar: along x).
void take_elements(const GmshFile& file, const std::vector<const GmshElement*>& kept,
                   const std::map<GmshTag, int>& local, Mesh& mesh) {
  for (const GmshElement* source : kept) {
    auto& placed = mesh.elements.emplace_back();
    placed.kind = *kind_of_gmsh_type(source->type);
    for (std::size_t i = 0; i < placed.size(); ++i) placed.node[i] = local.at(source->nodes[i]);
    const int index = static_cast<int>(mesh.elements.size()) - 1;
    const ElementCoordinates x = element_geometry(mesh, index).x;
    if (mesh.model == Model::bar && x(1, 0) < x(0, 0)) std::reverse(placed.begin(), placed.end());
    if (mesh.model != Model::bar && signed_area(x) < 0.0) std::reverse(placed.begin() + 1, placed.end());
    if (const auto defect = element_defect(mesh, index)) fail(file, *source, *defect);
    for (const std::string& name : group_names(file, *source)) mesh.element_groups[name].push_back(index);
  }
}

/// The element to the left of each edge; two there means that elements overlap.
std::map<Edge, int> elements_left_of_edges(const GmshFile& file, const std::vector<const GmshElement*>& kept,
                                           const Mesh& mesh) {
  std::map<Edge, int> left;
  for (int e = 0; e < static_cast<int>(mesh.elements.size()); ++e) {
    const Element& nodes = mesh.elements[at(e)];
    for (const auto& [a, b] : traits(nodes.kind).edges) {
      const Edge edge = {nodes[at(a)], nodes[at(b)]};
      const auto [other, fresh] = left.insert({edge, e});
      if (!fresh) fail(file, *kept[at(e)], fmt::format("overlaps element {}", kept[at(other->second)]->tag));
    }
  }
  return left;
}

/// Elements that use each node of a bar.
std::vector<int> elements_at_nodes(const Mesh& mesh) {
  std::vector<int> count(mesh.position.size(), 0);
  for (const auto& nodes : mesh.elements) {
    for (const int node : nodes) ++count[at(node)];
  }
  return count;
}

void take_surfaces(const GmshFile& file, const std::vector<const GmshElement*>& kept,
                   const std::map<GmshTag, int>& local, Mesh& mesh) {
  const bool bar = mesh.model == Model::bar;
  const std::map<Edge, int> left = elements_left_of_edges(file, kept, mesh);
  const std::vector<int> elements_at = bar ? elements_at_nodes(mesh) : std::vector<int>{};
  for (const GmshElement& source : file.elements) {
    if (source.entity.first != (bar ? 0 : 1)) continue;
    const auto a = local.find(source.nodes[0]);
    const auto b = local.find(source.nodes[bar ? 0 : 1]);
    if (a == local.end() || b == local.end()) continue;  // of another body
    Edge edge = {a->second, b->second};
    const bool forward = bar || left.contains(edge);
    const bool backward = left.contains({edge[1], edge[0]});
    if (!forward && !backward) continue;  // joins two nodes of this body, but through another one
    const std::vector<std::string> names = group_names(file, source);
    const bool inside = bar ? elements_at[at(edge[0])] > 1 : forward && backward;
    if (inside && !names.empty()) {
      fail(file, source, fmt::format("of \"{}\" lies inside the body, not on its surface", names[0]));
    }
    if (!forward) std::swap(edge[0], edge[1]);
    for (const std::string& name : names) mesh.surfaces[name].push_back(edge);
  }
}

/// Two nodes at one place are a crack that nobody sees.
void refuse_coincident_nodes(const GmshFile& file, const std::map<GmshTag, int>& local, const Mesh& mesh) {
  std::vector<std::pair<GmshTag, Eigen::Vector2d>> nodes;
  double largest = 0.0;
  for (const auto& [tag, index] : local) {
    nodes.emplace_back(tag, mesh.position[at(index)]);
    largest = std::max(largest, (mesh.position[at(index)] - mesh.position[0]).norm());
  }
  const double tolerance = 1e-9 * largest;
  std::sort(nodes.begin(), nodes.end(), [](const auto& a, const auto& b) { return a.second[0] < b.second[0]; });
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    for (std::size_t j = i + 1; j < nodes.size() && nodes[j].second[0] - nodes[i].second[0] <= tolerance; ++j) {
      if (std::abs(nodes[j].second[1] - nodes[i].second[1]) > tolerance) continue;
      const auto [first, second] = std::minmax(nodes[i].first, nodes[j].first);
      throw ConfigError(
          fmt::format("{}: nodes {} and {} of one body lie at the same place ({:.6g}, {:.6g}) m: the "
                      "mesh is cut there; merge the geometry with 'Coherence;'",
                      file.path, first, second, nodes[i].second[0], nodes[i].second[1]));
    }
  }
}

}  // namespace

Mesh read_gmsh(const std::string& path, Model model, const std::string& body) {
  const GmshFile file = read_gmsh_file(path);
  const auto kept = elements_of(file, model == Model::bar ? 1 : 2, body);
  Mesh mesh;
  mesh.model = model;
  const auto local = take_nodes(file, kept, mesh);
  take_elements(file, kept, local, mesh);
  refuse_coincident_nodes(file, local, mesh);
  take_surfaces(file, kept, local, mesh);
  return mesh;
}

}  // namespace ricochet::fem

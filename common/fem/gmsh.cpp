#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "common/base/error.hpp"
#include "common/base/names.hpp"
#include "common/fem/gmsh_file.hpp"
#include "common/fem/inp_file.hpp"
#include "common/fem/mesh.hpp"
#include "common/fem/mesh_check.hpp"
#include "common/fem/part.hpp"

namespace ricochet::fem {
namespace {

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
  if (file.sets)
    throw ConfigError(fmt::format("{}: no *ELSET \"{}\" for the body of that name; the file has: {}{}", file.path, body,
                                  list, did_you_mean(body, known)));
  throw ConfigError(fmt::format("{}: no physical {} \"{}\"{}; the file has: {}{}", file.path, kinds[at(dimension)],
                                body, elsewhere, list, did_you_mean(body, known)));
}

std::vector<const GmshElement*> elements_of(const GmshFile& file, int dimension, const std::string& body) {
  require_group(file, dimension, body);
  std::vector<const GmshElement*> kept;
  for (const GmshElement& element : file.elements) {
    if (element.entity.first != dimension) continue;
    if (file.entity_groups.at(element.entity).empty()) {
      if (file.sets) fail(file, element, "is in no *ELSET: of which body is it?");
      fail(file, element, fmt::format("in entity {} belongs to no physical group", element.entity.second));
    }
    if (contains(group_names(file, element), body)) kept.push_back(&element);
  }
  if (kept.empty())
    throw ConfigError(
        fmt::format("{}: {} \"{}\" has no elements", file.path, file.sets ? "*ELSET" : "physical group", body));
  return kept;
}

Eigen::Vector3d position_in(Model model, const GmshFile& file, GmshTag tag) {
  const Eigen::Vector3d& x = file.nodes.at(tag);
  for (int c = components(model); c < 3; ++c) {
    if (x[c] == 0.0) continue;
    throw ConfigError(fmt::format("{}: node {} has {} = {:.6g} m; {}", file.path, tag, "xyz"[c], x[c],
                                  model == Model::bar ? "bars lie on the x axis" : "the mesh must lie in z = 0"));
  }
  return x;
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
    mesh.position.push_back(position_in(mesh.model, file, tag));
    largest = std::max(largest, std::abs(mesh.position.back()[0]));
  }
  if (mesh.model != Model::axisymmetric) return local;
  // Gmsh leaves points of the axis at r = 1e-19 or so; what is meant is the axis.
  for (Eigen::Vector3d& x : mesh.position) {
    if (std::abs(x[0]) <= 1e-9 * largest) x[0] = 0.0;
  }
  return local;
}

/// The area of a polygon, positive if its corners run counter-clockwise.
double signed_area(const ElementCoordinates& x) {
  double twice = 0.0;
  for (Eigen::Index i = 2; i < x.rows(); ++i) {
    const Eigen::RowVector2d a = x.row(i - 1) - x.row(0), b = x.row(i) - x.row(0);
    twice += a[0] * b[1] - a[1] * b[0];
  }
  return 0.5 * twice;
}

/// Turns an element that runs backwards, clockwise or inside out.
void turn(Element& element, const ElementCoordinates& x) {
  const ElementTraits& kind = traits(element.kind);
  if (kind.dimension == 1 && x(1, 0) < x(0, 0)) std::reverse(element.begin(), element.end());
  if (kind.dimension == 2 && signed_area(x) < 0.0) std::reverse(element.begin() + 1, element.end());
  if (kind.dimension < 3 || kind.jacobian(x, kind.centre) >= 0.0) return;
  if (element.kind == ElementKind::tetrahedron) std::swap(element.begin()[1], element.begin()[2]);
  if (element.kind == ElementKind::hexahedron) std::rotate(element.begin(), element.begin() + 4, element.end());
}

void take_elements(const GmshFile& file, const std::vector<const GmshElement*>& kept,
                   const std::map<GmshTag, int>& local, Mesh& mesh) {
  for (const GmshElement* source : kept) {
    auto& placed = mesh.elements.emplace_back();
    placed.kind = *kind_of_gmsh_type(source->type);
    for (std::size_t i = 0; i < placed.size(); ++i) placed.node[i] = local.at(source->nodes[i]);
    const int index = static_cast<int>(mesh.elements.size()) - 1;
    turn(placed, element_geometry(mesh, index).x);
    if (const auto defect = element_defect(mesh, index)) fail(file, *source, *defect);
    for (const std::string& name : group_names(file, *source)) mesh.element_groups[name].push_back(index);
  }
}

/// The element behind each face (of bars: along each edge); two there mean that elements overlap.
std::map<Face, int> elements_behind_faces(const GmshFile& file, const std::vector<const GmshElement*>& kept,
                                          const Mesh& mesh) {
  std::map<Face, int> behind;
  const auto add = [&](Face face, int e) {
    for (int& node : face) node = mesh.elements[at(e)][at(node)];
    const auto [other, fresh] = behind.insert({from_smallest(face), e});
    if (!fresh) fail(file, *kept[at(e)], fmt::format("overlaps element {}", kept[at(other->second)]->tag));
  };
  for (int e = 0; e < static_cast<int>(mesh.elements.size()); ++e) {
    const ElementTraits& kind = traits(mesh.elements[at(e)].kind);
    if (mesh.model == Model::bar) {
      add({0, 1}, e);
      continue;
    }
    for (const Face& face : kind.faces) add(face, e);
  }
  return behind;
}

/// Elements that use each node of a bar.
std::vector<int> elements_at_nodes(const Mesh& mesh) {
  std::vector<int> count(mesh.position.size(), 0);
  for (const auto& nodes : mesh.elements) {
    for (const int node : nodes) ++count[at(node)];
  }
  return count;
}

/// An element of the file in the mesh's numbers; none if it has nodes of another body.
std::optional<Face> face_of(const GmshElement& source, const std::map<GmshTag, int>& local) {
  Face face{};
  const std::size_t nodes = source.entity.first == 0 ? 1 : at(traits(*kind_of_gmsh_type(source.type)).nodes);
  for (std::size_t i = 0; i < nodes; ++i) {
    const auto node = local.find(source.nodes[i]);
    if (node == local.end()) return std::nullopt;
    face.push_back(node->second);
  }
  return face;
}

void take_surfaces(const GmshFile& file, const std::vector<const GmshElement*>& kept,
                   const std::map<GmshTag, int>& local, Mesh& mesh) {
  const bool bar = mesh.model == Model::bar;
  const std::map<Face, int> behind = elements_behind_faces(file, kept, mesh);
  const std::vector<int> elements_at = bar ? elements_at_nodes(mesh) : std::vector<int>{};
  std::map<std::pair<std::string, Face>, GmshTag> taken;
  for (const GmshElement& source : file.elements) {
    if (source.entity.first != components(mesh.model) - 1) continue;
    const std::optional<Face> face = face_of(source, local);
    if (!face) continue;
    Face turned = *face;
    std::reverse(turned.begin(), turned.end());
    const bool forward = bar || behind.contains(from_smallest(*face));
    const bool backward = behind.contains(from_smallest(turned));
    if (!forward && !backward) continue;  // joins nodes of this body, but through another one
    const std::vector<std::string> names = group_names(file, source);
    const bool inside = bar ? elements_at[at((*face)[0])] > 1 : forward && backward;
    if (inside && !names.empty()) {
      fail(file, source, fmt::format("of \"{}\" lies inside the body, not on its surface", names[0]));
    }
    for (const std::string& name : names) {
      const Face& outward = forward ? *face : turned;
      const auto [other, fresh] = taken.insert({{name, from_smallest(outward)}, source.tag});
      if (!fresh) {
        fail(file, source,
             fmt::format("is the same face of \"{}\" as element {}: loads and contact would act there twice; leave one "
                         "out",
                         name, other->second));
      }
      mesh.surfaces[name].push_back(outward);
    }
  }
}

/// Two nodes at one place are a crack that nobody sees.
void refuse_coincident_nodes(const GmshFile& file, const std::map<GmshTag, int>& local, const Mesh& mesh) {
  std::vector<std::pair<GmshTag, Eigen::Vector3d>> nodes;
  double largest = 0.0;
  for (const auto& [tag, index] : local) {
    nodes.emplace_back(tag, mesh.position[at(index)]);
    largest = std::max(largest, (mesh.position[at(index)] - mesh.position[0]).norm());
  }
  const double tolerance = 1e-9 * largest;
  std::sort(nodes.begin(), nodes.end(), [](const auto& a, const auto& b) { return a.second[0] < b.second[0]; });
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    for (std::size_t j = i + 1; j < nodes.size() && nodes[j].second[0] - nodes[i].second[0] <= tolerance; ++j) {
      const Eigen::Vector3d apart = nodes[j].second - nodes[i].second;
      if (apart.tail<2>().cwiseAbs().maxCoeff() > tolerance) continue;
      const auto [first, second] = std::minmax(nodes[i].first, nodes[j].first);
      throw ConfigError(
          fmt::format("{}: nodes {} and {} of one body lie at the same place {}: the mesh is cut there; {}", file.path,
                      first, second, place_text(mesh.model, nodes[i].second),
                      file.sets ? "merge them where the mesh is made" : "merge the geometry with 'Coherence;'"));
    }
  }
}

}  // namespace

Mesh body_mesh(const GmshFile& file, Model model, const std::string& body) {
  const auto kept = elements_of(file, components(model), body);
  Mesh mesh;
  mesh.model = model;
  const auto local = take_nodes(file, kept, mesh);
  take_elements(file, kept, local, mesh);
  refuse_coincident_nodes(file, local, mesh);
  take_surfaces(file, kept, local, mesh);
  return mesh;
}

Mesh read_gmsh(const std::string& path, Model model, const std::string& body) {
  return body_mesh(read_gmsh_file(path), model, body);
}

}  // namespace ricochet::fem

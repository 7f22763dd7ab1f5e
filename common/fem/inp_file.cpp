#include "common/fem/inp_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>
#include <string_view>

#include "common/base/error.hpp"
#include "common/base/names.hpp"
#include "common/fem/element_kind.hpp"
#include "common/fem/inp_cards.hpp"

namespace ricochet::fem {
namespace {

const std::vector<std::string> mesh_cards{"NODE", "ELEMENT", "NSET", "ELSET", "SURFACE"};

/// The keywords that make, move or join parts of a mesh. To leave one out would be to compute another body.
const std::set<std::string, std::less<>> refused_cards{
    "INCLUDE", "PART",   "ASSEMBLY", "INSTANCE", "NGEN", "NFILL",     "NCOPY",    "NMAP",      "ELGEN",
    "ELCOPY",  "SYSTEM", "TIE",      "EQUATION", "MPC",  "RIGIDBODY", "COUPLING", "KINEMATIC", "EMBEDDEDELEMENT"};

struct InpType {
  std::string_view name;
  Model model;
  ElementKind kind;
};

constexpr std::array<InpType, 11> inp_types{{{"T3D2", Model::bar, ElementKind::bar},
                                             {"T2D2", Model::bar, ElementKind::bar},
                                             {"CPE3", Model::plane_strain, ElementKind::triangle},
                                             {"CPE4", Model::plane_strain, ElementKind::quadrilateral},
                                             {"CPE4R", Model::plane_strain, ElementKind::quadrilateral},
                                             {"CAX3", Model::axisymmetric, ElementKind::triangle},
                                             {"CAX4", Model::axisymmetric, ElementKind::quadrilateral},
                                             {"CAX4R", Model::axisymmetric, ElementKind::quadrilateral},
                                             {"C3D4", Model::solid, ElementKind::tetrahedron},
                                             {"C3D8", Model::solid, ElementKind::hexahedron},
                                             {"C3D8R", Model::solid, ElementKind::hexahedron}}};

/// Nodes of the faces S1, S2, ... in the element's own numbers, outward (CalculiX manual, "Element types").
const std::vector<Face>& faces_of(ElementKind kind) {
  static const std::vector<Face> bar{{0}, {1}}, triangle{{0, 1}, {1, 2}, {2, 0}},
      quadrilateral{{0, 1}, {1, 2}, {2, 3}, {3, 0}}, tetrahedron{{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}},
      hexahedron{{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
  switch (kind) {
    case ElementKind::bar: return bar;
    case ElementKind::triangle: return triangle;
    case ElementKind::quadrilateral: return quadrilateral;
    case ElementKind::tetrahedron: return tetrahedron;
    default: return hexahedron;
  }
}

/// Turns the cards of one file into its nodes, elements, sets and faces, in the file's order.
class InpReader {
 public:
  InpReader(const std::string& path, Model model) : model_(model) {
    file_.path = path;
    file_.sets = true;
  }

  GmshFile read() {
    for (const InpCard& card : read_inp_cards(file_.path, mesh_cards)) take(card);
    if (file_.nodes.empty()) throw ConfigError(file_.path + ": the file has no *NODE");
    if (place_.empty()) throw ConfigError(file_.path + ": the file has no *ELEMENT");
    place_elements();
    for (const InpCard& card : surfaces_) take_surface(card);
    return std::move(file_);
  }

 private:
  using Number = GmshTag;

  [[noreturn]] void fail(int line, const std::string& what) const {
    throw ConfigError(fmt::format("{}:{}: {}", file_.path, line, what));
  }

  void take(const InpCard& card) {
    if (refused_cards.contains(card.keyword))
      fail(card.line, fmt::format("found *{}, which makes, moves or joins parts of the mesh; allowed: one flat file of "
                                  "*NODE, *ELEMENT, *NSET, *ELSET and *SURFACE",
                                  card.keyword));
    if (card.keyword == "NODE") take_nodes(card);
    if (card.keyword == "ELEMENT") take_elements(card);
    if (card.keyword == "NSET") (void)needed(card, "NSET");
    if (card.keyword == "ELSET") take_set(card);
    if (card.keyword == "SURFACE") surfaces_.push_back(card);  // sets may come after it
  }

  void allow(const InpCard& card, const std::vector<std::string>& allowed) const {
    for (const InpParameter& parameter : card.parameters) {
      if (std::find(allowed.begin(), allowed.end(), parameter.key) != allowed.end()) continue;
      fail(card.line, fmt::format("found {} of *{}, which is not read; allowed: {}", parameter.key, card.keyword,
                                  fmt::join(allowed, ", ")));
    }
  }

  const std::string& needed(const InpCard& card, const std::string& key) const {
    const InpParameter* found = card.find(key);
    if (found == nullptr || found->value.empty())
      fail(card.line, fmt::format("found *{} without {}=; allowed: {}=NAME", card.keyword, key, key));
    return found->value;
  }

  template <class Value>
  Value value_of(int line, const std::string& field, std::string_view expected) const {
    std::string text = field.starts_with('+') ? field.substr(1) : field;
    if (!std::is_integral_v<Value>)
      std::replace_if(
          text.begin(), text.end(), [](char c) { return c == 'D' || c == 'd'; }, 'e');
    Value value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(static_cast<double>(value)))
      fail(line, fmt::format("expected {}, found \"{}\"", expected, field));
    return value;
  }

  void take_nodes(const InpCard& card) {
    allow(card, {"NSET"});
    for (const InpLine& data : card.data) {
      if (data.fields.size() < 2 || data.fields.size() > 4)
        fail(data.line,
             fmt::format("expected a node's number and its coordinates, found {} values", data.fields.size()));
      const auto tag = value_of<Number>(data.line, data.fields[0], "a node's number");
      Eigen::Vector3d place = Eigen::Vector3d::Zero();
      for (std::size_t i = 1; i < data.fields.size(); ++i)
        if (!data.fields[i].empty())
          place[static_cast<Eigen::Index>(i) - 1] = value_of<double>(data.line, data.fields[i], "a coordinate");
      if (!file_.nodes.insert({tag, place}).second) fail(data.line, fmt::format("node {} is defined twice", tag));
    }
  }

  ElementKind kind_of(const InpCard& card) const {
    const std::string name = upper_case(needed(card, "TYPE"));
    std::vector<std::string_view> allowed;
    for (const InpType& type : inp_types) {
      if (type.model != model_) continue;
      if (type.name == name) return type.kind;
      allowed.push_back(type.name);
    }
    fail(card.line, fmt::format("found element type {}; allowed in this model: {}", name, fmt::join(allowed, ", ")));
  }

  void take_elements(const InpCard& card) {
    allow(card, {"TYPE", "ELSET"});
    const ElementKind kind = kind_of(card);
    const std::size_t count = static_cast<std::size_t>(traits(kind).nodes);
    const int set = card.find("ELSET") == nullptr ? 0 : set_number(needed(card, "ELSET"));
    std::vector<std::string> fields;
    for (const InpLine& data : card.data) {
      fields.insert(fields.end(), data.fields.begin(), data.fields.end());
      if (fields.size() <= count && data.goes_on) continue;
      take_element(data.line, kind, fields, set);
      fields.clear();
    }
    if (!fields.empty()) fail(card.data.back().line, "the last element ends before all of its nodes are given");
  }

  void take_element(int line, ElementKind kind, const std::vector<std::string>& fields, int set) {
    GmshElement element;
    element.line = line;
    element.type = traits(kind).gmsh_type;
    element.tag = value_of<Number>(line, fields[0], "an element's number");
    if (fields.size() != static_cast<std::size_t>(traits(kind).nodes) + 1)
      fail(line,
           fmt::format("element {} has {} nodes, its type {}", element.tag, fields.size() - 1, traits(kind).nodes));
    for (std::size_t i = 1; i < fields.size(); ++i) {
      const auto node = value_of<Number>(line, fields[i], "a node of an element");
      if (!file_.nodes.contains(node))
        fail(line, fmt::format("element {} uses node {}, which is not defined before it", element.tag, node));
      element.nodes[i - 1] = node;
    }
    if (!place_.insert({element.tag, file_.elements.size()}).second)
      fail(line, fmt::format("element {} is defined twice", element.tag));
    file_.elements.push_back(element);
    if (set != 0) members_[set].push_back(element.tag);
  }

  /// From 1; upper and lower case are the same.
  int set_number(const std::string& name) {
    const auto [found, fresh] = set_.insert({upper_case(name), static_cast<int>(set_.size()) + 1});
    if (fresh) file_.group_name[{components(model_), found->second}] = name;
    return found->second;
  }

  void take_set(const InpCard& card) {
    allow(card, {"ELSET", "GENERATE", "INTERNAL", "UNSORTED"});
    const int set = set_number(needed(card, "ELSET"));
    for (const InpLine& data : card.data) {
      if (card.find("GENERATE") != nullptr) {
        generate(data, set);
        continue;
      }
      for (const std::string& field : data.fields)
        for (const Number tag : elements_named(data.line, field)) members_[set].push_back(tag);
    }
  }

  void generate(const InpLine& data, int set) {
    if (data.fields.size() != 2 && data.fields.size() != 3)
      fail(data.line, fmt::format("expected first, last and step of GENERATE, found {} values", data.fields.size()));
    const auto first = value_of<Number>(data.line, data.fields[0], "the first element");
    const auto last = value_of<Number>(data.line, data.fields[1], "the last element");
    const auto step = data.fields.size() == 3 ? value_of<Number>(data.line, data.fields[2], "a step") : 1;
    if (first < 1 || step < 1 || last < first)
      fail(data.line, fmt::format("found {}, {}, {} of GENERATE; allowed: 1 <= first <= last and a step of 1 or more",
                                  first, last, step));
    // Numbers of the range that no element has are passed over, as CalculiX does.
    for (auto at = place_.lower_bound(first); at != place_.end() && at->first <= last; ++at)
      if ((at->first - first) % step == 0) members_[set].push_back(at->first);
  }

  /// A number or the name of a set that was defined before.
  std::vector<Number> elements_named(int line, const std::string& field) const {
    const bool number = !field.empty() && field.find_first_not_of("+0123456789") == std::string::npos;
    if (number) {
      const auto tag = value_of<Number>(line, field, "an element's number");
      if (!place_.contains(tag)) fail(line, fmt::format("found element {}, which is not defined before it", tag));
      return {tag};
    }
    const auto set = set_.find(upper_case(field));
    if (set == set_.end()) {
      std::vector<std::string> known;
      for (const auto& [group, name] : file_.group_name)
        if (group.first == components(model_)) known.push_back(name);
      fail(line, fmt::format("found \"{}\", which is no element and no *ELSET defined before it{}", field,
                             did_you_mean(field, known)));
    }
    const auto members = members_.find(set->second);
    return members == members_.end() ? std::vector<Number>{} : members->second;
  }

  /// Elements of the same sets are of one entity.
  void place_elements() {
    std::vector<std::vector<int>> sets(file_.elements.size());
    for (const auto& [set, tags] : members_) {
      for (const Number tag : tags) {
        std::vector<int>& of = sets[place_.at(tag)];
        if (of.empty() || of.back() != set) of.push_back(set);
      }
    }
    std::map<std::vector<int>, int> entity;
    for (std::size_t e = 0; e < sets.size(); ++e) {
      const int tag = entity.insert({sets[e], static_cast<int>(entity.size()) + 1}).first->second;
      file_.elements[e].entity = {components(model_), tag};
    }
    for (const auto& [groups, tag] : entity) file_.entity_groups[{components(model_), tag}] = groups;
  }

  void take_surface(const InpCard& card) {
    allow(card, {"NAME", "TYPE", "INTERNAL"});
    const std::string& name = needed(card, "NAME");
    const InpParameter* type = card.find("TYPE");
    if (type != nullptr && upper_case(type->value) != "ELEMENT")
      fail(card.line,
           fmt::format("found TYPE={} of *SURFACE {}; allowed: TYPE=ELEMENT, faces of elements", type->value, name));
    const int dimension = components(model_) - 1;
    const auto [found, fresh] = surface_.insert({upper_case(name), static_cast<int>(surface_.size()) + 1});
    if (!fresh) fail(card.line, fmt::format("*SURFACE {} is defined twice", name));
    const GmshEntity entity{dimension, found->second};
    file_.group_name[entity] = name;
    file_.entity_groups[entity] = {found->second};
    for (const InpLine& data : card.data) {
      if (data.fields.size() != 2)
        fail(data.line, "expected an element or *ELSET and one of its faces, as in \"top, S2\"");
      std::set<Number> seen;  // a set may name an element twice
      for (const Number tag : elements_named(data.line, data.fields[0]))
        if (seen.insert(tag).second) take_face(data, tag, entity);
    }
  }

  void take_face(const InpLine& data, Number tag, const GmshEntity& entity) {
    const GmshElement source = file_.elements[place_.at(tag)];
    const std::vector<Face>& faces = faces_of(*kind_of_gmsh_type(source.type));
    const std::string prefix = model_ == Model::bar ? "END" : "S", label = upper_case(data.fields[1]);
    std::size_t index = 0;
    while (index < faces.size() && label != fmt::format("{}{}", prefix, index + 1)) ++index;
    if (index == faces.size())
      fail(data.line, fmt::format("found face {} of element {}; allowed: {}1 to {}{}", data.fields[1], tag, prefix,
                                  prefix, faces.size()));
    const Face& face = faces[index];
    GmshElement element;
    element.tag = tag;
    element.line = data.line;
    element.entity = entity;
    constexpr std::array<int, 5> gmsh_type{0, 15, 1, 2, 3};  // of a point, line, triangle, quadrilateral
    element.type = gmsh_type[face.size()];
    for (std::size_t i = 0; i < face.size(); ++i) element.nodes[i] = source.nodes[at(face[i])];
    file_.elements.push_back(element);
  }

  Model model_;
  GmshFile file_;
  std::map<Number, std::size_t> place_;       ///< of each element in the file's list
  std::map<std::string, int> set_, surface_;  ///< by name in upper case
  std::map<int, std::vector<Number>> members_;
  std::vector<InpCard> surfaces_;
};

}  // namespace

bool is_inp_file(const std::string& path) { return upper_case(path).ends_with(".INP"); }

GmshFile read_inp_file(const std::string& path, Model model) { return InpReader(path, model).read(); }

Mesh read_inp(const std::string& path, Model model, const std::string& body, bool only) {
  GmshFile file = read_inp_file(path, model);
  const int dimension = components(model);
  bool known = false;
  for (auto& [entity, name] : file.group_name) {
    if (entity.first != dimension || upper_case(name) != upper_case(body)) continue;
    name = body;
    known = true;
  }
  if (!known && only) {
    const GmshEntity all{dimension, 0};
    file.group_name[all] = body;
    for (auto& [entity, groups] : file.entity_groups)
      if (entity.first == dimension) groups.push_back(all.second);
  }
  return body_mesh(file, model, body);
}

std::vector<std::string> ignored_inp_cards(const std::string& path) {
  std::vector<std::string> ignored;
  for (const InpCard& card : read_inp_cards(path, {})) {
    if (std::find(mesh_cards.begin(), mesh_cards.end(), card.keyword) != mesh_cards.end()) continue;
    const std::string name = "*" + card.keyword;
    if (std::find(ignored.begin(), ignored.end(), name) == ignored.end()) ignored.push_back(name);
  }
  return ignored;
}

bool inp_has_node_set(const std::string& path, const std::string& name) {
  for (const InpCard& card : read_inp_cards(path, {})) {
    const bool may = card.keyword == "NSET" || card.keyword == "NODE";
    const InpParameter* set = may ? card.find("NSET") : nullptr;
    if (set != nullptr && upper_case(set->value) == upper_case(name)) return true;
  }
  return false;
}

}  // namespace ricochet::fem

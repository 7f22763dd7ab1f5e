#include "common/fem/gmsh_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <limits>
#include <set>
#include <sstream>
#include <string_view>

#include "common/base/error.hpp"
#include "common/fem/element_kind.hpp"

namespace ricochet::fem {
namespace {

constexpr std::string_view blank = " \t\r\n";

/// Words of a text and the line each stands on.
class Words {
 public:
  explicit Words(const std::string& path) : path_(path) {
    std::ifstream file(path, std::ios::binary);
    std::ostringstream text;
    if (!(file && text << file.rdbuf())) throw ConfigError(fmt::format("cannot read mesh file {}", path));
    text_ = text.str();
  }

  [[noreturn]] void fail(const std::string& what) const {
    throw ConfigError(fmt::format("{}:{}: {}", path_, line_, what));
  }
  [[nodiscard]] int line() const { return line_; }
  [[nodiscard]] bool at_end() {
    skip_blank();
    return position_ == text_.size();
  }

  std::string_view word(std::string_view expected) {
    if (at_end()) fail(fmt::format("the file ends where {} should be; was it cut off?", expected));
    const std::size_t end = std::min(text_.find_first_of(blank, position_), text_.size());
    const std::string_view found = std::string_view(text_).substr(position_, end - position_);
    position_ = end;
    return found;
  }

  template <class Number>
  Number number(std::string_view expected) {
    const std::string_view found = word(expected);
    Number value{};
    const auto [end, error] = std::from_chars(found.data(), found.data() + found.size(), value);
    if (error != std::errc{} || end != found.data() + found.size() || !std::isfinite(static_cast<double>(value))) {
      fail(fmt::format("expected {}, found \"{}\"", expected, found));
    }
    return value;
  }

  int count(std::string_view expected) {
    const int value = number<int>(expected);
    if (value < 0) fail(fmt::format("expected {}, found {}", expected, value));
    return value;
  }

  int dimension(std::string_view expected) {
    const int value = number<int>(expected);
    if (value < 0 || value > 3) fail(fmt::format("expected {}, 0 to 3, found {}", expected, value));
    return value;
  }

  /// Negative where the orientation is reversed.
  int physical_tag() {
    const int value = number<int>("a physical tag");
    if (value == std::numeric_limits<int>::min()) fail(fmt::format("expected a physical tag, found {}", value));
    return std::abs(value);
  }

  std::string quoted(std::string_view expected) {
    if (at_end() || text_[position_] != '"') fail(fmt::format("expected {} in double quotes", expected));
    const std::size_t end = text_.find_first_of("\"\n", position_ + 1);
    if (end == std::string::npos || text_[end] == '\n') fail(fmt::format("{} has no closing quote", expected));
    std::string found = text_.substr(position_ + 1, end - position_ - 1);
    position_ = end + 1;
    return found;
  }

  void expect(std::string_view expected) {
    const std::string_view found = word(expected);
    if (found != expected) fail(fmt::format("expected {}, found \"{}\"", expected, found));
  }

  void skip_past(const std::string& section_end) {
    while (word(section_end) != section_end) {
    }
  }

 private:
  void skip_blank() {
    for (; position_ < text_.size() && blank.find(text_[position_]) != std::string_view::npos; ++position_) {
      if (text_[position_] == '\n') ++line_;
    }
  }

  std::string path_;
  std::string text_;
  std::size_t position_ = 0;
  int line_ = 1;
};

void read_format(Words& words) {
  const std::string_view version = words.word("the format version");
  if (version != "4.1") {
    words.fail(fmt::format("MSH format {}, needed is 4.1: save with 'gmsh -format msh41' or Mesh.MshFileVersion = 4.1",
                           version));
  }
  if (words.number<int>("the file type, 0 for ASCII") != 0) {
    words.fail("the file is binary, needed is ASCII: save without '-bin' or with Mesh.Binary = 0");
  }
  words.number<int>("the data size");
}

void read_physical_names(Words& words, GmshFile& file) {
  std::set<std::pair<int, std::string>> seen;
  for (int left = words.count("the number of physical names"); left > 0; --left) {
    const int dimension = words.dimension("the dimension of a physical group");
    const int tag = words.number<int>("the tag of a physical group");
    const std::string name = words.quoted("the name of a physical group");
    if (!seen.insert({dimension, name}).second || !file.group_name.insert({{dimension, tag}, name}).second) {
      words.fail(fmt::format("physical group {} \"{}\" of dimension {} is named twice", tag, name, dimension));
    }
  }
}

void read_entities(Words& words, GmshFile& file) {
  std::array<int, 4> counts{};
  for (int& count : counts) count = words.count("the number of entities");
  for (int dimension = 0; dimension < 4; ++dimension) {
    for (int left = counts[static_cast<std::size_t>(dimension)]; left > 0; --left) {
      const int tag = words.number<int>("the tag of an entity");
      for (int i = dimension == 0 ? 3 : 6; i > 0; --i) words.number<double>("a coordinate of an entity");
      std::vector<int>& groups = file.entity_groups[{dimension, tag}];
      for (int i = words.count("the number of physical tags"); i > 0; --i) groups.push_back(words.physical_tag());
      if (dimension == 0) continue;
      for (int i = words.count("the number of bounding entities"); i > 0; --i) words.number<int>("a bounding entity");
    }
  }
}

void read_nodes(Words& words, GmshFile& file) {
  int blocks = words.count("the number of entity blocks");
  const int expected = words.count("the number of nodes");
  for (int i = 0; i < 2; ++i) words.number<GmshTag>("the smallest and the largest node tag");
  for (; blocks > 0; --blocks) {
    const int dimension = words.dimension("the dimension of a node block");
    words.number<int>("the entity of a node block");
    const bool parametric = words.number<int>("the parametric flag") != 0;
    std::vector<GmshTag> tags;  // grows, for the announced number may be nonsense
    for (int left = words.count("the number of nodes of a block"); left > 0; --left) {
      tags.push_back(words.number<GmshTag>("a node tag"));
      if (file.nodes.insert({tags.back(), Eigen::Vector3d::Zero()}).second) continue;
      words.fail(fmt::format("node {} is defined twice", tags.back()));
    }
    for (const GmshTag tag : tags) {
      for (double& x : file.nodes[tag]) x = words.number<double>("a node coordinate");
      for (int i = parametric ? dimension : 0; i > 0; --i) words.number<double>("a parametric coordinate");
    }
  }
  if (static_cast<int>(file.nodes.size()) != expected) {
    words.fail(fmt::format("{} nodes are announced, the blocks hold {}", expected, file.nodes.size()));
  }
}

struct ElementType {
  int number;
  int dimension;
  int nodes;
};

ElementType element_type(const Words& words, int type, const GmshEntity& entity) {
  constexpr int point = 15;
  if (type == point) return {type, 0, 1};
  if (const auto kind = kind_of_gmsh_type(type)) return {type, traits(*kind).dimension, traits(*kind).nodes};
  constexpr std::string_view allowed =
      "2-node lines, 3-node triangles, 4-node quadrilaterals, 4-node tetrahedra and 8-node hexahedra (types 1 to 5) "
      "can "
      "be used";
  const std::string where = fmt::format("in entity {} of dimension {}", entity.second, entity.first);
  switch (type) {
    case 8:
    case 9:
    case 10:
    case 11:
    case 12:
    case 16:
    case 17:
      words.fail(
          fmt::format("second-order elements (type {}) {}; only {}: set Mesh.ElementOrder = 1", type, where, allowed));
    default: words.fail(fmt::format("element type {} {}; only {}", type, where, allowed));
  }
}

GmshElement read_element(Words& words, const GmshFile& file, const GmshEntity& entity, const ElementType& type) {
  GmshElement element;
  element.type = type.number;
  element.tag = words.number<GmshTag>("an element tag");
  element.line = words.line();
  element.entity = entity;
  for (int i = 0; i < type.nodes; ++i) {
    const auto tag = words.number<GmshTag>("a node of an element");
    if (!file.nodes.contains(tag)) {
      words.fail(fmt::format("element {} uses node {}, which is not defined", element.tag, tag));
    }
    element.nodes[static_cast<std::size_t>(i)] = tag;
  }
  return element;
}

void read_elements(Words& words, GmshFile& file) {
  int blocks = words.count("the number of entity blocks");
  const int expected = words.count("the number of elements");
  for (int i = 0; i < 2; ++i) words.number<GmshTag>("the smallest and the largest element tag");
  std::set<GmshTag> seen;
  for (; blocks > 0; --blocks) {
    const int dimension = words.dimension("the dimension of an element block");
    const GmshEntity entity = {dimension, words.number<int>("the entity of an element block")};
    const ElementType type = element_type(words, words.number<int>("the element type"), entity);
    if (type.dimension != dimension || !file.entity_groups.contains(entity)) {
      words.fail(fmt::format("entity {} of dimension {} is not in $Entities or does not fit its elements",
                             entity.second, dimension));
    }
    for (int left = words.count("the number of elements of a block"); left > 0; --left) {
      file.elements.push_back(read_element(words, file, entity, type));
      if (seen.insert(file.elements.back().tag).second) continue;
      words.fail(fmt::format("element {} is defined twice", file.elements.back().tag));
    }
  }
  if (static_cast<int>(seen.size()) != expected) {
    words.fail(fmt::format("{} elements are announced, the blocks hold {}", expected, seen.size()));
  }
}

}  // namespace

GmshFile read_gmsh_file(const std::string& path) {
  Words words(path);
  GmshFile file;
  file.path = path;
  const std::map<std::string, std::function<void()>, std::less<>> readers = {
      {"$MeshFormat", [&] { read_format(words); }},
      {"$PhysicalNames", [&] { read_physical_names(words, file); }},
      {"$Entities", [&] { read_entities(words, file); }},
      {"$Nodes", [&] { read_nodes(words, file); }},
      {"$Elements", [&] { read_elements(words, file); }}};
  std::set<std::string, std::less<>> seen;
  while (!words.at_end()) {
    const std::string section(words.word("a section"));
    if (section[0] != '$') words.fail(fmt::format("expected a section like $Nodes, found \"{}\"", section));
    const std::string section_end = "$End" + section.substr(1);
    const auto reader = readers.find(section);
    if (reader == readers.end()) {
      words.skip_past(section_end);
      continue;
    }
    if (!seen.insert(section).second) words.fail(fmt::format("a second {}", section));
    if (!seen.contains("$MeshFormat")) words.fail(fmt::format("$MeshFormat must come before {}", section));
    reader->second();
    words.expect(section_end);
  }
  for (const auto& [section, reader] : readers) {
    if (section != "$PhysicalNames" && !seen.contains(section)) words.fail("the file has no " + section);
  }
  return file;
}

}  // namespace ricochet::fem

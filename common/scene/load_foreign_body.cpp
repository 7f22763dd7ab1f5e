#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <set>
#include <sstream>

#include "common/scene/loaders.hpp"
#include "common/scene/toml_file.hpp"

namespace ricochet::scene {
namespace {

constexpr int most_interface_nodes = 1'000'000;

std::string stripped(const std::string& text) {
  const auto first = text.find_first_not_of(" \t\r");
  return first == std::string::npos ? "" : text.substr(first, text.find_last_not_of(" \t\r") + 1 - first);
}

/// The numbers of a row, separated by commas; none if one of them is not a finite number.
std::vector<double> numbers_of(const std::string& row) {
  std::vector<double> numbers;
  std::istringstream cells(row + ",");
  for (std::string cell; std::getline(cells, cell, ',');) {
    cell = stripped(cell);
    double number = 0.0;
    const auto [stop, error] = std::from_chars(cell.data(), cell.data() + cell.size(), number);
    if (error != std::errc() || stop != cell.data() + cell.size() || !std::isfinite(number)) return {};
    numbers.push_back(number);
  }
  return numbers;
}

/// visit(numbers, found) of the rows of a file of numbers, separated by commas, `found` being the beginning of an error
/// text; lines that are empty or begin with '#' mean nothing. Returns the number of lines.
template <class Visit>
int for_each_row(const std::string& path, const Visit& visit) {
  std::istringstream lines(read_text(path));
  int line = 0;
  for (std::string text; std::getline(lines, text);) {
    ++line;
    const std::string row = stripped(text);
    if (row.empty() || row.front() == '#') continue;
    visit(numbers_of(row), fmt::format("{}:{}: found \"{}\"", path, line, row.substr(0, 80)));
  }
  return line;
}

/// A file of positions [m]: a row per node.
std::vector<double> read_nodes(const std::string& path, const std::vector<std::string>& components) {
  std::vector<double> positions;
  const int lines = for_each_row(path, [&](const std::vector<double>& numbers, const std::string& found) {
    if (numbers.size() != components.size() || positions.size() / components.size() == most_interface_nodes)
      throw ConfigError(fmt::format("{}; allowed: {} [m] of one node, finite, separated by commas, of at most {} nodes",
                                    found, fmt::join(components, ", "), most_interface_nodes));
    positions.insert(positions.end(), numbers.begin(), numbers.end());
  });
  if (positions.empty())
    throw ConfigError(fmt::format("{}:{}: found no node; allowed: a row for each node with its {} [m]", path, lines,
                                  fmt::join(components, ", ")));
  return positions;
}

/// A file of faces: a row per face with the rows of its nodes in the file of nodes, the first of which is 0.
std::vector<std::vector<int>> read_faces(const std::string& path, bool solid, std::size_t nodes) {
  std::vector<std::vector<int>> faces;
  const std::string corners = solid ? "three or four" : "two";
  const int lines = for_each_row(path, [&](const std::vector<double>& numbers, const std::string& found) {
    const auto fits = [&](double number) {
      return number == std::floor(number) && number >= 0.0 && number < static_cast<double>(nodes);
    };
    const bool as_many = solid ? numbers.size() == 3 || numbers.size() == 4 : numbers.size() == 2;
    const bool differ = std::set<double>(numbers.begin(), numbers.end()).size() == numbers.size();
    if (!as_many || !differ || !std::all_of(numbers.begin(), numbers.end(), fits))
      throw ConfigError(
          fmt::format("{}; allowed: {} rows of nodes of one face, each another whole number from 0 to {}, separated "
                      "by commas",
                      found, corners, nodes - 1));
    faces.emplace_back(numbers.begin(), numbers.end());
  });
  if (faces.empty())
    throw ConfigError(
        fmt::format("{}:{}: found no face; allowed: a row for each face with {} rows of nodes", path, lines, corners));
  return faces;
}

/// The absolute path of a file that a key names.
std::string load_file(TableReader& table, const std::string& key, const Scene& scene, const std::string& kind) {
  const std::string given = table.text(key);
  const auto folder = std::filesystem::path(scene.path).parent_path();
  const std::string path = (folder / given).lexically_normal().string();
  if (!is_file(path))
    table.refuse(key, "\"" + given + "\", and there is no file " + path, kind + ", relative to the scene file");
  return path;
}

}  // namespace

bool says_foreign(TableReader& table) { return table.boolean("foreign", false); }

ForeignBody load_foreign_body(TableReader& table, const Scene& scene) {
  ForeignBody body;
  body.name = table.name("name");
  table.rename("body." + body.name);
  for (const std::string& key : scene_schema().at("body")) {
    const bool known = key == "name" || key == "foreign" || key == "joined_to" || key == "surface" ||
                       key == "interface_nodes" || key == "interface_faces" || key == "mass_kg";
    if (!known) table.only_if(false, key, "a body that the scene meshes: of a foreign one its participant knows it");
  }
  std::vector<std::string> meshed;
  for (const Body& other : scene.bodies) meshed.push_back(other.name);
  if (meshed.empty()) table.refuse("foreign", "true, and no other body", "a [[body]] with a mesh that it is joined to");
  body.joined_to = table.word("joined_to", meshed);
  const bool by_file = table.has("interface_nodes"), own_mesh = table.has("interface_faces");
  table.only_if(by_file, "interface_faces", "interface_nodes, whose rows its faces count");
  table.only_if(scene.model != Model::bar, "interface_faces", "two or three dimensions: an end of a bar has one node");
  table.only_if(!by_file || own_mesh, "surface", "no interface_nodes, which name the shared nodes, too");
  if (by_file) {
    body.interface_nodes =
        load_file(table, "interface_nodes", scene, "a file with a row for each node, its position in m");
    body.interface_position_m = read_nodes(body.interface_nodes, component_names(scene.model));
  }
  if (own_mesh) {
    body.interface_faces = load_file(table, "interface_faces", scene, "a file with a row for each face");
    body.faces = read_faces(body.interface_faces, scene.model == Model::solid,
                            body.interface_position_m.size() / component_names(scene.model).size());
  }
  const bool at_surface = own_mesh || !by_file;
  if (at_surface && !table.has("surface"))
    table.missing("surface", "surface, a side of \"" + body.joined_to + "\" " +
                                 (own_mesh ? "on which the faces lie"
                                           : "whose nodes are all shared, or interface_nodes, a file with the "
                                             "positions of those that are"));
  if (at_surface) {
    const std::vector<std::string> surfaces = surface_names(scene.model, scene.body(body.joined_to));
    body.surface = surfaces.empty() ? table.text("surface") : table.word("surface", surfaces);
  }
  if (table.has("mass_kg")) body.mass_kg = table.number("mass_kg", above(0.0));
  table.finish();
  return body;
}

void check_foreign_bodies(TableReader& root, TableReader& time, const Scene& scene) {
  if (scene.foreign_bodies.empty()) return;
  const std::string body = "the foreign body \"" + scene.foreign_bodies.front().name + "\"";
  if (scene.coupling.protocol.layout != Layout::hybrid)
    root.table("coupling", "coupling")
        .refuse("protocol", "\"" + scene.coupling.protocol.name + "\" and " + body,
                "a protocol that couples, for example \"hughes_liu\": a baseline has every element in one participant");
  if (scene.time.largest_step_s)
    time.refuse("largest_step_s", "a largest step and " + body, "step_s: only its program knows what a step costs it");
  if (!scene.time.step_s)
    time.missing("step_s", "step_s, because of " + body + ": only its program knows its critical time step");
}

}  // namespace ricochet::scene

#include "coupler/report/shapes/shape_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <map>
#include <numeric>
#include <optional>
#include <string_view>
#include <utility>

#include "common/base/base64.hpp"
#include "common/base/error.hpp"
#include "coupler/report/parts/history_table.hpp"

namespace ricochet::report {
namespace {

namespace fs = std::filesystem;

/// The content of one file.
struct ShapeFile {
  std::string path, model;
  double largest_window_s = 0;
  bool nose = false, uneven = false;
  std::vector<std::array<std::string, 2>> touching;
  std::vector<std::int64_t> windows;
  std::vector<double> times_s;  ///< at their ends
  std::vector<Shapes::Body> bodies;
  std::vector<ShapePiece> pieces;  ///< of the body with the same index in `bodies`
  std::int64_t too_many_cells = 0;
};

[[noreturn]] void refuse_shapes(const std::string& path, const std::string& what) {
  throw ConfigError(fmt::format("{}: {}; delete it to have the report without this picture", path, what));
}

/// Numbers as they lie in memory, in base64; `expected`: how many, if that is known.
template <class Number>
std::vector<Number> unpacked(const Json& text, const std::string& path, const char* key,
                             std::optional<std::size_t> expected = std::nullopt) {
  const auto bytes = from_base64(text.get_ref<const std::string&>());
  const std::size_t count = bytes ? bytes->size() / sizeof(Number) : 0;
  if (!bytes || bytes->size() % sizeof(Number) != 0 || (expected && count != *expected)) {
    refuse_shapes(path, fmt::format("\"{}\" holds {} numbers, expected {}", key, bytes ? std::to_string(count) : "no",
                                    expected ? std::to_string(*expected) : "any number of them"));
  }
  std::vector<Number> values(count);
  if (count > 0) std::memcpy(values.data(), bytes->data(), bytes->size());
  return values;
}

std::size_t components_of(const std::string& model, const std::string& path) {
  if (model == "bar") return 1;
  if (model == "plane_strain" || model == "axisymmetric") return 2;
  if (model == "solid") return 3;
  refuse_shapes(path, fmt::format("found the model \"{}\"", model));
}

std::vector<Place> places_of(const std::vector<float>& values, std::size_t components) {
  std::vector<Place> places(values.size() / components, Place{});
  for (std::size_t i = 0; i < values.size(); ++i) places[i / components][i % components] = values[i];
  return places;
}

void check_cell(const std::array<int, 4>& cell, std::size_t nodes, std::size_t components, const std::string& path) {
  const int least = components == 1 ? 2 : 3;
  for (int k = 0; k < 4; ++k) {
    const int node = cell[static_cast<std::size_t>(k)];
    if (node >= static_cast<int>(nodes) || node < (k < least ? 0 : -1))
      refuse_shapes(path, fmt::format("found the node {}", node));
  }
}

ShapePiece piece_of(const Json& json, const ShapeFile& file) {
  const auto components = components_of(file.model, file.path);
  ShapePiece piece;
  piece.node = unpacked<int>(json.at("node"), file.path, "node");
  const std::size_t numbers = piece.node.size() * components;
  piece.position = places_of(unpacked<float>(json.at("position_m"), file.path, "position_m", numbers), components);
  const auto cells = unpacked<int>(json.at("cell"), file.path, "cell");
  if (cells.size() % 4 != 0)
    refuse_shapes(file.path, fmt::format("\"cell\" holds {} numbers, not four for each cell", cells.size()));
  for (std::size_t i = 0; i < cells.size(); i += 4) {
    piece.cells.push_back({cells[i], cells[i + 1], cells[i + 2], cells[i + 3]});
    check_cell(piece.cells.back(), piece.node.size(), components, file.path);
  }
  const auto &displacements = json.at("displacement_m"), &stresses = json.at("stress_pa");
  if (displacements.size() != file.windows.size() || stresses.size() != file.windows.size())
    refuse_shapes(file.path, "fields of another number of windows");
  for (std::size_t w = 0; w < file.windows.size(); ++w) {
    piece.displacement.push_back(
        places_of(unpacked<float>(displacements[w], file.path, "displacement_m", numbers), components));
    const auto stress = unpacked<float>(stresses[w], file.path, "stress_pa", piece.cells.size());
    piece.stress_pa.emplace_back(stress.begin(), stress.end());
  }
  for (const auto& [key, values] : {std::pair{"plastic_strain", &ShapePiece::plastic_strain},
                                    {"temperature_rise_k", &ShapePiece::temperature_rise_k},
                                    {"contact_pressure_pa", &ShapePiece::contact_pressure_pa}}) {
    const auto found = json.find(key);
    if (found == json.end()) continue;
    if (found->size() != file.windows.size()) refuse_shapes(file.path, "fields of another number of windows");
    for (const auto& packed : *found) {
      const auto of_window = unpacked<float>(packed, file.path, key, piece.cells.size());
      (piece.*values).emplace_back(of_window.begin(), of_window.end());
    }
  }
  return piece;
}

ShapeFile read_shape_file(const std::string& path) {
  const auto json = Json::parse(read_text(path));
  ShapeFile file;
  file.path = path;
  if (json.at("format") != "ricochet shapes 2") refuse_shapes(path, "found another format");
  file.model = json.at("model").get<std::string>();
  file.largest_window_s = json.at("largest_window_s").get<double>();
  file.nose = json.at("nose").get<bool>();
  file.uneven = json.at("uneven").get<bool>();
  file.touching = json.value("touching", decltype(file.touching)());  // none in files of former versions
  file.windows = json.at("windows").get<std::vector<std::int64_t>>();
  file.times_s = json.at("times_s").get<std::vector<double>>();
  if (file.times_s.size() != file.windows.size()) refuse_shapes(path, "times of another number of windows");
  file.too_many_cells = json.at("too_many_cells").get<std::int64_t>();
  for (const auto& body : json.at("bodies")) {
    file.pieces.push_back(piece_of(body, file));
    if (file.pieces.back().cells.empty()) {  // of a body of which this participant has contact nodes only
      file.pieces.pop_back();
      continue;
    }
    file.bodies.push_back({body.at("name").get<std::string>(), body.at("strip_m").get<double>(),
                           body.at("initial_velocity_m_s").get<Place>()});
  }
  return file;
}

bool finite_at(const std::vector<ShapePiece>& pieces, std::size_t window) {
  for (const auto& piece : pieces) {
    const auto& stress = piece.stress_pa[window];
    if (!std::all_of(stress.begin(), stress.end(), [](double x) { return std::isfinite(x); })) return false;
    for (const auto& u : piece.displacement[window]) {
      if (!std::isfinite(u[0] + u[1] + u[2])) return false;
    }
  }
  return true;
}

/// The windows that every file has, without those at which a number is not finite.
std::vector<std::int64_t> common_windows(const std::vector<ShapeFile>& files) {
  std::vector<std::int64_t> windows = files.front().windows;
  for (const auto& file : files) {
    std::erase_if(windows, [&](std::int64_t window) {
      const auto found = std::find(file.windows.begin(), file.windows.end(), window);
      return found == file.windows.end() ||
             !finite_at(file.pieces, static_cast<std::size_t>(found - file.windows.begin()));
    });
  }
  return windows;
}

/// Leaves of a piece what it has of these windows.
ShapePiece at_windows(ShapePiece&& piece, const std::vector<std::int64_t>& has,
                      const std::vector<std::int64_t>& wanted) {
  ShapePiece result = std::move(piece);
  auto displacement = std::exchange(result.displacement, {});
  auto stress = std::exchange(result.stress_pa, {}), strain = std::exchange(result.plastic_strain, {}),
       rise = std::exchange(result.temperature_rise_k, {}), pressure = std::exchange(result.contact_pressure_pa, {});
  for (const auto window : wanted) {
    const auto i = static_cast<std::size_t>(std::find(has.begin(), has.end(), window) - has.begin());
    result.displacement.push_back(std::move(displacement[i]));
    result.stress_pa.push_back(std::move(stress[i]));
    if (!strain.empty()) result.plastic_strain.push_back(std::move(strain[i]));
    if (!rise.empty()) result.temperature_rise_k.push_back(std::move(rise[i]));
    if (!pressure.empty()) result.contact_pressure_pa.push_back(std::move(pressure[i]));
  }
  return result;
}

Shapes merged_shapes(std::vector<ShapeFile>&& files) {
  Shapes shapes;
  shapes.model = files.front().model;
  shapes.largest_window_s = files.front().largest_window_s;
  shapes.nose = files.front().nose;
  shapes.uneven = files.front().uneven;
  shapes.touching = files.front().touching;
  const auto windows = common_windows(files);
  const auto& of_first = files.front().windows;
  for (const auto window : windows)
    shapes.times_s.push_back(
        files.front()
            .times_s[static_cast<std::size_t>(std::find(of_first.begin(), of_first.end(), window) - of_first.begin())]);
  for (auto& file : files) {
    if (file.model != shapes.model || file.largest_window_s != shapes.largest_window_s)
      refuse_shapes(file.path, fmt::format("it is of another run than {}", files.front().path));
    for (std::size_t b = 0; b < file.bodies.size(); ++b) {
      const auto known = std::find_if(shapes.bodies.begin(), shapes.bodies.end(),
                                      [&](const auto& body) { return body.name == file.bodies[b].name; });
      file.pieces[b].body = static_cast<int>(known - shapes.bodies.begin());
      if (known == shapes.bodies.end()) shapes.bodies.push_back(file.bodies[b]);
      shapes.pieces.push_back(at_windows(std::move(file.pieces[b]), file.windows, windows));
    }
  }
  return shapes;
}

void read_obstacles(const std::string& path, Shapes& shapes) {
  if (!fs::exists(path)) return;
  const auto json = Json::parse(read_text(path));
  if (json.at("format") != "ricochet obstacles 1") refuse_shapes(path, "found another format");
  for (const auto& obstacle : json.at("obstacles")) {
    const auto places = obstacle.at("place_m").get<std::vector<Place>>();
    const auto cells = obstacle.at("cell").get<std::vector<std::array<int, 4>>>();
    for (const auto& cell : cells) check_cell(cell, places.size(), components_of(shapes.model, path), path);
    add_obstacle(shapes, obstacle.at("name").get<std::string>(), obstacle.at("strip_m").get<double>(), places, cells);
  }
}

}  // namespace

void add_obstacle(Shapes& shapes, const std::string& name, double strip_m, const std::vector<Place>& places,
                  const std::vector<std::array<int, 4>>& cells) {
  ShapePiece piece;
  piece.body = static_cast<int>(shapes.bodies.size());
  piece.rigid = true;
  piece.node.resize(places.size());
  std::iota(piece.node.begin(), piece.node.end(), 0);
  piece.position = places;
  piece.cells = cells;
  shapes.pieces.push_back(std::move(piece));
  shapes.bodies.push_back({name, strip_m, {}});
}

Shapes read_shapes(const std::string& folder, const Json& summary) {
  const std::string ending = ".shapes.json";
  std::map<std::string, std::string> paths;  // of participants
  const fs::path fields = fs::path(folder) / "fields";
  if (fs::is_directory(fields)) {
    for (const auto& entry : fs::directory_iterator(fields)) {
      const auto name = entry.path().filename().string();
      if (name.ends_with(ending)) paths[name.substr(0, name.size() - ending.size())] = entry.path().string();
    }
  }
  std::vector<ShapeFile> files;
  std::vector<std::string> missing;
  for (const auto& process : summary.value("processes", Json::array())) {
    const auto name = process.value("name", "");
    if (name == "coupler" || paths.count(name) > 0) continue;
    missing.push_back(fmt::format("The elements of '{}' are not drawn: it left no fields/{}{}.", name, name, ending));
  }
  for (const auto& [name, path] : paths) {
    auto file = read_shape_file(path);
    if (file.too_many_cells > 0) {
      missing.push_back(
          fmt::format("The elements of '{}' are not drawn: they are too many, {}.", name, file.too_many_cells));
    } else if (!file.pieces.empty()) {
      files.push_back(std::move(file));
    }
  }
  Shapes shapes;
  if (!files.empty()) {
    shapes = merged_shapes(std::move(files));
    read_obstacles((fields / "obstacles.json").string(), shapes);
  }
  shapes.missing = std::move(missing);
  return shapes;
}

}  // namespace ricochet::report

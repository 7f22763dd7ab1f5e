#include "coupler/report/scene_page/scene_page.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <utility>
#include <vector>

#include "common/base/error.hpp"
#include "common/problem/drawing.hpp"
#include "common/problem/drawn_obstacles.hpp"
#include "coupler/report/assets/assets.hpp"
#include "coupler/report/parts/text.hpp"
#include "coupler/report/shapes/cell_looks.hpp"
#include "coupler/report/shapes/shape_viewer.hpp"

namespace ricochet::report {
namespace {

using scene::DrawnBody;
using scene::DrawnMark;
using scene::Problem;

// Told apart by colour-blind eyes, pale beneath the marks.
constexpr const char* implicit_colour = "#fdd49e";
constexpr std::array<const char*, 5> explicit_colours{"#c6dbef", "#d9d9d9", "#c7e9c0", "#dadaeb", "#9ecae1"};
constexpr std::array<const char*, 4> contact_colours{"#d7191c", "#e66101", "#b2182b", "#f46d43"};

Place place_of(const Eigen::Vector3d& x) { return {x[0], x[1], x[2]}; }

Shapes undeformed(const Problem& problem, const std::vector<DrawnBody>& drawn) {
  Shapes shapes;
  shapes.model = fem::model_name(problem.scene.model);
  shapes.times_s = {0.0};
  const bool bar = problem.scene.model == scene::Model::bar;
  for (std::size_t b = 0; b < drawn.size(); ++b) {
    const auto& seen = drawn[b].seen;
    const auto& body = problem.bodies[b];
    ShapePiece piece;
    piece.body = static_cast<int>(b);
    for (std::size_t i = 0; i < seen.node.size(); ++i) {
      piece.node.push_back(seen.image[i] ? -1 - seen.node[i] : seen.node[i]);
      piece.position.push_back(place_of(seen.position_m[i]));
    }
    piece.cells = seen.cells;
    shapes.pieces.push_back(std::move(piece));
    shapes.bodies.push_back({body.name, bar ? std::sqrt(body.section.measure) : 0.0, {}});
  }
  for (const auto& obstacle : scene::drawn_obstacles(problem)) {
    std::vector<Place> places;
    for (const auto& x : obstacle.place) places.push_back(place_of(x));
    add_obstacle(shapes, obstacle.name, obstacle.strip_m, places, obstacle.cells);
  }
  return shapes;
}

/// The kinds of cells: an entry for each participant, and one for what is rigid.
Json kinds_of(const Problem& problem) {
  Json kinds = Json::array();
  std::size_t next = 0;
  for (const auto& participant : problem.scene.participants) {
    const bool implicit = participant.role == scene::Role::implicit_solver;
    const char* colour = implicit ? implicit_colour : explicit_colours[next++ % explicit_colours.size()];
    kinds.push_back({{"name", fmt::format("{}{}: integrated {}", participant.name,
                                          participant.foreign() ? " (a program of its own)" : "",
                                          implicit ? "implicitly" : "explicitly")},
                     {"colour", colour}});
  }
  kinds.push_back({{"name", "rigid obstacles"}, {"colour", "#a6a6a6"}});
  return kinds;
}

/// Name, colour and size of the dots [px]: the first mark lies lowest, so it is larger.
Json look_of(const DrawnMark& mark, std::size_t contact) {
  const auto look = [](const std::string& name, const char* colour, int size_px) {
    return Json{{"name", name}, {"colour", colour}, {"size", size_px}};
  };
  switch (mark.kind) {
    case DrawnMark::Kind::contact:
      return look(mark.contact.empty() ? "contact" : "contact " + mark.contact,
                  contact_colours[contact % contact_colours.size()], 8);
    case DrawnMark::Kind::support: return look("supports", "#1b7837", 6);
    case DrawnMark::Kind::load: return look("loads on surfaces", "#762a83", 6);
    case DrawnMark::Kind::prescribed: return look("prescribed motion", "#8c510a", 6);
    case DrawnMark::Kind::absorbing: return look("absorbing surfaces", "#35978f", 6);
    case DrawnMark::Kind::joint: return look("shared with a foreign body", "#ce1256", 6);
    case DrawnMark::Kind::interface: return look("interface of explicit and implicit elements", "#000000", 4);
    case DrawnMark::Kind::probe: return look("probes", "#e7298a", 8);
  }
  return {};
}

Json marks_of(const Problem& problem, const Shapes& shapes) {
  Json result = Json::array();
  std::size_t contact = 0;
  for (const auto& mark : drawn_marks(problem)) {
    const std::size_t index = mark.kind == DrawnMark::Kind::contact ? contact++ : 0;
    if (mark.places_m.empty()) continue;
    std::vector<Place> places;
    for (const auto& x : mark.places_m) places.push_back(place_of(x));
    result.push_back(look_of(mark, index));
    result.back()["place"] = packed(node_places(shapes, places));
  }
  return result;
}

Json data_of(const Problem& problem, const std::vector<DrawnBody>& drawn) {
  const auto shapes = undeformed(problem, drawn);
  Json data = {{"model", shapes.model},
               {"first", 0},
               {"times", Json::array({""})},
               {"bodies", Json::array()},
               {"pieces", Json::array()},
               {"kinds", kinds_of(problem)},
               {"marks", marks_of(problem, shapes)}};
  const auto looks = cell_looks(shapes);
  const auto rigid = static_cast<std::uint8_t>(problem.scene.participants.size());
  for (std::size_t b = 0; b < shapes.bodies.size(); ++b) {
    data["bodies"].push_back({{"name", shapes.bodies[b].name}, {"strip_m", shapes.bodies[b].strip_m}});
    auto piece = cells_data(shapes.pieces[b], looks[b]);
    const auto kinds = b < drawn.size() ? std::vector<std::uint8_t>(drawn[b].owner.begin(), drawn[b].owner.end())
                                        : std::vector<std::uint8_t>(shapes.pieces[b].cells.size(), rigid);
    piece["kind"] = packed(kinds);
    piece["place"] = Json::array({packed(node_places(shapes, shapes.pieces[b].position))});
    data["pieces"].push_back(std::move(piece));
  }
  return data;
}

/// More than a browser draws with ease are refused.
std::vector<DrawnBody> drawn_or_refused(const Problem& problem) {
  auto drawn = drawn_bodies(problem);
  std::size_t count = 0;
  for (const auto& body : drawn) count += body.seen.cells.size();
  if (count > fem::SeenCells::most) {
    throw ConfigError(fmt::format("--picture: found {} elements (of solids: faces of the surface) in {}, allowed: {}",
                                  count, problem.scene.path, fem::SeenCells::most));
  }
  return drawn;
}

std::string note_of(const Problem& problem) {
  const auto& given = problem.scene;
  std::string note = "The meshes where the scene puts them, coloured by who integrates them; dots are nodes.";
  if (given.model == scene::Model::axisymmetric)
    note += " Both halves of the section are drawn, one computed, the other its mirror image.";
  if (given.model == scene::Model::solid) note += " Only surfaces are drawn; a section shows what lies inside.";
  for (const auto& contact : given.contacts) {
    const std::string name = contact.name.empty() ? "the contact" : "contact " + contact.name;
    if (!contact.second) note += fmt::format(" The rigid obstacle of {} goes on beyond what is drawn of it.", name);
    if (contact.second && contact.initial_gap_m > 0.0)
      note += fmt::format(" In {} initial_gap_m adds {:g} m, which is not drawn.", name, contact.initial_gap_m);
    if (contact.nose_radius_m > 0.0) note += fmt::format(" The rounded nose of {} is not drawn.", name);
  }
  for (const auto& foreign : given.foreign_bodies)
    note += fmt::format(" The foreign body {} is not drawn: the scene has no mesh of it.", foreign.name);
  return note;
}

}  // namespace

std::string scene_page(const Problem& problem, const std::string& checked) {
  const auto name = std::filesystem::path(problem.scene.path).filename().string();
  return fill_page(
      asset("page.html"),
      {{"title", escape_html(std::filesystem::path(name).stem().string())},
       {"style", std::string(asset("page.css"))},
       {"header", fmt::format("<h1>{}</h1>\n<p>The scene {} before it runs.</p>\n",
                              escape_html(std::filesystem::path(name).stem().string()), escape_html(name))},
       {"tables", ""},
       {"help", ""},
       {"figures", fmt::format("{}<h2>What <code>ricochet check</code> says</h2>\n<pre class=\"checked\">{}</pre>\n",
                               viewer_figure("Bodies and their parts", note_of(problem)), escape_html(checked))},
       {"libraries", viewer_scripts(data_of(problem, drawn_or_refused(problem)))},
       {"charts", "[]"},
       {"script", "document.body.dataset.drawn = \"true\";\n"}});
}

}  // namespace ricochet::report

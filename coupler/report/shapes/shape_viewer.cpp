#include "coupler/report/shapes/shape_viewer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "coupler/report/assets/assets.hpp"
#include "coupler/report/parts/quantity.hpp"
#include "coupler/report/parts/text.hpp"
#include "coupler/report/shapes/shape_motion.hpp"

namespace ricochet::report {
namespace {

/// Where the colours end, and the value that is largest.
struct ColourScale {
  double high = 1;
  double largest = 0;
  std::size_t largest_window = 0;  ///< of the kept times
};

using CellValues = std::vector<std::vector<double>> ShapePiece::*;

/// Ends at a value that all but one in two hundred cells stay below, where the largest is much larger: the corner of a
/// contact would leave the rest without colours.
ColourScale colour_scale(const Shapes& shapes, CellValues values) {
  ColourScale scale;
  std::vector<double> sizes;
  for (const auto& piece : shapes.pieces) {
    for (std::size_t w = 0; w < (piece.*values).size(); ++w) {
      for (const double value : (piece.*values)[w]) {
        sizes.push_back(std::abs(value));
        if (std::abs(value) <= std::abs(scale.largest)) continue;
        scale.largest = value;
        scale.largest_window = w;
      }
    }
  }
  if (sizes.empty()) return scale;
  const double most = std::abs(scale.largest);
  const auto at = sizes.begin() + static_cast<std::ptrdiff_t>(std::ceil(0.995 * static_cast<double>(sizes.size() - 1)));
  std::nth_element(sizes.begin(), at, sizes.end());
  const double end = *at > 0 && most > 1.25 * *at ? *at : most;
  if (end > 0) scale.high = end;
  return scale;
}

std::size_t components_of(const Shapes& shapes) { return shapes.model == "bar" ? 1 : shapes.model == "solid" ? 3 : 2; }

/// Where the nodes are drawn at the end of a window.
std::vector<float> drawn_places(const Shapes& shapes, const ShapePiece& piece, std::size_t window,
                                const Magnification& magnification) {
  if (piece.rigid) return node_places(shapes, piece.position);
  const auto& velocity = shapes.bodies[static_cast<std::size_t>(piece.body)].velocity_m_s;
  std::vector<Place> places;
  for (std::size_t i = 0; i < piece.position.size(); ++i)
    places.push_back(
        magnification.place(piece.position[i], piece.displacement[window][i], velocity, shapes.times_s[window]));
  return node_places(shapes, places);
}

/// cells_data and "place": a window's components of each node as float32; "stress" and, of a body that yields,
/// "plastic_strain", where that heats it "temperature_rise_k", of who enforces the contact "contact_pressure_pa": a
/// window's float32 of each cell. A rigid obstacle has none of them.
Json data_of(const Shapes& shapes, const ShapePiece& piece, const std::vector<CellLook>& looks,
             const Magnification& magnification) {
  Json data = cells_data(piece, looks);
  data["place"] = Json::array();
  for (std::size_t w = 0; w < shapes.times_s.size(); ++w)
    data["place"].push_back(packed(drawn_places(shapes, piece, w, magnification)));
  const auto add = [&](const char* key, CellValues values) {
    for (const auto& of_window : piece.*values) {
      std::vector<float> seen;
      for (std::size_t c = 0; c < piece.cells.size(); ++c) {
        if (!looks[c].hidden) seen.push_back(static_cast<float>(of_window[c]));
      }
      data[key].push_back(packed(seen));
    }
  };
  add("stress", &ShapePiece::stress_pa);
  add("plastic_strain", &ShapePiece::plastic_strain);
  add("temperature_rise_k", &ShapePiece::temperature_rise_k);
  add("contact_pressure_pa", &ShapePiece::contact_pressure_pa);
  return data;
}

/// -1: what is rigid, or not drawn.
int index_of(const Shapes& shapes, const std::string& body) {
  const auto found =
      std::find_if(shapes.bodies.begin(), shapes.bodies.end(), [&](const auto& b) { return b.name == body; });
  return found == shapes.bodies.end() ? -1 : static_cast<int>(found - shapes.bodies.begin());
}

std::string stress_name(const Shapes& shapes) { return shapes.model == "bar" ? "axial stress" : "von Mises stress"; }

/// "fields": what cells may be coloured by, the first at the beginning; "key" is that of the pieces, "factor" turns a
/// value into its unit. "touching": indices of the bodies of each contact.
Json data_of(const Shapes& shapes, const Magnification& magnification, const ColourScale& scale) {
  const auto looks = cell_looks(shapes);
  const auto unit = display_unit(scale.high, "Pa");
  Json data = {{"model", shapes.model},    {"first", scale.largest_window}, {"times", Json::array()},
               {"fields", Json::array()},  {"bodies", Json::array()},       {"pieces", Json::array()},
               {"touching", Json::array()}};
  data["fields"].push_back({{"key", "stress"},
                            {"name", stress_name(shapes)},
                            {"signed", shapes.model == "bar"},
                            {"high", scale.high},
                            {"factor", unit.factor},
                            {"unit", unit.name}});
  const auto offer = [&](const char* key, CellValues values, const char* name, double factor, const char* unit_name) {
    const ColourScale own = colour_scale(shapes, values);
    if (own.largest == 0.0) return;
    data["fields"].push_back(
        {{"key", key}, {"name", name}, {"signed", false}, {"high", own.high}, {"factor", factor}, {"unit", unit_name}});
  };
  offer("plastic_strain", &ShapePiece::plastic_strain, "equivalent plastic strain", 100.0, "%");
  offer("temperature_rise_k", &ShapePiece::temperature_rise_k, "rise of temperature", 1.0, "K");
  offer("contact_pressure_pa", &ShapePiece::contact_pressure_pa, "contact pressure", unit.factor, unit.name.c_str());
  for (const double time_s : shapes.times_s) data["times"].push_back(quantity(time_s, "s", 4));
  for (const auto& body : shapes.bodies) data["bodies"].push_back({{"name", body.name}, {"strip_m", body.strip_m}});
  for (const auto& names : shapes.touching)
    data["touching"].push_back({index_of(shapes, names[0]), index_of(shapes, names[1])});
  for (std::size_t p = 0; p < shapes.pieces.size(); ++p)
    data["pieces"].push_back(data_of(shapes, shapes.pieces[p], looks[p], magnification));
  return data;
}

std::string magnification_text(const Shapes& shapes, const Magnification& magnification) {
  if (magnification.factor == 1.0) return "Displacements are drawn to scale.";
  const bool flies = std::any_of(shapes.bodies.begin(), shapes.bodies.end(),
                                 [](const auto& body) { return body.velocity_m_s != Place{}; });
  const char* which = !flies                                  ? "Displacements"
                      : std::isfinite(magnification.flight_s) ? "Displacements from the first contact on"
                                                              : "Displacements beyond those of free flight";
  return fmt::format("{} are drawn {:g} times as large as they are.", which, magnification.factor);
}

std::string note_of(const Shapes& shapes, const Magnification& magnification, const ColourScale& scale) {
  std::string note = shapes.model == "bar" ? "Axial stress of each element. Blue: compression; red: tension."
                                           : "Von Mises stress in the middle of each element.";
  note += " " + magnification_text(shapes, magnification);
  if (shapes.model == "bar")
    note += " Bars are as thick as a square of their cross section is wide, or thicker to be seen.";
  if (shapes.model == "axisymmetric")
    note += " Both halves of the section are drawn, one computed, the other its mirror image.";
  const bool repeats = std::any_of(shapes.pieces.begin(), shapes.pieces.end(), [](const auto& piece) {
    return std::any_of(piece.node.begin(), piece.node.end(), [](int node) { return node < 0; });
  });
  if (repeats) note += " The mesh repeats across; one period of it is drawn.";
  if (shapes.nose) note += " The rounded nose is a gap of the contact, which the mesh does not have.";
  if (shapes.model == "solid") note += " Solids are kept as their surfaces; a section shows them from inside.";
  if (std::abs(scale.largest) > scale.high) {
    note += fmt::format(" The largest stress, {} at {}, lies beyond the colours.", quantity(scale.largest, "Pa", 4),
                        quantity(shapes.times_s[scale.largest_window], "s", 4));
  }
  if (std::any_of(shapes.pieces.begin(), shapes.pieces.end(), [](const auto& piece) { return piece.rigid; }))
    note += " Grey bodies are rigid and go on beyond what is drawn of them.";
  for (const auto& text : shapes.missing) note += " " + text;
  return note;
}

}  // namespace

Json cells_data(const ShapePiece& piece, const std::vector<CellLook>& looks) {
  std::vector<int> cells;
  std::vector<std::uint8_t> edges;
  for (std::size_t c = 0; c < piece.cells.size(); ++c) {
    if (looks[c].hidden) continue;
    cells.insert(cells.end(), piece.cells[c].begin(), piece.cells[c].end());
    for (const auto kind : looks[c].edges) edges.push_back(static_cast<std::uint8_t>(kind));
  }
  return {{"body", piece.body}, {"cell", packed(cells)}, {"edge", packed(edges)}};
}

std::vector<float> node_places(const Shapes& shapes, const std::vector<Place>& places) {
  std::vector<float> numbers;
  for (const auto& place : places) {
    for (std::size_t c = 0; c < components_of(shapes); ++c) numbers.push_back(static_cast<float>(place[c]));
  }
  return numbers;
}

std::string viewer_scripts(const Json& data) {
  return fmt::format(
      "<script>/*! three\n{}*/\n{}</script>\n<script type=\"application/json\" id=\"bodies\">{}</script>\n"
      "<script>\n{}</script>\n<script>\n{}</script>\n",
      asset("three.license"), inside_script(asset("three.js")), inside_script(data.dump()),
      inside_script(asset("viewer_bodies.js")), inside_script(asset("viewer.js")));
}

std::string viewer_figure(const std::string& title, const std::string& note) {
  return fmt::format(
      "<figure>\n<figcaption><h2>{}</h2><p>{}</p></figcaption>\n<div id=\"deformed_bodies\"></div>\n</figure>\n",
      escape_html(title), escape_html(note));
}

std::optional<ShapeViewer> shape_viewer(const Shapes& shapes, const HistoryTable& history, double first_contact_s) {
  if (shapes.pieces.empty() || shapes.times_s.empty()) return std::nullopt;
  const auto* gap = history.find("gap_min_m");
  const double first_gap_m = gap && history.rows() > 0 ? gap->front() : std::numeric_limits<double>::quiet_NaN();
  std::vector<std::size_t> windows(shapes.times_s.size());
  std::iota(windows.begin(), windows.end(), std::size_t{0});
  const auto magnification = magnification_of(shapes, windows, first_contact_s, first_gap_m);
  const auto scale = colour_scale(shapes, &ShapePiece::stress_pa);
  ShapeViewer viewer;
  viewer.data = data_of(shapes, magnification, scale);
  viewer.scripts = viewer_scripts(viewer.data);
  viewer.html =
      viewer_figure(fmt::format("Deformed bodies: {} at {} times", stress_name(shapes), shapes.times_s.size()),
                    note_of(shapes, magnification, scale));
  return viewer;
}

}  // namespace ricochet::report

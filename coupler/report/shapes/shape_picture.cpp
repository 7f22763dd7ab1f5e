#include "coupler/report/shapes/shape_picture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "common/base/base64.hpp"
#include "coupler/report/assets/assets.hpp"
#include "coupler/report/parts/quantity.hpp"
#include "coupler/report/parts/text.hpp"
#include "coupler/report/shapes/shape_layout.hpp"
#include "coupler/report/shapes/shape_motion.hpp"
#include "coupler/report/shapes/shape_view.hpp"

namespace ricochet::report {
namespace {

constexpr std::size_t most_panels = 6;
constexpr int sharpness = 2;  ///< pixels of the picture per pixel of the page
constexpr double most_height_px = 720, least_strip_px = 12, least_edge_px = 4, foot_px = 52;

/// YlOrRd of colorbrewer2.org, for magnitudes: told apart by colour-blind eyes, the darker the larger.
const std::vector<Rgb> magnitude_colours = {{255, 255, 204}, {255, 237, 160}, {254, 217, 118},
                                            {254, 178, 76},  {253, 141, 60},  {252, 78, 42},
                                            {227, 26, 28},   {189, 0, 38},    {128, 0, 38}};
/// RdBu of colorbrewer2.org, as of the stress waves: from compression to tension.
const std::vector<Rgb> signed_colours = {{5, 48, 97},     {33, 102, 172},  {67, 147, 195},  {146, 197, 222},
                                         {209, 229, 240}, {247, 247, 247}, {253, 219, 199}, {244, 165, 130},
                                         {214, 96, 77},   {178, 24, 43},   {103, 0, 31}};

/// What a colour means, and the stress that is largest.
struct StressScale {
  double low_pa = 0, high_pa = 1;
  double largest_pa = 0, largest_s = 0;

  [[nodiscard]] double share(double stress_pa) const { return (stress_pa - low_pa) / (high_pa - low_pa); }
};

/// Ends at a stress that all but one in two hundred cells stay below, where the largest is much larger: the corner of a
/// contact would leave the rest without colours.
StressScale stress_scale(const Shapes& shapes, const std::vector<std::size_t>& windows) {
  StressScale scale;
  std::vector<double> sizes;
  for (const auto& piece : shapes.pieces) {
    for (const auto w : windows) {
      for (const double stress : piece.stress_pa[w]) {
        sizes.push_back(std::abs(stress));
        if (std::abs(stress) <= std::abs(scale.largest_pa)) continue;
        scale.largest_pa = stress;
        scale.largest_s = shapes.times_s[w];
      }
    }
  }
  const double most = std::abs(scale.largest_pa);
  const auto at = sizes.begin() + static_cast<std::ptrdiff_t>(std::ceil(0.995 * static_cast<double>(sizes.size() - 1)));
  std::nth_element(sizes.begin(), at, sizes.end());
  const double end = *at > 0 && most > 1.25 * *at ? *at : most;
  if (end > 0) scale.high_pa = end;
  if (shapes.model == "bar") scale.low_pa = -scale.high_pa;
  return scale;
}

/// Everything that is drawn, of every panel.
struct ShapeScene {
  const Shapes& shapes;
  std::vector<std::size_t> windows;
  Magnification magnification;
  std::vector<std::vector<CellLook>> looks;

  [[nodiscard]] const Shapes::Body& body_of(const ShapePiece& piece) const {
    return shapes.bodies[static_cast<std::size_t>(piece.body)];
  }
  [[nodiscard]] Place place(const ShapePiece& piece, std::size_t node, std::size_t panel) const {
    const auto w = windows[panel];
    return magnification.place(piece.position[node], piece.displacement[w][node], body_of(piece).velocity_m_s,
                               shapes.times_s[w]);
  }
  [[nodiscard]] std::vector<SeenCell> cells(const ShapeView& view, std::size_t panel, double least_strip_m) const {
    std::vector<SeenCell> seen;
    std::size_t most = 0;
    for (const auto& piece : shapes.pieces) most += (view.mirrored() ? 2 : 1) * piece.cells.size();
    seen.reserve(most);
    for (std::size_t p = 0; p < shapes.pieces.size(); ++p) {
      const auto& piece = shapes.pieces[p];
      std::vector<Place> places;
      places.reserve(piece.position.size());
      for (std::size_t i = 0; i < piece.position.size(); ++i) places.push_back(place(piece, i, panel));
      view.add(piece, places, looks[p], windows[panel], std::max(body_of(piece).strip_m, least_strip_m), seen);
    }
    return seen;
  }
};

struct ShapeFrame {
  ShapeView view;
  PanelLayout layout;
  double least_strip_m = 0;
};

ShapeFrame framed(const ShapeScene& scene, bool turned) {
  ShapeFrame frame{ShapeView(scene.shapes.model, turned), {}, 0};
  auto extent = Extent::empty();
  for (std::size_t panel = 0; panel < scene.windows.size(); ++panel) {
    for (const auto& piece : scene.shapes.pieces) {
      for (std::size_t i = 0; i < piece.position.size(); ++i) {
        const auto x = frame.view.seen(scene.place(piece, i, panel));
        const double half = 0.5 * scene.body_of(piece).strip_m;
        extent.include({x[0], x[1] - half});
        extent.include({x[0], x[1] + half});
        if (frame.view.mirrored()) extent.include(frame.view.mirror_image(x));
      }
    }
  }
  const double thickness = scene.shapes.model == "bar" ? least_strip_px : 0;
  frame.layout = layout_of(scene.windows.size(), extent, chart_width, most_height_px, thickness);
  frame.least_strip_m = thickness / frame.layout.scale_px_m;
  return frame;
}

/// Turned where that shows the bodies a fifth larger.
ShapeFrame frame_of(const ShapeScene& scene) {
  auto upright = framed(scene, false);
  if (scene.shapes.model == "bar") return upright;
  auto turned = framed(scene, true);
  return turned.layout.scale_px_m > 1.2 * upright.layout.scale_px_m ? turned : upright;
}

/// Edges within bodies, if they are far enough apart to be seen: by the middle one of the cells' shortest edges.
bool shows_inner_edges(const std::vector<SeenCell>& cells, const PanelLayout& layout) {
  std::vector<double> lengths;
  for (const auto& cell : cells) {
    double shortest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < cell.count; ++i) {
      const auto &a = cell.corner[i], &b = cell.corner[(i + 1) % cell.count];
      shortest = std::min(shortest, layout.scale_px_m * std::hypot(a[0] - b[0], a[1] - b[1]));
    }
    lengths.push_back(shortest);
  }
  const auto middle = lengths.begin() + std::ssize(lengths) / 2;
  std::nth_element(lengths.begin(), middle, lengths.end());
  return !lengths.empty() && *middle >= least_edge_px;
}

/// What the pointer finds.
struct PointedCell {
  double time_s = 0, stress_pa = 0;
  int body = 0;
};

class ShapePainter {
 public:
  ShapePainter(const ShapeScene& scene, const ShapeFrame& frame, const StressScale& scale)
      : scene_(scene),
        frame_(frame),
        scale_(scale),
        canvas_(sharpness * chart_width, sharpness * static_cast<int>(std::ceil(frame.layout.height_px()))) {
    for (std::size_t panel = 0; panel < scene.windows.size(); ++panel) paint(panel);
  }
  [[nodiscard]] const Canvas& canvas() const { return canvas_; }
  [[nodiscard]] const PointedCell& pointed(int cell) const { return pointed_[static_cast<std::size_t>(cell)]; }
  [[nodiscard]] bool inner_edges() const { return inner_edges_; }
  /// Boxes of the bodies in the first panel, in pixels of the page (upwards is less).
  [[nodiscard]] const std::map<int, Extent>& boxes() const { return boxes_; }

 private:
  void paint(std::size_t panel) {
    auto cells = scene_.cells(frame_.view, panel, frame_.least_strip_m);
    if (panel == 0) inner_edges_ = shows_inner_edges(cells, frame_.layout);
    const bool solid = scene_.shapes.model == "solid";
    if (solid) {  // painted from the farthest to the nearest
      std::sort(cells.begin(), cells.end(), [](const SeenCell& a, const SeenCell& b) { return a.depth_m < b.depth_m; });
    }
    for (auto& cell : cells) {
      for (auto& x : cell.corner) x = frame_.layout.at(panel, x);
      if (panel == 0) {
        auto& box = boxes_.try_emplace(cell.body, Extent::empty()).first->second;
        for (const auto& x : cell.corners()) box.include(x);
      }
      for (auto& x : cell.corner) x = {sharpness * x[0], sharpness * x[1]};
    }
    for (const auto& cell : cells) {
      fill(cell, scene_.shapes.times_s[scene_.windows[panel]]);
      if (solid) edge(cell, EdgeKind::inner);
      if (solid) edge(cell, EdgeKind::outline);
    }
    if (solid) return;
    for (const auto kind : {EdgeKind::inner, EdgeKind::outline}) {
      for (const auto& cell : cells) edge(cell, kind);
    }
  }

  void fill(const SeenCell& cell, double time_s) {
    constexpr double tension_share = 0.15;
    canvas_.fill(cell.corners(), ShadedPalette::index(scale_.share(cell.stress_pa), cell.shade),
                 static_cast<int>(pointed_.size()));
    pointed_.push_back({time_s, cell.stress_pa, cell.body});
    const bool tension = scale_.low_pa < 0 && cell.stress_pa >= tension_share * scale_.high_pa;
    if (tension) canvas_.dot(cell.corners(), 8 * sharpness, 3);
  }

  void edge(const SeenCell& cell, EdgeKind kind) {
    if (kind == EdgeKind::inner && !inner_edges_) return;
    for (std::size_t i = 0; i < cell.count; ++i) {
      if (cell.edges[i] != kind) continue;
      const auto &from = cell.corner[i], &to = cell.corner[(i + 1) % cell.count];
      if (kind == EdgeKind::inner) {
        canvas_.darken(from, to, 1);
      } else {
        canvas_.draw(from, to, sharpness);
      }
    }
  }

  const ShapeScene& scene_;
  const ShapeFrame& frame_;
  const StressScale& scale_;
  Canvas canvas_;
  std::vector<PointedCell> pointed_;
  bool inner_edges_ = false;
  std::map<int, Extent> boxes_;
};

/// Of the last row of the history that is not later; nan if it has no such column.
double value_at(const HistoryTable& history, const std::string& name, double time_s) {
  const auto* column = history.find(name);
  double value = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t row = 0; column && row < history.rows() && history.columns[0][row] <= time_s * (1 + 1e-9); ++row)
    value = (*column)[row];
  return value;
}

double time_of_peak(const HistoryTable& history) {
  const auto* force = history.find("contact_force_n");
  double peak = 0, time_s = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t row = 0; force && row < history.rows(); ++row) {
    if (!((*force)[row] > peak)) continue;
    peak = (*force)[row];
    time_s = history.columns[0][row];
  }
  return time_s;
}

Json label_at(double x, double y, const std::string& text) {
  return {{"x", drawn(x)}, {"y", drawn(y)}, {"text", text}};
}

Json time_labels(const ShapeScene& scene, const PanelLayout& layout, const HistoryTable& history) {
  constexpr double room_for_force_px = 220;
  Json labels = Json::array();
  for (std::size_t panel = 0; panel < scene.windows.size(); ++panel) {
    const double time_s = scene.shapes.times_s[scene.windows[panel]];
    std::string text = quantity(time_s, "s", 4);
    const double force = value_at(history, "contact_force_n", time_s);
    if (std::isfinite(force) && layout.panel_width_px > room_for_force_px)
      text += fmt::format(", contact force {}", quantity(force, "N", 4));
    const auto corner = layout.corner(panel);
    labels.push_back(label_at(corner[0], corner[1] - 4, text));
  }
  return labels;
}

/// Below the first panel, if bodies lie side by side, else to the right of the first row.
struct BodyNames {
  Json below = Json::array(), beside = Json::array();
};

BodyNames body_names(const ShapeScene& scene, const ShapePainter& painter, const PanelLayout& layout) {
  constexpr std::size_t most = 6;
  BodyNames names;
  auto middles = Extent::empty();
  const auto middle = [](const Extent& box) {
    return Pixel{0.5 * (box.low[0] + box.high[0]), 0.5 * (box.low[1] + box.high[1])};
  };
  for (const auto& [body, box] : painter.boxes()) middles.include(middle(box));
  if (painter.boxes().size() > most) return names;  // the pointer tells
  const double to_the_last_px =
      static_cast<double>(std::min(layout.columns, scene.windows.size()) - 1) * (layout.panel_width_px + layout.gap_px);
  for (const auto& [body, box] : painter.boxes()) {
    const auto& name = scene.shapes.bodies[static_cast<std::size_t>(body)].name;
    if (middles.height() > middles.width()) {
      names.beside.push_back(label_at(to_the_last_px + layout.panel_width_px + 4, middle(box)[1], name));
    } else {
      const double bottom = layout.corner(0)[1] + layout.panel_height_px;
      names.below.push_back(label_at(middle(box)[0], bottom + 0.5 * PanelLayout::line_px, name));
    }
  }
  return names;
}

/// The axes as arrows and a length, at the foot.
struct ShapeFoot {
  Json lines = Json::array(), labels = Json::array();

  void line(double x, double y, double to_x, double to_y) {
    lines.push_back({{"x", drawn(x)}, {"y", drawn(y)}, {"x2", drawn(to_x)}, {"y2", drawn(to_y)}});
  }
};

ShapeFoot foot_of(const ShapeFrame& frame, double top_px) {
  constexpr double arrow_px = 22, bar_px = 120, letter_px = 8;
  ShapeFoot foot;
  const double bottom = top_px + foot_px - 12;
  double lowest = 0;
  for (const auto& axis : frame.view.axes()) lowest = std::min(lowest, axis.direction[1]);
  const Pixel origin = {14, bottom + arrow_px * lowest};
  for (const auto& axis : frame.view.axes()) {
    const auto [right, up] = axis.direction;
    const double length = std::hypot(right, up), letter = arrow_px + letter_px / length;
    foot.line(origin[0], origin[1], origin[0] + arrow_px * right, origin[1] - arrow_px * up);
    foot.labels.push_back(label_at(origin[0] + letter * right, origin[1] - letter * up, axis.letter));
  }
  const double most_m = bar_px / frame.layout.scale_px_m, power = std::pow(10.0, std::floor(std::log10(most_m)));
  const double length_m = power * (most_m >= 5 * power ? 5 : most_m >= 2 * power ? 2 : 1);
  const double begin = 80, end = begin + length_m * frame.layout.scale_px_m, y = bottom;
  foot.line(begin, y, end, y);
  for (const double x : {begin, end}) foot.line(x, y - 4, x, y + 4);
  foot.labels.push_back(label_at(0.5 * (begin + end), y - 11, quantity(length_m, "m", 3)));
  return foot;
}

std::string magnification_text(const ShapeScene& scene) {
  const auto& [factor, flight_s] = scene.magnification;
  if (factor == 1.0) return "Displacements are drawn to scale.";
  const bool flies = std::any_of(scene.shapes.bodies.begin(), scene.shapes.bodies.end(),
                                 [](const auto& body) { return body.velocity_m_s != Place{}; });
  const char* which = !flies                    ? "Displacements"
                      : std::isfinite(flight_s) ? "Displacements from the first contact on"
                                                : "Displacements beyond those of free flight";
  return fmt::format("{} are drawn {:g} times as large as they are.", which, factor);
}

std::string note_of_shapes(const ShapeScene& scene, const ShapeFrame& frame, const StressScale& scale,
                           bool inner_edges) {
  const auto& shapes = scene.shapes;
  const bool bar = shapes.model == "bar";
  std::string note = bar ? "Axial stress of each element. Blue: compression; red with dots: tension."
                         : "Von Mises stress in the middle of each element.";
  note += " " + magnification_text(scene);
  if (bar) {
    const bool thin = std::any_of(shapes.bodies.begin(), shapes.bodies.end(),
                                  [&](const auto& body) { return body.strip_m < frame.least_strip_m; });
    note += thin ? " Bars are drawn thicker than they are."
                 : " Bars are as thick as a square of their cross section is wide.";
  }
  if (frame.view.mirrored()) note += " Both halves of the section are drawn, one computed, the other its mirror image.";
  const bool repeats = std::any_of(shapes.pieces.begin(), shapes.pieces.end(), [](const auto& piece) {
    return std::any_of(piece.node.begin(), piece.node.end(), [](int node) { return node < 0; });
  });
  if (repeats) note += " The mesh repeats across; one period of it is drawn.";
  if (shapes.nose) note += " The rounded nose is a gap of the contact, which the mesh does not have.";
  if (shapes.model == "solid") note += " Of solids their surface is seen.";
  if (!inner_edges) note += " Element edges would lie too close to be seen and are left out.";
  if (std::abs(scale.largest_pa) > scale.high_pa) {
    note += fmt::format(" The largest stress, {} at {}, lies beyond the colours.", quantity(scale.largest_pa, "Pa", 4),
                        quantity(scale.largest_s, "s", 4));
  }
  for (const auto& text : shapes.missing) note += " " + text;
  return note;
}

/// What the pointer finds, in a grid.
void add_pointed(Chart& chart, const ShapePainter& painter, const Shapes& shapes, double grid_px, double time_factor,
                 double stress_factor) {
  chart.columns = {"x", "y", "time", "stress", "body"};
  const auto& canvas = painter.canvas();
  const int step = static_cast<int>(sharpness * grid_px);
  for (int y = step / 2; y < canvas.height(); y += step) {
    for (int x = step / 2; x < canvas.width(); x += step) {
      const int cell = canvas.cell(x, y);
      if (cell < 0) continue;
      const auto& found = painter.pointed(cell);
      chart.rows.push_back({x / sharpness, y / sharpness, drawn(time_factor * found.time_s),
                            drawn(stress_factor * found.stress_pa),
                            shapes.bodies[static_cast<std::size_t>(found.body)].name});
    }
  }
}

/// A panel's own answer to the pointer, where that is on no body.
Json panels_of(const ShapeScene& scene, const PanelLayout& layout, double time_factor, double stress_factor) {
  Json panels = Json::array();
  for (std::size_t panel = 0; panel < scene.windows.size(); ++panel) {
    const auto w = scene.windows[panel];
    double largest = 0;
    for (const auto& piece : scene.shapes.pieces) {
      for (const double stress : piece.stress_pa[w]) {
        if (std::abs(stress) > std::abs(largest)) largest = stress;
      }
    }
    const auto corner = layout.corner(panel);
    panels.push_back(
        {{"x", drawn(corner[0])},
         {"x2", drawn(corner[0] + layout.panel_width_px + layout.gap_px)},
         {"y", drawn(corner[1] - PanelLayout::line_px)},
         {"y2", drawn(corner[1] + layout.panel_height_px + (panel < layout.columns ? PanelLayout::line_px : 0))},
         {"time", drawn(time_factor * scene.shapes.times_s[w])},
         {"largest", drawn(stress_factor * largest)}});
  }
  return panels;
}

Json scale_values(const StressScale& scale, std::size_t count, double factor) {
  Json values = Json::array();
  for (std::size_t i = 0; i < count; ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(count - 1);
    values.push_back(drawn(factor * (scale.low_pa + share * (scale.high_pa - scale.low_pa))));
  }
  return values;
}

Json hex_colours(const std::vector<Rgb>& hues) {
  Json names = Json::array();
  for (const auto& [red, green, blue] : hues) names.push_back(fmt::format("#{:02x}{:02x}{:02x}", red, green, blue));
  return names;
}

Chart chart_of_shapes(const ShapeScene& scene, const ShapeFrame& frame, const StressScale& scale,
                      const HistoryTable& history) {
  const auto& shapes = scene.shapes;
  const auto& layout = frame.layout;
  const ShapePainter painter(scene, frame, scale);
  const bool bar = shapes.model == "bar";
  const auto& hues = bar ? signed_colours : magnitude_colours;
  const auto time_unit = display_unit(shapes.times_s[scene.windows.back()], "s");
  const auto stress_unit = display_unit(scale.high_pa, "Pa");
  Chart chart;
  chart.id = "deformed_bodies";
  chart.title =
      fmt::format("Deformed bodies: {} at {} times", bar ? "axial stress" : "von Mises stress", scene.windows.size());
  chart.note = note_of_shapes(scene, frame, scale, painter.inner_edges());
  const double picture_px = 1.0 * painter.canvas().height() / sharpness, whole_px = picture_px + foot_px;
  const double grid_px = std::max(6.0, std::ceil(std::sqrt(chart_width * picture_px / 2500)));
  add_pointed(chart, painter, shapes, grid_px, time_unit.factor, stress_unit.factor);
  const std::string time_title = fmt::format("time [{}]", time_unit.name),
                    stress_title = fmt::format("{} [{}]", bar ? "axial stress" : "von Mises stress", stress_unit.name);
  const auto names = body_names(scene, painter, layout);
  const auto foot = foot_of(frame, picture_px);
  const Json tooltip = {{{"field", "time"}, {"title", time_title}, {"format", ".4~g"}},
                        {{"field", "stress"}, {"title", stress_title}, {"format", ".4~g"}},
                        {{"field", "body"}, {"title", "body"}}};
  const Json panel_tooltip = {{{"field", "time"}, {"title", time_title}, {"format", ".4~g"}},
                              {{"field", "largest"}, {"title", "largest " + stress_title}, {"format", ".4~g"}}};
  const auto picture = "data:image/png;base64," + base64(painter.canvas().png_of(ShadedPalette(hues)));
  chart.spec = fill_json(
      asset("deformed_bodies.json"),
      {{"description", Json(chart.title).dump()},
       {"width", Json(chart_width).dump()},
       {"height", Json(whole_px).dump()},
       {"x_domain", Json({0, chart_width}).dump()},
       {"y_domain", Json({whole_px, 0}).dump()},
       {"picture", Json({{{"x", 0}, {"x2", chart_width}, {"y", 0}, {"y2", picture_px}, {"url", picture}}}).dump()},
       {"times", time_labels(scene, layout, history).dump()},
       {"names_below", names.below.dump()},
       {"names_beside", names.beside.dump()},
       {"lines", foot.lines.dump()},
       {"letters", foot.labels.dump()},
       {"panels", panels_of(scene, layout, time_unit.factor, stress_unit.factor).dump()},
       {"panel_tooltip", panel_tooltip.dump()},
       {"stress_title", Json(stress_title).dump()},
       {"stress_domain", scale_values(scale, hues.size(), stress_unit.factor).dump()},
       {"colors", hex_colours(hues).dump()},
       {"cell_area", Json(grid_px * grid_px).dump()},
       {"tooltip", tooltip.dump()}});
  return chart;
}

}  // namespace

std::optional<Chart> shape_picture(const Shapes& shapes, const HistoryTable& history, double first_contact_s) {
  if (shapes.pieces.empty() || shapes.times_s.empty()) return std::nullopt;
  ShapeScene scene{shapes, chosen_times(shapes.times_s, time_of_peak(history), most_panels), {}, cell_looks(shapes)};
  const double first_gap_m = value_at(history, "gap_min_m", 0.0);
  scene.magnification = magnification_of(shapes, scene.windows, first_contact_s, first_gap_m);
  return chart_of_shapes(scene, frame_of(scene), stress_scale(shapes, scene.windows), history);
}

}  // namespace ricochet::report

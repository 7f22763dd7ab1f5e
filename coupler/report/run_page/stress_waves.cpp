#include "coupler/report/run_page/stress_waves.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <utility>

#include "common/base/base64.hpp"
#include "common/base/error.hpp"
#include "coupler/report/assets/assets.hpp"
#include "coupler/report/parts/png.hpp"
#include "coupler/report/parts/quantity.hpp"
#include "coupler/report/parts/text.hpp"

namespace ricochet::report {
namespace {

constexpr std::size_t most_times = 200, most_layers = 200;
constexpr int height_px = 400;

/// RdBu of colorbrewer2.org, from compression to tension: told apart by colour-blind eyes. In black and white both ends
/// are dark; dots mark tension.
constexpr std::array<Rgb, 11> colours = {{{5, 48, 97},
                                          {33, 102, 172},
                                          {67, 147, 195},
                                          {146, 197, 222},
                                          {209, 229, 240},
                                          {247, 247, 247},
                                          {253, 219, 199},
                                          {244, 165, 130},
                                          {214, 96, 77},
                                          {178, 24, 43},
                                          {103, 0, 31}}};
constexpr Rgb unknown = {190, 190, 190};

struct Layer {
  double low_m = 0, high_m = 0;
  std::vector<const std::vector<double>*> columns;  ///< of equally thick layers, taken together

  [[nodiscard]] double stress(std::size_t row) const {
    double sum = 0;
    for (const auto* column : columns) sum += (*column)[row];
    return sum / static_cast<double>(columns.size());
  }
};

struct Body {
  std::string name;
  std::vector<Layer> layers;

  [[nodiscard]] double low_m() const { return layers.front().low_m; }
  [[nodiscard]] double high_m() const { return layers.back().high_m; }
};

double number_in(const std::string& text, const std::string& column) {
  double value = 0;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error == std::errc() && stop == text.data() + text.size()) return value;
  throw ConfigError(fmt::format("axial_stress.csv:1: found the column \"{}\", expected BODY/LOW/HIGH", column));
}

/// Layers of one body follow one another in the file, ascending.
std::vector<Body> bodies_of(const HistoryTable& table) {
  std::vector<Body> bodies;
  for (std::size_t c = 1; c < table.names.size(); ++c) {
    const std::string& column = table.names[c];
    const auto first = column.find('/'), last = column.rfind('/');
    if (first == std::string::npos || first == last) (void)number_in("", column);
    const std::string name = column.substr(0, first);
    if (bodies.empty() || bodies.back().name != name) bodies.push_back({name, {}});
    bodies.back().layers.push_back({number_in(column.substr(first + 1, last - first - 1), column),
                                    number_in(column.substr(last + 1), column),
                                    {&table.columns[c]}});
  }
  return bodies;
}

/// Takes neighbouring layers of a body together until there are few enough.
void thin_layers(std::vector<Body>& bodies) {
  std::size_t all = 0;
  for (const auto& body : bodies) all += body.layers.size();
  const std::size_t together = (all + most_layers - 1) / most_layers;
  if (together < 2) return;
  for (auto& body : bodies) {
    std::vector<Layer> layers;
    for (std::size_t i = 0; i < body.layers.size(); ++i) {
      if (i % together == 0) layers.push_back({body.layers[i].low_m, 0, {}});
      layers.back().high_m = body.layers[i].high_m;
      layers.back().columns.push_back(body.layers[i].columns.front());
    }
    body.layers = std::move(layers);
  }
}

/// The bodies of each diagram, from the lowest to the highest.
std::vector<std::vector<Body>> diagrams_of(std::vector<Body> bodies) {
  std::sort(bodies.begin(), bodies.end(), [](const Body& a, const Body& b) { return a.low_m() < b.low_m(); });
  bool overlap = false;
  for (std::size_t b = 1; b < bodies.size(); ++b) {
    const double tolerance = 1e-6 * (bodies.back().high_m() - bodies.front().low_m());
    overlap = overlap || bodies[b].low_m() < bodies[b - 1].high_m() - tolerance;
  }
  if (!overlap) return {bodies};
  std::vector<std::vector<Body>> alone;
  for (auto& body : bodies) alone.push_back({std::move(body)});
  return alone;
}

/// The stress that the colours reach to, and the stress beyond that is largest, if any.
struct Scale {
  double end_pa = 0, beyond_pa = 0, beyond_s = 0;
};

Scale scale_of(const HistoryTable& table, const std::vector<Body>& bodies) {
  Scale scale;
  std::vector<double> sizes;
  for (const auto& body : bodies) {
    for (const auto& layer : body.layers) {
      for (std::size_t row = 0; row < table.rows(); ++row) {
        const double stress = layer.stress(row);
        if (!std::isfinite(stress)) continue;
        sizes.push_back(std::abs(stress));
        if (std::abs(stress) > std::abs(scale.beyond_pa)) {
          scale.beyond_pa = stress;
          scale.beyond_s = table.columns[0][row];
        }
      }
    }
  }
  if (sizes.empty()) return scale;
  const auto at = sizes.begin() + static_cast<std::ptrdiff_t>(0.995 * static_cast<double>(sizes.size() - 1));
  std::nth_element(sizes.begin(), at, sizes.end());
  const double most = std::abs(scale.beyond_pa);
  scale.end_pa = *at > 0 && most > 1.25 * *at ? *at : most;
  return scale;
}

std::vector<Rgb> palette() {
  std::vector<Rgb> result = {unknown};
  for (int i = 0; i < 255; ++i) {
    const double at = i / 254.0 * (colours.size() - 1);
    const auto below = std::min(static_cast<std::size_t>(at), colours.size() - 2);
    Rgb mixed{};
    for (std::size_t c = 0; c < 3; ++c) {
      const double share = at - static_cast<double>(below);
      mixed[c] =
          static_cast<std::uint8_t>(std::lround((1 - share) * colours[below][c] + share * colours[below + 1][c]));
    }
    result.push_back(mixed);
  }
  return result;
}

std::uint8_t index_of(double stress_pa, double end_pa) {
  if (!std::isfinite(stress_pa)) return 0;
  return static_cast<std::uint8_t>(128 + std::lround(127 * std::clamp(stress_pa / end_pa, -1.0, 1.0)));
}

std::string image(const Body& body, const std::vector<std::size_t>& rows, double end_pa) {
  std::vector<std::uint8_t> pixels;
  for (auto layer = body.layers.rbegin(); layer != body.layers.rend(); ++layer) {
    for (const auto row : rows) pixels.push_back(index_of(layer->stress(row), end_pa));
  }
  return "data:image/png;base64," + base64(png(rows.size(), body.layers.size(), pixels, palette()));
}

/// Dots some 14 pixels apart where there is tension of a seventh of the scale or more.
Json tension_dots(const std::vector<Body>& bodies, const std::vector<double>& times,
                  const std::vector<std::size_t>& rows, double end_pa, double time_factor, double length_factor) {
  constexpr double spacing_px = 14, tension_share = 0.15;
  const double total_m = bodies.back().high_m() - bodies.front().low_m();
  const auto every = std::max<std::size_t>(
      1, static_cast<std::size_t>(std::lround(spacing_px * static_cast<double>(rows.size()) / chart_width)));
  Json dots = Json::array();
  for (const auto& body : bodies) {
    const double layer_px = height_px * (body.layers[0].high_m - body.layers[0].low_m) / total_m;
    const auto step = std::max<std::size_t>(1, static_cast<std::size_t>(std::lround(spacing_px / layer_px)));
    for (std::size_t i = step / 2; i < body.layers.size(); i += step) {
      const auto& layer = body.layers[i];
      for (std::size_t r = every / 2; r < rows.size(); r += every) {
        if (!(layer.stress(rows[r]) >= tension_share * end_pa)) continue;
        dots.push_back({{"time", drawn(time_factor * times[rows[r]])},
                        {"position", drawn(length_factor * 0.5 * (layer.low_m + layer.high_m))}});
      }
    }
  }
  return dots;
}

std::string note_of(const Scale& scale, std::size_t shown, std::size_t all, bool contact) {
  std::string note =
      "Mean over the cross section, over the undeformed axis. Blue: compression; red with dots: tension.";
  if (contact) note += " Line across: where the bodies meet.";
  if (std::abs(scale.beyond_pa) > scale.end_pa) {
    note += fmt::format(" The largest stress, {} at {}, lies beyond the colours.", quantity(scale.beyond_pa, "Pa", 4),
                        quantity(scale.beyond_s, "s", 4));
  }
  if (shown < all) note += fmt::format(" Drawn from {} of {} times.", shown, all);
  return note;
}

/// The data of a diagram in display units: one row for each time, one column for each layer.
void add_rows(Chart& chart, const std::vector<Body>& bodies, const std::vector<double>& times,
              const std::vector<std::size_t>& rows, double time_factor, double stress_factor) {
  chart.columns = {"time"};
  for (const auto& body : bodies) {
    for (std::size_t i = 0; i < body.layers.size(); ++i)
      chart.columns.push_back(fmt::format("s{}", chart.columns.size() - 1));
  }
  for (const auto row : rows) {
    Json cells = {drawn(time_factor * times[row])};
    for (const auto& body : bodies) {
      for (const auto& layer : body.layers) cells.push_back(drawn(stress_factor * layer.stress(row)));
    }
    chart.rows.push_back(std::move(cells));
  }
}

Json equally_spaced(double from, double to, std::size_t count) {
  Json values = Json::array();
  for (std::size_t i = 0; i < count; ++i) {
    values.push_back(drawn(from + (to - from) * static_cast<double>(i) / static_cast<double>(count - 1)));
  }
  return values;
}

Json colour_names() {
  Json names = Json::array();
  for (const auto& [red, green, blue] : colours) names.push_back(fmt::format("#{:02x}{:02x}{:02x}", red, green, blue));
  return names;
}

/// The values that are listed body by body or layer by layer in the specification, in display units.
struct Listed {
  Json lows = Json::array(), highs = Json::array(), bodies = Json::array(), names = Json::array(),
       planes = Json::array(), images = Json::array();
};

Listed listed(const std::vector<Body>& bodies, const std::vector<std::size_t>& rows, double end_pa, double begin,
              double end, double length_factor) {
  Listed all;
  for (const auto& body : bodies) {
    for (const auto& layer : body.layers) {
      all.lows.push_back(drawn(length_factor * layer.low_m));
      all.highs.push_back(drawn(length_factor * layer.high_m));
      all.bodies.push_back(body.name);
    }
    const double low = length_factor * body.low_m(), high = length_factor * body.high_m();
    all.names.push_back({{"name", body.name}, {"position", drawn(0.5 * (low + high))}});
    all.images.push_back(
        {{"begin", begin}, {"end", end}, {"low", low}, {"high", high}, {"url", image(body, rows, end_pa)}});
  }
  for (std::size_t b = 1; b < bodies.size(); ++b) {
    const double position = 0.5 * (bodies[b - 1].high_m() + bodies[b].low_m());
    all.planes.push_back({{"position", drawn(length_factor * position)}});
  }
  return all;
}

Chart chart_of(const HistoryTable& table, const std::vector<Body>& bodies, const Scale& scale, const TimeRange& range) {
  const auto& times = table.columns.front();
  const std::size_t every = (table.rows() + most_times - 1) / most_times;
  std::vector<std::size_t> rows;
  for (std::size_t row = 0; row < table.rows(); row += every) rows.push_back(row);
  const auto time_unit = display_unit(range.to_s, "s"), stress_unit = display_unit(scale.end_pa, "Pa");
  const auto length_unit =
      display_unit(std::max(std::abs(bodies.front().low_m()), std::abs(bodies.back().high_m())), "m");
  const double step =
      time_unit.factor * (times[rows.back()] - times[rows.front()]) / static_cast<double>(rows.size() - 1);
  const double begin = time_unit.factor * times[rows.front()] - 0.5 * step;
  const auto lists =
      listed(bodies, rows, scale.end_pa, begin, begin + static_cast<double>(rows.size()) * step, length_unit.factor);
  Chart chart;
  chart.id = "axial_stress";
  chart.title = "Stress waves: axial stress over time and position";
  chart.note = note_of(scale, rows.size(), table.rows(), !lists.planes.empty());
  chart.link = "time";
  add_rows(chart, bodies, times, rows, time_unit.factor, stress_unit.factor);
  const std::string time_title = fmt::format("time [{}]", time_unit.name),
                    position_title = fmt::format("axial position [{}]", length_unit.name),
                    stress_title = fmt::format("axial stress [{}]", stress_unit.name);
  Json events = Json::array();
  for (const double event : range.events_s) events.push_back({{"time", drawn(time_unit.factor * event)}});
  const double end = stress_unit.factor * scale.end_pa;
  const Json tooltip = {{{"field", "time"}, {"title", time_title}, {"format", ".5~g"}},
                        {{"field", "position"}, {"title", position_title}, {"format", ".4~g"}},
                        {{"field", "value"}, {"title", stress_title}, {"format", ".4~g"}},
                        {{"field", "body"}, {"title", "body"}}};
  chart.spec = fill_json(
      asset("stress_waves.json"),
      {{"description", Json(chart.title).dump()},
       {"width", Json(chart_width).dump()},
       {"height", Json(height_px).dump()},
       {"from", Json(time_unit.factor * range.from_s).dump()},
       {"to", Json(time_unit.factor * range.to_s).dump()},
       {"time_title", Json(time_title).dump()},
       {"position_title", Json(position_title).dump()},
       {"position_domain", Json({lists.lows.front(), lists.highs.back()}).dump()},
       {"stress_title", Json(stress_title).dump()},
       {"stress_domain", equally_spaced(-end, end, colours.size()).dump()},
       {"colors", colour_names().dump()},
       {"lows", lists.lows.dump()},
       {"highs", lists.highs.dump()},
       {"bodies", lists.bodies.dump()},
       {"names", lists.names.dump()},
       {"planes", lists.planes.dump()},
       {"images", lists.images.dump()},
       {"events", events.dump()},
       {"tension", tension_dots(bodies, times, rows, scale.end_pa, time_unit.factor, length_unit.factor).dump()},
       {"fields", Json(std::vector<std::string>(chart.columns.begin() + 1, chart.columns.end())).dump()},
       {"cell_width", Json(fmt::format("{:.6g} * width / (to - from)", step)).dump()},
       {"tooltip", tooltip.dump()}});
  return chart;
}

}  // namespace

std::vector<Chart> stress_wave_charts(const HistoryTable& table, const TimeRange& range) {
  std::vector<Chart> charts;
  if (table.rows() < 2 || table.names.size() < 2 || !(range.to_s > range.from_s)) return charts;
  auto bodies = bodies_of(table);
  thin_layers(bodies);
  const auto scale = scale_of(table, bodies);
  if (scale.end_pa == 0) return charts;
  const auto diagrams = diagrams_of(std::move(bodies));
  for (const auto& diagram : diagrams) {
    charts.push_back(chart_of(table, diagram, scale, range));
    if (diagrams.size() == 1) continue;
    charts.back().id += "_" + diagram.front().name;
    charts.back().title += " in " + diagram.front().name;
  }
  return charts;
}

}  // namespace ricochet::report

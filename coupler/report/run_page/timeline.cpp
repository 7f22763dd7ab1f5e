#include "coupler/report/run_page/timeline.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <map>
#include <string_view>
#include <vector>

#include "common/base/error.hpp"
#include "coupler/report/assets/assets.hpp"
#include "coupler/report/parts/quantity.hpp"
#include "coupler/report/parts/text.hpp"

namespace ricochet::report {
namespace {

struct Span {
  double begin_us = 0, end_us = 0;
  int window = 0;
  std::string what;
};

struct Process {
  std::string name;
  std::vector<Span> spans;
};

constexpr int last_settled = first_settled + timeline_windows - 1;

/// A line of results/trace.cpp that tells of a window that is not shown, or counts something.
bool is_beside(std::string_view line) {
  constexpr std::string_view key = "\"window\": ";
  if (!line.starts_with("{\"name\": ")) return false;
  const auto at = line.rfind(key);
  if (at == std::string_view::npos) return line.find("\"ph\": \"C\"") != std::string_view::npos;
  int window = 0;
  std::from_chars(line.data() + at + key.size(), line.data() + line.size(), window);
  return window > last_settled;
}

/// A trace without those lines, which are nearly all of it and would take their time to parse.
std::string shown_lines(std::string_view text) {
  std::string shown;
  while (!text.empty()) {
    const std::string_view line = text.substr(0, std::min(text.find('\n'), text.size() - 1) + 1);
    text.remove_prefix(line.size());
    if (is_beside(line)) continue;
    if (line.starts_with("]}") && shown.ends_with(",\n")) shown.resize(shown.size() - 2);
    shown += line;
  }
  return shown;
}

/// Keeps of a trace only names and the spans of windows that may be shown, already while it is parsed.
Json parse(const std::string& text) {
  const auto keep = [](int, Json::parse_event_t event, Json& value) {
    if (event != Json::parse_event_t::object_end || value.value("ph", "") != "X") return true;
    const int window = value.at("args").at("window");
    return 1 <= window && window <= last_settled;
  };
  try {
    return Json::parse(shown_lines(text), keep).at("traceEvents");
  } catch (const Json::exception& error) {
    throw ConfigError(fmt::format("trace.json is not the trace of a run: {}", error.what()));
  }
}

/// The first window to be shown: the first settled one if there are enough of them, else window 1.
int first_window(const Json& events) {
  for (const auto& event : events) {
    if (event.at("ph") == "X" && event.at("args").at("window") == last_settled) return first_settled;
  }
  return 1;
}

std::vector<Process> processes_of(const Json& events) {
  const int first = first_window(events), last = first + timeline_windows - 1;
  std::map<int, Process> by_id;  // ascending: the order in which the run named them
  for (const auto& event : events) {
    auto& process = by_id[event.at("pid").get<int>()];
    if (event.at("name") == "process_name") process.name = event.at("args").at("name");
    if (event.at("ph") != "X") continue;
    const int window = event.at("args").at("window");
    if (window < first || window > last) continue;
    const double begin = event.at("ts"), duration = event.at("dur");
    process.spans.push_back({begin, begin + duration, window, event.at("name")});
  }
  std::vector<Process> processes;
  for (auto& [id, process] : by_id) {
    if (process.spans.empty()) continue;
    std::sort(process.spans.begin(), process.spans.end(),
              [](const Span& a, const Span& b) { return a.begin_us < b.begin_us; });
    processes.push_back(std::move(process));
  }
  return processes;
}

/// The spans and what lies between them, without overlap.
std::vector<Span> without_gaps(const std::vector<Span>& spans) {
  const std::string between = spans.front().what == "computes" ? "waits" : "computes";
  std::vector<Span> filled;
  for (const auto& span : spans) {
    Span clipped = span;
    if (!filled.empty()) {
      const double end = filled.back().end_us;
      if (clipped.begin_us > end) filled.push_back({end, clipped.begin_us, span.window, between});
      clipped.begin_us = std::max(clipped.begin_us, end);
    }
    if (clipped.end_us > clipped.begin_us) filled.push_back(clipped);
  }
  return filled;
}

}  // namespace

std::optional<Chart> timeline(const std::string& trace_json) {
  auto processes = processes_of(parse(trace_json));
  if (processes.empty()) return std::nullopt;
  double first = processes.front().spans.front().begin_us, last = first;
  int first_window = processes.front().spans.front().window, last_window = first_window;
  Json names = Json::array();
  for (auto& process : processes) {
    process.spans = without_gaps(process.spans);
    first = std::min(first, process.spans.front().begin_us);
    last = std::max(last, process.spans.back().end_us);
    first_window = std::min(first_window, process.spans.front().window);
    last_window = std::max(last_window, process.spans.back().window);
    names.push_back(process.name);
  }
  const auto unit = display_unit(1e-6 * (last - first), "s");
  const double factor = 1e-6 * unit.factor;
  Chart chart;
  chart.id = "timeline";
  chart.title = "Who computes, who waits";
  chart.note = fmt::format("Windows {} to {}, in wall time; trace.json (ui.perfetto.dev) has the others.", first_window,
                           last_window);
  chart.link = "wall";
  chart.columns = {"process", "state", "activity", "window", "begin", "end", "duration"};
  for (const auto& process : processes) {
    for (const auto& span : process.spans) {
      chart.rows.push_back({process.name, span.what == "computes" ? "computes" : "waits", span.what, span.window,
                            drawn(factor * (span.begin_us - first)), drawn(factor * (span.end_us - first)),
                            drawn(factor * (span.end_us - span.begin_us))});
    }
  }
  const std::string begin = fmt::format("begin [{}]", unit.name), duration = fmt::format("duration [{}]", unit.name);
  const Json tooltip = {{{"field", "process"}},
                        {{"field", "activity"}},
                        {{"field", "window"}},
                        {{"field", "begin"}, {"title", begin}, {"format", ".5~g"}},
                        {{"field", "duration"}, {"title", duration}, {"format", ".4~g"}}};
  chart.spec = fill_json(asset("timeline.json"),
                         {{"description", Json(chart.title).dump()},
                          {"width", Json(chart_width).dump()},
                          {"from", "0"},
                          {"to", Json(factor * (last - first)).dump()},
                          {"time_title", Json(fmt::format("wall time since the first of them [{}]", unit.name)).dump()},
                          {"processes", names.dump()},
                          {"tooltip", tooltip.dump()}});
  return chart;
}

}  // namespace ricochet::report

#include "coupler/results/trace.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

namespace ricochet::coupler {
namespace {

std::string quoted(const std::string& text) { return nlohmann::json(text).dump(); }

template <class Out>
void put_counter(Out out, const char* name, const char* unit, double ts, std::ptrdiff_t pid, double value) {
  fmt::format_to(out,
                 "{{\"name\": \"{}\", \"ph\": \"C\", \"ts\": {:.3f}, \"pid\": {}, \"args\": {{\"{}\": {:.6g}}}}},\n",
                 name, ts, pid, unit, value);
}

}  // namespace

std::string to_trace(const std::vector<TraceTrack>& tracks, double begin_s) {
  std::vector<std::string> processes;
  std::string text = "{\"displayTimeUnit\": \"ms\", \"traceEvents\": [\n";
  auto out = std::back_inserter(text);
  for (std::size_t track = 0; track < tracks.size(); ++track) {
    const auto& t = tracks[track];
    auto found = std::find(processes.begin(), processes.end(), t.process);
    const auto pid = found - processes.begin() + 1;
    if (found == processes.end()) {
      processes.push_back(t.process);
      fmt::format_to(out, "{{\"name\": \"process_name\", \"ph\": \"M\", \"pid\": {}, \"args\": {{\"name\": {}}}}},\n",
                     pid, quoted(t.process));
    }
    const std::string label = quoted(t.label);
    fmt::format_to(
        out, "{{\"name\": \"thread_name\", \"ph\": \"M\", \"pid\": {}, \"tid\": {}, \"args\": {{\"name\": {}}}}},\n",
        pid, track + 1, label);
    for (const auto& span : t.spans) {
      fmt::format_to(
          out,
          "{{\"name\": {}, \"ph\": \"X\", \"ts\": {:.3f}, \"dur\": {:.3f}, \"pid\": {}, \"tid\": {}, \"args\": "
          "{{\"window\": {}}}}},\n",
          label, 1e6 * (span.begin_s - begin_s), 1e6 * (span.end_s - span.begin_s), pid, track + 1, span.window);
    }
    for (const auto& counter : t.counters) {
      const auto span = std::lower_bound(t.spans.begin(), t.spans.end(), counter.window,
                                         [](const WaitSpan& s, std::int64_t window) { return s.window < window; });
      if (span == t.spans.end()) break;
      const double ts = 1e6 * (span->end_s - begin_s);
      put_counter(out, "contact iterations", "iterations", ts, pid, counter.iterations);
      put_counter(out, "contact residual", "residual", ts, pid, counter.residual);
    }
  }
  if (const auto comma = text.find_last_of(','); !tracks.empty() && comma == text.size() - 2) text.erase(comma, 1);
  return text + "]}\n";
}

}  // namespace ricochet::coupler

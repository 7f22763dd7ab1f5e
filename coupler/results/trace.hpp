#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace ricochet::coupler {

/// How the contact problems of the windows up to a history row were solved.
struct ContactCounter {
  std::int64_t window = 0;  ///< of the row
  double iterations = 0, residual = 0;
};

/// Time that the coupler waited for a peer, on the steady clock [s].
struct WaitSpan {
  std::int64_t window = 0;
  double begin_s = 0.0, end_s = 0.0;
};

/// Spans of one row of the trace.
struct TraceTrack {
  std::string process;
  std::string label;  ///< "computes" | "waits for <name>"
  std::vector<WaitSpan> spans;
  std::vector<ContactCounter> counters;  ///< drawn at the ends of the spans of their windows
};

/// The text of trace.json in the Chrome trace event format (ui.perfetto.dev opens it): who computes, who waits for
/// whom, and how hard the contact was to solve. Times in microseconds since `begin_s` on the steady clock; participants
/// on other machines have clocks of their own.
[[nodiscard]] std::string to_trace(const std::vector<TraceTrack>& tracks, double begin_s);

}  // namespace ricochet::coupler

#pragma once

#include <string>
#include <vector>

#include "coupler/peers.hpp"

namespace ricochet::coupler {

/// Spans of one row of the trace.
struct TraceTrack {
  std::string process;
  std::string label;  ///< "computes" | "waits for <name>"
  std::vector<WaitSpan> spans;
};

/// The text of trace.json in the Chrome trace event format (ui.perfetto.dev opens it): who computes, who waits for
/// whom. Times in microseconds since `begin_s` on the steady clock; participants on other machines have clocks of their
/// own.
[[nodiscard]] std::string to_trace(const std::vector<TraceTrack>& tracks, double begin_s);

}  // namespace ricochet::coupler

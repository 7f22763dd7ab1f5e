#pragma once

#include <optional>
#include <string>

#include "coupler/report/parts/chart.hpp"

namespace ricochet::report {

/// The number of windows that the timeline shows, and the first of them if the run has them: memory is touched for the
/// first time in the windows before, so they take longer than all others.
inline constexpr int timeline_windows = 20, first_settled = 101;

/// The processes that compute and those that wait in some windows, from the text of trace.json (Chrome trace events,
/// see coupler/results/trace.hpp). A process either has spans "computes", then the time between them is waiting, or
/// only spans "waits for <name>", then the time between them is computing. Time counts from the beginning of the first
/// one shown. Empty if no window was traced. Throws ConfigError if the text is no trace.
[[nodiscard]] std::optional<Chart> timeline(const std::string& trace_json);

}  // namespace ricochet::report

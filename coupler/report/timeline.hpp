#pragma once

#include <optional>
#include <string>

#include "coupler/report/chart.hpp"

namespace ricochet::report {

/// Windows that the timeline shows: the first ones.
inline constexpr int timeline_windows = 40;

/// Who computes and who waits in the first windows, from the text of trace.json (Chrome trace events, see
/// coupler/trace.hpp). A process either has spans "computes", then the time between them is waiting, or only spans
/// "waits for <name>", then the time between them is computing. Time counts from the beginning of window 1. Empty if
/// no window was traced. Throws ConfigError if the text is no trace.
[[nodiscard]] std::optional<Chart> timeline(const std::string& trace_json);

}  // namespace ricochet::report

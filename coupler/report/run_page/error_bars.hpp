#pragma once

#include <string>

#include "coupler/report/parts/chart.hpp"

namespace ricochet::report {

/// HTML: the quantities with their error bars by cause, of a run with `--estimate-error`; else empty.
[[nodiscard]] std::string error_bars_html(const Json& summary);

}  // namespace ricochet::report

#pragma once

#include <string>

namespace ricochet::report {

/// The chart libraries, each with its licence, and chart_spec.js as <script> elements.
[[nodiscard]] std::string libraries_html();

}  // namespace ricochet::report

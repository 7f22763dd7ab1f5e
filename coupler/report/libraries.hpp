#pragma once

#include <string>

namespace ricochet::report {

/// The chart libraries as <script> elements, each with its licence.
[[nodiscard]] std::string libraries_html();

}  // namespace ricochet::report

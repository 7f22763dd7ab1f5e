#pragma once

#include <string>

namespace ricochet::coupler {

/// A text as one cell of a CSV file (RFC 4180), on one line.
inline std::string csv_cell(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) {
    quoted += c == '\n' ? ' ' : c;
    if (c == '"') quoted += c;
  }
  return quoted + "\"";
}

}  // namespace ricochet::coupler

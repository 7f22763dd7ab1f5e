#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/base/archive.hpp"
#include "common/wire/message.hpp"

namespace ricochet::coupler {

/// Rows about windows that a participant sends along with its answers when it is asked for them: every so many windows
/// one, from window 0 (or 1) on, each once and in order. The first number of a row is its window.
class WindowRows {
 public:
  /// `field`: where they come; `what`: a row of them, for error texts; `columns`: what was announced, none: no rows.
  WindowRows(const char* field, const char* what, std::size_t columns)
      : field_(field), what_(what), columns_(columns) {}

  /// Windows from row to row; 0: none are wanted.
  void expect_every(std::int64_t windows, std::int64_t first = 0) {
    every_ = columns_ > 0 ? windows : 0;
    next_ = first;
  }
  /// Takes what an answer brought when `computed` was the last window; `requested`: in which window all rows up to that
  /// were asked for, < 0: in none. Throws ProtocolError for a row that is not the next one, is missing or has another
  /// number of columns.
  void take(const wire::Array& rows, const std::string& participant, std::int64_t computed, std::int64_t requested);
  /// The numbers that came since the last call, row-major.
  [[nodiscard]] std::vector<double> taken();
  void archive(Archive& a) { a(next_, rows_); }

 private:
  const char *field_, *what_;
  std::size_t columns_;
  std::int64_t every_ = 0, next_ = 0;  ///< windows
  std::vector<double> rows_;
};

}  // namespace ricochet::coupler

#include "coupler/interface/window_rows.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "common/base/error.hpp"

namespace ricochet::coupler {

void WindowRows::take(const wire::Array& rows, const std::string& participant, std::int64_t computed,
                      std::int64_t requested) {
  if (rows.rows > 0 && every_ == 0) {
    throw ProtocolError(
        fmt::format("participant '{}' sent {} rows in '{}', expected none", participant, rows.rows, field_));
  }
  const int width = std::max(rows.columns, 1);
  for (int row = 0; row < rows.rows; ++row, next_ += every_) {
    const double found = rows.data[static_cast<std::size_t>(row) * static_cast<std::size_t>(width)];
    if (found == static_cast<double>(next_) && next_ <= computed) continue;
    throw ProtocolError(
        fmt::format("participant '{}' sent in '{}' the {} of window {}, the next one is that of window {}, and window "
                    "{} is computed",
                    participant, field_, what_, found, next_, computed));
  }
  if (every_ > 0 && requested >= 0 && next_ <= computed) {
    throw ProtocolError(
        fmt::format("participant '{}' left out of '{}' the {} of window {}, which was asked for in window {}",
                    participant, field_, what_, next_, requested));
  }
  if (rows.rows == 0) return;
  if (rows.columns != static_cast<int>(columns_)) {
    throw ProtocolError(fmt::format("participant '{}' sent {}s of {} numbers, it announced {} columns", participant,
                                    what_, rows.columns, columns_));
  }
  rows_.insert(rows_.end(), rows.data.begin(), rows.data.end());
}

std::vector<double> WindowRows::taken() { return std::exchange(rows_, {}); }

}  // namespace ricochet::coupler

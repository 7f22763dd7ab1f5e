#pragma once

#include <optional>
#include <string>
#include <vector>

namespace ricochet::bench {

/// The value that a ratio is wanted to have.
struct Level {
  bool at_most = true;  ///< false: at least
  double value = 0.0;
};

/// One figure: a ratio, measured once per repeat.
struct Row {
  std::string quantity, at;
  std::vector<double> ratios;
  std::optional<Level> level;
  std::string missing = {};  ///< why there is no figure, if `ratios` is empty
};

/// Median; of an even count the mean of the middle two. `values` not empty.
[[nodiscard]] double median(std::vector<double> values);
/// Element by element numerator / denominator: the repeats are interleaved, so a pair saw the same machine.
[[nodiscard]] std::vector<double> quotients(const std::vector<double>& numerator,
                                            const std::vector<double>& denominator);

/// The table that is printed, and the same as CSV.
[[nodiscard]] std::string to_text(const std::vector<Row>& rows);
[[nodiscard]] std::string to_csv(const std::vector<Row>& rows);

}  // namespace ricochet::bench

#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/base/archive.hpp"
#include "common/base/window_clock.hpp"
#include "common/scene/scene.hpp"
#include "coupler/results/history.hpp"

namespace ricochet::coupler {

/// A row of probes.csv: the values at a time, in the order of scene::probe_columns.
struct ProbeRow {
  std::int64_t window = 0;
  double time_s = 0.0;
  std::vector<double> values;
};

/// Adds the participants' shares of what probes and gauges see up to the rows of probes.csv. A column of which shares
/// are missing (of a participant of others) is nan. A gauge with a rise time t_r is filtered:
///   y' = (x - y) / tau,   tau = t_r / ln 9,
/// which takes t_r from 10 to 90 % of a step. Between two windows x is linear, for which the filter is solved exactly:
///   y_{n+1} = x_{n+1} - s tau + (y_n - x_n + s tau) e^{-h/tau},   s = (x_{n+1} - x_n) / h,   y_0 = x_0.
class Probes {
 public:
  /// Columns of a participant: "window", then COLUMN/SHARE; none: it tells nothing. Throws ProtocolError naming the
  /// participant and the column if one is something else.
  Probes(const std::vector<History::Source>& sources, const scene::Scene& scene);

  /// Names of columns, without the time.
  [[nodiscard]] const std::vector<std::string>& columns() const { return columns_; }
  /// Names of probes and gauges of which shares are missing.
  [[nodiscard]] std::vector<std::string> untold() const;
  /// `values`: rows of this participant, row-major.
  void add(std::size_t participant, const std::vector<double>& values);
  /// The next row that all who tell any have told; nothing if somebody has not yet.
  [[nodiscard]] std::optional<ProbeRow> next(const WindowClock& clock);
  void archive(Archive& a);

 private:
  struct Stream {
    std::vector<std::size_t> places;  ///< in columns_, of its columns
    std::vector<double> values;       ///< rows: window, then its columns
    std::size_t used = 0;             ///< numbers of the rows that were made one already

    [[nodiscard]] std::size_t width() const { return 1 + places.size(); }
    void forget_used();
    [[nodiscard]] bool empty() const { return used == values.size(); }
    void archive(Archive& a);
  };
  void add_column(const History::Source& source, const std::string& column);
  void filter(ProbeRow& row);

  std::vector<std::string> columns_;
  std::vector<double> share_, time_constant_s_;  ///< per column: told of it; of its filter, 0: none
  std::vector<Stream> streams_;
  std::vector<double> input_, output_;  ///< of the filters, in the last row; empty before the first
  double time_s_ = 0.0;                 ///< of that row
};

}  // namespace ricochet::coupler

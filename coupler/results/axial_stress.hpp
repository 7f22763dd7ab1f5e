#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "common/base/window_clock.hpp"
#include "coupler/results/history.hpp"

namespace ricochet::coupler {

/// Adds the participants' shares of the axial stress up to axial_stress.csv: time_s, then one column BODY/LOW/HIGH for
/// each layer, bodies in the given order, layers ascending, LOW and HIGH its borders on the axis [m]; values: mean
/// axial stress over the layer [Pa], tension positive. A layer in which nobody tells the stress of some elements (a
/// participant of others) is nan. Ends with the last time that all who tell any have told.
class AxialStress {
 public:
  /// Columns of a participant: "window", then BODY/LOW/HIGH/SHARE for each layer in which it has elements, SHARE its
  /// share of the layer's volume; none: it tells nothing. Throws ProtocolError naming the participant and the column
  /// if one is something else.
  AxialStress(const std::vector<History::Source>& sources, const std::vector<std::string>& bodies);

  /// `values`: rows of this participant, row-major, every so many windows the same for all.
  void add(std::size_t participant, const std::vector<double>& values);
  /// Whether any stress is told at all.
  [[nodiscard]] bool told() const { return !layers_.empty(); }
  /// The text of axial_stress.csv. All adding up is left to it, after the last window.
  [[nodiscard]] std::string csv(const WindowClock& clock) const;
  void archive(Archive& a);

 private:
  struct Layer {
    std::string name;    ///< of its column
    double share = 0.0;  ///< of its volume that is told of
  };
  using Place = std::pair<std::size_t, double>;  ///< body, low border [m]
  struct Stream {
    std::vector<Place> places;   ///< of its columns
    std::vector<double> values;  ///< rows as told: window, then its columns

    [[nodiscard]] std::size_t width() const { return 1 + places.size(); }
    void archive(Archive& a) { a(values); }
  };
  void add_column(const History::Source& source, const std::string& column, const std::vector<std::string>& bodies);
  [[nodiscard]] std::size_t rows() const;

  std::map<Place, Layer> layers_;
  std::vector<Stream> streams_;
};

}  // namespace ricochet::coupler

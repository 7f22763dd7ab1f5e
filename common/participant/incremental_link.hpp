#pragma once

#include <vector>

#include "common/base/archive.hpp"
#include "common/wire/message.hpp"

namespace ricochet::participant {

/// Link input and output of one participant: absolute here, increments since the last accepted window on the wire
/// (Eq. 6: Delta P). With x the link input, y the link output, and X, Y what both ends have accumulated up to the last
/// accepted window:
///   received:  x = X + d,             X = x when the window is accepted
///   sent:      d = y - Y,  y' = Y + d,  Y = y' when the window is accepted    (the coupler does the same sum)
/// so that no rounding piles up, and a repeated window starts from the same values. A resynchronisation replaces x or
/// y' by the absolute values that travel with the increments.
class IncrementalLink {
 public:
  IncrementalLink(int nodes, int components);

  /// Numbers in one vector: nodes x components.
  [[nodiscard]] std::size_t size() const { return input_.size(); }
  /// Starts again from absolute values.
  void set_input(const wire::Array& absolute);
  void set_output(const std::vector<double>& absolute);
  /// x from `increment`, or from `absolute` if it has rows.
  void receive(const wire::Array& increment, const wire::Array& absolute);
  [[nodiscard]] const std::vector<double>& input() const { return input_; }
  /// d (and y if `with_absolute`) into arrays of a message.
  void send(const std::vector<double>& output, bool with_absolute, wire::Array& increment, wire::Array& absolute);
  /// X = x, Y = y'. Until the next `receive` or `set_input`, `input` then is some older one.
  void accept();
  /// Largest max|X + d - x| / max|x| of all resynchronisations; the plain difference where x = 0.
  [[nodiscard]] double largest_drift() const { return largest_drift_; }

  /// Between windows: what both ends have accumulated.
  void archive(Archive& a) {
    a(accepted_input_, accepted_output_, largest_drift_);
    input_ = accepted_input_;
    output_ = accepted_output_;
  }

 private:
  int nodes_, components_;
  std::vector<double> input_, accepted_input_, output_, accepted_output_;
  double largest_drift_ = 0.0;
};

}  // namespace ricochet::participant

#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "common/base/separation.hpp"
#include "coupler/results/history.hpp"

namespace ricochet::coupler {

/// What is kept of one of several contacts for the end of a run. Times are those of rows of the history, which is as
/// exact as history_every lets it be.
class ContactResult {
 public:
  /// `row_windows` from row to row; so many windows open with growing gaps are `separation_windows`.
  ContactResult(std::string name, int row_windows, double window_size_s, int separation_windows)
      : name_(std::move(name)),
        row_windows_(row_windows),
        row_s_(row_windows * window_size_s),
        separation_((separation_windows + row_windows - 1) / row_windows) {}

  void add(std::int64_t window, const ContactTotals& contact) {
    const std::int64_t row = window / row_windows_;
    if (!first_contact_s_ && contact.contact_force_n > 0) first_contact_s_ = static_cast<double>(row) * row_s_;
    separation_.update(row, static_cast<int>(contact.pairs_stick + contact.pairs_slip), contact.gap_min_m);
    peak_force_n_ = std::max(peak_force_n_, contact.contact_force_n);
    peak_pressure_pa_ = std::max(peak_pressure_pa_, contact.contact_pressure_max_pa);
    largest_radius_m_ = std::max(largest_radius_m_, contact.contact_radius_m);
    last_ = contact;
  }

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] std::optional<double> first_contact_s() const { return first_contact_s_; }
  [[nodiscard]] std::optional<double> separation_time_s() const {
    const std::int64_t row = separation_.separation_window();
    return row < 0 ? std::nullopt : std::optional(static_cast<double>(row) * row_s_);
  }
  [[nodiscard]] double peak_force_n() const { return peak_force_n_; }
  [[nodiscard]] double peak_pressure_pa() const { return peak_pressure_pa_; }
  [[nodiscard]] double largest_radius_m() const { return largest_radius_m_; }  ///< 0: it has none
  /// At the end so far.
  [[nodiscard]] const ContactTotals& last() const { return last_; }

  void archive(Archive& a) {
    a(separation_, first_contact_s_, peak_force_n_, peak_pressure_pa_, largest_radius_m_, last_);
  }

 private:
  std::string name_;
  int row_windows_;
  double row_s_;
  SeparationWatch separation_;
  std::optional<double> first_contact_s_;
  double peak_force_n_ = 0, peak_pressure_pa_ = 0, largest_radius_m_ = 0;
  ContactTotals last_;
};

}  // namespace ricochet::coupler

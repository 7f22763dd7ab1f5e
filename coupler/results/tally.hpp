#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "coupler/results/contact_result.hpp"
#include "coupler/results/history.hpp"
#include "coupler/results/theory.hpp"

namespace ricochet::coupler {

/// How the contact problems of a run were solved. All zero where they have a closed form.
struct ContactTally {
  double iterations_mean = 0;  ///< per window
  double iterations_max = 0;   ///< per window; of a row that stands for several windows, their mean
  double residual_max = 0;     ///< relative to the largest normal force of the window
  std::int64_t windows_unconverged = 0;

  void add(const HistoryRow& row) {
    residual_max = std::max(residual_max, row.contact.contact_residual);
    windows_unconverged = static_cast<std::int64_t>(row.contact.contact_unconverged);
    if (row.window <= last_window_) return;
    const auto windows = static_cast<double>(row.window - last_window_);
    iterations_max = std::max(iterations_max, row.contact.contact_iterations / windows);
    iterations_mean +=
        (row.contact.contact_iterations / windows - iterations_mean) * windows / static_cast<double>(row.window);
    last_window_ = row.window;
  }

  void archive(Archive& a) { a(iterations_mean, iterations_max, residual_max, windows_unconverged, last_window_); }

 private:
  std::int64_t last_window_ = 0;
};

/// How bodies have yielded so far.
struct PlasticTally {
  double work_j = 0, largest_equivalent_strain = 0;
  double hottest_k = 0;  ///< 0: plastic work heats no body

  void archive(Archive& a) { a(work_j, largest_equivalent_strain, hottest_k); }
};

/// Numbers kept of the history for the end of a run: extremes, and the mean interface stress on the plateau, that is
/// from 15 % to 65 % of 2L/c after the first contact, and not beyond the first step of the stress.
class Tally {
 public:
  /// `solid`: friction has a component along the binormal. `of_all`: for the sum of all contacts; empty: there is none.
  /// `contacts`: each of several.
  explicit Tally(std::optional<ImpactTheory> theory, bool solid = false, std::optional<ForceTally> of_all = {},
                 std::vector<ContactResult> contacts = {})
      : forces(std::move(of_all)), each_contact(std::move(contacts)), solid_(solid), theory_(std::move(theory)) {}

  /// Takes the force of each contact over a window [N]; windows ascend.
  void add_forces(std::int64_t window, const double* force_n) {
    double sum = 0.0;
    for (std::size_t i = 0; i < std::max<std::size_t>(each_contact.size(), 1); ++i) {
      if (i < each_contact.size()) each_contact[i].forces.add(window, force_n[i]);
      sum += force_n[i];
    }
    if (forces) forces->add(window, sum);
  }

  void add(const HistoryRow& row) {
    ++rows;
    contact.add(row);
    contact_impulse_n_s = row.contact.contact_impulse_n_s;
    friction_impulse_n_s = row.contact.friction_impulse_n_s;
    friction_impulse_b_n_s = row.contact.friction_impulse_b_n_s;
    for (std::size_t i = 0; i < each_contact.size(); ++i) each_contact[i].add(row.contact.contacts[i]);
    gap_smallest_m = std::min(gap_smallest_m, row.contact.gap_min_m);
    if (row.energy_reference_j > 0)
      interface_energy_max =
          std::max(interface_energy_max, std::abs(row.sum.energy_interface_j) / row.energy_reference_j);
    if (plastic) plastic = {row.sum.plastic_work_j, row.sum.equivalent_plastic_strain_max, row.sum.temperature_max_k};
    if (highest_modes_energy_max && row.energy_reference_j > 0)
      highest_modes_energy_max =
          std::max(*highest_modes_energy_max, row.sum.energy_highest_modes_j / row.energy_reference_j);
    energy_error_last = row.energy_error;
    energy_error_lowest = std::min(energy_error_lowest, row.energy_error);
    energy_error_highest = std::max(energy_error_highest, row.energy_error);
    momentum_error_max = std::max(momentum_error_max, row.momentum_error);
    if (row.angular_momentum_error)
      angular_momentum_error_max = std::max(angular_momentum_error_max.value_or(0.0), *row.angular_momentum_error);
    peak_contact_pressure_pa = std::max(peak_contact_pressure_pa, row.contact.contact_pressure_max_pa);
    largest_contact_radius_m = std::max(largest_contact_radius_m, row.contact.contact_radius_m);
    const auto first_s = first_contact_s();
    if (!theory_ || !first_s) return;
    // With a body whose wave returns before the contact's end, the plateau is the first step of a staircase.
    const double end_s = std::min(0.65 * theory_->contact_duration_s, 0.9 * theory_->first_step_s),
                 begin_s = 0.15 / 0.65 * end_s;
    const double since_s = row.time_s - *first_s;
    if (since_s < begin_s || since_s > end_s) return;
    plateau_sum_pa_ += row.contact.contact_pressure_mean_pa;
    ++plateau_rows_;
  }

  [[nodiscard]] double energy_error_max() const { return std::max(energy_error_highest, -energy_error_lowest); }
  /// Empty if no row lies on the plateau.
  [[nodiscard]] std::optional<double> plateau_stress_pa() const {
    if (plateau_rows_ == 0) return std::nullopt;
    return plateau_sum_pa_ / static_cast<double>(plateau_rows_);
  }
  [[nodiscard]] std::optional<double> first_contact_s() const {
    return forces ? forces->first_contact_s() : std::nullopt;
  }
  [[nodiscard]] const std::optional<ImpactTheory>& theory() const { return theory_; }
  [[nodiscard]] bool solid() const { return solid_; }
  void archive(Archive& a) {
    a(rows, energy_error_last, energy_error_lowest, energy_error_highest, momentum_error_max, gap_smallest_m,
      interface_energy_max, contact_impulse_n_s, friction_impulse_n_s, friction_impulse_b_n_s, contact,
      angular_momentum_error_max, plateau_sum_pa_, plateau_rows_, peak_contact_pressure_pa, largest_contact_radius_m);
    if (plastic) a(*plastic);
    if (highest_modes_energy_max) a(*highest_modes_energy_max);
    if (forces) a(*forces);
    for (auto& result : each_contact) a(result);
  }

  std::int64_t rows = 0;
  double energy_error_last = 0, energy_error_lowest = 0, energy_error_highest = 0, momentum_error_max = 0;
  double contact_impulse_n_s = 0, friction_impulse_n_s = 0, friction_impulse_b_n_s = 0;
  double peak_contact_pressure_pa = 0;
  double largest_contact_radius_m = 0;  ///< 0: it has none
  /// Largest energy that the coupling itself has made or lost so far, over the reference of energy_error.
  double interface_energy_max = 0;
  double gap_smallest_m = std::numeric_limits<double>::max();
  ContactTally contact;
  std::optional<ForceTally> forces;  ///< of all contacts together
  std::vector<ContactResult> each_contact;
  std::optional<PlasticTally> plastic;  ///< empty: no body yields
  /// Largest share of the energy, over the reference of energy_error, in the highest tenth of the modes of bodies that
  /// are reduced to them: small, and fewer do. Empty: no body is.
  std::optional<double> highest_modes_energy_max;
  std::optional<double> angular_momentum_error_max;  ///< empty: it is not computed

 private:
  bool solid_;
  std::optional<ImpactTheory> theory_;
  double plateau_sum_pa_ = 0;
  std::int64_t plateau_rows_ = 0;
};

/// Before the first row of a run of the scene.
[[nodiscard]] Tally tally_of(const scene::Problem& problem);

}  // namespace ricochet::coupler

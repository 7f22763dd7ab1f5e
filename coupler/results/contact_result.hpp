#pragma once

#include <algorithm>
#include <string>

#include "coupler/results/force_tally.hpp"
#include "coupler/results/history.hpp"

namespace ricochet::coupler {

/// The numbers that are kept of one of several contacts for the end of a run.
struct ContactResult {
  std::string name;
  ForceTally forces;
  ContactTotals last;                                 ///< at the end so far
  double peak_pressure_pa = 0, largest_radius_m = 0;  ///< of rows of the history; a radius of 0: it has none

  void add(const ContactTotals& row) {
    last = row;
    peak_pressure_pa = std::max(peak_pressure_pa, row.contact_pressure_max_pa);
    largest_radius_m = std::max(largest_radius_m, row.contact_radius_m);
  }
  void archive(Archive& a) { a(forces, last, peak_pressure_pa, largest_radius_m); }
};

}  // namespace ricochet::coupler

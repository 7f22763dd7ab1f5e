#pragma once

#include <string>

#include "coupler/results/force_tally.hpp"
#include "coupler/results/history.hpp"

namespace ricochet::coupler {

/// What is kept of one of several contacts for the end of a run.
struct ContactResult {
  std::string name;
  ForceTally forces;
  ContactTotals last;  ///< at the end so far

  void archive(Archive& a) { a(forces, last); }
};

}  // namespace ricochet::coupler

#pragma once

#include <string>
#include <vector>

#include "coupler/results/results_directory.hpp"

namespace ricochet::coupler {

/// Adds the participants' shares, fields/<participant>.axial_stress (common/solver/axial_stress_file.hpp), up to
/// axial_stress.csv and removes them: time_s, then one column BODY/LOW/HIGH for each layer, bodies in the given order,
/// layers ascending, LOW and HIGH its borders on the axis [m]; values: mean axial stress over the layer [Pa], tension
/// positive. A layer in which nobody told the stress of some elements (a participant of others) is nan. Ends with the
/// last time that all have told. Does nothing if there are no shares. Throws ConfigError for a file that is none of
/// these or cannot be written.
void add_up_axial_stress(const ResultsDirectory& results, const std::vector<std::string>& participants,
                         const std::vector<std::string>& bodies);

}  // namespace ricochet::coupler

#pragma once

#include <filesystem>
#include <vector>

#include "coupler/report/parts/chart.hpp"

namespace ricochet::report {

/// The stability maps that `ricochet stability` has drawn for the scene of a run: those of stability.json in its
/// results folder DIR or, where `ricochet run` and `ricochet stability` leave them side by side, in DIR_stability. The
/// note of the first one says where it comes from. Empty if there is no such file. Throws ConfigError if it is none of
/// ours.
[[nodiscard]] std::vector<Chart> stability_maps(const std::filesystem::path& folder);

}  // namespace ricochet::report

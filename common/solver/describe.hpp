#pragma once

#include <optional>

#include "common/body/body_state.hpp"
#include "common/fem/vtk_output.hpp"
#include "common/participant/participant.hpp"

namespace ricochet::solver {

/// Facts that every solver of ours tells: interface nodes body by body with positions and own lumped masses, scene
/// hash, and the history columns: `<quantity>/<body>` for each body, and the contact columns if it owns the contact.
/// The critical step of its elements is the one that it was told [s], 0 if it needs none; one that they cannot have is
/// refused by ConfigError. A solver that was not told finds it.
[[nodiscard]] participant::Description describe(const scene::Problem& problem,
                                                const scene::ParticipantSpec& participant,
                                                const std::vector<BodyState>& states, bool contact_owner,
                                                std::optional<double> told_critical_step_s = {});

/// Appends the body totals in the order of the columns of `describe`.
void record_bodies(const std::vector<BodyState>& states, std::vector<double>& row);

/// One VTU file `<directory>/<participant>.<body>_<window>.vtu` for each body of a participant; `contact` of its owner,
/// for each body, else none. Accelerations of shared nodes that the link moves (`moved_by_link`) are not a number: who
/// integrates these nodes has them.
void write_fields(const std::string& directory, const std::string& participant, std::int64_t window,
                  const std::vector<BodyState>& states, const std::vector<fem::ContactFields>& contact,
                  bool moved_by_link);

}  // namespace ricochet::solver

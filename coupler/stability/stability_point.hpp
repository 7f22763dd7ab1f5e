#pragma once

#include <string>
#include <vector>

#include "common/check/check.hpp"
#include "common/problem/problem.hpp"
#include "coupler/results/results_directory.hpp"
#include "coupler/spectrum/spectral_radius.hpp"

namespace ricochet::coupler {

struct ContactStability {
  FrozenContact frozen_contact;
  SpectralRadius radius;
};

/// Starts the participants of a scene and measures the spectral radius of one window of its protocol, with the contact
/// frozen in each of the given ways; `plans`: scene::plan_participants of it. Steps above the critical one are not
/// refused: they are what is to be seen. Throws what `run_scene` throws, and ConfigError naming a participant that
/// lacks the capability "load_state".
[[nodiscard]] std::vector<ContactStability> measure_stability(const scene::Problem& problem,
                                                              const std::vector<scene::ParticipantPlan>& plans,
                                                              const std::vector<FrozenContact>& frozen_contacts,
                                                              const ResultsDirectory& results);

}  // namespace ricochet::coupler

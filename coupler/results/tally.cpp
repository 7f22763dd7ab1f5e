#include "coupler/results/tally.hpp"

#include "common/problem/rise_time.hpp"

namespace ricochet::coupler {

Tally tally_of(const scene::Problem& problem) {
  const auto forces = [&](double rise_time_s) {
    return ForceTally(problem.clock, rise_time_s, problem.scene.coupling.separation_windows);
  };
  std::vector<ContactResult> each;  // of several
  const auto names = problem.scene.contact_names();
  for (std::size_t i = 0; i < names.size(); ++i)
    each.push_back({names[i], forces(scene::rise_time_s(problem, problem.contacts[i])), {}});
  std::optional<ForceTally> all;
  if (!problem.contacts.empty()) all = forces(scene::rise_time_s(problem));
  const bool yields = scene::yields(problem);
  Tally tally(yields ? std::nullopt : impact_theory(problem), problem.scene.components() == 3, std::move(all),
              std::move(each));
  if (yields) tally.plastic.emplace();
  if (problem.scene.any_reduced()) tally.highest_modes_energy_max = 0.0;
  return tally;
}

}  // namespace ricochet::coupler

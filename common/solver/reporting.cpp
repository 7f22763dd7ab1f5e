#include "common/solver/reporting.hpp"

namespace ricochet::solver {

void Reporting::describe(const scene::Problem& problem, const std::vector<BodyState>& states,
                         participant::Description& d) {
  axial_stress_ = AxialStressShares(problem, states);
  d.axial_stress_columns = axial_stress_.columns();
  probes_ = ProbeShares(problem, states);
  d.probe_columns = probes_.columns();
}

void Reporting::begin(const scene::Problem& problem, const std::vector<BodyState>& states,
                      const participant::Setup& setup, const std::string& participant, PressedSurface pressing,
                      bool windows_are_cheap) {
  setup_ = &setup;
  surface_ = pressing.surface;
  separation_ = SeparationWatch(setup.separation_windows);
  model_watch_ = ModelWatch(problem, states, surface_, windows_are_cheap);
  outline_ = WatchedOutline(problem, states);
  shapes_.emplace(problem, states, setup, participant, pressing);
}

void Reporting::note(std::int64_t window, const std::vector<BodyState>& states,
                     const std::vector<BodyState>& of_surface) {
  model_watch_.look(window, states, of_surface);
  shapes_->note(window);
}

void Reporting::note_contact(std::int64_t window, const std::vector<BodyState>& of_surface, int pairs_closed) {
  status_ = solver::contact_status(*surface_, of_surface, pairs_closed, window, *setup_, separation_);
}

void Reporting::finish(std::int64_t window, const std::vector<BodyState>& states,
                       const std::vector<BodyState>& of_surface) {
  model_watch_.look(window, states, of_surface, true);
  shapes_->finish(window);
}

}  // namespace ricochet::solver

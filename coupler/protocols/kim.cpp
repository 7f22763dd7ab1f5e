#include "coupler/protocols/kim.hpp"

namespace ricochet::coupler {

void Kim::step(Coupling& coupling, const Step& step) {
  if (coupling.all_explicit()) {
    coupling.advance_implicit(step, coupling.advance_explicit(step, coupling.predicted(0.0), Acceptance::at_once));
    return;
  }
  // Absolute values and history rows belong to what is accepted.
  Step trial = step;
  trial.absolute = trial.records = false;
  const auto& force = coupling.advance_explicit(trial, coupling.predicted(0.0), Acceptance::trial);
  coupling.advance_implicit(step, force);
  coupling.advance_explicit(step, coupling.displacement(), Acceptance::at_once);
}

}  // namespace ricochet::coupler

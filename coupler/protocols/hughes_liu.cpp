#include "coupler/protocols/hughes_liu.hpp"

namespace ricochet::coupler {

void HughesLiu::step(Coupling& coupling, const Step& step) {
  const auto& predicted = coupling.predicted(coupling.beta());
  const auto& force = coupling.advance_explicit(step, predicted, Acceptance::at_once);
  coupling.advance_implicit(step, force);
}

}  // namespace ricochet::coupler

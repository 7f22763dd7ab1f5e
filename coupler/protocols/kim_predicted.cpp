#include "coupler/protocols/kim_predicted.hpp"

namespace ricochet::coupler {

void KimPredicted::step(Coupling& coupling, const Step& step) {
  coupling.advance_implicit(step, coupling.advance_explicit(step, coupling.predicted(0.0), Acceptance::at_once));
}

}  // namespace ricochet::coupler

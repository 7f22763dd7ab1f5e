#include "coupler/protocols/prakash_hjelmstad.hpp"

namespace ricochet::coupler {

void PrakashHjelmstad::step(Coupling& coupling, const Step& step) {
  interface_.advance_free(step);
  coupling.advance_implicit(step, interface_.held_force(coupling));
  interface_.correct(step, coupling.velocity());
}

}  // namespace ricochet::coupler

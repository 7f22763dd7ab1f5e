#pragma once

#include "coupler/protocols/protocol.hpp"

namespace ricochet::coupler {

/// The paper's coupling, Eq. 16, with its sentence "the incremental nodal displacements of the interface are
/// re-evaluated using the results of the implicit calculation":
///   1. explicit trial with u~_Gamma = u + dt v + dt^2/2 a,  answer P(u~)
///   2. implicit step with the rows of P(u~) at Gamma,       answer u_Gamma
///   3. the same explicit window again with the corrected u_Gamma, accepted.
/// Stable for the dt of `hughes_liu`. The force on Gamma is that of step 1, the force on the explicit nodes that of
/// step 3: momentum is conserved only to the order of the method. While the implicit side integrates explicitly,
/// u_Gamma equals u~_Gamma and step 3 is left out.
class Kim final : public Protocol {
 public:
  void step(Coupling& coupling, const Step& step) override;
};

}  // namespace ricochet::coupler

#pragma once

#include "coupler/protocols/protocol.hpp"

namespace ricochet::coupler {

/// Implicit-explicit partition by elements (Hughes, Liu: Implicit-explicit finite elements in transient analysis, J.
/// Appl. Mech. 45, 1978). The explicit elements see the predictor of the shared nodes,
///   u^ = u + dt v + dt^2/4 a,   P = P(u~_E, u^_Gamma),
/// and their force at Gamma goes to the right-hand side of the implicit step. One evaluation a window; the force that
/// acts on Gamma is the one that acts on the explicit nodes, so momentum is conserved to round-off.
/// Stable for dt <= 2/omega_max(K_E, M) of the explicit elements with the summed mass.
class HughesLiu final : public Protocol {
 public:
  void step(Coupling& coupling, const Step& step) override;
};

}  // namespace ricochet::coupler

#pragma once

#include <vector>

#include "coupler/protocols/protocol.hpp"

namespace ricochet::coupler {

/// Implicit-explicit partition by nodes (Belytschko, Mullen: Stability of explicit-implicit mesh partitions in time
/// integration, Int. J. Numer. Meth. Engng 12, 1978). The implicit operator also holds the explicit elements' stiffness
/// at the shared nodes, so that their force there is that of the new displacement:
///   P_Gamma = K_Gamma,E u~_E + K_Gamma,Gamma u_Gamma,  u~_E = u + dt v + dt^2/2 a
/// The explicit nodes move first; then the shared ones, implicitly; the explicit elements' force follows from both.
/// K_Gamma,Gamma comes from unit responses at the start. Two evaluations a window, the first with u_Gamma of the window
/// before. Momentum is conserved to round-off. Stable for dt <= 2/omega_max of the explicit nodes with the shared ones
/// held, which is not below that of `hughes_liu`. The second evaluation tells in every window whether that stiffness
/// still serves: explicit elements that are not linear are refused.
class BelytschkoMullen final : public Protocol {
 public:
  void start(Coupling& coupling, const wire::Initialize& request) override;
  void step(Coupling& coupling, const Step& step) override;

 private:
  void require_linear(const Coupling& coupling, const Step& step);

  std::vector<double> force_, held_force_, after_;  ///< P_Gamma [N]; less K u_Gamma, before and after Gamma moves
};

}  // namespace ricochet::coupler

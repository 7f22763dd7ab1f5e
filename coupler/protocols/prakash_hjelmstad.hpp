#pragma once

#include "coupler/protocols/dual_interface.hpp"
#include "coupler/protocols/protocol.hpp"

namespace ricochet::coupler {

/// Dual coupling with m explicit steps in a window, velocities equal at the window's end, lambda linear over the window
/// (Prakash, Hjelmstad: A FETI-based multi-time-step coupling method for Newmark schemes, Int. J. Numer. Meth. Engng
/// 61, 2004). Two exchanges a window: the explicit side's free velocity up, the multiplier down. Keeps a pseudo-energy
/// exactly; displacements of the two sides drift apart by dt^2/4 of the change of acceleration. m = 1 is `hughes_liu`.
class PrakashHjelmstad final : public Protocol {
 public:
  void start(Coupling& coupling, const wire::Initialize& request) override {
    interface_.start(coupling, request, Step{});
  }
  void reconfigure(Coupling& coupling) override {
    interface_.reconfigure(coupling, Step{.accepted_window = coupling.window()});
  }
  void archive(Archive& a) override { interface_.archive(a); }
  void step(Coupling& coupling, const Step& step) override;

 private:
  DualInterface interface_;
};

}  // namespace ricochet::coupler

#pragma once

#include "coupler/protocols/protocol.hpp"

namespace ricochet::coupler {

/// Eq. 16 read literally: the explicit elements only ever see u~_Gamma = u + dt v + dt^2/2 a. Unstable at almost any
/// step (growth 1.00002 to 1.4 a window); here to be studied beside `kim`.
class KimPredicted final : public Protocol {
 public:
  void step(Coupling& coupling, const Step& step) override;
};

}  // namespace ricochet::coupler

#pragma once

#include "coupler/protocols/protocol.hpp"

namespace ricochet::coupler {

/// Baselines `all_implicit`, `all_explicit` and `local_explicit`: one participant owns every element, so nothing is
/// exchanged and it advances many windows at a request.
class FreeRun final : public Protocol {
 public:
  void step(Coupling& coupling, const Step& step) override { coupling.advance_alone(step); }
};

}  // namespace ricochet::coupler

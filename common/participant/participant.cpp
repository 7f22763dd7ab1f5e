#include "common/participant/participant.hpp"

#include "common/base/error.hpp"

namespace ricochet::participant {

void Participant::load_state(const std::vector<double>&, FrozenContact) {
  throw ParticipantError("it announces the capability 'load_state' but cannot load a state");
}

void Participant::read_state(std::vector<double>&, std::vector<double>&) {
  throw ParticipantError("it announces the capability 'load_state' but cannot tell its state");
}

}  // namespace ricochet::participant

#pragma once

#include "coupler/contract/contract_peer.hpp"

namespace ricochet::coupler {

/// `ricochet check-participant`: runs a program through the contract of docs/participants.md, clause by clause, and
/// prints a verdict for each. Several processes are started, one after the other. `window_size_s` 0: half of the
/// participant's own critical time step. True if no clause failed.
bool check_participant(const ContractCommand& command, double window_size_s);

}  // namespace ricochet::coupler

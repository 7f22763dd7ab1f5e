#pragma once

#include <string>

#include "coupler/contract/contract_peer.hpp"

namespace ricochet::coupler {

/// The command line of `ricochet check-participant`.
struct ContractRequest {
  ContractCommand command;      ///< with a scene it may be without words: the scene's program for the participant
  double window_size_s = 0;     ///< 0: half of its own critical time step, beside the shipped solver the scene's
  std::string scene, name;      ///< of the participant; empty: it is driven without a scene
  std::string interface_nodes;  ///< file to write the positions of its interface nodes into; empty: none
};

/// Runs a program through the contract of docs/participants.md, clause by clause, and prints a verdict for each; with a
/// scene also beside the shipped solver. Several processes are started, one after the other. True if no clause failed.
/// Throws ConfigError if interface nodes are to be written that are not of one body.
bool check_participant(const ContractRequest& request);

}  // namespace ricochet::coupler

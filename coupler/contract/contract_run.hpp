#pragma once

#include <string>
#include <vector>

#include "coupler/contract/contract_peer.hpp"

namespace ricochet::coupler {

/// How a participant is driven in one run of the contract.
struct ContractDrive {
  int windows = 20;
  bool zero_input = false;   ///< link input 0 throughout
  bool try_first = false;    ///< each window: trial, trial with another input, the first trial again, accept
  int save_at = 0;           ///< another process goes on from what was saved at the end of this window; 0: none
  double window_size_s = 0;  ///< 0: half of its own critical time step, 1e-6 s if it needs none
};

/// What came of it. Vectors are concatenated over the windows, from the first synchronisation on.
struct ContractRun {
  wire::Hello hello;
  wire::Description description;
  double window_size_s = 0;
  std::vector<double> first_output;   ///< of `initialized`
  std::vector<double> input, output;  ///< absolute link values, (windows + 1) x nodes x components
  std::vector<double> velocity, acceleration;
  std::vector<double> records;          ///< rows x record_columns
  std::vector<std::int64_t> forgotten;  ///< windows whose repeated trial differed from the first

  [[nodiscard]] bool implicit() const { return hello.role == name_of(Role::implicit_solver); }
  /// Numbers of one link vector.
  [[nodiscard]] std::size_t size() const { return description.interface_position_m.data.size(); }
  /// A record column, summed over bodies, at each row: "name" or "name/<body>". Empty if there is none.
  [[nodiscard]] std::vector<double> column(const std::string& name) const;
};

/// Runs the program through its windows to `finished`. The link input oscillates and grows over the windows, other in
/// each component; displacements are some 1e-6 of the interface's extent, forces of the size that moves the interface
/// masses so far in a window. Throws what ContractPeer throws, and ParticipantError if it ends with another exit code
/// than 0. `run` is filled as far as it went.
void run_contract(const ContractCommand& command, const ContractDrive& drive, ContractRun& run);

/// The first messages only: hello, welcome, describe, and what is wrong with the description (ProtocolError).
void describe(ContractPeer& peer, double timeout_s, ContractRun& run);

/// From `initialize` through the given number of windows.
void advance(ContractPeer& peer, const ContractDrive& drive, ContractRun& run);

}  // namespace ricochet::coupler

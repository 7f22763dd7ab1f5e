#pragma once

#include <string>
#include <vector>

#include "coupler/contract/contract_peer.hpp"
#include "coupler/watch/tried_causes.hpp"

namespace ricochet::coupler {

/// How a participant is driven in one run of the contract.
struct ContractDrive {
  int windows = 20;
  bool zero_input = false;   ///< link input 0 throughout
  bool try_first = false;    ///< each window: trial, trial with another input, the first trial again, accept
  int save_at = 0;           ///< another process goes on from what was saved at the end of this window; 0: none
  double window_size_s = 0;  ///< 0: half of its own critical time step, 1e-6 s if it needs none
  double begin_with_s = 0;   ///< windows so long are told at the start, the true size by `reconfigure`; 0: at once
  bool by_force = false;     ///< an explicit participant, too; with its own masses
  int substeps = 1;          ///< by force: steps in a window
  bool one_by_one = false;   ///< each substep is asked for by itself
  int fine = 1;              ///< the link input is that of windows so many times as long, linear in between
  bool as_explicit = false;  ///< an implicit participant integrates by central differences
  std::vector<double> interface_stiffness{};  ///< of an implicit participant, in its own rows
  std::vector<double> inputs{};  ///< link input, (windows + 1) x nodes x components, in place of the one made here
};

/// The outcome of a trial. Vectors are concatenated over the windows, from the first synchronisation on.
struct ContractRun {
  wire::Hello hello;
  wire::Description description;
  double window_size_s = 0;
  bool by_force = false;              ///< link input is a force, link output a motion
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

/// A clause that is not kept.
[[noreturn]] void fail(const std::string& text);

/// Runs the program through its windows to `finished`. The link input oscillates and grows over the windows, other in
/// each component; displacements are some 1e-6 of the interface's extent, forces of the size that moves the interface
/// masses so far in a window. Throws what ContractPeer throws, and ParticipantError if it ends with another exit code
/// than 0. `run` is filled as far as it went.
void run_contract(const ContractCommand& command, const ContractDrive& drive, ContractRun& run);

/// The first messages only: hello, welcome, describe, and what is wrong with the description (ProtocolError).
void describe(ContractPeer& peer, double timeout_s, ContractRun& run);

/// `initialize` and the first synchronisation.
void start(ContractPeer& peer, const ContractDrive& drive, ContractRun& run);

/// Link output, velocity and acceleration of the interface at the present time, of this absolute link input; velocity
/// and acceleration are empty of who is driven by displacement.
struct ContractAnswer {
  std::vector<double> output, velocity, acceleration;
};
ContractAnswer synchronise(ContractPeer& peer, const ContractRun& run, const std::vector<double>& input,
                           Integration integration);
/// The same at the end of a window, which is accepted or stays a trial; `input` at its end, `last` before it.
ContractAnswer try_window(ContractPeer& peer, const ContractRun& run, int window, const std::vector<double>& last,
                          const std::vector<double>& input, bool accept);

/// From `initialize` through the given number of windows.
void advance(ContractPeer& peer, const ContractDrive& drive, ContractRun& run);

}  // namespace ricochet::coupler

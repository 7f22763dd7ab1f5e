#pragma once

#include <string>
#include <vector>

#include "coupler/contract/contract_run.hpp"

namespace ricochet::coupler {

/// A clause that does not apply to this participant, and why.
struct NotApplicable {
  std::string why;
};

using Values = std::vector<double>;

/// Answers that differ by less, over the largest, are one.
constexpr double rounding = 1e-6;
/// The same of one that is not linear, whose windows may be solved to a tolerance, the same problem put in two ways.
constexpr double solved = 1e-3;

/// Throw NotApplicable.
void require_capability(const ContractRun& first, Capability capability, const std::string& who_needs_it);
void require_role(const ContractRun& first, Role role);
/// "interface node 3, component 1".
[[nodiscard]] std::string place(const ContractRun& run, std::size_t row);
/// Displacement of a unit response [m], or force [N], as the contract's link inputs are sized.
[[nodiscard]] double probe_size(const ContractRun& run, std::size_t row);

/// Clauses about how a participant answers its link, each with processes of its own. `first` is a run that went to its
/// end. They throw NotApplicable, or ProtocolError saying what is wrong; they return what is worth saying beside
/// "passed".

/// Answers to unit inputs: a symmetric matrix that is not negative, as K of an elastic body is and the mobility of one
/// driven by force. Wrong signs and rows in another order are not.
std::string respond_like_an_elastic_body(const ContractCommand& command, const ContractDrive& drive,
                                         const ContractRun& first);
/// Driven by force, a window of m steps ends like m windows of one step with the same, linear, link input.
std::string take_substeps(const ContractCommand& command, const ContractDrive& drive, const ContractRun& first);
/// Substeps that are asked for one by one end like a whole window.
std::string take_single_substeps(const ContractCommand& command, const ContractDrive& drive, const ContractRun& first);
/// A stiffness S on the interface gives the motion that the force S u gives.
std::string take_interface_stiffness(const ContractCommand& command, const ContractDrive& drive,
                                     const ContractRun& first);
/// By central differences displacements follow from what was before: u_n+1 = u_n + dt v_n + dt^2/2 a_n.
std::string switch_integration(const ContractCommand& command, const ContractDrive& drive, const ContractRun& first);
/// `read_state` tells what `load_state` was given, and a window is linear in state and link input.
std::string load_their_motion(const ContractCommand& command, const ContractDrive& drive, const ContractRun& first);

}  // namespace ricochet::coupler

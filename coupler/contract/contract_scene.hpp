#pragma once

#include <string>

#include "common/problem/problem.hpp"
#include "coupler/contract/contract_run.hpp"

namespace ricochet::coupler {

/// Clauses of a participant of a scene, beside the solver that is shipped for it. They throw ProtocolError or
/// ConfigError naming body, node, quantity and by how much, or NotApplicable, and return what is worth saying.
class ContractScene {
 public:
  /// `problem` must outlive it. ConfigError if the scene has no participant of that name.
  ContractScene(const scene::Problem& problem, const std::string& name);

  /// Command for the participant that is tested: `words`, or the scene's own program for it, with the arguments of a
  /// run.
  [[nodiscard]] std::vector<std::string> command(std::vector<std::string> words) const;
  /// Driven as the scene's protocol drives it.
  [[nodiscard]] ContractDrive drive(ContractDrive basis) const;

  /// Places and masses of its interface nodes.
  std::string declares_the_scene(const ContractCommand& command) const;
  /// Stiffness by a displacement, masses and substeps by a force.
  std::string answers_as_the_elements(const ContractCommand& command) const;
  /// Window by window.
  std::string computes_what_the_shipped_solver_does(const ContractCommand& command, const ContractDrive& drive) const;

 private:
  [[nodiscard]] PeerDescription description_of(const ContractRun& run) const;
  void require_no_difference() const;
  /// The scene has no elements of a foreign body, and no solver of ours computes it.
  void require_meshed_bodies() const;
  const scene::Problem& problem_;
  const scene::ParticipantSpec& participant_;
};

}  // namespace ricochet::coupler

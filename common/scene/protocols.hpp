#pragma once

#include <limits>
#include <string>
#include <vector>

#include "common/base/vocabulary.hpp"

namespace ricochet::scene {

/// How a protocol spreads a scene over participants.
enum class Layout {
  hybrid,        ///< explicit participants and one implicit participant, by the partition
  all_implicit,  ///< one implicit participant owns every element
  all_explicit,  ///< one explicit participant owns every element
};

/// Everything that is known of a coupling protocol but how it computes a window. A scene holds the row of its protocol,
/// and nobody looks one up by name after that.
struct ProtocolTraits {
  std::string name = "";
  Layout layout = Layout::hybrid;
  bool dual = false;          ///< duplicated nodes with own masses, tied by multipliers; explicit substeps
  bool own_substeps = false;  ///< explicit participants may take different numbers of substeps
  bool iterated = false;      ///< repeats a window until the interface agrees
  bool local_steps = false;   ///< elements that the window is too long for take several steps in it (fem::LocalSteps)
  bool massless_boundary = false;  ///< shared nodes may have no mass of the explicit side: bodies reduced to modes
  bool may_switch = false;         ///< goes on with an implicit participant that integrates explicitly after separation
  /// Momentum is exact with that many substeps or fewer; of an iterated one to its tolerance.
  int exact_up_to_substeps = std::numeric_limits<int>::max();
  std::vector<Capability> explicit_capabilities = {};  ///< every explicit participant must have them
  std::vector<Capability> implicit_capabilities = {};
  std::string trouble =
      "";  ///< goes on after "protocol NAME", said when the energy watch stops a run; empty: none known
  std::string warning = "";  ///< what `check` says of it; empty: nothing

  /// Baselines, where one participant owns everything and nothing is exchanged, are not.
  [[nodiscard]] bool coupled() const { return layout == Layout::hybrid; }
};

/// The one table of protocols.
[[nodiscard]] const std::vector<ProtocolTraits>& protocols();
[[nodiscard]] std::vector<std::string> protocol_names();
/// Throws ConfigError with the nearest known name for a name that is not in the table.
[[nodiscard]] const ProtocolTraits& protocol_traits(const std::string& name);

}  // namespace ricochet::scene

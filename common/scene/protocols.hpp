#pragma once

#include <string>
#include <vector>

namespace ricochet::scene {

/// How a protocol spreads a scene over participants.
enum class Layout {
  hybrid,        ///< explicit participants and one implicit participant, by the partition
  all_implicit,  ///< one implicit participant owns every element
  all_explicit,  ///< one explicit participant owns every element
};

/// What a scene has to know of a coupling protocol. A new protocol is one more row of `protocols()`.
struct ProtocolTraits {
  std::string name;
  Layout layout = Layout::hybrid;
  bool dual = false;    ///< duplicated nodes with own masses, tied by multipliers; explicit substeps
  bool may_switch = false;  ///< goes on with an implicit participant that integrates explicitly after separation
  std::string warning;      ///< what `check` says about it; empty: nothing
};
[[nodiscard]] const std::vector<ProtocolTraits>& protocols();
[[nodiscard]] std::vector<std::string> protocol_names();
/// Throws ConfigError for a name that is not in the table.
[[nodiscard]] const ProtocolTraits& protocol_traits(const std::string& name);

}  // namespace ricochet::scene

#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common/wire/message.hpp"

namespace ricochet::coupler {

/// The words of a participant on itself, under the name and in the role that the scene gives it.
struct PeerDescription : wire::Description {
  std::string participant;
  Role role = Role::explicit_solver;
  std::int64_t substeps = 0;  ///< of its windows, by the scene; 0: those of `initialize`
  std::vector<double>
      scene_position_m{};  ///< the scene's places of its interface nodes; empty: its own are the scene's
};

/// The other end of one link, wherever it runs: another process behind a socket, or an object in this one. At most one
/// message is under way: `post`, then `wait`.
struct Peer {
  std::string name;
  /// Sends; stamps the header fields version, run_id and sequence.
  std::function<void(wire::Message&)> post;
  /// The answer to the last `post`, valid until the next `wait`; its arrays may be taken away instead of copied. Throws
  /// if the peer fails, dies or is silent too long.
  std::function<wire::Message&()> wait;
};

}  // namespace ricochet::coupler

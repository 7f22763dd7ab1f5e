#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "coupler/protocols/coupling.hpp"
#include "coupler/protocols/settings.hpp"

namespace ricochet::coupler {

/// The numerics of coupling: what is exchanged when, and who waits. Symbols as in docs/words.md:
/// Gamma shared nodes (integrated by the implicit participant with the summed mass), P internal force of the explicit
/// elements, dt the window.
class Protocol {
 public:
  virtual ~Protocol() = default;
  /// Initialises all participants and synchronises them at t = 0. `request`: see Link::post_initialize.
  virtual void start(Coupling& coupling, const wire::Message& request) { coupling.initialize(request); }
  /// Computes and accepts the windows after `step.window` on every participant.
  virtual void step(Coupling& coupling, const Step& step) = 0;
  /// What is worth knowing after the run, for its summary; empty: nothing.
  [[nodiscard]] virtual std::string note() const { return ""; }
};

/// What the coupler knows of a protocol by name.
struct ProtocolEntry {
  std::string name;
  std::vector<std::string> explicit_capabilities;  ///< every explicit participant must have them
  std::vector<std::string> implicit_capabilities;
  bool coupled = true;        ///< false: baseline of one participant, nothing is exchanged
  std::string known_trouble;  ///< named when the energy watch stops a run; empty: none known
  std::function<std::unique_ptr<Protocol>(const ProtocolSettings&)> make;
};

/// The one list of protocols.
[[nodiscard]] const std::vector<ProtocolEntry>& protocols();
/// Throws ConfigError with the nearest known name.
[[nodiscard]] const ProtocolEntry& find_protocol(const std::string& name);
/// ConfigError naming the participant and the capability it lacks; `activity`: what it cannot take part in.
void require_capability(const wire::Message& description, const std::string& needed, const std::string& activity);
/// Refuses a participant that lacks what the protocol needs: ConfigError naming the participant, the capability and the
/// protocol. Coupled protocols also need exactly one implicit participant.
void check_capabilities(const ProtocolEntry& protocol, const std::vector<wire::Message>& descriptions);

}  // namespace ricochet::coupler

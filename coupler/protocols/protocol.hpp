#pragma once

#include <memory>
#include <string>
#include <vector>

#include "coupler/interface/coupling.hpp"
#include "coupler/protocols/settings.hpp"

namespace ricochet::coupler {

/// The numerics of coupling: what is exchanged when, and who waits. Symbols as in docs/words.md:
/// Gamma shared nodes (integrated by the implicit participant with the summed mass), P internal force of the explicit
/// elements, dt the window.
class Protocol {
 public:
  virtual ~Protocol() = default;
  /// Initialises all participants and synchronises them at t = 0. `request`: see Link::post_initialize.
  virtual void start(Coupling& coupling, const wire::Initialize& request) { coupling.initialize(request); }
  /// Between windows, where the coupling's clock has another size for the next one.
  virtual void reconfigure(Coupling& coupling) { coupling.reconfigure(); }
  /// Computes and accepts the windows after `step.accepted_window` on every participant.
  virtual void step(Coupling& coupling, const Step& step) = 0;
  /// Reads or writes what it goes on from between windows, beside the coupling and what `start` makes.
  virtual void archive(Archive& /*a*/) {}
  /// All that is worth knowing after the run, for its summary; empty: nothing.
  [[nodiscard]] virtual std::string note() const { return ""; }
};

/// The protocol of a name of the scene's table (common/scene/protocols.hpp). Throws std::invalid_argument for one that
/// is not here.
[[nodiscard]] std::unique_ptr<Protocol> make_protocol(const std::string& name, const ProtocolSettings& settings);
/// Names of the protocols that `make_protocol` knows.
[[nodiscard]] std::vector<std::string> implemented_protocols();

}  // namespace ricochet::coupler

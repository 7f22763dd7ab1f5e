#pragma once

#include <string>

#include "coupler/protocols/protocol.hpp"
#include "coupler/spectrum/spectral_radius.hpp"

namespace ricochet::coupler {

/// One window of a coupled scheme as a linear map of `Coupling::read_state`, scaled to energies, with the contact
/// frozen so: measured on the participants themselves, through the protocol itself. The arguments
/// must outlive the map, and the coupling must have been initialized.
[[nodiscard]] LinearMap window_map(Coupling& coupling, Protocol& protocol, FrozenContact frozen_contact);

}  // namespace ricochet::coupler

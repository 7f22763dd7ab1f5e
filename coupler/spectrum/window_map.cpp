#include "coupler/spectrum/window_map.hpp"

#include <vector>

namespace ricochet::coupler {

LinearMap window_map(Coupling& coupling, Protocol& protocol, FrozenContact frozen_contact) {
  std::vector<double> state, scale;
  coupling.read_state(state, scale);
  LinearMap map;
  map.size = static_cast<Eigen::Index>(state.size());
  map.load = [&coupling, state, scale, frozen_contact](const Eigen::VectorXd& x) mutable {
    for (std::size_t i = 0; i < state.size(); ++i) state[i] = x[static_cast<Eigen::Index>(i)] / scale[i];
    coupling.load_state(state, frozen_contact);
  };
  map.advance = [&coupling, &protocol](std::int64_t windows) {
    for (std::int64_t n = 0; n < windows; ++n) protocol.step(coupling, {.accepted_window = coupling.window()});
  };
  map.read = [&coupling, state, scale](Eigen::VectorXd& x) mutable {
    coupling.read_state(state, scale);
    x.resize(static_cast<Eigen::Index>(state.size()));
    for (std::size_t i = 0; i < state.size(); ++i) x[static_cast<Eigen::Index>(i)] = state[i] * scale[i];
  };
  return map;
}

}  // namespace ricochet::coupler

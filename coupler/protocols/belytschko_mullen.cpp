#include "coupler/protocols/belytschko_mullen.hpp"

#include "coupler/protocols/unit_response.hpp"

namespace ricochet::coupler {

void BelytschkoMullen::start(Coupling& coupling, const wire::Message& request) {
  coupling.initialize_explicit(request, Masses::summed);
  const auto size = static_cast<std::size_t>(coupling.map().nodes() * coupling.map().components());
  std::vector<double> stiffness(size * size, 0.0);
  for (auto& link : coupling.links()) {
    if (link.implicit()) continue;
    // Only the implicit participant knows the displacement at t = 0; K does not depend on it.
    const std::vector<double> zero(link.input().size(), 0.0), metre(link.input().size(), 1.0);
    link.post_synchronise("explicit_central", zero);
    link.wait_synchronised();
    const auto own = unit_response(link, Response::output, Step{}, metre);
    const auto dofs = link.rows().dofs();
    for (std::size_t i = 0; i < dofs.size(); ++i) {
      for (std::size_t j = 0; j < dofs.size(); ++j) stiffness[dofs[i] * size + dofs[j]] += own[i * dofs.size() + j];
    }
  }
  coupling.initialize_implicit(request, Masses::summed, stiffness);
  coupling.synchronise("implicit_newmark");
}

void BelytschkoMullen::step(Coupling& coupling, const Step& step) {
  Step trial = step;
  trial.absolute = trial.records = false;
  std::vector<double> force = coupling.advance_explicit(trial, coupling.displacement(), Acceptance::trial);
  coupling.subtract_stiffness_force(force);
  coupling.advance_implicit(step, force);
  coupling.advance_explicit(step, coupling.displacement(), Acceptance::at_once);
}

}  // namespace ricochet::coupler

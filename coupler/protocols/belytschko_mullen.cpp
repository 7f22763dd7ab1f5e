#include "coupler/protocols/belytschko_mullen.hpp"

#include "coupler/protocols/unit_response.hpp"

namespace ricochet::coupler {
namespace {

/// Displacement that is tried, in extents of the interface: small strains, which a body that is not linear has, too.
constexpr double probe_share = 1e-6;

}  // namespace

void BelytschkoMullen::start(Coupling& coupling, const wire::Initialize& request) {
  coupling.initialize_explicit(request, Masses::summed);
  const auto size = static_cast<Eigen::Index>(coupling.displacement().size());
  const double extent_m = coupling.map().extent_m();
  const double probe_m = probe_share * (extent_m > 0.0 ? extent_m : 1.0);  // one node in the origin has no extent
  Eigen::MatrixXd stiffness = Eigen::MatrixXd::Zero(size, size);
  for (auto& link : coupling.links()) {
    if (link.implicit()) continue;
    // Only the implicit participant knows the displacement at t = 0; K does not depend on it.
    const std::vector<double> zero(link.input().size(), 0.0), probes(link.input().size(), probe_m);
    link.post_synchronise(Integration::explicit_central, zero);
    link.wait_synchronised();
    link.rows().add_matrix(unit_response(link, Response::output, Step{}, probes), stiffness);
  }
  coupling.initialize_implicit(request, Masses::summed, stiffness);
  coupling.synchronise(Integration::implicit_newmark);
}

void BelytschkoMullen::step(Coupling& coupling, const Step& step) {
  Step trial = step;
  trial.absolute = trial.records = false;
  force_ = coupling.advance_explicit(trial, coupling.displacement(), Acceptance::trial);
  coupling.subtract_stiffness_force(force_);
  coupling.advance_implicit(step, force_);
  coupling.advance_explicit(step, coupling.displacement(), Acceptance::at_once);
}

}  // namespace ricochet::coupler

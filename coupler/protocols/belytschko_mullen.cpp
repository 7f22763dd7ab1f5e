#include "coupler/protocols/belytschko_mullen.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "common/base/error.hpp"
#include "coupler/protocols/unit_response.hpp"

namespace ricochet::coupler {
namespace {

/// Displacement that is tried, in extents of the interface: small strains, which a body that is not linear has, too.
constexpr double probe_share = 1e-6;
/// Of the largest force that a stiffness makes: rounding is far below, what is not linear soon above.
constexpr double linear_share = 1e-6;

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
  held_force_ = coupling.advance_explicit(trial, coupling.displacement(), Acceptance::trial);
  coupling.subtract_stiffness_force(held_force_);
  coupling.advance_implicit(step, held_force_);
  force_ = coupling.advance_explicit(step, coupling.displacement(), Acceptance::at_once);
  require_linear(coupling, step);
}

/// P_Gamma - K u_Gamma is what it was before the shared nodes moved.
void BelytschkoMullen::require_linear(const Coupling& coupling, const Step& step) {
  after_ = force_;
  coupling.subtract_stiffness_force(after_);
  double scale = 0.0, worst = 0.0;
  for (std::size_t i = 0; i < force_.size(); ++i) {
    scale = std::max({scale, std::abs(force_[i]), std::abs(after_[i]), std::abs(held_force_[i])});
    worst = std::max(worst, std::abs(after_[i] - held_force_[i]));
  }
  if (!(worst > linear_share * scale)) return;
  std::vector<std::string> names;
  for (const auto& link : coupling.links())
    if (!link.implicit()) names.push_back(fmt::format("'{}'", link.name()));
  throw ConfigError(fmt::format(
      "window {}: explicit elements, of participant {}, do not answer the shared nodes' displacement linearly: found a "
      "force that is {:.3g} N from the expected one, of forces up to {:.3g} N; allowed: {}",
      step.accepted_window + 1, fmt::join(names, " or "), worst, scale, linear_bodies_are_needed(false)));
}

}  // namespace ricochet::coupler

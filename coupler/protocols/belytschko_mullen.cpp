#include "coupler/protocols/belytschko_mullen.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "common/base/archive.hpp"
#include "common/base/error.hpp"
#include "coupler/interface/vectors.hpp"
#include "coupler/protocols/unit_response.hpp"

namespace ricochet::coupler {
namespace {

double sum_of_magnitudes(const Eigen::VectorXd& weights, const std::vector<double>& values) {
  return weights.cwiseAbs().dot(view(values).cwiseAbs());
}

/// Displacement that is tried, in extents of the interface: small strains, which a body that is not linear has, too.
constexpr double probe_share = 1e-6;
/// Share of the largest force so far: an error of the interface that shows in results.
constexpr double linear_tolerance = 1e-3;
/// Share of the terms of K u, which cancel where a body moves as a whole: far above what rounding leaves.
constexpr double rounding = 1e-9;

/// Share of the largest answer: rounding in a moving body is below it, the effect of another window far above.
constexpr double same_answer = 1e-6;

/// Weights of which no two are alike and none is small.
Eigen::VectorXd different_weights(Eigen::Index count) {
  return Eigen::VectorXd::LinSpaced(count, 1.0, 2.0)
      .cwiseProduct(Eigen::VectorXd::NullaryExpr(count, [](Eigen::Index i) { return i % 3 == 1 ? -1.0 : 1.0; }));
}

}  // namespace

void BelytschkoMullen::start(Coupling& coupling, const wire::Initialize& request) {
  coupling.initialize_explicit(request, Masses::summed);
  const double extent_m = coupling.map().extent_m();
  probe_m_ = probe_share * (extent_m > 0.0 ? extent_m : 1.0);  // one node in the origin has no extent
  for (auto& link : coupling.links()) {
    if (link.implicit()) continue;
    // Only the implicit participant knows the displacement at t = 0; K does not depend on it.
    link.post_synchronise(Integration::explicit_central, std::vector<double>(link.input().size(), 0.0));
    link.wait_synchronised();
  }
  coupling.initialize_implicit(request, Masses::summed, measure(coupling, Step{}));
  coupling.synchronise(Integration::implicit_newmark);
}

/// K of all explicit participants, by unit responses.
Eigen::MatrixXd BelytschkoMullen::measure(Coupling& coupling, const Step& step) {
  const auto size = static_cast<Eigen::Index>(coupling.displacement().size());
  Eigen::MatrixXd stiffness = Eigen::MatrixXd::Zero(size, size);
  sums_.resize(coupling.links().size());
  for (std::size_t l = 0; l < sums_.size(); ++l) {
    auto& link = coupling.links()[l];
    if (link.implicit()) continue;
    const std::vector<double> probes(link.input().size(), probe_m_);
    const Eigen::MatrixXd own = unit_response(link, Response::output, step, probes);
    link.rows().add_matrix(own, stiffness);
    sums_[l].weights = different_weights(own.rows());
    sums_[l].row = own * sums_[l].weights;
  }
  return stiffness;
}

/// By one motion of all shared nodes.
bool BelytschkoMullen::answer_as_before(Coupling& coupling, const Step& step) {
  for (std::size_t l = 0; l < sums_.size(); ++l) {
    auto& link = coupling.links()[l];
    const auto& sum = sums_[l];
    if (sum.row.size() == 0) continue;
    const std::vector<double> still = link.input(), pushed = to_vector(view(still) + probe_m_ * sum.weights);
    Eigen::VectorXd moved = trial_answer(link, Response::output, step, pushed);
    moved -= trial_answer(link, Response::output, step, still);
    const Eigen::VectorXd expected = probe_m_ * sum.row;
    if ((moved - expected).cwiseAbs().maxCoeff() > same_answer * expected.cwiseAbs().maxCoeff()) return false;
  }
  return true;
}

void BelytschkoMullen::reconfigure(Coupling& coupling) {
  coupling.reconfigure_explicit();
  const Step step{.accepted_window = coupling.window()};
  coupling.reconfigure_implicit(answer_as_before(coupling, step) ? coupling.interface_stiffness()
                                                                 : measure(coupling, step));
}

void BelytschkoMullen::step(Coupling& coupling, const Step& step) {
  Step trial = step;
  trial.absolute = trial.records = false;
  force_ = coupling.advance_explicit(trial, coupling.displacement(), Acceptance::trial);
  note_first_answers(coupling);
  coupling.subtract_stiffness_force(force_);
  coupling.advance_implicit(step, force_);
  coupling.advance_explicit(step, coupling.displacement(), Acceptance::at_once);
  require_linear(coupling, step);
}

void BelytschkoMullen::archive(Archive& a) {
  for (auto& sum : sums_) {
    a.same_size(sum.row);
    a(sum.largest);
  }
}

void BelytschkoMullen::note_first_answers(const Coupling& coupling) {
  for (std::size_t l = 0; l < sums_.size(); ++l) {
    auto& sum = sums_[l];
    if (sum.row.size() == 0) continue;
    const auto& link = coupling.links()[l];
    link.rows().gather(coupling.displacement(), motion_);
    sum.of_input = sum.row.dot(view(motion_));
    sum.of_output = sum.weights.dot(view(link.output()));
    sum.largest = std::max(sum.largest, sum_of_magnitudes(sum.weights, link.output()));
  }
}

void BelytschkoMullen::require_linear(const Coupling& coupling, const Step& step) {
  for (std::size_t l = 0; l < sums_.size(); ++l) {
    auto& sum = sums_[l];
    if (sum.row.size() == 0) continue;
    const auto& link = coupling.links()[l];
    sum.largest = std::max(sum.largest, sum_of_magnitudes(sum.weights, link.output()));
    link.rows().gather(coupling.displacement(), motion_);
    const double expected = sum.row.dot(view(motion_)) - sum.of_input;
    const double off = std::abs(sum.weights.dot(view(link.output())) - sum.of_output - expected);
    const double rounded = rounding * sum_of_magnitudes(sum.row, motion_);
    if (!(off > linear_tolerance * sum.largest + rounded)) continue;  // the energy watch says what is not finite
    throw ConfigError(fmt::format(
        "participant '{}' is not linear any more: in window {} its force changed with the shared nodes by {:.3g} of "
        "its largest force otherwise than at the start, where {:g} may be rounding; allowed: {}",
        link.name(), step.accepted_window + 1, off / sum.largest, linear_tolerance, linear_bodies_are_needed(false)));
  }
}

}  // namespace ricochet::coupler

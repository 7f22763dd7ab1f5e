#include "coupler/protocols/fixed_point.hpp"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <stdexcept>

#include "common/base/error.hpp"
#include "coupler/interface/vectors.hpp"

namespace ricochet::coupler {
namespace {

/// Columns whose share in the fit is below this are rounding.
constexpr double rank_tolerance = 1e-8;
/// Share of a displacement: in balance nothing moves, and no residual is smaller than this.
constexpr double round_off = 1e-15;

Eigen::MatrixXd newest_first(const std::vector<Eigen::VectorXd>& columns, Eigen::Index rows) {
  Eigen::MatrixXd matrix(rows, static_cast<Eigen::Index>(columns.size()));
  for (std::size_t k = 0; k < columns.size(); ++k) {
    matrix.col(static_cast<Eigen::Index>(k)) = columns[columns.size() - 1 - k];
  }
  return matrix;
}

}  // namespace

FixedPoint::FixedPoint(const ProtocolSettings& settings) : settings_(settings) {
  if (settings.acceleration == "constant") {
    accelerate_ = &FixedPoint::relax;
  } else if (settings.acceleration == "aitken") {
    accelerate_ = &FixedPoint::relax_aitken;
  } else if (settings.acceleration == "iqn_ils") {
    accelerate_ = &FixedPoint::quasi_newton;
  } else {
    throw std::invalid_argument("acceleration \"" + settings.acceleration + "\"");
  }
}

void FixedPoint::step(Coupling& coupling, const Step& step) {
  Step trial = step;
  trial.records = false;
  const Vector start = view(coupling.displacement());
  Vector u = view(coupling.predicted(coupling.beta()));
  std::vector<double> tried(coupling.displacement().size());
  for (int iteration = 1; iteration <= settings_.max_iterations; ++iteration) {
    Eigen::Map<Vector>(tried.data(), u.size()) = u;
    const auto& force = coupling.advance_explicit(trial, tried, Acceptance::trial);
    coupling.advance_implicit(trial, force, Acceptance::trial);
    const Vector answer = view(coupling.displacement()), residual = answer - u;
    scale_ = std::max(scale_, (answer - start).norm());
    if (residual.norm() <= std::max(settings_.tolerance * scale_, round_off * answer.norm())) {
      coupling.accept(step);
      ++windows_;
      iterations_ += iteration;
      most_ = std::max<std::int64_t>(most_, iteration);
      return;
    }
    (this->*accelerate_)(residual, answer, iteration == 1, u);
  }
  throw SolverError(fmt::format(
      "window {}: fixed_point has not converged to coupling.tolerance = {} in coupling.max_iterations = {} iterations; "
      "use acceleration = \"iqn_ils\", a smaller relaxation or a smaller step",
      step.accepted_window + 1, settings_.tolerance, settings_.max_iterations));
}

void FixedPoint::relax(const Vector& residual, const Vector& /*answer*/, bool /*first*/, Vector& u) {
  u += settings_.relaxation * residual;
}

void FixedPoint::relax_aitken(const Vector& residual, const Vector& /*answer*/, bool first, Vector& u) {
  if (first) {
    relaxation_ = settings_.relaxation;
  } else {
    const Vector change = residual - last_residual_;
    relaxation_ *= -last_residual_.dot(change) / change.squaredNorm();
  }
  last_residual_ = residual;
  u += relaxation_ * residual;
}

void FixedPoint::quasi_newton(const Vector& residual, const Vector& answer, bool first, Vector& u) {
  if (first) {
    const auto old = static_cast<std::ptrdiff_t>(residual_differences_.size() - of_this_window_);
    residual_differences_.erase(residual_differences_.begin(), residual_differences_.begin() + old);
    answer_differences_.erase(answer_differences_.begin(), answer_differences_.begin() + old);
    of_this_window_ = 0;
  } else {
    residual_differences_.push_back(residual - last_residual_);
    answer_differences_.push_back(answer - last_answer_);
    ++of_this_window_;
  }
  last_residual_ = residual;
  last_answer_ = answer;
  if (residual_differences_.empty()) {
    u += settings_.relaxation * residual;
    return;
  }
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> fit;
  fit.setThreshold(rank_tolerance);
  fit.compute(newest_first(residual_differences_, residual.size()));
  const Vector weights = fit.solve(-residual);
  u = answer + newest_first(answer_differences_, residual.size()) * weights;
}

std::string FixedPoint::note() const {
  if (windows_ == 0) return "";
  return fmt::format("fixed_point: {:.2f} iterations a window, at most {}",
                     static_cast<double>(iterations_) / static_cast<double>(windows_), most_);
}

}  // namespace ricochet::coupler

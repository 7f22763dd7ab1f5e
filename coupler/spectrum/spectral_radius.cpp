#include "coupler/spectrum/spectral_radius.hpp"

#include <Spectra/GenEigsSolver.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

namespace ricochet::coupler {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr Index largest_exact = 600;
constexpr std::int64_t most_windows = 10'000;
constexpr std::int64_t windows_per_sample = 25;
/// Amplification of the fastest mode over the random start at which it is taken to be alone.
constexpr double alone = 1e8;
constexpr Index krylov_dimension = 40;
constexpr Index most_restarts = 25;
constexpr double arnoldi_tolerance = 1e-9;

/// The same start on every run and platform (a multiplicative congruential generator).
VectorXd random_start(Index size) {
  VectorXd x(size);
  std::uint64_t state = 1;
  for (Index i = 0; i < size; ++i) {
    state = state * 48271 % 2147483647;
    x[i] = static_cast<double>(state) / 2147483647.0 - 0.5;
  }
  return x.normalized();
}

struct Sample {
  double window, log_size;
};

/// Slope of the line through the second half of the samples, by least squares.
double slope_of_second_half(const std::vector<Sample>& samples) {
  const auto first = samples.begin() + static_cast<std::ptrdiff_t>(samples.size() / 2);
  const auto count = static_cast<double>(samples.end() - first);
  double mean_window = 0.0, mean_log = 0.0, covariance = 0.0, variance = 0.0;
  for (auto s = first; s != samples.end(); ++s) {
    mean_window += s->window / count;
    mean_log += s->log_size / count;
  }
  for (auto s = first; s != samples.end(); ++s) {
    covariance += (s->window - mean_window) * (s->log_size - mean_log);
    variance += (s->window - mean_window) * (s->window - mean_window);
  }
  return covariance / variance;
}

struct Growth {
  double per_window = 0.0;  ///< of the logarithm
  double resolution = 0.0;
  std::int64_t windows = 0;
  VectorXd direction;  ///< the last x_{n+1} - x_n, of length 1
};

Growth measure_growth(const LinearMap& map) {
  const double hidden = 0.5 * std::log(static_cast<double>(map.size));  // ln(sqrt N)
  std::vector<Sample> samples;
  Growth growth;
  VectorXd before, after;
  double log_scale = 0.0;
  map.load(random_start(map.size));
  while (growth.windows < most_windows) {
    map.advance(windows_per_sample - 1);
    map.read(before);
    map.advance(1);
    map.read(after);
    growth.windows += windows_per_sample;
    growth.direction = after - before;
    const double size = growth.direction.norm();
    if (!(size > 0.0)) return growth;  // everything has died out
    samples.push_back({static_cast<double>(growth.windows), std::log(size) + log_scale});
    growth.direction /= size;
    growth.resolution = hidden / static_cast<double>(growth.windows);
    if (samples.size() > 3) growth.per_window = slope_of_second_half(samples);
    const double risen = samples.back().log_size - samples.front().log_size;
    if (samples.size() > 3 && risen > std::log(alone) + hidden) break;
    const double length = after.norm();
    if (length < 1e30) continue;
    map.load(after / length);
    log_scale += std::log(length);
  }
  return growth;
}

/// The map as Spectra wants it.
class Operation {
 public:
  using Scalar = double;
  explicit Operation(const LinearMap& map) : map_(&map) {}
  [[nodiscard]] Index rows() const { return map_->size; }
  [[nodiscard]] Index cols() const { return map_->size; }
  void perform_op(const double* x_in, double* y_out) const {
    map_->load(Eigen::Map<const VectorXd>(x_in, map_->size));
    map_->advance(1);
    map_->read(y_);
    Eigen::Map<VectorXd>(y_out, map_->size) = y_;
  }

 private:
  const LinearMap* map_;
  mutable VectorXd y_;
};

std::optional<double> arnoldi(const LinearMap& map, const VectorXd& start, std::int64_t& windows) {
  Operation operation(map);
  Spectra::GenEigsSolver<Operation> solver(operation, 1, std::min(krylov_dimension, map.size));
  solver.init(start.data());
  const Index converged = solver.compute(Spectra::SortRule::LargestMagn, most_restarts, arnoldi_tolerance);
  windows += solver.num_operations();
  if (converged < 1) return {};
  return solver.eigenvalues().cwiseAbs().maxCoeff();
}

}  // namespace

SpectralRadius exact_spectral_radius(const LinearMap& map) {
  Eigen::MatrixXd matrix(map.size, map.size);
  VectorXd column;
  for (Index i = 0; i < map.size; ++i) {
    map.load(VectorXd::Unit(map.size, i));
    map.advance(1);
    map.read(column);
    matrix.col(i) = column;
  }
  const Eigen::EigenSolver<Eigen::MatrixXd> solver(matrix, false);
  const VectorXd x = random_start(map.size);
  map.load(x);
  map.advance(1);
  map.read(column);
  const double norm = matrix.operatorNorm(), defect = (column - matrix * x).norm();
  const double perturbation = std::max(defect, std::numeric_limits<double>::epsilon() * norm);
  return {solver.eigenvalues().cwiseAbs().maxCoeff(), 10.0 * std::sqrt(norm * perturbation), "exact", map.size,
          map.size + 1};
}

SpectralRadius iterated_spectral_radius(const LinearMap& map) {
  const Growth growth = measure_growth(map);
  SpectralRadius result{std::exp(growth.per_window), growth.resolution, "growth", map.size, growth.windows};
  if (result.stable()) return result;
  if (const auto value = arnoldi(map, growth.direction, result.windows); value && *value - 1.0 > result.resolution) {
    result.value = *value;
    result.method = "Arnoldi";
  }
  return result;
}

SpectralRadius spectral_radius(const LinearMap& map) {
  return map.size <= largest_exact ? exact_spectral_radius(map) : iterated_spectral_radius(map);
}

}  // namespace ricochet::coupler

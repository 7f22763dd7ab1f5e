#include "coupler/spectrum/spectral_radius.hpp"

#include <arpack/arpack.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <vector>

extern "C" {
// LAPACK: eigenvalues of a matrix, singular values of a matrix. Both overwrite it.
void dgeev_(const char* left, const char* right, const int* n, double* a, const int* stride, double* real,
            double* imaginary, double* left_vectors, const int* left_stride, double* right_vectors,
            const int* right_stride, double* work, const int* work_size, int* info);
void dgesvd_(const char* left, const char* right, const int* rows, const int* columns, double* a, const int* stride,
             double* values, double* left_vectors, const int* left_stride, double* right_vectors,
             const int* right_stride, double* work, const int* work_size, int* info);
}

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
    if (!(size > 0.0)) {  // everything has died out
      growth.resolution = 0.0;
      return growth;
    }
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

/// Largest |eigenvalue| by ARPACK's implicitly restarted Arnoldi method, which asks for products with the map; none if
/// it has not converged after `most_restarts`.
std::optional<double> arnoldi(const LinearMap& map, VectorXd start, std::int64_t& windows) {
  const int size = static_cast<int>(map.size), basis = static_cast<int>(std::min(krylov_dimension, map.size));
  const int work_size = 3 * basis * (basis + 2);
  int wanted = 1, request = 0, info = 1;  // 1: begin with `start`
  int settings[11] = {1, 0, most_restarts, 1, 0, 0, 1, 0, 0, 0, 0}, places[14] = {};
  VectorXd vectors(size * basis), work(work_size), ends(3 * size), y;
  while (true) {
    dnaupd_c(&request, "I", size, "LM", wanted, arnoldi_tolerance, start.data(), basis, vectors.data(), size, settings,
             places, ends.data(), work.data(), work_size, &info);
    if (request != 1 && request != -1) break;
    map.load(ends.segment(places[0] - 1, size));
    map.advance(1);
    map.read(y);
    ends.segment(places[1] - 1, size) = y;
    ++windows;
  }
  if (info != 0 || settings[4] < wanted) return {};
  const auto ritz = [&](int at) { return work.segment(at - 1, basis); };  // places 6 and 7: real and imaginary parts
  const VectorXd error = ritz(places[7]);
  double largest = 0.0;
  for (Index i = 0; i < basis; ++i) {
    const double value = std::hypot(ritz(places[5])[i], ritz(places[6])[i]);
    if (std::abs(error[i]) <= arnoldi_tolerance * value) largest = std::max(largest, value);
  }
  return largest;
}

/// Largest |eigenvalue| of a matrix.
double largest_eigenvalue_of(Eigen::MatrixXd matrix) {
  const int n = static_cast<int>(matrix.rows()), one = 1, work_size = 34 * n;
  VectorXd real(n), imaginary(n), work(work_size);
  int info = 0;
  dgeev_("N", "N", &n, matrix.data(), &n, real.data(), imaginary.data(), nullptr, &one, nullptr, &one, work.data(),
         &work_size, &info);
  if (info != 0) throw std::runtime_error("LAPACK's dgeev finds no eigenvalues of the map of one window");
  return (real.array().square() + imaginary.array().square()).sqrt().maxCoeff();
}

/// max |A x| / |x|, the largest singular value.
double operator_norm_of(Eigen::MatrixXd matrix) {
  const int n = static_cast<int>(matrix.rows()), one = 1, work_size = 66 * n;
  VectorXd values(n), work(work_size);
  int info = 0;
  dgesvd_("N", "N", &n, &n, matrix.data(), &n, values.data(), nullptr, &one, nullptr, &one, work.data(), &work_size,
          &info);
  if (info != 0) throw std::runtime_error("LAPACK's dgesvd finds no singular values of the map of one window");
  return values[0];
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
  const VectorXd x = random_start(map.size);
  map.load(x);
  map.advance(1);
  map.read(column);
  const double norm = operator_norm_of(matrix), defect = (column - matrix * x).norm();
  const double perturbation = std::max(defect, std::numeric_limits<double>::epsilon() * norm);
  return {largest_eigenvalue_of(matrix), 10.0 * std::sqrt(norm * perturbation), "exact", map.size, map.size + 1};
}

SpectralRadius iterated_spectral_radius(const LinearMap& map) {
  const Growth growth = measure_growth(map);
  SpectralRadius result{std::exp(growth.per_window), growth.resolution, "growth", map.size, growth.windows};
  if (!result.grows()) return result;
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

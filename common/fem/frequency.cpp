#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>

#include "common/base/error.hpp"
#include "common/fem/part.hpp"
#include "common/fem/stiffness_product.hpp"

namespace ricochet::fem {
namespace {

/// M^-1/2 per dof, zero on fixed dofs, which takes them out of the eigenproblem.
Eigen::VectorXd inverse_root_mass(const Eigen::VectorXd& mass, int dofs_per_node, const std::vector<bool>& fixed_dof) {
  Eigen::VectorXd scale = Eigen::VectorXd::Zero(mass.size() * dofs_per_node);
  for (Eigen::Index i = 0; i < scale.size(); ++i) {
    if (fixed_dof[static_cast<std::size_t>(i)]) continue;
    const double m = mass[i / dofs_per_node];
    if (!(m > 0.0)) throw std::invalid_argument(fmt::format("node {} has no mass", i / dofs_per_node));
    scale[i] = 1.0 / std::sqrt(m);
  }
  return scale;
}

/// The same start on every run and platform, with a share of every mode (a multiplicative congruential generator).
Eigen::VectorXd start_vector(const Eigen::VectorXd& scale) {
  Eigen::VectorXd v(scale.size());
  std::uint64_t state = 1;
  for (Eigen::Index i = 0; i < v.size(); ++i) {
    state = state * 48271 % 2147483647;
    v[i] = scale[i] > 0.0 ? static_cast<double>(state) / 2147483647.0 - 0.5 : 0.0;
  }
  return v.normalized();
}

/// Tridiagonal matrix T of the Lanczos recursion.
struct Tridiagonal {
  std::vector<double> diagonal;
  std::vector<double> beside;  ///< as long as the diagonal; the last entry couples to the next, not yet made, vector
};

/// Pivots of the L D L^T of T - shift; all negative exactly if the shift lies above the spectrum.
bool factor_above_spectrum(const Tridiagonal& t, double shift, std::vector<double>& pivot) {
  pivot.resize(t.diagonal.size());
  for (std::size_t i = 0; i < pivot.size(); ++i) {
    pivot[i] = t.diagonal[i] - shift - (i == 0 ? 0.0 : t.beside[i - 1] * t.beside[i - 1] / pivot[i - 1]);
    if (!(pivot[i] < 0.0)) return false;
  }
  return true;
}

struct Bracket {
  double below, above;
};

/// The largest eigenvalue to round-off, by bisection between the largest diagonal entry and Gershgorin's bound.
Bracket bracket_largest_eigenvalue(const Tridiagonal& t) {
  Bracket bracket{t.diagonal[0], t.diagonal[0]};
  for (std::size_t i = 0; i < t.diagonal.size(); ++i) {
    const double reach = (i > 0 ? t.beside[i - 1] : 0.0) + (i + 1 < t.diagonal.size() ? t.beside[i] : 0.0);
    bracket.below = std::max(bracket.below, t.diagonal[i]);
    bracket.above = std::max(bracket.above, (t.diagonal[i] + reach) * (1.0 + 1e-14));
  }
  std::vector<double> pivot;
  for (;;) {
    const double middle = 0.5 * (bracket.below + bracket.above);
    if (!(bracket.below < middle && middle < bracket.above)) return bracket;
    (factor_above_spectrum(t, middle, pivot) ? bracket.above : bracket.below) = middle;
  }
}

/// Last component of the unit eigenvector of the largest eigenvalue, by inverse iteration with a shift just above it:
/// T - shift is negative definite, so its L D L^T needs no pivoting.
double last_component(const Tridiagonal& t, double shift) {
  std::vector<double> pivot;
  factor_above_spectrum(t, shift, pivot);
  const std::size_t size = pivot.size();
  Eigen::VectorXd y = Eigen::VectorXd::Ones(static_cast<Eigen::Index>(size));
  const auto at = [&y](std::size_t i) -> double& { return y[static_cast<Eigen::Index>(i)]; };
  for (int iteration = 0; iteration < 3; ++iteration) {
    for (std::size_t i = 1; i < size; ++i) at(i) -= t.beside[i - 1] / pivot[i - 1] * at(i - 1);
    for (std::size_t i = 0; i < size; ++i) at(i) /= pivot[i];
    for (std::size_t i = size - 1; i-- > 0;) at(i) -= t.beside[i] / pivot[i] * at(i + 1);
    y.normalize();
  }
  return std::abs(at(size - 1));
}

}  // namespace

// Lanczos without reorthogonalisation: lost orthogonality only repeats Ritz values that have converged already, which
// leaves the largest one right (Paige 1976), and three vectors are all it stores. With theta the largest Ritz value and
// s its vector in the Krylov basis, an eigenvalue lies within beta_k |s_k| of theta: the stopping test.
double max_frequency_squared(const SparseMatrix& stiffness, const Eigen::VectorXd& mass, int components,
                             const std::vector<bool>& fixed_dof, double tolerance, double rough) {
  constexpr double cheap_rows = 2e7;
  const Eigen::VectorXd scale = inverse_root_mass(mass, components, fixed_dof);
  if (scale.isZero(0.0)) return 0.0;
  const StiffnessProduct product(stiffness, components);  // several times faster than Eigen's
  const Eigen::Index limit = 10 * scale.size() + 100;
  Eigen::VectorXd v = start_vector(scale), previous = Eigen::VectorXd::Zero(v.size()), w(v.size()), scaled(v.size());
  Tridiagonal t;
  double beta = 0.0;
  for (Eigen::Index k = 1, check = 1; k <= limit; ++k) {
    scaled = scale.cwiseProduct(v);
    product.multiply(scaled, w);
    w = scale.cwiseProduct(w) - beta * previous;
    const double alpha = v.dot(w);
    w -= alpha * v;
    beta = w.norm();
    t.diagonal.push_back(alpha);
    t.beside.push_back(beta);
    if (!std::isfinite(beta)) throw SolverError("the largest frequency is not finite: stiffness or mass is not");
    const bool invariant = beta <= std::numeric_limits<double>::epsilon() * std::abs(alpha);
    if (k == check || invariant) {
      const auto [below, above] = bracket_largest_eigenvalue(t);
      const bool cheap = static_cast<double>(k) * static_cast<double>(v.size()) < cheap_rows;
      const double enough = cheap ? tolerance : std::max(tolerance, rough);
      if (invariant || beta * last_component(t, above) <= enough * below) return std::max(below, 0.0);
      check = k + std::max<Eigen::Index>(5, k / 10);
    }
    previous.swap(v);
    v = w / beta;
  }
  throw SolverError(fmt::format("Lanczos found no largest frequency to {} in {} steps", tolerance, limit));
}

}  // namespace ricochet::fem

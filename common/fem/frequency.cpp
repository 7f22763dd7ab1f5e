#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <utility>

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

/// Lanczos on M^-1/2 K M^-1/2 without reorthogonalisation: lost orthogonality only repeats Ritz values that have
/// converged already, which leaves the largest one right (Paige 1976), and three vectors are all it stores.
class Lanczos {
 public:
  Lanczos(TimesStiffness product, const Eigen::VectorXd& mass, int components, const std::vector<bool>& fixed_dof)
      : product_(std::move(product)), scale_(inverse_root_mass(mass, components, fixed_dof)) {
    if (none_free()) return;
    v_ = start_vector(scale_);
    previous_ = Eigen::VectorXd::Zero(v_.size());
    w_.resize(v_.size());
    scaled_.resize(v_.size());
  }

  [[nodiscard]] bool none_free() const { return scale_.isZero(0.0); }
  [[nodiscard]] Eigen::Index unknowns() const { return scale_.size(); }

  /// False if nothing is left to look for: the vectors so far are an invariant space.
  bool step() {
    if (!t_.diagonal.empty()) {
      previous_.swap(v_);
      v_ = w_ / beta_;
    }
    scaled_ = scale_.cwiseProduct(v_);
    product_(scaled_, w_);
    w_ = scale_.cwiseProduct(w_) - beta_ * previous_;
    const double alpha = v_.dot(w_);
    w_ -= alpha * v_;
    beta_ = w_.norm();
    t_.diagonal.push_back(alpha);
    t_.beside.push_back(beta_);
    if (!std::isfinite(beta_)) throw SolverError("the largest frequency is not finite: stiffness or mass is not");
    return beta_ > std::numeric_limits<double>::epsilon() * std::abs(alpha);
  }

  /// The largest Ritz value, never above the largest eigenvalue but for rounding.
  [[nodiscard]] Bracket largest() const { return bracket_largest_eigenvalue(t_); }
  /// Error of that value, `above`: within it lies an eigenvalue, beta_k |s_k| with s its vector in the Krylov basis.
  [[nodiscard]] double uncertainty(double above) const { return beta_ * last_component(t_, above); }

 private:
  TimesStiffness product_;
  Eigen::VectorXd scale_, v_, previous_, w_, scaled_;
  Tridiagonal t_;
  double beta_ = 0.0;
};

TimesStiffness times(const StiffnessProduct& product) {
  return [&product](const Eigen::VectorXd& u, Eigen::VectorXd& force) { product.multiply(u, force); };
}

}  // namespace

double max_frequency_squared(const SparseMatrix& stiffness, const Eigen::VectorXd& mass, int components,
                             const std::vector<bool>& fixed_dof, double tolerance, double rough) {
  const StiffnessProduct product(stiffness, components);  // several times faster than Eigen's
  return max_frequency_squared(times(product), mass, components, fixed_dof, tolerance, rough);
}

double max_frequency_squared(const TimesStiffness& product, const Eigen::VectorXd& mass, int components,
                             const std::vector<bool>& fixed_dof, double tolerance, double rough) {
  constexpr double cheap_rows = 2e7;
  Lanczos lanczos(product, mass, components, fixed_dof);
  if (lanczos.none_free()) return 0.0;
  const Eigen::Index limit = 10 * lanczos.unknowns() + 100;
  for (Eigen::Index k = 1, check = 1; k <= limit; ++k) {
    const bool invariant = !lanczos.step();
    if (k != check && !invariant) continue;
    const auto [below, above] = lanczos.largest();
    const bool cheap = static_cast<double>(k) * static_cast<double>(lanczos.unknowns()) < cheap_rows;
    const double enough = cheap ? tolerance : std::max(tolerance, rough);
    if (invariant || lanczos.uncertainty(above) <= enough * below) return std::max(below, 0.0);
    check = k + std::max<Eigen::Index>(5, k / 10);
  }
  throw SolverError(fmt::format("Lanczos found no largest frequency to {} in {} steps", tolerance, limit));
}

double frequency_squared_at_least(const StiffnessProduct& stiffness, const Eigen::VectorXd& mass, int components,
                                  const std::vector<bool>& fixed_dof, int products) {
  return frequency_squared_at_least(times(stiffness), mass, components, fixed_dof, products);
}

double frequency_squared_at_least(const TimesStiffness& stiffness, const Eigen::VectorXd& mass, int components,
                                  const std::vector<bool>& fixed_dof, int products) {
  Lanczos lanczos(stiffness, mass, components, fixed_dof);
  if (lanczos.none_free()) return 0.0;
  for (int k = 1; k <= products && lanczos.step(); ++k) continue;
  return std::max(lanczos.largest().below, 0.0);
}

}  // namespace ricochet::fem

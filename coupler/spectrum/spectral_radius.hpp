#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <string>

namespace ricochet::coupler {

/// A linear map x -> T x that is applied where it lives: load x, advance, read. Numbers are scaled so that |x|^2 is an
/// energy.
struct LinearMap {
  Eigen::Index size = 0;
  std::function<void(const Eigen::VectorXd&)> load;
  std::function<void(std::int64_t windows)> advance;
  std::function<void(Eigen::VectorXd&)> read;
};

/// Largest modulus of the eigenvalues of T, and what it is worth.
struct SpectralRadius {
  double value = 0.0;
  double resolution = 0.0;  ///< a growth per window below this cannot be told from none
  std::string method;       ///< "exact" | "Arnoldi" | "growth"
  Eigen::Index unknowns = 0;
  std::int64_t windows = 0;  ///< applications of T it took
  [[nodiscard]] double growth() const { return value - 1.0; }
  /// With a coarser resolution nothing is said of a scheme that does not grow: thousands of windows are to follow.
  static constexpr double coarsest_resolution = 0.01;
  [[nodiscard]] bool grows() const { return growth() > resolution; }
  [[nodiscard]] bool known() const { return grows() || resolution <= coarsest_resolution; }
  [[nodiscard]] bool stable() const { return known() && !grows(); }
  [[nodiscard]] const char* verdict() const { return !known() ? "unknown" : grows() ? "unstable" : "stable"; }
};

/// T column by column, then all eigenvalues. A stable scheme has every eigenvalue on the unit circle, and rigid motion
/// a 2 x 2 Jordan block at 1. A perturbation e splits the eigenvalues of a block with the coupling c by sqrt(c e); c is
/// |T| (the 2-norm) at most, and e what T is not linear by, measured on a random x, or eps |T|. The resolution
/// therefore is
///   10 sqrt(|T| max(|T x - sum_i x_i T e_i|, eps |T|)).
[[nodiscard]] SpectralRadius exact_spectral_radius(const LinearMap& map);

/// For large T. First T^n on a random vector, n up to 10000, which lets growing modes get out. Where nothing grows, the
/// eigenvalues fill the unit circle, and no Krylov iteration converges to the largest of them; so growth is measured
/// first, as the slope of ln |x_{n+1} - x_n| over the second half (differences, because rigid motion makes x itself
/// grow linearly). A mode that is one of N in the random start is as large as all others together after ln(sqrt N) /
/// growth windows, so the resolution is ln(sqrt N)/n. Where something grows faster, restarted Arnoldi goes on from
/// there and gives the eigenvalue.
[[nodiscard]] SpectralRadius iterated_spectral_radius(const LinearMap& map);

/// The exact one up to 600 unknowns, else the iterated one.
[[nodiscard]] SpectralRadius spectral_radius(const LinearMap& map);

}  // namespace ricochet::coupler

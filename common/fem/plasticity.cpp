#include "common/fem/plasticity.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ricochet::fem {
namespace {

struct Value {
  double left, slope;
};

/// Where a falling function is zero between `low` and `high`, from `high` on: Newton's method, and halves of the
/// bracket where its step would leave that; at p = 0 the slope of hardening may be infinite. It ends where rounding in
/// `scale` is left, or by a step that is so short that the square of it is rounding.
template <class F>
double root(double low, double high, double scale, const F& value_at) {
  constexpr double rounding = 2.0 * std::numeric_limits<double>::epsilon(), short_step = 1e-9;
  double x = high;
  for (int i = 0; i < 100; ++i) {
    const auto [left, slope] = value_at(x);
    if (std::abs(left) <= rounding * scale) break;
    (left > 0.0 ? low : high) = x;
    const double next = x - left / slope;
    if (next > low && next < high) {
      if (std::abs(next - x) <= short_step * std::abs(next)) return next;
      x = next;
    } else {
      x = 0.5 * (low + high);
    }
  }
  return x;
}

}  // namespace

double PlasticHeat::softening(double temperature_k) const {
  if (!melting_k) return 1.0;
  const double homologous = std::clamp((temperature_k - reference_k) / (*melting_k - reference_k), 0.0, 1.0);
  return 1.0 - (exponent == 1.0 ? homologous : std::pow(homologous, exponent));
}

/// Where the rate matters, the unknown is x = ln(g/(step_s reference rate)): y grows by its logarithm, and over a short
/// step by little else.
double Plasticity::growth_by_power_and_rate(double stress_pa, double rest_pa, double drop_pa, double equivalent,
                                            double softening, double step_s) const {
  if (rate_factor > 0.0 && step_s == 0.0) return 0.0;
  // y at rest after a growth, and its slope.
  const auto hardened = [&](double grown) -> Value {
    const double p = equivalent + grown;
    const double by_strain = hardening_pa * (hardening_exponent == 1.0 ? p : std::pow(p, hardening_exponent));
    return {softening * (yield_stress_pa + by_strain), softening * hardening_exponent * by_strain / p};
  };
  const auto at_rest_after = [&](double grown) -> Value {
    const auto [y_pa, slope_pa] = hardened(grown);
    return {stress_pa - drop_pa * grown - y_pa, -drop_pa - slope_pa};
  };
  const double most = (stress_pa - rest_pa) / drop_pa;
  const double reference = step_s * reference_rate_per_s;
  if (rate_factor == 0.0 || most <= reference || at_rest_after(reference).left <= 0.0)
    return root(0.0, rate_factor == 0.0 ? most : std::min(most, reference), stress_pa, at_rest_after);
  const double fastest = std::min(std::log(most / reference), (stress_pa / rest_pa - 1.0) / rate_factor);
  return reference * std::exp(root(0.0, fastest, stress_pa, [&](double x) -> Value {
           const double grown = reference * std::exp(x), by_rate = 1.0 + rate_factor * x;
           const auto [y_pa, slope_pa] = hardened(grown);
           return {stress_pa - drop_pa * grown - y_pa * by_rate,
                   -(drop_pa + slope_pa * by_rate) * grown - y_pa * rate_factor};
         }));
}

}  // namespace ricochet::fem

#include "common/fem/plasticity.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ricochet::fem {

double PlasticHeat::softening(double temperature_k) const {
  if (!melting_k) return 1.0;
  const double homologous = (temperature_k - reference_k) / (*melting_k - reference_k);
  return 1.0 - std::pow(std::clamp(homologous, 0.0, 1.0), exponent);
}

/// Newton's method within the bracket that holds the root, which is halved where a step would leave it: at p = 0 the
/// slope of hardening may be infinite, and y has a kink where the rate begins to matter.
double Plasticity::growth_of_power(double stress_pa, double drop_pa, double equivalent, double softening,
                                   double step_s) const {
  if (rate_factor > 0.0 && step_s == 0.0) return 0.0;
  constexpr double rounding = 2.0 * std::numeric_limits<double>::epsilon();
  double low = 0.0, high = (stress_pa - at_rest(equivalent, softening)) / drop_pa, grown = high;
  for (int i = 0; i < 100; ++i) {
    const double hardened = std::pow(equivalent + grown, hardening_exponent);
    const double slope_pa = softening * hardening_pa * hardening_exponent * hardened / (equivalent + grown);
    const double y_pa = softening * (yield_stress_pa + hardening_pa * hardened);
    const double faster = rate_factor > 0.0 ? grown / (step_s * reference_rate_per_s) : 0.0;
    const bool fast = faster > 1.0;
    const double by_rate = fast ? 1.0 + rate_factor * std::log(faster) : 1.0;
    const double left_pa = stress_pa - drop_pa * grown - y_pa * by_rate;
    if (std::abs(left_pa) <= rounding * stress_pa) return grown;
    (left_pa > 0.0 ? low : high) = grown;
    const double fall_pa = drop_pa + slope_pa * by_rate + (fast ? y_pa * rate_factor / grown : 0.0);
    double next = grown + left_pa / fall_pa;
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    if (std::abs(next - grown) <= rounding * grown) return next;
    grown = next;
  }
  return grown;
}

}  // namespace ricochet::fem

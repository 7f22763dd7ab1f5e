#pragma once

#include <cmath>
#include <optional>

namespace ricochet::fem {

/// Plastic work heats the place where it is done, without time to conduct: by its share `fraction` (Taylor, Quinney
/// 1934) over the volumetric heat capacity. Yield stress falls with the temperature T by 1 - ((T - reference)/(melting
/// - reference))^exponent, between both; without a melting temperature it does not.
struct PlasticHeat {
  double capacity_j_m3_k = 0.0;  ///< density times specific heat
  double fraction = 0.9;
  double reference_k = 293.15;  ///< at the start
  std::optional<double> melting_k = std::nullopt;
  double exponent = 1.0;

  /// At a temperature, from 1 to 0.
  [[nodiscard]] double softening(double temperature_k) const;
};

/// Von Mises plasticity with isotropic hardening. At equivalent plastic strain p, rate p' [1/s] and temperature T a
/// point yields where its von Mises stress passes
///   y = (yield_stress_pa + hardening_pa p^hardening_exponent) (1 + rate_factor ln max(1, p'/reference_rate_per_s))
///       PlasticHeat::softening(T)
/// (Johnson, Cook: 7th International Symposium on Ballistics, 1983). By default hardening is linear, and neither rate
/// nor temperature matters.
struct Plasticity {
  double yield_stress_pa = 0.0;
  double hardening_pa = 0.0;
  double hardening_exponent = 1.0;  ///< > 0, at most 1
  double rate_factor = 0.0;
  double reference_rate_per_s = 1.0;
  std::optional<PlasticHeat> heat = std::nullopt;

  /// y at rest [Pa], below which nothing flows; `softening` of its temperature.
  [[nodiscard]] double at_rest(double equivalent, double softening) const {
    const double hardened = hardening_exponent == 1.0 ? equivalent : std::pow(equivalent, hardening_exponent);
    return softening * (yield_stress_pa + hardening_pa * hardened);
  }
  /// By how much p grows in a step of which a von Mises stress of `stress_pa` would be the end if nothing flowed, above
  /// `rest_pa`, y at rest; it falls by `drop_pa` per unit of growth. The solution g of
  ///   stress_pa - drop_pa g = y(p + g, g/step_s),
  /// with the temperature before the step, to rounding: y grows with g, so that there is one. In a step without
  /// duration nothing flows if the rate matters.
  [[nodiscard]] double growth(double stress_pa, double rest_pa, double drop_pa, double equivalent, double softening,
                              double step_s) const {
    if (hardening_exponent == 1.0 && rate_factor == 0.0)
      return (stress_pa - rest_pa) / (drop_pa + softening * hardening_pa);
    return growth_by_power_and_rate(stress_pa, rest_pa, drop_pa, equivalent, softening, step_s);
  }

 private:
  [[nodiscard]] double growth_by_power_and_rate(double stress_pa, double rest_pa, double drop_pa, double equivalent,
                                                double softening, double step_s) const;
};

}  // namespace ricochet::fem

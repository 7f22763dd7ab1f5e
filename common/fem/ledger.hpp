#pragma once

#include <array>
#include <string_view>
#include <vector>

/// What every run reports of each body: energy, momentum and what changed them.
namespace ricochet::fem {

/// Totals of one body's nodes that one participant integrates; sums over participants give the body.
struct BodyTotals {
  double mass_kg = 0.0;
  double energy_kinetic_j = 0.0;
  double energy_strain_j = 0.0;
  double energy_external_j = 0.0;   ///< work done so far by loads, supports and prescribed motion
  double energy_interface_j = 0.0;  ///< work done so far by the link
  double momentum_n_kg_m_s = 0.0;   ///< along the contact normal (without contact: the axis)
  double momentum_t_kg_m_s = 0.0;
  double impulse_n_kg_m_s = 0.0;  ///< given so far by loads, supports, prescribed motion and a rigid plane
  double impulse_t_kg_m_s = 0.0;
  /// Plane strain: about the origin, with the reference positions as arms, which is what small displacements conserve.
  /// Else 0.
  double angular_momentum_kg_m2_s = 0.0;
  double angular_impulse_kg_m2_s = 0.0;
};

inline constexpr std::array<std::string_view, 11> body_quantities = {"mass_kg",
                                                                     "energy_kinetic_j",
                                                                     "energy_strain_j",
                                                                     "energy_external_j",
                                                                     "energy_interface_j",
                                                                     "momentum_n_kg_m_s",
                                                                     "momentum_t_kg_m_s",
                                                                     "impulse_n_kg_m_s",
                                                                     "impulse_t_kg_m_s",
                                                                     "angular_momentum_kg_m2_s",
                                                                     "angular_impulse_kg_m2_s"};

/// Appends the totals in the order of `body_quantities`.
inline void append(const BodyTotals& totals, std::vector<double>& row) {
  row.insert(row.end(),
             {totals.mass_kg, totals.energy_kinetic_j, totals.energy_strain_j, totals.energy_external_j,
              totals.energy_interface_j, totals.momentum_n_kg_m_s, totals.momentum_t_kg_m_s, totals.impulse_n_kg_m_s,
              totals.impulse_t_kg_m_s, totals.angular_momentum_kg_m2_s, totals.angular_impulse_kg_m2_s});
}

}  // namespace ricochet::fem

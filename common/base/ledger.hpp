#pragma once

#include <array>
#include <string_view>
#include <utility>
#include <vector>

#include "common/base/archive.hpp"

/// Reported by every run of each body and of its contact: one list of names and members, which participants write
/// their history rows by and the coupler reads them by.
namespace ricochet {

/// Totals of one body's nodes that one participant integrates; sums over participants give the body.
struct BodyTotals {
  double mass_kg = 0.0;
  double energy_kinetic_j = 0.0;
  double energy_strain_j = 0.0;
  double energy_external_j = 0.0;   ///< work done so far by loads, supports and prescribed motion
  double energy_interface_j = 0.0;  ///< work done so far by the link
  double momentum_n_kg_m_s = 0.0;   ///< along the contact normal (without contact: the axis)
  double momentum_t_kg_m_s = 0.0;
  double momentum_b_kg_m_s = 0.0;  ///< of solids: along the binormal n x t
  double impulse_n_kg_m_s = 0.0;   ///< given so far by loads, supports, prescribed motion and a rigid plane
  double impulse_t_kg_m_s = 0.0;
  double impulse_b_kg_m_s = 0.0;
  /// Sum of (x + u) x m v about the origin, and what was given of it so far: of solids, and in plane strain about z.
  /// Else 0, which nobody tells of.
  double angular_momentum_x_kg_m2_s = 0.0, angular_momentum_y_kg_m2_s = 0.0, angular_momentum_z_kg_m2_s = 0.0;
  double angular_impulse_x_kg_m2_s = 0.0, angular_impulse_y_kg_m2_s = 0.0, angular_impulse_z_kg_m2_s = 0.0;
  /// Bodies that yield tell these; their elements keep them, so that they are in no archive.
  double plastic_work_j = 0.0;
  double equivalent_plastic_strain_max = 0.0;  ///< of all elements: the largest, not a sum
  double temperature_max_k = 0.0;              ///< the same; where plastic work heats the body
  double energy_highest_modes_j =
      0.0;  ///< of a body reduced to modes: what the highest tenth of them hold of its energy

  void archive(Archive& a);
};

/// Numbers of one contact, and of all contacts of a scene together. A contact force is the impulse that acted over
/// the window, divided by its size: the only force that all laws and integrators share, and the one for which sum F dt
/// = change of momentum holds exactly.
struct ContactTotals {
  double gap_min_m = 0.0;
  double contact_force_n = 0.0;  ///< on B along +n, over the window, friction's too
  /// In closed pairs, whose normal force over their area is above 1e-3 of the largest: mean and largest of it.
  double contact_pressure_mean_pa = 0.0, contact_pressure_max_pa = 0.0;
  double contact_radius_m = 0.0;    ///< of axisymmetric and solid bodies: of the circle as large as their area
  double friction_force_n = 0.0;    ///< of friction on B along +t, over the window
  double friction_force_b_n = 0.0;  ///< of solids: of friction on B along +(n x t)
  /// Impulse of the normal forces of a curved surface on B along +t and, of solids, along +(n x t), over the window.
  double normal_force_t_n = 0.0, normal_force_b_n = 0.0;
  double pairs_stick = 0.0, pairs_slip = 0.0, pairs_open = 0.0;  ///< numbers of pairs
  double contact_impulse_n_s = 0.0, friction_impulse_n_s = 0.0;  ///< sums of F dt so far
  double friction_impulse_b_n_s = 0.0;
  double normal_impulse_t_n_s = 0.0, normal_impulse_b_n_s = 0.0;

  void archive(Archive& a);
};

/// The report of the owner of the contacts: of all of them together, each along its own directions, and of each.
struct ContactRecord : ContactTotals {
  double principal_stress_mean_pa = 0.0;  ///< of the first contact
  double energy_contact_j = 0.0;   ///< work so far of the normal contact forces: what impacts cost (a loss is negative)
  double energy_friction_j = 0.0;  ///< dissipated so far by friction
  std::vector<ContactTotals> contacts;  ///< in the scene's order; empty where there is but one
  // Counts of the contact problems since the row before; all zero where they have a closed form.
  double contact_iterations = 0.0;
  double contact_residual = 0.0;     ///< largest violation of their conditions, relative to the largest normal force
  double contact_unconverged = 0.0;  ///< windows so far in which that was above what counts as converged
};

/// A quantity's name in history columns and its member; a body's column is "NAME/BODY", that of one of several contacts
/// "NAME/CONTACT".
template <class Totals>
using Quantity = std::pair<std::string_view, double Totals::*>;

inline constexpr std::array<Quantity<BodyTotals>, 17> body_quantities = {{
    {"mass_kg", &BodyTotals::mass_kg},
    {"energy_kinetic_j", &BodyTotals::energy_kinetic_j},
    {"energy_strain_j", &BodyTotals::energy_strain_j},
    {"energy_external_j", &BodyTotals::energy_external_j},
    {"energy_interface_j", &BodyTotals::energy_interface_j},
    {"momentum_n_kg_m_s", &BodyTotals::momentum_n_kg_m_s},
    {"momentum_t_kg_m_s", &BodyTotals::momentum_t_kg_m_s},
    {"momentum_b_kg_m_s", &BodyTotals::momentum_b_kg_m_s},
    {"impulse_n_kg_m_s", &BodyTotals::impulse_n_kg_m_s},
    {"impulse_t_kg_m_s", &BodyTotals::impulse_t_kg_m_s},
    {"impulse_b_kg_m_s", &BodyTotals::impulse_b_kg_m_s},
    {"angular_momentum_x_kg_m2_s", &BodyTotals::angular_momentum_x_kg_m2_s},
    {"angular_momentum_y_kg_m2_s", &BodyTotals::angular_momentum_y_kg_m2_s},
    {"angular_momentum_z_kg_m2_s", &BodyTotals::angular_momentum_z_kg_m2_s},
    {"angular_impulse_x_kg_m2_s", &BodyTotals::angular_impulse_x_kg_m2_s},
    {"angular_impulse_y_kg_m2_s", &BodyTotals::angular_impulse_y_kg_m2_s},
    {"angular_impulse_z_kg_m2_s", &BodyTotals::angular_impulse_z_kg_m2_s},
}};

/// Bodies that yield tell these after those, the last one where plastic work heats them.
inline constexpr std::array<Quantity<BodyTotals>, 3> plastic_quantities = {{
    {"plastic_work_j", &BodyTotals::plastic_work_j},
    {"equivalent_plastic_strain_max", &BodyTotals::equivalent_plastic_strain_max},
    {"temperature_max_k", &BodyTotals::temperature_max_k},
}};

/// Bodies that are reduced to modes tell this after those.
inline constexpr std::array<Quantity<BodyTotals>, 1> reduced_quantities = {{
    {"energy_highest_modes_j", &BodyTotals::energy_highest_modes_j},
}};

inline constexpr std::array<Quantity<ContactRecord>, 23> contact_quantities = {{
    {"gap_min_m", &ContactRecord::gap_min_m},
    {"contact_force_n", &ContactRecord::contact_force_n},
    {"contact_pressure_mean_pa", &ContactRecord::contact_pressure_mean_pa},
    {"contact_pressure_max_pa", &ContactRecord::contact_pressure_max_pa},
    {"contact_radius_m", &ContactRecord::contact_radius_m},
    {"principal_stress_mean_pa", &ContactRecord::principal_stress_mean_pa},
    {"friction_force_n", &ContactRecord::friction_force_n},
    {"friction_force_b_n", &ContactRecord::friction_force_b_n},
    {"normal_force_t_n", &ContactRecord::normal_force_t_n},
    {"normal_force_b_n", &ContactRecord::normal_force_b_n},
    {"pairs_stick", &ContactRecord::pairs_stick},
    {"pairs_slip", &ContactRecord::pairs_slip},
    {"pairs_open", &ContactRecord::pairs_open},
    {"energy_contact_j", &ContactRecord::energy_contact_j},
    {"energy_friction_j", &ContactRecord::energy_friction_j},
    {"contact_impulse_n_s", &ContactRecord::contact_impulse_n_s},
    {"friction_impulse_n_s", &ContactRecord::friction_impulse_n_s},
    {"friction_impulse_b_n_s", &ContactRecord::friction_impulse_b_n_s},
    {"normal_impulse_t_n_s", &ContactRecord::normal_impulse_t_n_s},
    {"normal_impulse_b_n_s", &ContactRecord::normal_impulse_b_n_s},
    {"contact_iterations", &ContactRecord::contact_iterations},
    {"contact_residual", &ContactRecord::contact_residual},
    {"contact_unconverged", &ContactRecord::contact_unconverged},
}};

inline constexpr std::array<Quantity<ContactTotals>, 17> named_contact_quantities = {{
    {"gap_min_m", &ContactTotals::gap_min_m},
    {"contact_force_n", &ContactTotals::contact_force_n},
    {"contact_pressure_mean_pa", &ContactTotals::contact_pressure_mean_pa},
    {"contact_pressure_max_pa", &ContactTotals::contact_pressure_max_pa},
    {"contact_radius_m", &ContactTotals::contact_radius_m},
    {"friction_force_n", &ContactTotals::friction_force_n},
    {"friction_force_b_n", &ContactTotals::friction_force_b_n},
    {"normal_force_t_n", &ContactTotals::normal_force_t_n},
    {"normal_force_b_n", &ContactTotals::normal_force_b_n},
    {"pairs_stick", &ContactTotals::pairs_stick},
    {"pairs_slip", &ContactTotals::pairs_slip},
    {"pairs_open", &ContactTotals::pairs_open},
    {"contact_impulse_n_s", &ContactTotals::contact_impulse_n_s},
    {"friction_impulse_n_s", &ContactTotals::friction_impulse_n_s},
    {"friction_impulse_b_n_s", &ContactTotals::friction_impulse_b_n_s},
    {"normal_impulse_t_n_s", &ContactTotals::normal_impulse_t_n_s},
    {"normal_impulse_b_n_s", &ContactTotals::normal_impulse_b_n_s},
}};

inline void BodyTotals::archive(Archive& a) {
  for (const auto& [name, member] : body_quantities) a(this->*member);
}
inline void ContactTotals::archive(Archive& a) {
  for (const auto& [name, member] : named_contact_quantities) a(this->*member);
}

/// Appends the quantities in the order of their table; of several contacts those of each follow.
inline void append_quantities(const BodyTotals& totals, std::vector<double>& row) {
  for (const auto& [name, member] : body_quantities) row.push_back(totals.*member);
}
inline void append_quantities(const ContactRecord& record, std::vector<double>& row) {
  for (const auto& [name, member] : contact_quantities) row.push_back(record.*member);
  for (const auto& contact : record.contacts) {
    for (const auto& [name, member] : named_contact_quantities) row.push_back(contact.*member);
  }
}

}  // namespace ricochet

#pragma once

#include <string>
#include <vector>

/// What a contact's owner reports of it, and the states of its pairs.
namespace ricochet::solver {

enum class ContactState { open, stick, slip };

/// Contact forces with a larger residual are counted as not converged, and the user is warned.
constexpr double converged_contact_residual = 1e-6;

/// What the contact owner reports; names of the columns, in the order of `append`. A contact force is the impulse that
/// acted over the window, divided by its size: the only force that all laws and integrators share, and the one for
/// which sum F dt = change of momentum holds exactly.
struct ContactRecord {
  double gap_min_m = 0.0;
  double contact_force_n = 0.0;           ///< on B along +n, over the window
  double contact_pressure_mean_pa = 0.0;  ///< that over the area of all pairs
  double principal_stress_mean_pa = 0.0;
  double friction_force_n = 0.0;  ///< on B along +t, over the window
  int pairs_stick = 0, pairs_slip = 0, pairs_open = 0;
  double energy_contact_j =
      0.0;  ///< work done so far by the normal contact forces: what impacts cost (a loss is negative)
  double energy_friction_j = 0.0;                                ///< dissipated so far by friction
  double contact_impulse_n_s = 0.0, friction_impulse_n_s = 0.0;  ///< sums of F dt so far
  // Of the contact problems since the row before; all zero where they have a closed form.
  int contact_iterations = 0;
  double contact_residual = 0.0;  ///< largest violation of their conditions, relative to the largest normal force
  int contact_unconverged = 0;    ///< windows so far in which that was above `converged_contact_residual`
};
[[nodiscard]] std::vector<std::string> report_columns();
void append(const ContactRecord& report, std::vector<double>& row);

}  // namespace ricochet::solver

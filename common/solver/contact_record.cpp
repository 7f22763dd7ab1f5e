#include "common/solver/contact_record.hpp"

namespace ricochet::solver {

std::vector<std::string> report_columns() {
  return {"gap_min_m",
          "contact_force_n",
          "contact_pressure_mean_pa",
          "principal_stress_mean_pa",
          "friction_force_n",
          "pairs_stick",
          "pairs_slip",
          "pairs_open",
          "energy_contact_j",
          "energy_friction_j",
          "contact_impulse_n_s",
          "friction_impulse_n_s",
          "contact_iterations",
          "contact_residual",
          "contact_unconverged"};
}

void append(const ContactRecord& report, std::vector<double>& row) {
  row.insert(
      row.end(),
      {report.gap_min_m, report.contact_force_n, report.contact_pressure_mean_pa, report.principal_stress_mean_pa,
       report.friction_force_n, static_cast<double>(report.pairs_stick), static_cast<double>(report.pairs_slip),
       static_cast<double>(report.pairs_open), report.energy_contact_j, report.energy_friction_j,
       report.contact_impulse_n_s, report.friction_impulse_n_s, static_cast<double>(report.contact_iterations),
       report.contact_residual, static_cast<double>(report.contact_unconverged)});
}

}  // namespace ricochet::solver

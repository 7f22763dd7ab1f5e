#include "common/solver/pairs.hpp"

#include <algorithm>

#include "common/base/error.hpp"

namespace ricochet::solver {
namespace {

PairSide find_side(const std::vector<scene::ParticipantPart>& parts, int body, int body_node) {
  for (std::size_t p = 0; p < parts.size(); ++p) {
    if (parts[p].body != body) continue;
    const auto& nodes = parts[p].part.body_node;
    const auto found = std::lower_bound(nodes.begin(), nodes.end(), body_node);
    if (found != nodes.end() && *found == body_node)
      return {static_cast<int>(p), static_cast<int>(found - nodes.begin())};
  }
  throw ConfigError("contact node " + std::to_string(body_node) + " belongs to no part of the contact's owner");
}

}  // namespace

std::vector<Pair> local_pairs(const scene::Problem& problem, const std::vector<scene::ParticipantPart>& parts) {
  std::vector<Pair> pairs;
  const auto& geometry = problem.contact;
  for (const auto& pair : geometry.pairs) {
    Pair local;
    local.a = find_side(parts, geometry.body_a, pair.node_a);
    if (geometry.body_b >= 0) local.b = find_side(parts, geometry.body_b, pair.node_b);
    local.gap0_m = pair.gap0_m;
    local.area_m2 = pair.area_m2;
    pairs.push_back(local);
  }
  return pairs;
}

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

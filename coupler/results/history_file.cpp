#include "coupler/results/history_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <string_view>
#include <utility>

namespace ricochet::coupler {
namespace {

/// A column of the whole scene; those of the bodies follow.
struct Column {
  const char* name;
  double (*value)(const HistoryRow& row);
};

constexpr Column columns[] = {
    {"time_s", [](const HistoryRow& row) -> double { return row.time_s; }},
    {"gap_min_m", [](const HistoryRow& row) -> double { return row.contact.gap_min_m; }},
    {"contact_force_n", [](const HistoryRow& row) -> double { return row.contact.contact_force_n; }},
    {"contact_pressure_mean_pa", [](const HistoryRow& row) -> double { return row.contact.contact_pressure_mean_pa; }},
    {"contact_pressure_max_pa", [](const HistoryRow& row) -> double { return row.contact.contact_pressure_max_pa; }},
    {"principal_stress_mean_pa", [](const HistoryRow& row) -> double { return row.contact.principal_stress_mean_pa; }},
    {"friction_force_n", [](const HistoryRow& row) -> double { return row.contact.friction_force_n; }},
    {"normal_force_t_n", [](const HistoryRow& row) -> double { return row.contact.normal_force_t_n; }},
    {"pairs_stick", [](const HistoryRow& row) -> double { return row.contact.pairs_stick; }},
    {"pairs_slip", [](const HistoryRow& row) -> double { return row.contact.pairs_slip; }},
    {"pairs_open", [](const HistoryRow& row) -> double { return row.contact.pairs_open; }},
    {"energy_kinetic_j", [](const HistoryRow& row) -> double { return row.sum.energy_kinetic_j; }},
    {"energy_strain_j", [](const HistoryRow& row) -> double { return row.sum.energy_strain_j; }},
    {"energy_external_j", [](const HistoryRow& row) -> double { return row.sum.energy_external_j; }},
    {"energy_contact_j", [](const HistoryRow& row) -> double { return row.contact.energy_contact_j; }},
    {"energy_friction_j", [](const HistoryRow& row) -> double { return row.contact.energy_friction_j; }},
    {"energy_interface_j", [](const HistoryRow& row) -> double { return row.sum.energy_interface_j; }},
    {"energy_error", [](const HistoryRow& row) -> double { return row.energy_error; }},
    {"momentum_n_kg_m_s", [](const HistoryRow& row) -> double { return row.sum.momentum_n_kg_m_s; }},
    {"momentum_t_kg_m_s", [](const HistoryRow& row) -> double { return row.sum.momentum_t_kg_m_s; }},
    {"contact_impulse_n_s", [](const HistoryRow& row) -> double { return row.contact.contact_impulse_n_s; }},
    {"friction_impulse_n_s", [](const HistoryRow& row) -> double { return row.contact.friction_impulse_n_s; }},
    {"normal_impulse_t_n_s", [](const HistoryRow& row) -> double { return row.contact.normal_impulse_t_n_s; }},
    {"contact_iterations", [](const HistoryRow& row) -> double { return row.contact.contact_iterations; }},
    {"contact_residual", [](const HistoryRow& row) -> double { return row.contact.contact_residual; }},
    {"contact_unconverged", [](const HistoryRow& row) -> double { return row.contact.contact_unconverged; }},
};

constexpr Column solid_columns[] = {
    {"friction_force_b_n", [](const HistoryRow& row) -> double { return row.contact.friction_force_b_n; }},
    {"normal_force_b_n", [](const HistoryRow& row) -> double { return row.contact.normal_force_b_n; }},
    {"friction_impulse_b_n_s", [](const HistoryRow& row) -> double { return row.contact.friction_impulse_b_n_s; }},
    {"normal_impulse_b_n_s", [](const HistoryRow& row) -> double { return row.contact.normal_impulse_b_n_s; }},
    {"momentum_b_kg_m_s", [](const HistoryRow& row) -> double { return row.sum.momentum_b_kg_m_s; }},
};

constexpr Column plastic_columns[] = {
    {"plastic_work_j", [](const HistoryRow& row) -> double { return row.sum.plastic_work_j; }},
    {"equivalent_plastic_strain_max",
     [](const HistoryRow& row) -> double { return row.sum.equivalent_plastic_strain_max; }},
};

/// nan where nobody tells it.
constexpr Column temperature_column = {
    "temperature_max_k", [](const HistoryRow& row) -> double {
      return row.sum.temperature_max_k > 0.0 ? row.sum.temperature_max_k : std::numeric_limits<double>::quiet_NaN();
    }};

constexpr Column reduced_column = {"energy_highest_modes_j",
                                   [](const HistoryRow& row) -> double { return row.sum.energy_highest_modes_j; }};

constexpr Column radius_column = {"contact_radius_m",
                                  [](const HistoryRow& row) -> double { return row.contact.contact_radius_m; }};

/// nan where somebody does not tell it.
double told(const HistoryRow& row, double kg_m2_s) {
  return row.angular_momentum_error ? kg_m2_s : std::numeric_limits<double>::quiet_NaN();
}

/// In plane strain the last one alone.
constexpr Column angular_columns[] = {
    {"angular_momentum_x_kg_m2_s",
     [](const HistoryRow& row) -> double { return told(row, row.sum.angular_momentum_x_kg_m2_s); }},
    {"angular_momentum_y_kg_m2_s",
     [](const HistoryRow& row) -> double { return told(row, row.sum.angular_momentum_y_kg_m2_s); }},
    {"angular_momentum_z_kg_m2_s",
     [](const HistoryRow& row) -> double { return told(row, row.sum.angular_momentum_z_kg_m2_s); }},
};

bool of_solids_alone(double ContactTotals::*member) {
  return member == &ContactTotals::friction_force_b_n || member == &ContactTotals::friction_impulse_b_n_s ||
         member == &ContactTotals::normal_force_b_n || member == &ContactTotals::normal_impulse_b_n_s;
}

/// Calls f(name, member) for what is told of each of several contacts.
template <class F>
void for_each_of_a_contact(const HistoryShape& shape, const F& f) {
  for (const auto& [name, member] : named_contact_quantities) {
    if (member == &ContactTotals::contact_radius_m ? shape.round : shape.solid || !of_solids_alone(member))
      f(name, member);
  }
}

/// Calls f(column) for those that not all scenes have.
template <class F>
void for_each_further(const HistoryShape& shape, const F& f) {
  if (shape.solid) {
    for (const auto& column : solid_columns) f(column);
  }
  for (int i = 3 - shape.angular; i < 3; ++i) f(angular_columns[i]);
  if (shape.round) f(radius_column);
  if (shape.yields) {
    for (const auto& column : plastic_columns) f(column);
  }
  if (shape.heats) f(temperature_column);
  if (shape.reduced) f(reduced_column);
}

/// The gap is none without a contact, and where no pair is left of bodies that have slid off each other.
void tell_no_gap(ContactTotals& contact, bool has_contact) {
  if (!has_contact || contact.gap_min_m == std::numeric_limits<double>::max())
    contact.gap_min_m = std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

int angular_components(const scene::Problem& problem) {
  const bool periodic = std::any_of(problem.bodies.begin(), problem.bodies.end(), [](const auto& body) {
    return body.mesh.period_m > 0.0 || body.mesh.period_wide_m > 0.0;
  });
  // A guide that keeps a rigid body from turning takes moments that nobody books.
  const bool guided = std::any_of(problem.bodies.begin(), problem.bodies.end(), [&](const auto& body) {
    return body.mesh.rigid_nodes > 0 && body.mesh.rigid_nodes <= problem.scene.components();
  });
  if (periodic || guided) return 0;
  return problem.scene.model == scene::Model::solid ? 3 : problem.scene.model == scene::Model::plane_strain ? 1 : 0;
}

HistoryShape history_shape(const scene::Problem& problem) {
  HistoryShape shape{.has_contact = !problem.contacts.empty(),
                     .solid = problem.scene.components() == 3,
                     .angular = angular_components(problem),
                     .round = problem.scene.components() == 3 || problem.scene.model == scene::Model::axisymmetric,
                     .yields = scene::yields(problem),
                     .heats = scene::heats(problem),
                     .reduced = problem.scene.any_reduced(),
                     .contacts = problem.scene.contact_names()};
  shape.bodies = problem.scene.body_names();
  return shape;
}

std::vector<std::string> history_columns(const HistoryShape& shape) {
  std::vector<std::string> names;
  for (const auto& column : columns) names.emplace_back(column.name);
  for (const auto& body : shape.bodies) names.push_back(fmt::format("velocity_mean_{}_m_s", body));
  for_each_further(shape, [&](const Column& column) { names.emplace_back(column.name); });
  for (const auto& contact : shape.contacts) {
    for_each_of_a_contact(shape, [&](std::string_view quantity, double ContactTotals::*) {
      names.push_back(fmt::format("{}/{}", quantity, contact));
    });
  }
  return names;
}

HistoryFile::HistoryFile(std::string path, HistoryShape shape, const Beginning& keep)
    : shape_(std::move(shape)), rows_(std::move(path), history_columns(shape_), keep) {}

void HistoryFile::add(HistoryRow row) {
  tell_no_gap(row.contact, shape_.has_contact);
  for (auto& contact : row.contact.contacts) tell_no_gap(contact, true);
  for (const auto& column : columns) rows_.put(column.value(row));
  for (const auto& body : row.bodies) rows_.put(body.mass_kg > 0 ? body.momentum_n_kg_m_s / body.mass_kg : 0.0);
  for_each_further(shape_, [&](const Column& column) { rows_.put(column.value(row)); });
  for (const auto& contact : row.contact.contacts) {
    for_each_of_a_contact(shape_, [&](std::string_view, double ContactTotals::*member) { rows_.put(contact.*member); });
  }
  rows_.end_row();
}

}  // namespace ricochet::coupler

// All that a session answers besides link values: motion, contact, history rows, what has left the model.
#include <fmt/format.h>

#include <algorithm>
#include <initializer_list>

#include "common/participant/session.hpp"

namespace ricochet::participant {

void Session::put_absolute(wire::Array& absolute) const {
  absolute.set(output_.value, nodes_, description_.components);
}

void Session::put_rates(wire::Rates& reply) const {
  const int rows = moves_ ? nodes_ : 0;
  reply.velocity_m_s.set(output_.velocity_m_s, rows, description_.components);
  reply.acceleration_m_s2.set(output_.acceleration_m_s2, rows, description_.components);
}

void Session::put_departures(wire::Array& array) {
  const auto found = participant_.departures();
  array.resize(static_cast<int>(found.size()), wire::departure_columns);
  auto out = array.data.begin();
  for (const auto& d : found) {
    for (const double value :
         {static_cast<double>(d.kind), static_cast<double>(d.body), static_cast<double>(d.last_without),
          static_cast<double>(d.first), static_cast<double>(d.looks), d.largest, static_cast<double>(d.window), d.x_m,
          d.y_m, d.z_m, d.first_size, d.first_x_m, d.first_y_m, d.first_z_m}) {
      *out++ = value;
    }
  }
}

void Session::put_outline(wire::Array& array) {
  const auto nodes = participant_.outline();
  array.resize(static_cast<int>(nodes.size()), 2 + description_.components);
  auto out = array.data.begin();
  for (const auto& node : nodes) {
    *out++ = node.body;
    *out++ = node.node;
    out = std::copy(node.displacement_m.begin(), node.displacement_m.end(), out);
  }
}

void Session::record() { append_row(&Participant::record, description_.record_columns.size(), rows_); }

void Session::record_axial_stress() {
  append_row(&Participant::axial_stress, description_.axial_stress_columns.size(), stress_rows_);
}

void Session::record_probes() { append_row(&Participant::probes, description_.probe_columns.size(), probe_rows_); }

/// Records every window of the contact's owner; the first tells how many numbers a row has.
void Session::record_contact_forces() {
  if (!description_.contact_owner) return;
  force_rows_.push_back(static_cast<double>(accepted_window_));
  const auto before = force_rows_.size();
  participant_.contact_forces(force_rows_);
  const auto told = force_rows_.size() - before;
  if (told == 0) force_rows_.pop_back();
  if (force_columns_ < 0) force_columns_ = static_cast<std::int64_t>(told);
  if (static_cast<std::int64_t>(told) == force_columns_) return;
  throw ParticipantError(fmt::format("participant '{}' told the forces of {} contacts, it told those of {} before",
                                     description_.name, told, force_columns_));
}

bool Session::wants_axial_stress(std::int64_t window) const {
  const int every = setup_.axial_stress_every;
  return every > 0 && !description_.axial_stress_columns.empty() && window % every == 0;
}

bool Session::wants_probes(std::int64_t window) const {
  const int every = setup_.probes_every;
  return every > 0 && !description_.probe_columns.empty() && window % every == 0;
}

/// All that the participant tells of the last accepted window, behind its number. `columns`: with the window.
void Session::append_row(Tell tell, std::size_t columns, std::vector<double>& rows) {
  rows.push_back(static_cast<double>(accepted_window_));
  const auto before = rows.size();
  (participant_.*tell)(rows);
  const auto expected = columns - 1;
  if (rows.size() - before == expected) return;
  throw ParticipantError(fmt::format("participant '{}' recorded {} numbers, it announced {} columns", description_.name,
                                     rows.size() - before, expected));
}

void Session::put_records(bool requested, wire::Records& reply) {
  const auto put = [requested](wire::Array& array, std::size_t columns, std::vector<double>& rows) {
    array.resize(0, static_cast<int>(columns));
    if (!requested || rows.empty()) return;
    array.rows = static_cast<int>(rows.size() / columns);
    array.data.swap(rows);
  };
  put(reply.records, description_.record_columns.size(), rows_);
  put(reply.axial_stress, description_.axial_stress_columns.size(), stress_rows_);
  put(reply.probes, description_.probe_columns.size(), probe_rows_);
  put(reply.contact_forces, static_cast<std::size_t>(1 + std::max<std::int64_t>(force_columns_, 0)), force_rows_);
  reply.departures.resize(0, wire::departure_columns);
  if (requested) put_departures(reply.departures);
}

void Session::put_accepted_window(bool records_requested, wire::AcceptedWindow& reply) {
  if (records_requested) finish_window();
  static_cast<wire::ContactReport&>(reply) = {contact_.pairs_closed,      contact_.gap_min_m,
                                              contact_.gap_rate_min_m_s,  contact_.separated,
                                              contact_.separation_time_s, contact_.finished};
  put_records(records_requested, reply);
  reply.outline.resize(0, 2 + description_.components);
  if (records_requested) put_outline(reply.outline);
}

}  // namespace ricochet::participant

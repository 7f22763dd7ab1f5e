#include "coupler/results/history.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>
#include <utility>

#include "common/base/error.hpp"

namespace ricochet::coupler {
namespace {

template <class Table>
auto member_of(const Table& table, const std::string& name) -> decltype(table[0].second) {
  for (const auto& [known, member] : table) {
    if (name == known) return member;
  }
  return nullptr;
}

/// Values of one quantity, made one: their sum, or the largest.
void join(double BodyTotals::*member, double value, BodyTotals& all) {
  const bool largest = member == &BodyTotals::equivalent_plastic_strain_max || member == &BodyTotals::temperature_max_k;
  all.*member = largest ? std::max(all.*member, value) : all.*member + value;
}

void add_to(BodyTotals& sum, const BodyTotals& row) {
  for (const auto& [name, member] : body_quantities) sum.*member += row.*member;
  for (const auto& [name, member] : plastic_quantities) join(member, row.*member, sum);
  for (const auto& [name, member] : reduced_quantities) sum.*member += row.*member;
}

/// Everyone says the angular momentum of each body that it says the momentum of: of solids (which have momentum along
/// b) all of it, else about z.
bool tell_angular_momentum(const std::vector<History::Source>& sources, const Conserved& conserved) {
  const bool solid = std::any_of(conserved.directions.begin(), conserved.directions.end(),
                                 [](const Conserved::Direction& d) { return d.b != 0; });
  return std::all_of(sources.begin(), sources.end(), [solid](const History::Source& source) {
    const auto count = [&](std::string_view quantity) {
      return std::count_if(source.columns.begin(), source.columns.end(),
                           [&](const std::string& column) { return column.rfind(quantity, 0) == 0; });
    };
    const auto bodies = count("momentum_n_kg_m_s/");
    const bool about_z = count("angular_momentum_z_kg_m2_s/") == bodies;
    return about_z && (!solid || (count("angular_momentum_x_kg_m2_s/") == bodies &&
                                  count("angular_momentum_y_kg_m2_s/") == bodies));
  });
}

}  // namespace

double EnergyBalance::created_j(const HistoryRow& row) {
  const double energy = row.sum.energy_kinetic_j + row.sum.energy_strain_j;
  if (!first_j_) first_j_ = energy + row.sum.plastic_work_j;
  largest_work_j_ = std::max(largest_work_j_, std::abs(row.sum.energy_external_j));
  return row.sum.plastic_work_j + energy + row.contact.energy_friction_j - row.sum.energy_external_j - *first_j_;
}

void Errors::add(HistoryRow& row) {
  const auto ratio = [](double part, double whole) { return whole > 0 ? part / whole : part; };
  const double created = energy_.created_j(row);
  row.energy_reference_j = energy_.reference_j();
  row.energy_error = told_.energy ? ratio(created, row.energy_reference_j) : std::numeric_limits<double>::quiet_NaN();

  const auto along = [](const Conserved::Direction& d, double n, double t, double b) {
    return d.n * n + d.t * t + d.b * b;
  };
  constexpr double at_rest = 1e-6;  // its bodies turn or vibrate, and go nowhere
  double momentum = 0, of_motion = 0;
  for (const auto& body : row.bodies) {
    double square = 0;
    for (const auto& d : conserved_.directions)
      square += std::pow(along(d, body.momentum_n_kg_m_s, body.momentum_t_kg_m_s, body.momentum_b_kg_m_s), 2);
    momentum += std::sqrt(square);
    of_motion += std::sqrt(2.0 * body.mass_kg * std::max(0.0, body.energy_kinetic_j));
  }
  if (momentum < at_rest * of_motion) momentum = of_motion;
  largest_momentum_ = std::max(largest_momentum_, momentum);
  std::vector<double> balance;
  for (const auto& d : conserved_.directions) {
    balance.push_back(along(d, row.sum.momentum_n_kg_m_s - row.sum.impulse_n_kg_m_s,
                            row.sum.momentum_t_kg_m_s - row.sum.impulse_t_kg_m_s,
                            row.sum.momentum_b_kg_m_s - row.sum.impulse_b_kg_m_s));
  }
  const std::array<double, 3> angular = {row.sum.angular_momentum_x_kg_m2_s - row.sum.angular_impulse_x_kg_m2_s,
                                         row.sum.angular_momentum_y_kg_m2_s - row.sum.angular_impulse_y_kg_m2_s,
                                         row.sum.angular_momentum_z_kg_m2_s - row.sum.angular_impulse_z_kg_m2_s};
  if (first_.empty()) {
    first_ = balance;
    first_angular_ = angular;
  }
  double lost = 0;
  for (std::size_t i = 0; i < balance.size(); ++i) lost = std::max(lost, std::abs(balance[i] - first_[i]));
  row.momentum_error = told_.momentum ? ratio(lost, largest_momentum_) : std::numeric_limits<double>::quiet_NaN();
  row.momentum_reference_kg_m_s = largest_momentum_;
  if (conserved_.arm_m > 0) {
    const double turned =
        std::hypot(angular[0] - first_angular_[0], angular[1] - first_angular_[1], angular[2] - first_angular_[2]);
    row.angular_momentum_error = ratio(turned, conserved_.arm_m * largest_momentum_);
  }
}

History::History(const std::vector<Source>& sources, const std::vector<std::string>& bodies, Conserved conserved,
                 const std::vector<std::string>& contacts, ToldBalances told)
    : bodies_(bodies), contacts_(contacts) {
  if (!tell_angular_momentum(sources, conserved)) conserved.arm_m = 0;
  errors_ = Errors(std::move(conserved), told);
  tells_interface_ = std::all_of(sources.begin(), sources.end(), [](const Source& source) {
    return std::any_of(source.columns.begin(), source.columns.end(),
                       [](const std::string& column) { return column.rfind("energy_interface_j", 0) == 0; });
  });
  for (const auto& source : sources) {
    auto& stream = streams_.emplace_back();
    stream.participant = source.participant;
    if (source.columns.empty() || source.columns[0] != "window") {
      throw ProtocolError(
          fmt::format("participant '{}': the first history column must be \"window\"", source.participant));
    }
    stream.columns.emplace_back();
    for (std::size_t c = 1; c < source.columns.size(); ++c) {
      if (std::find(source.columns.begin(), source.columns.begin() + static_cast<std::ptrdiff_t>(c),
                    source.columns[c]) != source.columns.begin() + static_cast<std::ptrdiff_t>(c)) {
        throw ProtocolError(fmt::format("participant '{}' announces the history column \"{}\" twice",
                                        source.participant, source.columns[c]));
      }
      stream.columns.push_back(parse(source.columns[c], source.participant));
    }
  }
}

History::Column History::parse(const std::string& column, const std::string& participant) const {
  Column parsed;
  const auto slash = column.find('/');
  if (slash != std::string::npos) {
    if (const auto named = parse_named(column.substr(0, slash), column.substr(slash + 1))) return *named;
  } else if (column == "energy_interface_j") {
    parsed.of_body = &BodyTotals::energy_interface_j;
    return parsed;
  } else if ((parsed.of_contacts = member_of(contact_quantities, column))) {
    return parsed;
  }
  std::string names = bodies_.empty() ? "no bodies" : fmt::format("bodies: {}", fmt::join(bodies_, ", "));
  if (!contacts_.empty()) names += fmt::format("; contacts: {}", fmt::join(contacts_, ", "));
  throw ProtocolError(
      fmt::format("participant '{}' announces the unknown history column \"{}\" ({})", participant, column, names));
}

/// The column of a body or of one of several contacts.
std::optional<History::Column> History::parse_named(const std::string& quantity, const std::string& name) const {
  Column parsed;
  const auto body = std::find(bodies_.begin(), bodies_.end(), name);
  parsed.of_body = member_of(body_quantities, quantity);
  if (!parsed.of_body) parsed.of_body = member_of(plastic_quantities, quantity);
  if (!parsed.of_body) parsed.of_body = member_of(reduced_quantities, quantity);
  if (body != bodies_.end() && parsed.of_body) {
    parsed.body = static_cast<int>(body - bodies_.begin());
    return parsed;
  }
  const auto contact = std::find(contacts_.begin(), contacts_.end(), name);
  parsed.of_one_contact = member_of(named_contact_quantities, quantity);
  if (contact == contacts_.end() || !parsed.of_one_contact) return std::nullopt;
  parsed.contact = static_cast<std::size_t>(contact - contacts_.begin());
  return parsed;
}

void History::add(std::size_t participant, const std::vector<double>& values) {
  auto& stream = streams_[participant];
  const std::size_t width = stream.columns.size();
  for (std::size_t begin = 0; begin + width <= values.size(); begin += width) {
    const auto first = values.begin() + static_cast<std::ptrdiff_t>(begin);
    if (!(*first > stream.last_window)) {
      throw ProtocolError(fmt::format("participant '{}' sent the history row of window {} after that of window {}",
                                      stream.participant, *first, stream.last_window));
    }
    stream.last_window = *first;
    stream.rows.emplace_back(first, first + static_cast<std::ptrdiff_t>(width));
  }
}

void History::Stream::archive(Archive& a) {
  a(rows, last_window, first_created_j);
  for (const auto& row : rows) {
    if (row.size() != columns.size()) a.refuse("history rows of other columns");
  }
}

void History::archive(Archive& a) {
  const auto participants = streams_.size();
  a(streams_, errors_);
  if (streams_.size() != participants) a.refuse("other participants");
}

void History::check_windows() const {
  for (const auto& stream : streams_) {
    const auto& reference = streams_.front();
    if (stream.rows.front()[0] == reference.rows.front()[0]) continue;
    throw ProtocolError(
        fmt::format("history rows disagree: participant '{}' reports window {}, participant '{}' window {}",
                    reference.participant, reference.rows.front()[0], stream.participant, stream.rows.front()[0]));
  }
}

std::optional<HistoryRow> History::next(const WindowClock& clock) {
  for (const auto& stream : streams_) {
    if (stream.rows.empty()) return std::nullopt;
  }
  check_windows();
  HistoryRow row;
  row.window = static_cast<std::int64_t>(streams_.front().rows.front()[0]);
  row.time_s = clock.time_s(row.window);
  row.bodies.resize(bodies_.size());
  row.contact.contacts.resize(contacts_.size());
  for (auto& stream : streams_) merge(stream, row);
  for (const auto& body : row.bodies) add_to(row.sum, body);
  errors_.add(row);
  return row;
}

void History::merge(Stream& stream, HistoryRow& row) const {
  const auto values = std::move(stream.rows.front());
  stream.rows.pop_front();
  BodyTotals own;  // of this participant
  double friction = 0;
  for (std::size_t c = 1; c < values.size(); ++c) {
    const auto& column = stream.columns[c];
    if (column.of_contacts) {
      row.contact.*column.of_contacts = values[c];
      if (column.of_contacts == &ContactRecord::energy_friction_j) friction = values[c];
      continue;
    }
    if (column.of_one_contact) {
      row.contact.contacts[column.contact].*column.of_one_contact = values[c];
      continue;
    }
    join(column.of_body, values[c], own);
    join(column.of_body, values[c], column.body >= 0 ? row.bodies[static_cast<std::size_t>(column.body)] : row.sum);
  }
  const double created = own.energy_kinetic_j + own.energy_strain_j + own.plastic_work_j + friction -
                         own.energy_external_j - own.energy_interface_j;
  if (!stream.first_created_j) stream.first_created_j = created;
  row.created_j.push_back(created - *stream.first_created_j);
}

std::vector<std::string> contacts_named_in(const std::vector<std::string>& columns) {
  std::vector<std::string> names;
  for (const auto& column : columns) {
    const auto slash = column.find('/');
    if (slash == std::string::npos || !member_of(named_contact_quantities, column.substr(0, slash))) continue;
    const auto name = column.substr(slash + 1);
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  }
  return names;
}

}  // namespace ricochet::coupler

#include "coupler/study/study_measures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "common/base/error.hpp"
#include "coupler/results/theory.hpp"

namespace ricochet::coupler {
namespace {

/// Midpoints of a period at which histories are compared.
constexpr int samples = 4000;
constexpr const char* of_probe = "probe/";

std::optional<double> value_of(const nlohmann::ordered_json& summary, const char* key) {
  const auto found = summary.find(key);
  return found != summary.end() && found->is_number() ? std::optional(found->get<double>()) : std::nullopt;
}

double contact_period_s(const ContactObservation& of) { return of.contact_end_s - of.contact_begin_s; }

/// A history of means over the windows that end at the rows: each stands at the middle of its window, and no window
/// ends at the first row.
Curve window_means(const std::vector<double>& time_s, const std::vector<double>& values, double window_s) {
  Curve curve;
  for (std::size_t row = std::min<std::size_t>(1, time_s.size()); row < time_s.size(); ++row) {
    curve.time_s.push_back(time_s[row] - 0.5 * window_s);
    curve.value.push_back(values[row]);
  }
  return curve;
}

bool is_velocity(const std::string& column) { return column.rfind("velocity_mean_", 0) == 0; }

/// RMS over the contact period of the reference, over the mean of the plateau of its history `level`.
std::optional<double> history_error(const Curve& run, const Curve& curve, const Curve& level,
                                    const ContactObservation& reference) {
  const auto rms = rms_difference(run, curve, reference);
  if (!rms) return {};
  double plateau = 0.0;
  for (int i = 0; i < samples; ++i) {
    const double phase = 0.15 + 0.5 * (i + 0.5) / samples;
    plateau += level.at(reference.contact_begin_s + phase * contact_period_s(reference)) / samples;
  }
  return *rms / std::abs(plateau);
}

/// Where the reference knows no friction there is nothing to be right or wrong.
std::optional<double> friction_error(Curve ContactObservation::*friction, const ContactObservation& run,
                                     const ContactObservation& reference) {
  const auto& force = (reference.*friction).value;
  if (std::all_of(force.begin(), force.end(), [](double n) { return n == 0.0; })) return {};
  return history_error(run.*friction, reference.*friction, reference.contact_force_n, reference);
}

std::optional<double> relative(const std::optional<double>& run, const std::optional<double>& reference, double scale) {
  if (!run || !reference || !(scale > 0.0)) return {};
  return std::abs(*run - *reference) / scale;
}

std::optional<double> rebound_error(const Observation& run, const Observation& reference) {
  if (run.rebound_velocity_m_s.size() != reference.rebound_velocity_m_s.size() || !(reference.greatest_speed_m_s > 0.0))
    return {};
  double largest = 0.0;
  for (std::size_t b = 0; b < run.rebound_velocity_m_s.size(); ++b) {
    largest = std::max(largest, std::abs(run.rebound_velocity_m_s[b] - reference.rebound_velocity_m_s[b]));
  }
  return largest / reference.greatest_speed_m_s;
}

/// "QUANTITY/CONTACT", or a quantity of all contacts.
struct QuantityName {
  std::string quantity, contact;

  explicit QuantityName(const std::string& name) : quantity(name.substr(0, name.find('/'))) {
    if (quantity.size() < name.size()) contact = name.substr(quantity.size() + 1);
  }
  /// A contact that is not there is one of which nothing is known.
  [[nodiscard]] const ContactObservation& of(const Observation& seen) const {
    static const ContactObservation unknown;
    if (contact.empty()) return seen;
    const auto found = seen.contacts.find(contact);
    return found == seen.contacts.end() ? unknown : found->second;
  }
};

/// Root of the mean square of the difference from `begin_s` to `end_s`.
double rms_between(const Curve& run, const Curve& reference, double begin_s, double end_s) {
  double squares = 0.0;
  for (int i = 0; i < samples; ++i) {
    const double time_s = begin_s + (i + 0.5) / samples * (end_s - begin_s);
    const double difference = run.at(time_s) - reference.at(time_s);
    squares += difference * difference;
  }
  return std::sqrt(squares / samples);
}

/// A value that nobody told is nan, and so is an error with it.
std::optional<double> probe_error(const std::string& column, const Observation& run, const Observation& reference) {
  const auto own = run.probes.find(column), other = reference.probes.find(column);
  if (own == run.probes.end() || other == reference.probes.end()) return {};
  const Curve &curve = own->second, &exact = other->second;
  if (curve.time_s.empty() || exact.time_s.empty()) return {};
  double largest = 0.0;
  for (const double value : exact.value) largest = std::max(largest, std::abs(value));
  const double error = rms_between(curve, exact, exact.time_s.front(), exact.time_s.back()) / largest;
  return std::isfinite(error) ? std::optional(error) : std::nullopt;
}

std::optional<double> contact_error(const std::string& quantity, const ContactObservation& run,
                                    const ContactObservation& reference) {
  if (quantity == "contact_force")
    return history_error(run.contact_force_n, reference.contact_force_n, reference.contact_force_n, reference);
  if (quantity == "friction_force") return friction_error(&ContactObservation::friction_force_n, run, reference);
  if (quantity == "friction_force_b") return friction_error(&ContactObservation::friction_force_b_n, run, reference);
  if (quantity == "peak_force")
    return relative(run.peak_force_n, reference.peak_force_n, reference.peak_force_n.value_or(0));
  if (quantity == "separation_time")
    return relative(run.separation_time_s, reference.separation_time_s, contact_period_s(reference));
  throw std::logic_error("no quantity " + quantity);
}

const std::vector<double>& column_of(const report::HistoryTable& history, const std::string& name) {
  const auto* values = history.find(name);
  if (values == nullptr) throw ConfigError(fmt::format("history.csv has no column {}", name));
  return *values;
}

/// From the columns whose names end in `suffix`, and what the summary says of them.
ContactObservation observe_contact(const report::HistoryTable& history, const std::string& suffix,
                                   const nlohmann::ordered_json& summary, double window_s) {
  ContactObservation seen;
  const auto column = [&](const std::string& name) -> const std::vector<double>& {
    return column_of(history, name + suffix);
  };
  const auto &time_s = column_of(history, "time_s"), &force_n = column("contact_force_n");
  seen.contact_pressure_pa = window_means(time_s, column("contact_pressure_mean_pa"), window_s);
  seen.contact_force_n = window_means(time_s, force_n, window_s);
  seen.friction_force_n = window_means(time_s, column("friction_force_n"), window_s);
  if (const auto* along_b = history.find("friction_force_b_n" + suffix))
    seen.friction_force_b_n = window_means(time_s, *along_b, window_s);
  const auto touches = [](double force) { return force > 0.0; };
  const auto first = std::find_if(force_n.begin(), force_n.end(), touches);
  if (first != force_n.end()) {
    const auto last = std::find_if(force_n.rbegin(), force_n.rend(), touches).base() - 1;
    seen.contact_begin_s = time_s[static_cast<std::size_t>(first - force_n.begin())] - window_s;
    seen.contact_end_s = time_s[static_cast<std::size_t>(last - force_n.begin())];
  }
  seen.peak_force_n = value_of(summary, "peak_contact_force_n");
  seen.separation_time_s = value_of(summary, "separation_time_s");
  return seen;
}

void require(bool holds, const scene::Scene& scene, const std::string& found) {
  if (!holds) {
    throw ConfigError(
        fmt::format("{}: found {}; allowed with reference.exact = \"impedance_theory\": two bars without "
                    "supports and loads, the one of lower impedance returning its wave first",
                    scene.path, found));
  }
}

/// Mass of a bar on which nothing acts but the contact.
double free_mass_kg(const scene::Scene& scene, const scene::Body& body) {
  const auto still = [](const std::vector<double>& values) {
    return std::all_of(values.begin(), values.end(), [](double x) { return x == 0.0; });
  };
  const bool free = body.supports.empty() && body.tractions.empty() && body.prescribed.empty();
  require(free && still(body.gravity_m_s2), scene, fmt::format("supports or loads of '{}'", body.name));
  require(still(body.initial_displacement_start_m) && still(body.initial_displacement_end_m), scene,
          fmt::format("an initial displacement of '{}'", body.name));
  const auto* mesh = body.structured();
  require(mesh != nullptr, scene, fmt::format("a mesh of pieces or of a file for '{}'", body.name));
  return body.material.density_kg_m3 * body.area_m2 * mesh->length_m;
}

}  // namespace

double Curve::at(double t) const {
  const auto after = std::upper_bound(time_s.begin(), time_s.end(), t);
  if (after == time_s.begin()) return value.front();
  if (after == time_s.end()) return value.back();
  const auto i = static_cast<std::size_t>(after - time_s.begin());
  return value[i - 1] + (value[i] - value[i - 1]) * (t - time_s[i - 1]) / (time_s[i] - time_s[i - 1]);
}

Observation observe(const report::HistoryTable& history, const nlohmann::ordered_json& summary,
                    const report::HistoryTable& probes) {
  Observation seen;
  for (std::size_t c = 1; c < probes.columns.size(); ++c)
    seen.probes[probes.names[c]] = {probes.columns.front(), probes.columns[c]};
  const double window_s = value_of(summary, "window_size_s").value_or(0.0);
  static_cast<ContactObservation&>(seen) = observe_contact(history, "", summary, window_s);
  if (const auto contacts = summary.find("contacts"); contacts != summary.end()) {
    for (const auto& [name, of_contact] : contacts->items())
      seen.contacts[name] = observe_contact(history, "/" + name, of_contact, window_s);
  }
  seen.principal_stress_pa = {column_of(history, "time_s"), column_of(history, "principal_stress_mean_pa")};
  // Contact nodes without implicit elements: their stress is not zero, it is not known.
  const auto& stress = seen.principal_stress_pa.value;
  if (seen.contact_end_s > seen.contact_begin_s &&
      std::all_of(stress.begin(), stress.end(), [](double pa) { return pa == 0.0; }))
    seen.principal_stress_pa = {};
  seen.energy_drift = value_of(summary, "energy_error_max");
  for (std::size_t c = 0; c < history.names.size(); ++c) {
    if (!is_velocity(history.names[c]) || history.columns[c].empty()) continue;
    seen.rebound_velocity_m_s.push_back(history.columns[c].back());
    for (const double v : history.columns[c]) seen.greatest_speed_m_s = std::max(seen.greatest_speed_m_s, std::abs(v));
  }
  return seen;
}

Observation exact_impact(const scene::Problem& problem) {
  const auto& scene = problem.scene;
  const std::string other = "another model, another number of bodies, or bodies that do not approach each other";
  require(scene.model == scene::Model::bar && scene.bodies.size() == 2, scene, other);
  require(scene.foreign_bodies.empty(), scene, "a foreign body");
  std::vector<double> masses_kg;  // refused here, where the reason is known, if a body does not fly freely
  for (const auto& body : scene.bodies) masses_kg.push_back(free_mass_kg(scene, body));
  const auto theory = impact_theory(problem);
  require(theory.has_value(), scene, other);
  require(theory->other_body_returns_later, scene, "a wave of the other bar that changes the force before the end");
  Observation exact;
  const auto& pair = problem.contacts.front().pairs.front();
  const double begin_s = pair.gap0_m / theory->closing_velocity_m_s, end_s = begin_s + theory->contact_duration_s;
  const double force_n = theory->stress_pa * pair.area_m2;
  exact.contact_begin_s = begin_s;
  exact.contact_end_s = end_s;
  exact.contact_pressure_pa = {{begin_s, begin_s, end_s, end_s}, {0.0, theory->stress_pa, theory->stress_pa, 0.0}};
  exact.principal_stress_pa = exact.contact_pressure_pa;
  exact.contact_force_n = {exact.contact_pressure_pa.time_s, {0.0, force_n, force_n, 0.0}};
  exact.peak_force_n = force_n;
  exact.separation_time_s = end_s;
  for (int b = 0; b < 2; ++b) {
    const auto& body = scene.bodies[static_cast<std::size_t>(b)];
    const double mass_kg = masses_kg[static_cast<std::size_t>(b)],
                 direction = b == problem.contacts.front().body_a ? -1.0 : 1.0;
    const double before =
        body.initial_velocity_m_s.empty() ? 0.0 : problem.contacts.front().normal[0] * body.initial_velocity_m_s[0];
    const double after = before + direction * force_n * theory->contact_duration_s / mass_kg;
    exact.rebound_velocity_m_s.push_back(after);
    exact.greatest_speed_m_s = std::max({exact.greatest_speed_m_s, std::abs(before), std::abs(after)});
  }
  exact.energy_drift = 0.0;
  return exact;
}

std::vector<std::string> quantity_names(const MeasuredScene& scene) {
  std::vector<std::string> names{"contact_force",   "principal_stress", "friction_force", "peak_force",
                                 "separation_time", "rebound_velocity", "energy_drift"};
  if (scene.solid) names.insert(names.begin() + 3, "friction_force_b");
  return names;
}

std::vector<std::string> more_quantity_names(const MeasuredScene& scene) {
  std::vector<std::string> names;
  for (const auto& contact : scene.contacts) {
    for (const char* quantity :
         {"contact_force", "friction_force", "friction_force_b", "peak_force", "separation_time"}) {
      if (scene.solid || quantity != std::string("friction_force_b"))
        names.push_back(fmt::format("{}/{}", quantity, contact));
    }
  }
  for (const auto& column : scene.probes) names.push_back(of_probe + column);
  return names;
}

std::vector<std::string> history_names(const MeasuredScene& scene) {
  std::vector<std::string> names{"contact_pressure", "principal_stress"};
  for (const auto& contact : scene.contacts) names.push_back("contact_pressure/" + contact);
  return names;
}

const Curve& history_of(const std::string& quantity, const Observation& of) {
  if (quantity == "principal_stress") return of.principal_stress_pa;
  return QuantityName(quantity).of(of).contact_pressure_pa;
}

std::optional<double> rms_difference(const std::string& quantity, const Observation& run, const Observation& other) {
  return rms_difference(history_of(quantity, run), history_of(quantity, other), QuantityName(quantity).of(other));
}

std::optional<double> rms_difference(const Curve& run, const Curve& reference, const ContactObservation& of) {
  const double period_s = contact_period_s(of);
  if (!(period_s > 0.0) || run.time_s.empty() || reference.time_s.empty()) return {};
  return rms_between(run, reference, of.contact_begin_s, of.contact_end_s);
}

std::optional<double> error_of(const std::string& quantity, const Observation& run, const Observation& reference) {
  if (quantity == "principal_stress")
    return history_error(run.principal_stress_pa, reference.principal_stress_pa, reference.principal_stress_pa,
                         reference);
  if (quantity == "rebound_velocity") return rebound_error(run, reference);
  if (quantity == "energy_drift") return run.energy_drift;
  if (quantity.starts_with(of_probe)) return probe_error(quantity.substr(std::strlen(of_probe)), run, reference);
  const QuantityName name(quantity);
  return contact_error(name.quantity, name.of(run), name.of(reference));
}

}  // namespace ricochet::coupler

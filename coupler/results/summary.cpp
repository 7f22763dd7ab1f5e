#include "coupler/results/summary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "common/base/computer.hpp"

namespace ricochet::coupler {
namespace {

using Json = nlohmann::ordered_json;

/// JSON has no nan or infinity; they become null.
Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }
Json number(const std::optional<double>& value) { return value ? number(*value) : Json(nullptr); }

std::string_view transport_text(const ProcessTimes& process) {
  if (process.inside) return "inside";
  return process.transport ? name_of(*process.transport) : "";
}

Json process_json(const ProcessTimes& process) {
  Json waited = Json::object();
  for (const auto& entry : process.waited_for) waited[entry.whom] = number(entry.time_s);
  return {{"name", process.name},
          {"role", process.role ? name_of(*process.role) : "coupler"},
          {"process_id", process.process_id},
          {"transport", transport_text(process)},
          {"wall_s", number(process.wall_s)},
          {"compute_s", number(process.compute_s)},
          {"wait_s", number(process.wait_s)},
          {"waited_for_s", waited}};
}

/// `solid`: with its z.
Json departed_json(const Departed& d, bool solid) {
  const auto json_of = [solid](const std::array<double, 3>& place_m) {
    Json place = {number(place_m[0]), number(place_m[1])};
    if (solid) place.push_back(number(place_m[2]));
    return place;
  };
  return {{"kind", d.kind},
          {"body", d.body},
          {"size", number(d.size)},
          {"first_s", number(d.first_s)},
          {"first_size", number(d.first_size)},
          {"first_place_m", json_of(d.first_place_m)},
          {"last_without_s", number(d.within_s)},
          {"time_s", number(d.time_s)},
          {"place_m", json_of(d.place_m)},
          {"looks", d.looks},
          {"results_wrong", d.wrong},
          {"text", d.text}};
}

Json theory_json(const ImpactTheory& theory) {
  return {{"contact_duration_s", number(theory.contact_duration_s)},
          {"contact_duration_body", theory.body},
          {"contact_stress_pa", number(theory.stress_pa)},
          {"first_step_s", number(theory.first_step_s)}};
}

/// The force to quote: that after 2h/c, or the largest there is.
ForceTally::Peak headline(const ForceTally& forces) { return forces.settled().value_or(forces.largest()); }

/// Writes the forces of one contact, or of all together.
void put_forces(const ForceTally& forces, Json& json) {
  json["first_contact_s"] = number(forces.first_contact_s());
  json["separation_time_s"] = number(forces.separation_time_s());
  json["peak_contact_force_n"] = number(headline(forces).force_n);
  json["peak_contact_force_s"] = number(forces.time_s(headline(forces).window));
  json["first_window_force_n"] = number(forces.first_window_n());
  json["gauge_peak_force_n"] = number(forces.gauge_n());
  json["rise_time_s"] = number(forces.rise_time_s());
  json["contact_level_n"] = number(forces.level_n());
}

Json contact_json(const ContactTally& contact) {
  return {{"iterations_mean", number(contact.iterations_mean)},
          {"iterations_max", number(contact.iterations_max)},
          {"residual_max", number(contact.residual_max)},
          {"windows_unconverged", contact.windows_unconverged}};
}

/// A contact that has none says so.
Json radius(double largest_m) { return largest_m > 0 ? number(largest_m) : Json(nullptr); }

Json result_json(const ContactResult& contact, bool solid) {
  Json json;
  put_forces(contact.forces, json);
  json["peak_contact_pressure_pa"] = number(contact.peak_pressure_pa);
  json["largest_contact_radius_m"] = radius(contact.largest_radius_m);
  json["contact_impulse_n_s"] = number(contact.last.contact_impulse_n_s);
  json["friction_impulse_n_s"] = number(contact.last.friction_impulse_n_s);
  if (solid) json["friction_impulse_b_n_s"] = number(contact.last.friction_impulse_b_n_s);
  return json;
}

std::string row(const std::string& label, const std::string& value) {
  return fmt::format("  {:<24} {}\n", label, value);
}

/// In the unit that shows it best: an impact lasts microseconds, a model problem seconds.
std::string duration(double time_s) {
  if (std::abs(time_s) < 1e-3) return fmt::format("{:.4f} us", 1e6 * time_s);
  return std::abs(time_s) < 1.0 ? fmt::format("{:.4f} ms", 1e3 * time_s) : fmt::format("{:.4f} s", time_s);
}

std::string named_contact_row(const ContactResult& contact) {
  const auto time = [](const std::optional<double>& time_s, const char* otherwise) {
    return time_s ? duration(*time_s) : std::string(otherwise);
  };
  return row(fmt::format("contact '{}'", contact.name),
             fmt::format("first {}, separation {}, impulse {:.6g} N s, peak {:.6g} N",
                         time(contact.forces.first_contact_s(), "never"),
                         time(contact.forces.separation_time_s(), "not within this run"),
                         contact.last.contact_impulse_n_s, headline(contact.forces).force_n));
}

/// Peaks, each with what it is of, and what counts as contact.
std::string force_rows(const ForceTally& forces) {
  const auto peak = headline(forces);
  const std::string when = fmt::format("{:.6g} N at {}", peak.force_n, duration(forces.time_s(peak.window)));
  const std::string after = duration(forces.rise_time_s());
  std::string text =
      row("peak contact force", forces.settled() ? fmt::format("{}, after the first 2h/c = {} of contact", when, after)
                                                 : fmt::format("{}, in a contact shorter than 2h/c = {}", when, after));
  text += row("", fmt::format("{:.6g} N in the first window; {:.6g} N for a gauge that means over 2h/c",
                              forces.first_window_n(), forces.gauge_n()));
  return text + row("in contact", fmt::format("from {} on: force above {:.3g} N, {:g} of the largest",
                                              duration(forces.first_contact_s().value_or(0.0)), forces.level_n(),
                                              ForceTally::level_share));
}

/// The line for a run in which nothing was in contact.
std::string no_contact_row(const Tally& tally) {
  if (!tally.forces) return row("contact", "none in this scene");
  const bool gap_known = tally.gap_smallest_m < std::numeric_limits<double>::max();
  return row("contact", "none in this run: the bodies never met" +
                            (gap_known ? fmt::format("; smallest gap {:.4g} m", tally.gap_smallest_m) : ""));
}

std::string contact_rows(const Tally& tally) {
  if (!tally.first_contact_s()) return no_contact_row(tally);
  std::string text;
  const auto& theory = tally.theory();
  const double first = tally.first_contact_s().value_or(0.0);
  const auto separation_s = tally.forces->separation_time_s();
  std::string separation = separation_s ? duration(*separation_s) : "not within this run";
  if (theory) {
    separation += fmt::format("   (first contact + 2L/c of '{}': {})", theory->body,
                              duration(first + theory->contact_duration_s));
  }
  text += row("separation", separation);
  if (theory && tally.plateau_stress_pa()) {
    text += row("mean interface stress", fmt::format("{:.2f} MPa   (impedance theory: {:.2f} MPa)",
                                                     1e-6 * *tally.plateau_stress_pa(), 1e-6 * theory->stress_pa));
  }
  if (tally.each_contact.empty()) text += force_rows(*tally.forces);
  if (tally.each_contact.empty() && tally.largest_contact_radius_m > 0)
    text += row("largest pressure",
                fmt::format("{:.4g} MPa, on a circle of at most {:.4g} mm radius",
                            1e-6 * tally.peak_contact_pressure_pa, 1e3 * tally.largest_contact_radius_m));
  for (const auto& contact : tally.each_contact) text += named_contact_row(contact);
  if (!tally.each_contact.empty())
    text +=
        row("in contact", fmt::format("by a force above {:g} of the largest of that contact", ForceTally::level_share));
  return text;
}

std::string switch_rows(const Summary& summary) {
  constexpr std::size_t shown = 4;  // a body that bounces switches at every flight
  std::string text;
  for (std::size_t i = 0; i < std::min(shown, summary.switches.size()); ++i) {
    const auto& event = summary.switches[i];
    text += row("integration switched", fmt::format("to {} at {}", name_of(event.to), duration(event.time_s)));
  }
  const std::size_t more = summary.switches.size() - std::min(shown, summary.switches.size());
  return more == 0 ? text : text + row("", fmt::format("and {} times more, see summary.json", more));
}

std::string process_rows(const Summary& summary) {
  std::string text = fmt::format("  {:<14} {:>9} {:>9} {:>11} {:>9}  {}\n", "process", "transport", "wall s",
                                 "compute s", "wait s", "waited for (s)");
  const auto shown = [](const std::optional<double>& value) {
    return value ? fmt::format("{:.3f}", *value) : std::string("-");
  };
  for (const auto& process : summary.processes) {
    std::vector<std::string> waited;
    for (const auto& entry : process.waited_for) waited.push_back(fmt::format("{} {:.3f}", entry.whom, entry.time_s));
    text += fmt::format("  {:<14} {:>9} {:>9.3f} {:>11} {:>9}  {}\n", process.name, transport_text(process),
                        process.wall_s, shown(process.compute_s), shown(process.wait_s), fmt::join(waited, ", "));
  }
  return text;
}

}  // namespace

std::string contact_warning(const Tally& tally) {
  if (tally.contact.windows_unconverged == 0) return "";
  return fmt::format(
      "{} window{} whose contact forces were not found to 1e-6 of the largest one; worst residual {:.2g}",
      tally.contact.windows_unconverged, tally.contact.windows_unconverged == 1 ? "" : "s", tally.contact.residual_max);
}

std::string substeps_warning(const Summary& summary, const Tally& tally) {
  const bool known = summary.interface_known && summary.substeps > 1;
  if (!known || tally.interface_energy_max < largest_interface_energy) return "";
  return fmt::format(
      "the interface made or lost up to {:.2g} % of the energy: windows of {} substeps are too long for the waves that "
      "cross it, expect errors of forces and rebound of that size; fewer coupling.substeps have less",
      100.0 * tally.interface_energy_max, summary.substeps);
}

std::string to_json(const Summary& s, const Tally& tally) {
  const auto of_energy = [&s](double value) { return s.energy_not_told_by.empty() ? number(value) : Json(nullptr); };
  const auto of_momentum = [&s](double value) {
    return s.momentum_not_told_by.empty() ? number(value) : Json(nullptr);
  };
  Json json = {{"status", name_of(s.status)},
               {"error", s.error},
               {"exit_code", s.exit_code},
               {"protocol", s.protocol},
               {"transport", name_of(s.transport)},
               {"windows", s.windows},
               {"windows_planned", s.windows_planned},
               {"window_size_s", number(s.clock.size_s(1))},
               {"end_time_s", number(s.clock.time_s(s.windows))},
               {"wall_s", number(s.wall_s)},
               {"cpu_s", number(s.cpu_s)},
               {"phases",
                {{"start_s", number(s.phases.start_s)},
                 {"setup_s", number(s.phases.setup_s)},
                 {"stepping_s", number(s.phases.stepping_s)},
                 {"finish_s", number(s.phases.finish_s)}}},
               {"energy_error_max", of_energy(tally.energy_error_max())},
               {"energy_error_lowest", of_energy(tally.energy_error_lowest)},
               {"energy_error_highest", of_energy(tally.energy_error_highest)},
               {"energy_error_last", of_energy(tally.energy_error_last)},
               {"momentum_error_max", of_momentum(tally.momentum_error_max)},
               {"angular_momentum_error_max", number(tally.angular_momentum_error_max)},
               {"peak_contact_pressure_pa", number(tally.peak_contact_pressure_pa)},
               {"largest_contact_radius_m", radius(tally.largest_contact_radius_m)},
               {"contact_impulse_n_s", number(tally.contact_impulse_n_s)},
               {"friction_impulse_n_s", number(tally.friction_impulse_n_s)}};
  put_forces(tally.forces.value_or(ForceTally{}), json);
  if (tally.solid()) json["friction_impulse_b_n_s"] = number(tally.friction_impulse_b_n_s);
  if (!tally.each_contact.empty()) {  // in series they hand on one force, which a sum would count twice
    for (const char* of_one : {"peak_contact_force_n", "peak_contact_force_s", "first_window_force_n",
                               "gauge_peak_force_n", "contact_impulse_n_s", "friction_impulse_n_s"})
      json[of_one] = nullptr;
    json.erase("friction_impulse_b_n_s");
  }
  json["contact"] = contact_json(tally.contact);
  for (const auto& contact : tally.each_contact) json["contacts"][contact.name] = result_json(contact, tally.solid());
  json["plateau_stress_pa"] = number(tally.plateau_stress_pa());
  if (tally.theory()) json["theory"] = theory_json(*tally.theory());
  if (tally.plastic) {
    json["plastic_work_j"] = number(tally.plastic->work_j);
    json["equivalent_plastic_strain_max"] = number(tally.plastic->largest_equivalent_strain);
    if (tally.plastic->hottest_k > 0) json["temperature_max_k"] = number(tally.plastic->hottest_k);
  }
  if (tally.highest_modes_energy_max) json["highest_modes_energy_max"] = number(*tally.highest_modes_energy_max);
  json["added_mass_kg"] = number(s.added_mass_kg);
  json["added_mass_share"] = number(s.added_mass_share);
  json["largest_drift"] = number(s.largest_drift);
  json["interface_drift_m"] = number(s.interface_drift_m);
  json["interface_energy_max"] = s.interface_known ? number(tally.interface_energy_max) : Json(nullptr);
  json["energy_not_told_by"] = s.energy_not_told_by;
  json["momentum_not_told_by"] = s.momentum_not_told_by;
  json["limits"] = Json::array();
  for (const auto& limit : s.limits)
    json["limits"].push_back({{"body", limit.body},
                              {"yield_stress_pa", number(limit.yield_stress_pa)},
                              {"strength_pa", number(limit.strength_pa)}});
  json["outside_model"] = Json::array();
  for (const auto& departed : s.outside_model) json["outside_model"].push_back(departed_json(departed, tally.solid()));
  json["valid_until_s"] = number(s.valid_until_s);
  json["switches"] = Json::array();
  for (const auto& event : s.switches)
    json["switches"].push_back({{"time_s", number(event.time_s)}, {"to", name_of(event.to)}});
  json["notes"] = s.notes;
  json["processes"] = Json::array();
  for (const auto& process : s.processes) json["processes"].push_back(process_json(process));
  json["scene"] = s.scene_path;
  json["scene_sha256"] = s.scene_sha256;
  json["run_id"] = s.run_id;
  json["version"] = RICOCHET_VERSION;
  const Computer computer = this_computer();
  json["processor"] = computer.processor;
  json["blas"] = computer.blas;
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string to_table(const Summary& s, const Tally& tally) {
  const std::string status = s.status == RunStatus::left_model ? "left the model" : std::string(name_of(s.status));
  std::string text = fmt::format("{}: {} windows{} of {:.6g} s with {}, {:.3f} s wall\n", status, s.windows,
                                 s.clock.changes() ? ", the first" : "", s.clock.size_s(1), s.protocol, s.wall_s);
  text += contact_rows(tally);
  const auto balance = [](const std::vector<std::string>& not_told_by, const std::string& error) {
    return not_told_by.empty() ? error : fmt::format("not told by {}", fmt::join(not_told_by, ", "));
  };
  text +=
      row("energy drift", balance(s.energy_not_told_by, fmt::format("{:+.3e} at the end, {:+.3e} to {:+.3e} on the way",
                                                                    tally.energy_error_last, tally.energy_error_lowest,
                                                                    tally.energy_error_highest)));
  text += row("momentum error", balance(s.momentum_not_told_by, fmt::format("{:.3e}", tally.momentum_error_max)));
  if (tally.angular_momentum_error_max) {
    text += row("angular momentum error", fmt::format("{:.3e}", *tally.angular_momentum_error_max));
  }
  if (tally.plastic)
    text +=
        row("plastic work",
            fmt::format("{:.4g} J, equivalent plastic strain up to {:.3g}{}", tally.plastic->work_j,
                        tally.plastic->largest_equivalent_strain,
                        tally.plastic->hottest_k > 0 ? fmt::format(", up to {:.4g} K", tally.plastic->hottest_k) : ""));
  if (tally.highest_modes_energy_max)
    text += row("highest modes", fmt::format("at most {:.2g} of the energy in the highest tenth of those that are kept",
                                             *tally.highest_modes_energy_max));
  if (s.interface_drift_m > 0)
    text += row("interface drift", fmt::format("{:.3e} m between the two sides of a shared node", s.interface_drift_m));
  if (s.added_mass_kg > 0)
    text +=
        row("added mass", fmt::format("{:.6g} kg, {:.3g} % of the bodies', by mass scaling: momenta and energies are "
                                      "of the scaled masses",
                                      s.added_mass_kg, 100.0 * s.added_mass_share));
  text += switch_rows(s);
  for (const auto& note : s.notes) text += row("note", note);
  for (const auto& warning : {contact_warning(tally), substeps_warning(s, tally)}) {
    if (!warning.empty()) text += row("warning", warning);
  }
  for (const auto& departed : s.outside_model) text += row("outside the model", departed.text);
  return text + process_rows(s);
}

}  // namespace ricochet::coupler

#include "coupler/results/summary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

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

Json departed_json(const Departed& d) {
  return {{"kind", d.kind},
          {"body", d.body},
          {"size", number(d.size)},
          {"first_s", number(d.first_s)},
          {"time_s", number(d.time_s)},
          {"place_m", {number(d.x_m), number(d.y_m)}},
          {"looks", d.looks},
          {"results_wrong", d.wrong},
          {"text", d.text}};
}

Json theory_json(const Tally& tally) {
  if (!tally.theory()) return nullptr;
  return {{"contact_duration_s", number(tally.theory()->contact_duration_s)},
          {"contact_duration_body", tally.theory()->body},
          {"contact_stress_pa", number(tally.theory()->stress_pa)},
          {"first_step_s", number(tally.theory()->first_step_s)}};
}

Json contact_json(const ContactTally& contact) {
  return {{"iterations_mean", number(contact.iterations_mean)},
          {"iterations_max", number(contact.iterations_max)},
          {"residual_max", number(contact.residual_max)},
          {"windows_unconverged", contact.windows_unconverged}};
}

Json result_json(const ContactResult& contact, bool solid) {
  Json json = {{"first_contact_s", number(contact.first_contact_s())},
               {"separation_time_s", number(contact.separation_time_s())},
               {"peak_contact_force_n", number(contact.peak_force_n())},
               {"contact_impulse_n_s", number(contact.last().contact_impulse_n_s)},
               {"friction_impulse_n_s", number(contact.last().friction_impulse_n_s)}};
  if (solid) json["friction_impulse_b_n_s"] = number(contact.last().friction_impulse_b_n_s);
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
  return row(
      fmt::format("contact '{}'", contact.name()),
      fmt::format("first {}, separation {}, impulse {:.6g} N s, peak {:.6g} N",
                  time(contact.first_contact_s(), "never"), time(contact.separation_time_s(), "not within this run"),
                  contact.last().contact_impulse_n_s, contact.peak_force_n()));
}

std::string contact_rows(const Summary& summary, const Tally& tally) {
  std::string text;
  const auto& theory = tally.theory();
  const double first = tally.first_contact_s.value_or(0.0);
  std::string separation = summary.separation_time_s ? duration(*summary.separation_time_s) : "not within this run";
  if (theory) {
    separation += fmt::format("   (first contact + 2L/c of '{}': {})", theory->body,
                              duration(first + theory->contact_duration_s));
  }
  text += row("separation", separation);
  if (theory && tally.plateau_stress_pa()) {
    text += row("mean interface stress", fmt::format("{:.2f} MPa   (impedance theory: {:.2f} MPa)",
                                                     1e-6 * *tally.plateau_stress_pa(), 1e-6 * theory->stress_pa));
  }
  text += row("peak contact force", fmt::format("{:.6g} N", tally.peak_contact_force_n));
  for (const auto& contact : tally.each_contact) text += named_contact_row(contact);
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
               {"steps", s.steps},
               {"windows", s.windows},
               {"window_size_s", number(s.window_size_s)},
               {"end_time_s", number(static_cast<double>(s.steps) * s.window_size_s)},
               {"wall_s", number(s.wall_s)},
               {"cpu_s", number(s.cpu_s)},
               {"phases",
                {{"start_s", number(s.phases.start_s)},
                 {"setup_s", number(s.phases.setup_s)},
                 {"stepping_s", number(s.phases.stepping_s)},
                 {"finish_s", number(s.phases.finish_s)}}},
               {"first_contact_s", number(tally.first_contact_s)},
               {"separation_time_s", number(s.separation_time_s)},
               {"energy_error_max", of_energy(tally.energy_error_max())},
               {"energy_error_lowest", of_energy(tally.energy_error_lowest)},
               {"energy_error_highest", of_energy(tally.energy_error_highest)},
               {"energy_error_last", of_energy(tally.energy_error_last)},
               {"momentum_error_max", of_momentum(tally.momentum_error_max)},
               {"angular_momentum_error_max", of_momentum(tally.angular_momentum_error_max)},
               {"peak_contact_force_n", number(tally.peak_contact_force_n)},
               {"contact_impulse_n_s", number(tally.contact_impulse_n_s)},
               {"friction_impulse_n_s", number(tally.friction_impulse_n_s)}};
  if (tally.solid()) json["friction_impulse_b_n_s"] = number(tally.friction_impulse_b_n_s);
  json["contact"] = contact_json(tally.contact);
  for (const auto& contact : tally.each_contact) json["contacts"][contact.name()] = result_json(contact, tally.solid());
  json["plateau_stress_pa"] = number(tally.plateau_stress_pa());
  json["theory"] = theory_json(tally);
  json["largest_drift"] = number(s.largest_drift);
  json["interface_drift_m"] = number(s.interface_drift_m);
  json["energy_not_told_by"] = s.energy_not_told_by;
  json["momentum_not_told_by"] = s.momentum_not_told_by;
  json["outside_model"] = Json::array();
  for (const auto& departed : s.outside_model) json["outside_model"].push_back(departed_json(departed));
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
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string to_table(const Summary& s, const Tally& tally) {
  std::string text = fmt::format("{}: {} windows of {:.6g} s with {}, {:.3f} s wall\n", name_of(s.status), s.steps,
                                 s.window_size_s, s.protocol, s.wall_s);
  if (tally.first_contact_s) text += contact_rows(s, tally);
  const auto balance = [](const std::vector<std::string>& not_told_by, const std::string& error) {
    return not_told_by.empty() ? error : fmt::format("not told by {}", fmt::join(not_told_by, ", "));
  };
  text +=
      row("energy drift", balance(s.energy_not_told_by, fmt::format("{:+.3e} at the end, {:+.3e} to {:+.3e} on the way",
                                                                    tally.energy_error_last, tally.energy_error_lowest,
                                                                    tally.energy_error_highest)));
  text += row("momentum error", balance(s.momentum_not_told_by, fmt::format("{:.3e}", tally.momentum_error_max)));
  if (tally.angular_momentum_error_max > 0) {
    text += row("angular momentum error", fmt::format("{:.3e}", tally.angular_momentum_error_max));
  }
  if (s.interface_drift_m > 0)
    text += row("interface drift", fmt::format("{:.3e} m between the two sides of a shared node", s.interface_drift_m));
  text += switch_rows(s);
  for (const auto& note : s.notes) text += row("note", note);
  if (const auto warning = contact_warning(tally); !warning.empty()) text += row("warning", warning);
  for (const auto& departed : s.outside_model) text += row("outside the model", departed.text);
  return text + process_rows(s);
}

}  // namespace ricochet::coupler

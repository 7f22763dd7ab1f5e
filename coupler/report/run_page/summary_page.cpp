#include "coupler/report/run_page/summary_page.hpp"

#include <fmt/format.h>

#include <filesystem>

#include "common/base/error.hpp"
#include "common/base/vocabulary.hpp"
#include "coupler/report/parts/history_table.hpp"
#include "coupler/report/parts/quantity.hpp"
#include "coupler/report/parts/text.hpp"
#include "coupler/report/run_page/error_bars.hpp"

namespace ricochet::report {
namespace {

std::string data_cell(const std::string& text) { return "<td>" + escape_html(text) + "</td>"; }

std::string row(const std::string& name, const std::string& value) {
  return "<tr><th scope=\"row\">" + escape_html(name) + "</th><td colspan=\"3\">" + escape_html(value) + "</td></tr>\n";
}

std::string row(const std::string& name, const std::string& value, const std::string& theory,
                const std::string& difference) {
  return "<tr><th scope=\"row\">" + escape_html(name) + "</th>" + data_cell(value) + data_cell(theory) +
         data_cell(difference) + "</tr>\n";
}

std::string difference(double value, double theory) {
  return theory == 0 ? "" : fmt::format("{:+.2f} %", 100 * (value / theory - 1));
}

std::string shown(const std::optional<double>& value, const std::string& unit) {
  return value ? quantity(*value, unit) : "–";
}

std::string seconds(const Json& process, const std::string& key) {
  const auto value = number(process, key);
  return value ? fmt::format("{:.3f}", *value) : "–";
}

/// Beside the forces it is about: a reader of the page has not seen what the run said.
std::string unconverged_row(const Json& summary) {
  const Json contact = summary.value("contact", Json::object());
  const auto windows = contact.value("windows_unconverged", 0LL);
  if (windows == 0) return "";
  return row("windows whose contact forces were not found",
             fmt::format("{}; worst residual {:.2g} of the largest force, 1e-6 is wanted", windows,
                         number(contact, "residual_max").value_or(0.0)));
}

/// One of several contacts.
std::string named_contact_row(const std::string& name, const Json& contact) {
  const auto first = number(contact, "first_contact_s"), separation = number(contact, "separation_time_s");
  if (!first) return row("contact " + name, "never");
  return row("contact " + name, fmt::format("first {}, separation {}, peak {}, impulse {}", quantity(*first, "s"),
                                            separation ? quantity(*separation, "s") : "not within this run",
                                            shown(number(contact, "peak_contact_force_n"), "N"),
                                            shown(number(contact, "contact_impulse_n_s"), "N s")));
}

std::string contact_rows(const Json& summary) {
  const auto first = number(summary, "first_contact_s"), separation = number(summary, "separation_time_s");
  if (!first) {
    // In a scene without contact the run has no level of forces, either.
    const bool none = number(summary, "rise_time_s").value_or(0.0) == 0.0;
    return row("contact", none ? "none in this scene" : "none in this run: the bodies never met");
  }
  std::string text = row("first contact", fmt::format("{} (force above {}, 1e-3 of the largest)", quantity(*first, "s"),
                                                      shown(number(summary, "contact_level_n"), "N")));
  const Json theory = summary.value("theory", Json());
  if (theory.is_null()) {
    text += row("separation", separation ? quantity(*separation, "s") : "not within this run");
  } else {
    const double duration = number(theory, "contact_duration_s").value_or(0.0);
    text += row("separation", separation ? quantity(*separation, "s") : "not within this run",
                fmt::format("{} (first contact + 2L/c of {})", quantity(*first + duration, "s"),
                            theory.value("contact_duration_body", "")),
                separation ? difference(*separation - *first, duration) : "");
    const auto plateau = number(summary, "plateau_stress_pa"), stress = number(theory, "contact_stress_pa");
    text += row("mean interface stress", shown(plateau, "Pa"), shown(stress, "Pa") + " (impedance theory)",
                plateau && stress ? difference(*plateau, *stress) : "");
  }
  const Json contacts = summary.value("contacts", Json::object());
  if (contacts.empty()) {
    text += row("peak contact force, after the first 2h/c",
                fmt::format("{} at {}", shown(number(summary, "peak_contact_force_n"), "N"),
                            shown(number(summary, "peak_contact_force_s"), "s"))) +
            row("force in the first window", shown(number(summary, "first_window_force_n"), "N")) +
            row("peak of a gauge that means over 2h/c",
                fmt::format("{} (2h/c = {})", shown(number(summary, "gauge_peak_force_n"), "N"),
                            shown(number(summary, "rise_time_s"), "s"))) +
            row("contact impulse", shown(number(summary, "contact_impulse_n_s"), "N s")) +
            row("largest contact pressure", shown(number(summary, "peak_contact_pressure_pa"), "Pa"));
    if (const auto radius = number(summary, "largest_contact_radius_m"))
      text += row("largest contact radius", quantity(*radius, "m"));
  }
  for (const auto& [name, contact] : contacts.items()) text += named_contact_row(name, contact);
  return text + unconverged_row(summary);
}

std::string balance_rows(const Json& summary) {
  const auto last = number(summary, "energy_error_last"), lowest = number(summary, "energy_error_lowest"),
             highest = number(summary, "energy_error_highest"), momentum = number(summary, "momentum_error_max");
  std::string text;
  for (const auto& [label, key] :
       {std::pair{"energy drift", "energy_not_told_by"}, std::pair{"momentum error", "momentum_not_told_by"}}) {
    const auto names = summary.value(key, std::vector<std::string>());
    if (!names.empty()) text += row(label, fmt::format("not told by {}", fmt::join(names, ", ")));
  }
  if (last && lowest && highest) {
    text +=
        row("energy drift", fmt::format("{:+.3e} at the end, {:+.3e} to {:+.3e} on the way", *last, *lowest, *highest));
  }
  if (momentum) text += row("momentum error", fmt::format("{:.3e}", *momentum));
  const auto angular = number(summary, "angular_momentum_error_max"), drift = number(summary, "interface_drift_m");
  if (angular) text += row("angular momentum error", fmt::format("{:.3e}", *angular));
  if (drift && *drift > 0) text += row("interface drift", quantity(*drift, "m"));
  if (const auto share = number(summary, "interface_energy_max"); drift && *drift > 0 && share)
    text += row("energy that the interface made or lost", fmt::format("up to {:.2g} %", 100.0 * *share));
  return text;
}

std::string course_rows(const Json& summary) {
  std::string text = row(
      "windows", fmt::format("{} of {} each, up to {}", summary.value("windows", 0LL),
                             shown(number(summary, "window_size_s"), "s"), shown(number(summary, "end_time_s"), "s")));
  std::string switches;
  for (const auto& event : summary.value("switches", Json::array())) {
    switches += fmt::format("{}to {} at {}", switches.empty() ? "" : ", ", event.value("to", ""),
                            shown(number(event, "time_s"), "s"));
  }
  if (!switches.empty()) text += row("integration switched", switches);
  for (const auto& note : summary.value("notes", Json::array())) text += row("note", note);
  for (const auto& departed : summary.value("outside_model", Json::array())) {
    text += row("outside the model", departed.value("text", ""));
  }
  if (const auto until = number(summary, "valid_until_s")) text += row("valid until", quantity(*until, "s"));
  const Json phases = summary.value("phases", Json::object());
  // A phase that the run did not come to the end of has no time.
  const auto wall = [](const std::optional<double>& value) {
    return value && *value > 0 ? quantity(*value, "s", 3) : "–";
  };
  return text +
         row("wall time", fmt::format("{} (start {}, set-up {}, stepping {}, end {})", wall(number(summary, "wall_s")),
                                      wall(number(phases, "start_s")), wall(number(phases, "setup_s")),
                                      wall(number(phases, "stepping_s")), wall(number(phases, "finish_s"))));
}

std::string process_rows(const Json& summary) {
  std::string text;
  for (const auto& process : summary.value("processes", Json::array())) {
    std::string waited;
    const Json waited_for = process.value("waited_for_s", Json::object());
    for (const auto& [whom, time_s] : waited_for.items()) {
      if (!waited.empty()) waited += ", ";
      waited += fmt::format("{} {:.3f}", whom, time_s.is_number() ? time_s.get<double>() : 0.0);
    }
    text += "<tr><th scope=\"row\">" + escape_html(process.value("name", "")) + "</th>" +
            data_cell(process.value("role", "")) + data_cell(process.value("transport", "")) +
            data_cell(seconds(process, "wall_s")) + data_cell(seconds(process, "compute_s")) +
            data_cell(seconds(process, "wait_s")) + data_cell(waited) + "</tr>\n";
  }
  return text;
}

}  // namespace

Json read_summary(const std::string& path) {
  try {
    auto summary = Json::parse(read_text(path));
    if (summary.is_object() && summary.contains("status")) return summary;
  } catch (const Json::parse_error& error) {
    throw ConfigError(fmt::format("{} is not the summary of a run: {}", path, error.what()));
  }
  throw ConfigError(fmt::format("{} is not the summary of a run: no \"status\"", path));
}

std::optional<double> number(const Json& summary, const std::string& key) {
  const auto found = summary.find(key);
  return found != summary.end() && found->is_number() ? std::optional(found->get<double>()) : std::nullopt;
}

std::string scene_name(const Json& summary) {
  return std::filesystem::path(summary.value("scene", "")).stem().string();
}

namespace {

/// Style of the status: a run that left the model, but not by so much that it stopped, has results to be read with
/// care.
const char* badge_of(const std::string& status, int exit_code) {
  if (status == name_of(RunStatus::done)) return "done";
  return status == name_of(RunStatus::left_model) && exit_code == 0 ? "warned" : "failed";
}

}  // namespace

std::string header_html(const Json& summary) {
  const std::string status = summary.value("status", ""), error = summary.value("error", "");
  std::string words = status == name_of(RunStatus::left_model) ? "left the model" : status;
  if (status == name_of(RunStatus::running)) words = "running, or its coupler was killed";
  std::string text =
      fmt::format("<h1>{}</h1>\n<p class=\"status {}\"><strong>{}</strong></p>\n", escape_html(scene_name(summary)),
                  badge_of(status, summary.value("exit_code", 0)), escape_html(words));
  if (!error.empty()) text += fmt::format("<pre class=\"error\">{}</pre>\n", escape_html(error));
  text += fmt::format(
      "<dl><dt>scene</dt><dd>{} <small>(SHA-256 {}…)</small></dd>\n<dt>protocol</dt><dd>{} over {}</dd>\n"
      "<dt>run</dt><dd>{}</dd>\n<dt>version</dt><dd>ricochet {}</dd></dl>\n",
      escape_html(std::filesystem::path(summary.value("scene", "")).filename().string()),
      escape_html(summary.value("scene_sha256", "").substr(0, 12)), escape_html(summary.value("protocol", "")),
      escape_html(summary.value("transport", "")), escape_html(summary.value("run_id", "")),
      escape_html(summary.value("version", "")));
  return text;
}

std::string tables_html(const Json& summary) {
  std::string text =
      !summary.value("theory", Json()).is_null()
          ? "<table>\n<thead><tr><th></th><th>computed</th><th>theory</th><th>difference</th></tr></thead>\n<tbody>\n"
          : "<table>\n<thead><tr><th></th><th colspan=\"3\">computed</th></tr></thead>\n<tbody>\n";
  text += contact_rows(summary) + balance_rows(summary) + course_rows(summary) + "</tbody>\n</table>\n" +
          error_bars_html(summary);
  text +=
      "<table class=\"processes\">\n<thead><tr><th>process</th><th>role</th><th>transport</th><th>wall [s]</th>"
      "<th>compute [s]</th><th>wait [s]</th><th>waited for [s]</th></tr></thead>\n<tbody>\n";
  return text + process_rows(summary) + "</tbody>\n</table>\n";
}

}  // namespace ricochet::report

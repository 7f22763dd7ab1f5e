#include "coupler/study/companions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/base/error.hpp"
#include "coupler/report/parts/history_table.hpp"
#include "coupler/report/run_page/summary_page.hpp"
#include "coupler/study/study_case.hpp"

namespace ricochet::coupler {

using report::Json;
using scene::Override;

namespace {

/// "QUANTITY/CONTACT" of each of several contacts.
void add_contact_values(const Json& contact, const std::string& suffix, Values& values) {
  for (const char* key : {"peak_contact_force_n", "contact_impulse_n_s", "separation_time_s"}) {
    if (const auto value = report::number(contact, key)) values[key + suffix] = *value;
  }
  const double pressing_n_s = report::number(contact, "contact_impulse_n_s").value_or(0.0);
  for (const char* along : {"", "_b"}) {
    const auto friction_n_s = report::number(contact, fmt::format("friction_impulse{}_n_s", along));
    if (friction_n_s && *friction_n_s != 0.0 && pressing_n_s > 0.0)
      values[fmt::format("impulse_ratio{}{}", along, suffix)] = *friction_n_s / pressing_n_s;
  }
  const auto first = report::number(contact, "first_contact_s"), last = report::number(contact, "separation_time_s");
  if (first && last) values["contact_duration_s" + suffix] = *last - *first;
}

}  // namespace

Values values_of(const std::string& folder, const scene::Scene& scene) {
  const std::string of_velocity = "velocity_mean_";
  const Json summary = report::read_summary(folder + "/summary.json");
  Values values;
  if (report::number(summary, "first_contact_s")) add_contact_values(summary, "", values);
  const Json contacts = summary.value("contacts", Json::object());
  for (const auto& [name, contact] : contacts.items()) add_contact_values(contact, "/" + name, values);
  if (const auto stress = report::number(summary, "plateau_stress_pa")) values["plateau_stress_pa"] = *stress;
  const auto history = report::read_history(folder + "/history.csv");
  double before_m_s = 0.0, after_m_s = 0.0;  // of the second body relative to the first
  for (std::size_t c = 0; c < history.names.size(); ++c) {
    const auto& name = history.names[c];
    if (name.rfind(of_velocity, 0) != 0 || history.columns[c].empty()) continue;
    values["rebound_velocity_" + name.substr(of_velocity.size())] = history.columns[c].back();
    before_m_s = history.columns[c].front() - before_m_s;
    after_m_s = history.columns[c].back() - after_m_s;
  }
  const auto known = scene.quantities_with_bars();
  const bool has_restitution = std::find(known.begin(), known.end(), "restitution") != known.end();
  if (has_restitution && report::number(summary, "separation_time_s") && before_m_s != 0.0)
    values["restitution"] = -after_m_s / before_m_s;
  return values;
}

double floor_of(const std::string& quantity, double step_s) {
  const bool is_time = quantity.rfind("separation_time_s", 0) == 0 || quantity.rfind("contact_duration_s", 0) == 0;
  return is_time ? 3.0 * step_s : 0.0;
}

std::optional<double> Companion::value(const std::string& quantity) const {
  const auto found = values.find(quantity);
  return found == values.end() ? std::nullopt : std::optional(found->second);
}

Companion Companions::compute(const std::string& what, const std::vector<Override>& changes) {
  StudyCase run(scene_.path, changes, folder_);
  if (!run.failed() && run.repeats() == 0) run.compute();
  Companion companion{what, run.error(), 0.0, {}};
  if (!run.failed()) {
    companion.wall_s = run.costs().front().wall_s;
    companion.values = values_of(run.folder() + "/1", scene_);
  }
  return all_.emplace_back(std::move(companion));
}

std::optional<std::vector<Override>> with_elements(const scene::Scene& scene, double times) {
  std::vector<Override> changes;
  // The addend: 30 elements times 1.1 are 33, and not 32.
  const auto count = [times](int elements) { return std::max(1.0, std::floor(elements * times + 1e-9)); };
  for (const auto& body : scene.bodies) {
    for (const auto& piece : body.pieces) {
      const auto* mesh = std::get_if<scene::StructuredMesh>(&piece.elements);
      if (mesh == nullptr) return {};
      const std::string key =
          fmt::format("body.{}.mesh.{}elements", body.name, body.of_pieces() ? "piece." + piece.name + "." : "");
      if (scene.model == scene::Model::bar) {
        changes.push_back({key, count(mesh->elements_along)});
      } else if (scene.model == scene::Model::solid && !mesh->cylinder) {
        changes.push_back(
            {key, std::vector{count(mesh->elements_across), count(mesh->elements_wide), count(mesh->elements_along)}});
      } else {
        changes.push_back({key, std::vector{count(mesh->elements_across), count(mesh->elements_along)}});
      }
    }
  }
  return changes;
}

std::vector<Override> with(std::vector<Override> changes, const std::vector<Override>& more) {
  changes.insert(changes.end(), more.begin(), more.end());
  return changes;
}

void require_companions(const scene::Scene& scene, const std::string& asked) {
  const auto refuse = [&](const std::string& found, const std::string& allowed) {
    throw ConfigError(fmt::format("{}: {}: found {}; allowed: {}", scene.path, asked, found, allowed));
  };
  const std::string whole = "bodies and participants of ricochet alone, whose mesh and step it can change";
  for (const auto& body : scene.foreign_bodies) refuse(fmt::format("the foreign body '{}'", body.name), whole);
  for (const auto& participant : scene.participants) {
    if (participant.foreign())
      refuse(fmt::format("participant '{}', a program of somebody else's", participant.name), whole);
    if (participant.start == scene::Start::by_hand)
      refuse(fmt::format("participant '{}', started by hand", participant.name), "participants that ricochet starts");
  }
  if (!scene.time.one_step()) refuse(std::string("time.") + scene.time.key_of_sizes(), "one step for the whole run");
}

}  // namespace ricochet::coupler

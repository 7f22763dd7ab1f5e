#include "common/scene/scene.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "common/base/error.hpp"
#include "common/base/names.hpp"
#include "common/fem/mesh.hpp"

namespace ricochet::scene {
namespace {

/// The entry of `list` called `name`; `what` says what it is in the error.
template <typename Entry>
const Entry& find_by_name(const std::vector<Entry>& list, const std::string& name, const std::string& what,
                          const std::string& path) {
  std::vector<std::string> names;
  for (const Entry& entry : list) {
    if (entry.name == name) return entry;
    names.push_back(entry.name);
  }
  throw ConfigError(fmt::format("{}: no {} is called \"{}\"{}", path, what, name, did_you_mean(name, names)));
}

}  // namespace

double StructuredMesh::elements_in_layer() const {
  const double core = fem::core_of_cylinder(elements_across);
  return cylinder ? 4.0 * core * (2.0 * elements_across - core) : 1.0 * elements_across * elements_wide;
}

const StructuredMesh* Body::structured() const {
  return of_pieces() ? nullptr : std::get_if<StructuredMesh>(&pieces.front().elements);
}

std::vector<const GmshMesh*> Body::files() const {
  std::vector<const GmshMesh*> files;
  for (const MeshPiece& piece : pieces)
    if (const auto* file = std::get_if<GmshMesh>(&piece.elements)) files.push_back(file);
  return files;
}

std::vector<std::pair<std::string, Material>> Body::materials() const {
  std::vector<std::pair<std::string, Material>> all;
  for (const MeshPiece& piece : pieces)
    all.emplace_back(of_pieces() ? name + "." + piece.name : name, piece.material.value_or(material));
  for (const GroupMaterial& of : groups) all.emplace_back(name + "." + of.group, of.material);
  return all;
}

bool Body::yields() const {
  const auto all = materials();
  return std::any_of(all.begin(), all.end(), [](const auto& of) { return of.second.plasticity.has_value(); });
}

bool Body::heats() const {
  const auto all = materials();
  return std::any_of(all.begin(), all.end(),
                     [](const auto& of) { return of.second.plasticity && of.second.plasticity->heat; });
}

double StructuredMesh::nodes_in_layer() const {
  if (cylinder) return elements_in_layer() + 4.0 * fem::core_of_cylinder(elements_across) + 1.0;
  return (elements_across + 1.0) * (width_m > 0.0 ? elements_wide + 1.0 : 1.0);
}

double Amplitude::at(double t) const {
  if (time_s.empty()) return 1.0;
  const auto next = std::upper_bound(time_s.begin(), time_s.end(), t);
  if (next == time_s.begin()) return factor.front();
  if (next == time_s.end()) return factor.back();
  const auto i = static_cast<std::size_t>(next - time_s.begin());
  const double part = (t - time_s[i - 1]) / (time_s[i] - time_s[i - 1]);
  return factor[i - 1] + part * (factor[i] - factor[i - 1]);
}

std::string Scene::where(const std::string& key) const {
  for (std::string at = key;; at.resize(at.find_last_of(".["))) {
    const auto found = lines.find(at);
    if (found != lines.end() && found->second > 0) return fmt::format("{}:{}: {}", path, found->second, key);
    if (at.find_first_of(".[") == std::string::npos) return fmt::format("{}: {}", path, key);
  }
}

int Output::probes_told_every() const {
  if (!wants_probes()) return 0;
  const bool filtered =
      std::any_of(gauges.begin(), gauges.end(), [](const Gauge& gauge) { return gauge.rise_time_s > 0.0; });
  return filtered ? 1 : probes_every;
}

bool Scene::friction() const {
  return std::any_of(contacts.begin(), contacts.end(), [](const Contact& c) { return c.friction_coefficient > 0.0; });
}

std::vector<std::string> Scene::contact_names() const {
  std::vector<std::string> names;
  for (const Contact& contact : contacts)
    if (contacts.size() > 1) names.push_back(contact.name);
  return names;
}

std::vector<std::string> Scene::body_names() const {
  std::vector<std::string> names;
  for (const Body& body : bodies) names.push_back(body.name);
  for (const ForeignBody& body : foreign_bodies) names.push_back(body.name);
  return names;
}

bool Scene::is_foreign(const std::string& body) const {
  return std::any_of(foreign_bodies.begin(), foreign_bodies.end(),
                     [&](const ForeignBody& foreign) { return foreign.name == body; });
}

bool Scene::is_reduced(const std::string& body) const {
  return coupling.protocol.layout == Layout::hybrid && partition.reduced_modes.count(body) > 0;
}

bool Scene::any_reduced() const {
  return std::any_of(bodies.begin(), bodies.end(), [&](const Body& body) { return is_reduced(body.name); });
}

const Body& Scene::body(const std::string& name) const { return find_by_name(bodies, name, "body", path); }

const ParticipantSpec& Scene::participant(const std::string& name) const {
  return find_by_name(participants, name, "participant", path);
}

Scene::Substeps Scene::substeps(const std::string& body) const {
  Substeps found{most_substeps, 1};
  for (const ParticipantSpec& one : participants) {
    if (one.role == Role::implicit_solver) continue;
    if (!body.empty() && std::find(one.bodies.begin(), one.bodies.end(), body) == one.bodies.end()) continue;
    found = {std::min(found.fewest, one.substeps), std::max(found.most, one.substeps)};
  }
  found.fewest = std::min(found.fewest, found.most);
  return found;
}

std::vector<std::string> Scene::quantities_with_bars() const {
  std::vector<std::string> quantities;
  for (const char* of_contact :
       {"peak_contact_force_n", "contact_impulse_n_s", "contact_duration_s", "separation_time_s"}) {
    if (contacts.empty()) continue;
    quantities.emplace_back(of_contact);
    for (const std::string& name : contact_names()) quantities.push_back(of_contact + ("/" + name));
  }
  for (const char* of_friction : {"impulse_ratio", "impulse_ratio_b"}) {
    if (!friction()) continue;
    quantities.emplace_back(of_friction);
    for (const std::string& name : contact_names()) quantities.push_back(of_friction + ("/" + name));
    if (model != Model::solid) break;
  }
  if (!contacts.empty()) quantities.emplace_back("plateau_stress_pa");
  const bool all_touch = contacts.size() == 1 && bodies.size() == (contacts.front().second ? 2 : 1);
  if (all_touch && foreign_bodies.empty()) quantities.emplace_back("restitution");
  for (const Body& body : bodies) quantities.push_back("rebound_velocity_" + body.name + "_m_s");
  return quantities;
}

}  // namespace ricochet::scene

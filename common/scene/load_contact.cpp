#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "common/base/names.hpp"
#include "common/scene/loaders.hpp"

namespace ricochet::scene {
namespace {

/// "steel.end" -> steel, end.
SurfaceName load_surface_name(const TableReader& table, const std::string& text, const Scene& scene) {
  const std::size_t dot = text.find('.');
  const std::string found = "\"" + text + "\"";
  if (dot == std::string::npos || dot == 0 || dot + 1 == text.size())
    table.refuse("surfaces", found,
                 R"("body.surface", or "rigid_sphere", "rigid_cylinder" or "rigid_plane" as the second)");
  const SurfaceName name{text.substr(0, dot), text.substr(dot + 1)};
  std::vector<std::string> bodies;
  for (const Body& body : scene.bodies) bodies.push_back(body.name);
  if (std::find(bodies.begin(), bodies.end(), name.body) == bodies.end())
    table.refuse("surfaces", fmt::format("{} of an unknown body{}", found, did_you_mean(name.body, bodies)),
                 "a surface of " + one_of(bodies));
  const std::vector<std::string> surfaces = surface_names(scene.model, scene.body(name.body));
  const bool known = surfaces.empty() || std::find(surfaces.begin(), surfaces.end(), name.surface) != surfaces.end();
  if (!known) table.refuse("surfaces", found + did_you_mean(name.surface, surfaces), one_of(surfaces));
  return name;
}

void load_surfaces(TableReader& table, const Scene& scene, Contact& contact) {
  const std::vector<std::string> names = table.texts("surfaces");
  if (names.size() != 2) table.refuse("surfaces", fmt::format("{} surfaces", names.size()), "two surfaces");
  contact.first = load_surface_name(table, names[0], scene);
  const auto obstacle = std::find(obstacle_names.begin(), obstacle_names.end(), names[1]);
  if (obstacle != obstacle_names.end()) {
    contact.obstacle = static_cast<Obstacle>(obstacle - obstacle_names.begin());
    return;
  }
  contact.second = load_surface_name(table, names[1], scene);
  if (contact.first.body == contact.second->body)
    table.refuse("surfaces", "two surfaces of body \"" + contact.first.body + "\"", "surfaces of two bodies");
}

void load_obstacle(TableReader& table, Model model, Contact& contact) {
  const bool sphere = contact.obstacle == Obstacle::sphere, cylinder = contact.obstacle == Obstacle::cylinder;
  const bool round = sphere || cylinder, solid = model == Model::solid;
  if (sphere && model != Model::axisymmetric && !solid)
    table.refuse("surfaces", "\"rigid_sphere\"", R"(a rigid sphere only with model = "axisymmetric" or "solid")");
  if (cylinder && model != Model::plane_strain && !solid)
    table.refuse("surfaces", "\"rigid_cylinder\"", R"(a rigid cylinder only with model = "plane_strain" or "solid")");
  table.only_if(round, "rigid_radius_m", R"("rigid_sphere" or "rigid_cylinder" as the second surface)");
  table.only_if(cylinder && solid, "rigid_axis", R"("rigid_cylinder" as the second surface and model = "solid")");
  const bool plane = !contact.second && !round;
  table.only_if(plane ? model != Model::bar : round && model != Model::axisymmetric, "rigid_place_m",
                R"("rigid_sphere" or "rigid_cylinder" as the second surface, model = "plane_strain" or "solid"; or )"
                R"("rigid_plane" there in two or three dimensions)");
  table.only_if(!round, "nose_radius_m", "a second surface that is not round itself");
  contact.rigid_radius_m = round ? table.number("rigid_radius_m", above(0.0)) : 0.0;
  if (cylinder && solid) {
    const std::vector<std::string> axes = component_names(model);
    const std::string axis = table.word("rigid_axis", axes);
    contact.rigid_axis = static_cast<int>(std::find(axes.begin(), axes.end(), axis) - axes.begin());
  }
  contact.rigid_place_m.clear();
  if (table.has("rigid_place_m"))
    contact.rigid_place_m = table.numbers("rigid_place_m", any_number(), component_names(model).size());
}

void load_normal(TableReader& table, const Scene& scene, Contact& contact) {
  contact.normal.clear();
  table.only_if(scene.model != Model::bar, "normal", "a model of two or three dimensions");
  if (!table.has("normal")) return;
  contact.normal = table.numbers("normal", any_number(), static_cast<std::size_t>(scene.components()));
  double square = 0.0;
  for (const double x : contact.normal) square += x * x;
  if (!(square > 0.0)) table.refuse("normal", "a direction without length", "a vector out of the first surface");
  for (double& x : contact.normal) x /= std::sqrt(square);
}

/// A plane that has a place has a direction, too, and its distance follows from both.
void check_placed_plane(TableReader& table, Model model, const Contact& contact) {
  if (contact.second || contact.obstacle != Obstacle::plane || contact.rigid_place_m.empty()) return;
  if (contact.normal.empty())
    table.missing("normal", "beside rigid_place_m the direction of the plane, out of the body and into the plane");
  if (model == Model::axisymmetric && contact.normal[0] != 0.0)
    table.refuse("normal", "a plane askew to the axis, which would be a cone", "[0.0, 1.0] or [0.0, -1.0]");
  for (const char* key : {"initial_gap_m", "nose_radius_m"})
    table.only_if(false, key, "a plane without rigid_place_m, from which its distance follows");
}

/// A scene's only contact needs no name; of several each has one, which its columns and the overrides of studies use.
void load_name(TableReader& table, const Scene& scene, bool named, Contact& contact) {
  table.only_if(named, "name", "[[contact]], for one of several; a single [contact] has none");
  if (!named) return;
  contact.name = table.name("name");
  for (const Contact& other : scene.contacts)
    if (other.name == contact.name) table.refuse("name", "\"" + contact.name + "\" a second time", "a new name");
  table.rename("contact." + contact.name);
}

/// The contacts of a scene are solved together.
void require_same_law(const TableReader& table, const Contact& first, const Contact& contact) {
  const auto require = [&](bool same, const char* key) {
    if (!same)
      table.refuse(key, "another value than that of contact \"" + first.name + "\"",
                   "the same in every contact: left out, it is taken from the first");
  };
  require(contact.enforcement == first.enforcement, "enforcement");
  require(contact.multiplier_update == first.multiplier_update, "multiplier_update");
  require(contact.penalty_pa_m == first.penalty_pa_m, "penalty_pa_m");
  require(contact.impact_update == first.impact_update, "impact_update");
  require(contact.friction_law == first.friction_law, "friction_law");
  require(contact.friction_regularisation_s_m == first.friction_regularisation_s_m, "friction_regularisation_s_m");
}

void load_enforcement(TableReader& table, Contact& contact) {
  contact.enforcement = table.choice<Enforcement>(
      "enforcement", {{"multiplier", Enforcement::multiplier}, {"penalty", Enforcement::penalty}}, contact.enforcement);
  const bool penalty = contact.enforcement == Enforcement::penalty;
  table.only_if(!penalty, "multiplier_update", "enforcement = \"multiplier\"");
  table.only_if(penalty, "penalty_pa_m", "enforcement = \"penalty\"");
  table.only_if(penalty, "impact_update", "enforcement = \"penalty\"");
  contact.multiplier_update =
      table.choice<MultiplierUpdate>("multiplier_update",
                                     {{"fully_implicit", MultiplierUpdate::fully_implicit},
                                      {"trapezoidal_reset", MultiplierUpdate::trapezoidal_reset},
                                      {"massless", MultiplierUpdate::massless}},
                                     contact.multiplier_update);
  if (penalty && (contact.penalty_pa_m == 0.0 || table.has("penalty_pa_m")))
    contact.penalty_pa_m = table.number("penalty_pa_m", above(0.0));
  contact.impact_update = table.choice<ImpactUpdate>(
      "impact_update",
      {{"none", ImpactUpdate::none}, {"impedance", ImpactUpdate::impedance}, {"mass", ImpactUpdate::mass}},
      contact.impact_update);
}

void load_friction(TableReader& table, Model model, Contact& contact) {
  table.only_if(model != Model::bar, "friction_coefficient",
                "a model of two or three dimensions: a bar has no tangential motion");
  contact.friction_coefficient = table.number("friction_coefficient", at_least(0.0), contact.friction_coefficient);
  table.only_if(table.has("friction_coefficient"), "friction_law", "friction_coefficient");
  contact.friction_law = table.choice<FrictionLaw>(
      "friction_law", {{"return_mapping", FrictionLaw::return_mapping}, {"regularised", FrictionLaw::regularised}},
      contact.friction_law);
  const bool regularised = contact.friction_law == FrictionLaw::regularised;
  table.only_if(regularised, "friction_regularisation_s_m", "friction_law = \"regularised\"");
  contact.friction_regularisation_s_m =
      table.number("friction_regularisation_s_m", {0.0, 1.0, false, true}, contact.friction_regularisation_s_m);
}

}  // namespace

Contact load_contact(TableReader& table, const Scene& scene, bool named) {
  Contact contact;
  if (!scene.contacts.empty()) contact = scene.contact_law();
  contact.second.reset();
  load_name(table, scene, named, contact);
  load_surfaces(table, scene, contact);
  load_obstacle(table, scene.model, contact);
  load_normal(table, scene, contact);
  check_placed_plane(table, scene.model, contact);
  contact.initial_gap_m = table.number("initial_gap_m", at_least(0.0), 0.0);
  table.only_if(scene.model != Model::bar, "nose_radius_m", "a model of two or three dimensions");
  contact.nose_radius_m = table.has("nose_radius_m") ? table.number("nose_radius_m", above(0.0)) : 0.0;
  load_enforcement(table, contact);
  load_friction(table, scene.model, contact);
  if (!scene.contacts.empty()) require_same_law(table, scene.contact_law(), contact);
  table.finish();
  return contact;
}

}  // namespace ricochet::scene

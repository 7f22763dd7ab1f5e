#include <fmt/format.h>

#include <algorithm>
#include <functional>

#include "common/scene/loaders.hpp"
#include "common/scene/material_library.hpp"
#include "common/scene/toml_file.hpp"

namespace ricochet::scene {
namespace {

/// Far beyond every material, in any system of units; wave speeds and energies of other values leave the range of
/// numbers.
constexpr Range densities{1e-15, 1e20, true, true};

std::optional<fem::PlasticHeat> load_heat(TableReader& plasticity, double density_kg_m3) {
  if (!plasticity.has("heat")) return std::nullopt;
  TableReader table = plasticity.table("heat", "heat");
  fem::PlasticHeat heat;
  heat.capacity_j_m3_k = density_kg_m3 * table.number("specific_heat_j_kg_k", above(0.0));
  heat.fraction = table.number("work_fraction", {0.0, 1.0, false, true}, heat.fraction);
  heat.reference_k = table.number("reference_k", above(0.0), heat.reference_k);
  table.only_if(table.has("melting_k"), "softening_exponent", "melting_k");
  if (table.has("melting_k")) heat.melting_k = table.number("melting_k", above(heat.reference_k));
  heat.exponent = table.number("softening_exponent", above(0.0), heat.exponent);
  table.finish();
  return heat;
}

std::optional<fem::Plasticity> load_plasticity(TableReader& material, double density_kg_m3) {
  if (!material.has("plasticity")) return std::nullopt;
  material.only_if(!material.has("yield_stress_pa"), "yield_stress_pa",
                   "an elastic material: one with plasticity keeps to the yield stress that is given there");
  TableReader table = material.table("plasticity", "plasticity");
  fem::Plasticity plasticity;
  plasticity.yield_stress_pa = table.number("yield_stress_pa", above(0.0));
  plasticity.hardening_pa = table.number("hardening_pa", at_least(0.0), 0.0);
  table.only_if(plasticity.hardening_pa > 0.0, "hardening_exponent", "hardening_pa > 0");
  plasticity.hardening_exponent = table.number("hardening_exponent", {0.0, 1.0, false, true}, 1.0);
  plasticity.rate_factor = table.number("rate_factor", at_least(0.0), 0.0);
  table.only_if(plasticity.rate_factor > 0.0, "reference_rate_per_s", "rate_factor > 0");
  plasticity.reference_rate_per_s = table.number("reference_rate_per_s", above(0.0), 1.0);
  plasticity.heat = load_heat(table, density_kg_m3);
  table.finish();
  return plasticity;
}

Material load_material(TableReader table, Model model) {
  Material material;
  material.youngs_modulus_pa = table.number("youngs_modulus_pa", above(0.0));
  const Range poisson{-1.0, 0.5, false, false};
  // A bar has no lateral strain: its Poisson ratio may be given but need not be.
  material.poisson_ratio =
      model == Model::bar ? table.number("poisson_ratio", poisson, 0.0) : table.number("poisson_ratio", poisson);
  material.density_kg_m3 = table.number("density_kg_m3", densities);
  material.yield_stress_pa = table.number("yield_stress_pa", above(0.0), material.yield_stress_pa);
  material.strength_pa = table.number("strength_pa", above(0.0), material.strength_pa);
  material.plasticity = load_plasticity(table, material.density_kg_m3);
  table.finish();
  return material;
}

/// A surface named by the key "surface" of a table.
std::string load_surface(TableReader& table, const std::vector<std::string>& known) {
  return known.empty() ? table.text("surface") : table.word("surface", known);
}

Amplitude load_amplitude(TableReader& owner) {
  Amplitude amplitude;
  if (!owner.has("amplitude")) return amplitude;
  TableReader table = owner.table("amplitude", "amplitude");
  amplitude.time_s = table.numbers("time_s", any_number(), 0);
  amplitude.factor = table.numbers("factor", any_number(), amplitude.time_s.size());
  if (std::adjacent_find(amplitude.time_s.begin(), amplitude.time_s.end(), std::greater_equal<>()) !=
      amplitude.time_s.end())
    table.refuse("time_s", "times that do not grow", "times, each later than the one before");
  table.finish();
  return amplitude;
}

Support load_support(TableReader& table, Model model, const std::vector<std::string>& surfaces) {
  Support support;
  const std::vector<std::string> names = component_names(model);
  table.only_if(!table.has("at_m"), "surface",
                "no at_m beside it: a support is of a surface or of the node at a place");
  if (table.has("at_m")) {
    support.at_m = table.numbers("at_m", any_number(), names.size());
    support.surface = fmt::format("the node at ({})", fmt::join(support.at_m, ", "));
  } else {
    support.surface = load_surface(table, surfaces);
  }
  for (const std::string& fixed : table.words("fixed", names))
    support.components.push_back(static_cast<int>(std::find(names.begin(), names.end(), fixed) - names.begin()));
  table.finish();
  return support;
}

Traction load_traction(TableReader& table, Model model, const std::vector<std::string>& surfaces) {
  const std::size_t components = component_names(model).size();
  Traction traction{load_surface(table, surfaces), std::vector<double>(components, 0.0), {}};
  table.only_if(model != Model::bar, "pressure_pa", "two or three dimensions: of a bar, traction_pa");
  table.only_if(!table.has("pressure_pa"), "traction_pa", "no pressure_pa beside it: an entry has one of them");
  if (table.has("pressure_pa"))
    traction.pressure_pa = table.number("pressure_pa", any_number());
  else if (!table.has("traction_pa") && model != Model::bar)
    table.missing("traction_pa", fmt::format("{} numbers, or pressure_pa in their place", components));
  else
    traction.traction_pa = table.numbers("traction_pa", any_number(), components);
  traction.amplitude = load_amplitude(table);
  table.finish();
  return traction;
}

/// In a plane one number, about the axis across it.
std::array<double, 3> load_axial(TableReader& table, Model model, const char* key) {
  std::array<double, 3> axial{};
  if (model == Model::plane_strain)
    axial[2] = table.number(key, any_number());
  else
    std::ranges::copy(table.numbers(key, any_number(), 3), axial.begin());
  return axial;
}

PrescribedTurn load_turn(TableReader& table, Model model) {
  PrescribedTurn turn{load_axial(table, model, "turn_rad"), {}};
  std::ranges::copy(table.numbers("about_m", any_number(), component_names(model).size()), turn.about_m.begin());
  return turn;
}

PrescribedMotion load_prescribed(TableReader& table, Model model, const std::vector<std::string>& surfaces) {
  PrescribedMotion prescribed;
  prescribed.surface = load_surface(table, surfaces);
  table.only_if(model == Model::plane_strain || model == Model::solid, "turn_rad",
                R"(model = "plane_strain" or "solid")");
  table.only_if(table.has("turn_rad"), "about_m", "turn_rad beside it");
  if (table.has("turn_rad")) {
    for (const char* key : {"component", "displacement_m"})
      table.only_if(false, key, "no turn_rad beside it: an entry has one of them");
    prescribed.turn = load_turn(table, model);
  } else {
    const std::vector<std::string> names = component_names(model);
    const std::string component = table.word("component", names);
    prescribed.component = static_cast<int>(std::find(names.begin(), names.end(), component) - names.begin());
    prescribed.displacement_m = table.number("displacement_m", any_number());
  }
  prescribed.amplitude = load_amplitude(table);
  table.finish();
  return prescribed;
}

AbsorbingSurface load_absorbing(TableReader& table, Model model, const std::vector<std::string>& surfaces) {
  AbsorbingSurface absorbing{load_surface(table, surfaces), Wave::bar};
  table.only_if(model != Model::bar, "wave", "two or three dimensions: a bar has one wave");
  if (model != Model::bar && table.word("wave", {"bar", "dilatational"}) == "dilatational")
    absorbing.wave = Wave::dilatational;
  table.finish();
  return absorbing;
}

/// A body that moves as one has no waves, no plastic points and no place that a support could hold alone.
void load_rigid(TableReader& table, Body& body) {
  body.rigid = table.boolean("rigid", false);
  if (!body.rigid) return;
  const auto refuse = [&](const std::string& beside, const std::string& allowed) {
    table.refuse("rigid", "true beside " + beside, allowed);
  };
  if (body.of_pieces() || !body.pieces.front().refine.empty())
    refuse("mesh.piece or mesh.refine", "one mesh without them, fine enough for its shape");
  if (body.structured() != nullptr && body.structured()->periodic_across)
    refuse("mesh.periodic_across", "a mesh that ends");
  if (body.yields()) refuse("plasticity", "a material that stays elastic");
  if (!body.absorbing.empty()) refuse("absorbing", "surfaces without it: no wave reaches them");
  if (body.initial_displacement_start_m != body.initial_displacement_end_m)
    refuse("initial_displacement_m that strains it", "the same start and end");
  if (std::ranges::any_of(body.supports, [](const Support& support) { return !support.at_m.empty(); }))
    refuse("a support with at_m", "supports of surfaces, which hold the whole body");
  if (body.large_rotation && !body.told_to_turn() && !(body.supports.empty() && body.prescribed.empty()))
    refuse("large_rotation and a support or prescribed displacement",
           "one of the two, or a prescribed turn: what holds a component keeps it from turning");
}

void load_rotation(TableReader& table, Model model, Body& body) {
  const bool can_turn = model == Model::plane_strain || model == Model::solid;
  table.only_if(can_turn, "large_rotation", R"(model = "plane_strain" or "solid")");
  body.large_rotation = table.boolean("large_rotation", false);
  const char* const spin = "initial_angular_velocity_rad_s";
  table.only_if(body.large_rotation, spin, "large_rotation = true beside it");
  if (table.has(spin)) body.initial_angular_velocity_rad_s = load_axial(table, model, spin);
}

void load_initial_state(TableReader& table, std::size_t components, Body& body) {
  const auto vector = [&](TableReader& from, const std::string& key) {
    return from.has(key) ? from.numbers(key, any_number(), components) : std::vector<double>(components, 0.0);
  };
  body.initial_velocity_m_s = vector(table, "initial_velocity_m_s");
  body.gravity_m_s2 = vector(table, "gravity_m_s2");
  body.initial_displacement_start_m.assign(components, 0.0);
  body.initial_displacement_end_m.assign(components, 0.0);
  if (!table.has("initial_displacement_m")) return;
  TableReader displacement = table.table("initial_displacement_m", "initial_displacement_m");
  body.initial_displacement_start_m = displacement.numbers("start", any_number(), components);
  body.initial_displacement_end_m = displacement.numbers("end", any_number(), components);
  displacement.finish();
}

}  // namespace

std::vector<std::string> component_names(Model model) {
  if (model == Model::bar) return {"x"};
  if (model == Model::plane_strain) return {"x", "y"};
  if (model == Model::solid) return {"x", "y", "z"};
  return {"r", "z"};
}

std::map<std::string, Material> load_materials(TableReader& root, Model model) {
  std::map<std::string, Material> materials;
  for (const auto& [name, table] : root.tables_by_name("material", "material"))
    materials[name] = load_material(table, model);
  return materials;
}

Material load_material_of(TableReader& table, Model model, const std::map<std::string, Material>& materials) {
  if (!table.is_text("material")) return load_material(table.table("material", "material"), model);
  std::vector<std::string> known;
  for (const auto& entry : materials) known.push_back(entry.first);
  for (const LibraryMaterial& entry : material_library()) known.push_back(entry.name);
  const std::string name = table.word("material", known);
  if (const auto own = materials.find(name); own != materials.end()) return own->second;
  const auto named = [&name](const LibraryMaterial& entry) { return entry.name == name; };
  return std::find_if(material_library().begin(), material_library().end(), named)->material;
}

namespace {

/// Materials of element groups, which the mesh has to have.
void load_groups(TableReader& table, Model model, const std::map<std::string, Material>& materials, Body& body) {
  table.only_if(body.structured() == nullptr, "group", "a body of pieces or read from a mesh file");
  for (TableReader& entry : table.tables("group", "group")) {
    const std::string name = entry.text("name");
    const auto same = [&](const GroupMaterial& other) { return other.group == name; };
    if (std::ranges::any_of(body.groups, same))
      entry.refuse("name", "\"" + name + "\" a second time", "each group once");
    entry.rename("body." + body.name + ".group." + name);
    body.groups.push_back({name, load_material_of(entry, model, materials)});
    entry.finish();
  }
}

}  // namespace

Body load_body(TableReader& table, Model model, const std::string& folder,
               const std::map<std::string, Material>& materials) {
  Body body;
  body.name = table.name("name");
  table.rename("body." + body.name);
  for (const char* key : {"joined_to", "surface", "interface_nodes", "interface_faces", "mass_kg"})
    table.only_if(false, key, "foreign = true");
  load_mesh(table, model, folder, materials, body);
  load_groups(table, model, materials, body);
  table.only_if(model == Model::bar, "area_m2", "model = \"bar\"");
  table.only_if(model == Model::plane_strain, "thickness_m", "model = \"plane_strain\"");
  if (model == Model::bar) body.area_m2 = table.number("area_m2", above(0.0), 1.0);
  if (model == Model::plane_strain) body.thickness_m = table.number("thickness_m", above(0.0), 1.0);
  load_initial_state(table, component_names(model).size(), body);
  load_rotation(table, model, body);
  const std::vector<std::string> surfaces = surface_names(model, body);
  for (TableReader& entry : table.tables("support", "support"))
    body.supports.push_back(load_support(entry, model, surfaces));
  for (TableReader& entry : table.tables("traction", "traction"))
    body.tractions.push_back(load_traction(entry, model, surfaces));
  for (TableReader& entry : table.tables("prescribed", "prescribed"))
    body.prescribed.push_back(load_prescribed(entry, model, surfaces));
  for (TableReader& entry : table.tables("absorbing", "absorbing")) {
    AbsorbingSurface absorbing = load_absorbing(entry, model, surfaces);
    for (const AbsorbingSurface& other : body.absorbing)
      if (other.surface == absorbing.surface)
        entry.refuse("surface", "\"" + other.surface + "\" a second time", "each surface once");
    body.absorbing.push_back(std::move(absorbing));
  }
  load_rigid(table, body);
  table.finish();
  return body;
}

}  // namespace ricochet::scene

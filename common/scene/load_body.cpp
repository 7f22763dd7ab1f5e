#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <numbers>

#include "common/fem/inp_file.hpp"
#include "common/fem/mesh.hpp"
#include "common/scene/loaders.hpp"
#include "common/scene/material_library.hpp"
#include "common/scene/toml_file.hpp"

namespace ricochet::scene {
namespace {

using fem::most_elements;
/// Far beyond every material, in any system of units; wave speeds and energies of other values leave the range of
/// numbers.
constexpr Range densities{1e-15, 1e20, true, true};
/// With fewer, an element would meet its own image: nodes lie within half a period of each other.
constexpr int fewest_periodic_elements = 3;

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

/// A table of its own, the name of one of the scene's, or that of one of the library.
Material load_material_of(TableReader& body, Model model, const std::map<std::string, Material>& materials) {
  if (!body.is_text("material")) return load_material(body.table("material", "material"), model);
  std::vector<std::string> known;
  for (const auto& entry : materials) known.push_back(entry.first);
  for (const LibraryMaterial& entry : material_library()) known.push_back(entry.name);
  const std::string name = body.word("material", known);
  if (const auto own = materials.find(name); own != materials.end()) return own->second;
  const auto named = [&name](const LibraryMaterial& entry) { return entry.name == name; };
  return std::find_if(material_library().begin(), material_library().end(), named)->material;
}

/// A mesh file, by the key "gmsh" or "inp"; by the end of its name the reader knows later which of them it was.
GmshMesh load_mesh_file(TableReader& table, const std::string& folder) {
  const char* key = table.has("inp") ? "inp" : "gmsh";
  const bool abaqus = table.has("inp");
  table.only_if(!abaqus, "gmsh", "no inp beside it: a mesh is read from one file");
  for (const char* other :
       {"length_m", "radius_m", "height_m", "width_m", "elements", "start_m", "grading", "periodic_across"})
    table.only_if(false, other, "a structured mesh; this one is read from a file");
  const std::string given = table.text(key);
  if (fem::is_inp_file(given) != abaqus)
    table.refuse(key, "\"" + given + "\"",
                 abaqus ? "an Abaqus or CalculiX input file, whose name ends with .inp"
                        : "a Gmsh MSH 4.1 file; the key of an .inp file is inp");
  const std::filesystem::path path = (std::filesystem::path(folder) / given).lexically_normal();
  if (!is_file(path.string()))
    table.refuse(
        key, "\"" + given + "\", and there is no file " + path.string(),
        abaqus ? "an .inp file, relative to the scene file" : "a Gmsh MSH 4.1 file, relative to the scene file");
  const std::vector<std::pair<std::string, double>> units{
      {"m", 1.0}, {"cm", 1e-2}, {"mm", 1e-3}, {"um", 1e-6}, {"in", 0.0254}};
  return {path.string(), table.choice("length_unit", units, 1.0)};
}

/// elements = 20 for a bar, [across, along] in two dimensions and of a solid cylinder, [x, y, z] of a block; grading
/// likewise.
void load_divisions(TableReader& table, Model model, StructuredMesh& mesh) {
  if (model == Model::bar) {
    mesh.elements_along = table.integer("elements", 1, most_elements);
    mesh.grading_along = table.number("grading", above(0.0), 1.0);
    return;
  }
  const bool block = model == Model::solid && !mesh.cylinder;
  const std::size_t size = block ? 3 : 2;
  const std::vector<int> elements = table.integers("elements", 1, most_elements, size);
  mesh.elements_across = elements.front();
  mesh.elements_along = elements.back();
  if (block) mesh.elements_wide = elements[1];
  const double all = mesh.elements_in_layer() * mesh.elements_along;
  if (all > most_elements)
    table.refuse("elements", mesh.cylinder ? fmt::format("{:.0f}", all) : fmt::format("{}", fmt::join(elements, " x ")),
                 fmt::format("at most {} elements in a body", most_elements));
  if (!table.has("grading")) return;
  const std::vector<double> grading = table.numbers("grading", above(0.0), size);
  mesh.grading_across = grading.front();
  mesh.grading_along = grading.back();
  if (block) mesh.grading_wide = grading[1];
}

/// radius_m in axisymmetry and of a solid cylinder, height_m in plane strain, height_m and width_m of a block.
void load_extent_across(TableReader& table, Model model, StructuredMesh& mesh) {
  const bool round = model == Model::axisymmetric || mesh.cylinder;
  table.only_if(round, "radius_m", R"(model = "axisymmetric" or "solid")");
  const bool has_height = model == Model::plane_strain || (model == Model::solid && !mesh.cylinder);
  for (const char* key : {"height_m", "width_m", "periodic_across"})
    table.only_if(!mesh.cylinder, key, "a block: a solid with radius_m is a cylinder");
  table.only_if(has_height, "height_m", R"(model = "plane_strain" or "solid")");
  table.only_if(model == Model::solid, "width_m", "model = \"solid\"");
  table.only_if(has_height, "periodic_across", R"(model = "plane_strain" or "solid")");
  if (round) mesh.across_m = table.number("radius_m", above(0.0));
  if (has_height) mesh.across_m = table.number("height_m", above(0.0));
  if (has_height && model == Model::solid) mesh.width_m = table.number("width_m", above(0.0));
  if (has_height) mesh.periodic_across = table.boolean("periodic_across", false);
}

std::vector<RefinedBox> load_refined_boxes(TableReader& mesh, Model model) {
  constexpr int largest_ratio = 64;
  const std::size_t components = component_names(model).size();
  std::vector<RefinedBox> boxes;
  for (TableReader& table : mesh.tables("refine", "refine")) {
    RefinedBox& box = boxes.emplace_back();
    box.from_m = table.numbers("from_m", any_number(), components);
    box.to_m = table.numbers("to_m", any_number(), components);
    for (std::size_t c = 0; c < components; ++c)
      if (!(box.to_m[c] > box.from_m[c]))
        table.refuse("to_m", fmt::format("{}", box.to_m[c]),
                     fmt::format("a number > {}, that of from_m", box.from_m[c]));
    box.ratio = table.integer("ratio", 2, largest_ratio);
    table.finish();
  }
  return boxes;
}

/// In a plane one angle, about the axis across it.
MeshPlace load_place(TableReader& mesh, Model model) {
  MeshPlace place;
  const bool plane = model == Model::plane_strain;
  mesh.only_if(plane || model == Model::solid, "place", R"(model = "plane_strain" or "solid")");
  if (!mesh.has("place")) return place;
  TableReader table = mesh.table("place", "place");
  constexpr double degree = std::numbers::pi / 180.0;
  if (plane && table.has("turned_deg")) {
    place.turned_rad[2] = degree * table.number("turned_deg", any_number());
  } else if (table.has("turned_deg")) {
    std::ranges::transform(table.numbers("turned_deg", any_number(), 3), place.turned_rad.begin(),
                           [](double degrees) { return degree * degrees; });
  }
  table.only_if(table.has("turned_deg"), "about_m", "turned_deg");
  for (const auto& [key, to] : {std::pair{"about_m", &place.about_m}, {"moved_m", &place.moved_m}})
    if (table.has(key)) std::ranges::copy(table.numbers(key, any_number(), plane ? 2 : 3), to->begin());
  table.finish();
  return place;
}

std::variant<StructuredMesh, GmshMesh> load_mesh(TableReader& table, Model model, const std::string& folder) {
  if (table.has("gmsh") || table.has("inp")) return load_mesh_file(table, folder);
  table.only_if(false, "length_unit", "gmsh or inp; lengths of a structured mesh are metres");
  StructuredMesh mesh;
  mesh.length_m = table.number("length_m", above(0.0));
  mesh.start_m = table.number("start_m", any_number(), 0.0);
  mesh.cylinder = model == Model::solid && table.has("radius_m");
  load_extent_across(table, model, mesh);
  load_divisions(table, model, mesh);
  const bool solid = model == Model::solid;
  const int fewest = solid ? std::min(mesh.elements_across, mesh.elements_wide) : mesh.elements_across;
  if (mesh.periodic_across && fewest < fewest_periodic_elements)
    table.refuse("elements", fmt::format("{} across", fewest), "3 or more across a periodic mesh");
  const double grading = solid && mesh.grading_across == 1.0 ? mesh.grading_wide : mesh.grading_across;
  if (mesh.periodic_across && grading != 1.0)
    table.refuse("grading", fmt::format("{} across", grading), "1 across a periodic mesh");
  return mesh;
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
  Support support{load_surface(table, surfaces), {}};
  const std::vector<std::string> names = component_names(model);
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

PrescribedDisplacement load_prescribed(TableReader& table, Model model, const std::vector<std::string>& surfaces) {
  PrescribedDisplacement prescribed;
  prescribed.surface = load_surface(table, surfaces);
  const std::vector<std::string> names = component_names(model);
  const std::string component = table.word("component", names);
  prescribed.component = static_cast<int>(std::find(names.begin(), names.end(), component) - names.begin());
  prescribed.displacement_m = table.number("displacement_m", any_number());
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

/// In a plane one number, about the axis across it.
void load_rotation(TableReader& table, Model model, Body& body) {
  const bool can_turn = model == Model::plane_strain || model == Model::solid;
  table.only_if(can_turn, "large_rotation", R"(model = "plane_strain" or "solid")");
  body.large_rotation = table.boolean("large_rotation", false);
  const char* const spin = "initial_angular_velocity_rad_s";
  table.only_if(body.large_rotation, spin, "large_rotation = true beside it");
  if (!table.has(spin)) return;
  if (model == Model::plane_strain)
    body.initial_angular_velocity_rad_s[2] = table.number(spin, any_number());
  else
    std::ranges::copy(table.numbers(spin, any_number(), 3), body.initial_angular_velocity_rad_s.begin());
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

std::vector<std::string> surface_names(Model model, const Body& body) {
  const auto* mesh = std::get_if<StructuredMesh>(&body.mesh);
  if (mesh == nullptr) return {};
  if (model == Model::bar || mesh->periodic_across) return {"start", "end"};
  if (mesh->cylinder) return {"start", "end", "outer"};
  if (model == Model::solid) return {"start", "end", "inner", "outer", "front", "back"};
  return {"start", "end", "inner", "outer"};
}

std::map<std::string, Material> load_materials(TableReader& root, Model model) {
  std::map<std::string, Material> materials;
  for (const auto& [name, table] : root.tables_by_name("material", "material"))
    materials[name] = load_material(table, model);
  return materials;
}

Body load_body(TableReader& table, Model model, const std::string& folder,
               const std::map<std::string, Material>& materials) {
  Body body;
  body.name = table.name("name");
  table.rename("body." + body.name);
  for (const char* key : {"joined_to", "surface", "interface_nodes", "mass_kg"})
    table.only_if(false, key, "foreign = true");
  body.material = load_material_of(table, model, materials);
  TableReader mesh = table.table("mesh", "mesh");
  body.mesh = load_mesh(mesh, model, folder);
  body.refine = load_refined_boxes(mesh, model);
  const auto* structured = std::get_if<StructuredMesh>(&body.mesh);
  mesh.only_if(structured == nullptr || !structured->periodic_across, "place", "a mesh that does not repeat");
  body.place = load_place(mesh, model);
  table.only_if(!body.place.turned(), "initial_displacement_m", "a mesh that place does not turn");
  mesh.finish();
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
  table.finish();
  return body;
}

}  // namespace ricochet::scene

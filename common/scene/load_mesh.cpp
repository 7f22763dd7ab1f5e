#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <numbers>

#include "common/fem/inp_file.hpp"
#include "common/fem/mesh.hpp"
#include "common/scene/loaders.hpp"

namespace ricochet::scene {
namespace {

using fem::most_elements;
/// With fewer, an element would meet its own image: nodes lie within half a period of each other.
constexpr int fewest_periodic_elements = 3;

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

std::variant<StructuredMesh, GmshMesh> load_elements(TableReader& table, Model model, const std::string& folder) {
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

MeshPiece load_piece(TableReader& table, Model model, const std::string& folder) {
  // Made with its mesh: GCC 12 warns of an assignment to the variant where it inlines it.
  MeshPiece piece{.name = "",
                  .elements = load_elements(table, model, folder),
                  .refine = load_refined_boxes(table, model),
                  .place = {}};
  const auto* structured = std::get_if<StructuredMesh>(&piece.elements);
  table.only_if(structured == nullptr || !structured->periodic_across, "place", "a mesh that does not repeat");
  piece.place = load_place(table, model);
  return piece;
}

/// Every one with a name of its own.
void load_pieces(TableReader& mesh, Model model, const std::string& folder,
                 const std::map<std::string, Material>& materials, Body& body) {
  for (TableReader& table : mesh.tables("piece", "piece")) {
    const std::string name = table.name("name");
    table.rename(fmt::format("body.{}.mesh.piece.{}", body.name, name));
    if (std::ranges::any_of(body.pieces, [&](const MeshPiece& other) { return other.name == name; }))
      table.refuse("name", "\"" + name + "\" a second time", "a name for each piece of a body");
    table.only_if(false, "periodic_across", "a mesh without pieces");
    body.pieces.push_back(load_piece(table, model, folder));
    body.pieces.back().name = name;
    if (table.has("material")) body.pieces.back().material = load_material_of(table, model, materials);
    table.finish();
  }
  const std::vector<std::string> known = surface_names(model, body);
  for (TableReader& table : mesh.tables("tie", "tie")) {
    const std::vector<std::string> surfaces = known.empty() ? table.texts("surfaces") : table.words("surfaces", known);
    if (surfaces.size() != 2)
      table.refuse("surfaces", fmt::format("{} surfaces", surfaces.size()), "two, each \"PIECE.SURFACE\"");
    body.ties.push_back({surfaces[0], surfaces[1]});
    table.finish();
  }
}

/// Surfaces of a structured mesh.
std::vector<std::string> surfaces_of(Model model, const StructuredMesh& mesh) {
  if (model == Model::bar || mesh.periodic_across) return {"start", "end"};
  if (mesh.cylinder) return {"start", "end", "outer"};
  if (model == Model::solid) return {"start", "end", "inner", "outer", "front", "back"};
  return {"start", "end", "inner", "outer"};
}

}  // namespace

void load_mesh(TableReader& table, Model model, const std::string& folder,
               const std::map<std::string, Material>& materials, Body& body) {
  TableReader mesh = table.table("mesh", "mesh");
  if (mesh.has("piece")) {
    for (const char* key : {"length_m", "radius_m", "height_m", "width_m", "elements", "start_m", "grading",
                            "periodic_across", "gmsh", "inp", "length_unit", "refine", "place"})
      mesh.only_if(false, key, "a mesh without pieces; each [[body.mesh.piece]] has keys of its own");
    load_pieces(mesh, model, folder, materials, body);
  } else {
    mesh.only_if(false, "tie", "a mesh of pieces: [[body.mesh.piece]]");
    body.pieces.push_back(load_piece(mesh, model, folder));
  }
  const auto turned = [](const MeshPiece& piece) { return piece.place.turned(); };
  table.only_if(std::ranges::none_of(body.pieces, turned), "initial_displacement_m", "a mesh that place does not turn");
  mesh.finish();
  const auto has_own = [](const MeshPiece& piece) { return piece.material.has_value(); };
  const bool all_have = std::ranges::all_of(body.pieces, has_own);
  body.material =
      all_have && !table.has("material") ? *body.pieces.front().material : load_material_of(table, model, materials);
}

std::vector<std::string> surface_names(Model model, const Body& body) {
  std::vector<std::string> names;
  for (const MeshPiece& piece : body.pieces) {
    const auto* mesh = std::get_if<StructuredMesh>(&piece.elements);
    if (mesh == nullptr) return {};
    for (const std::string& surface : surfaces_of(model, *mesh))
      names.push_back(piece.name.empty() ? surface : piece.name + "." + surface);
  }
  if (has_outside(body)) names.emplace_back(outside_surface);
  return names;
}

}  // namespace ricochet::scene

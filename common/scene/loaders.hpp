#pragma once

#include <map>
#include <string>
#include <vector>

#include "common/scene/reader.hpp"
#include "common/scene/scene.hpp"

/// The tables of a scene file, one loader each; `load_scene` calls them in this order. Internal to common/scene.
namespace ricochet::scene {

/// Names of the displacement components, in order: x | x, y | r, z | x, y, z.
[[nodiscard]] std::vector<std::string> component_names(Model model);
/// Surfaces of a structured mesh; empty for a Gmsh mesh, whose surfaces are known only once it is read.
[[nodiscard]] std::vector<std::string> surface_names(Model model, const Body& body);

/// The scene's tables [material.NAME].
[[nodiscard]] std::map<std::string, Material> load_materials(TableReader& root, Model model);
/// The key `material` of a body or a piece: a table of its own, the name of one of the scene's, or of one of the
/// library.
[[nodiscard]] Material load_material_of(TableReader& table, Model model,
                                        const std::map<std::string, Material>& materials);
/// Mesh and materials of a body.
void load_mesh(TableReader& table, Model model, const std::string& folder,
               const std::map<std::string, Material>& materials, Body& body);
[[nodiscard]] Body load_body(TableReader& table, Model model, const std::string& folder,
                             const std::map<std::string, Material>& materials);
/// The entry says foreign = true.
[[nodiscard]] bool says_foreign(TableReader& table);
/// `scene` has its other bodies already.
[[nodiscard]] ForeignBody load_foreign_body(TableReader& table, const Scene& scene);
/// Refuses all that does not go with foreign bodies: a baseline, and a step that is not given. Nothing without one.
void check_foreign_bodies(TableReader& root, TableReader& time, const Scene& scene);
[[nodiscard]] Contact load_contact(TableReader& table, const Scene& scene, bool named);
[[nodiscard]] Partition load_partition(TableReader& table, const Scene& scene);
/// Refuses what does not go with bodies that are reduced to modes. `scene` has its coupling and its time already.
void check_reduced_bodies(const Scene& scene);
[[nodiscard]] Time load_time(TableReader& table, bool has_contact);
[[nodiscard]] CouplingSettings load_coupling(TableReader& table, bool has_contact);
/// `scene` has its bodies and its time already.
[[nodiscard]] Output load_output(TableReader& table, const Scene& scene);
Checkpointing load_checkpoint(TableReader& table);
/// `scene` has its bodies and contacts already.
void load_accuracy(TableReader& table, Scene& scene);
/// Entries of [[participant]], checked one by one and against each other.
[[nodiscard]] std::vector<ParticipantSpec> load_participants(std::vector<TableReader>& tables, const Scene& scene);
/// Throws ConfigError if a foreign body of the scene is nobody's.
void require_foreign_owners(const Scene& scene);

/// The participants that run the scene's protocol: `given` where they fit, else the shipped solvers.
[[nodiscard]] std::vector<ParticipantSpec> participants_of(const Scene& scene,
                                                           const std::vector<ParticipantSpec>& given);

}  // namespace ricochet::scene

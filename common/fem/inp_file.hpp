#pragma once

#include <string>
#include <vector>

#include "common/fem/gmsh_file.hpp"
#include "common/fem/mesh.hpp"

/// Meshes of Abaqus and CalculiX input files: *NODE, *ELEMENT, *NSET, *ELSET and *SURFACE.
/// Format: CalculiX CrunchiX user's manual, "Input deck format"; Abaqus keywords reference.
namespace ricochet::fem {

/// By the end of its name.
[[nodiscard]] bool is_inp_file(const std::string& path);

/// The file in the terms of a Gmsh file: element sets are the groups of its elements, and each face of a *SURFACE is an
/// element of one dimension less. Names are the same in upper and lower case and keep the spelling of their first
/// place. Throws ConfigError "file:line: ..." for an element type that `model` has not, a card that makes or joins
/// parts of a mesh out of sight (*INCLUDE, *PART, *NCOPY, *TIE ...), a parameter that is not read, a number that cannot
/// be read, a node, element or set that is not defined or defined twice, and a surface of nodes.
[[nodiscard]] GmshFile read_inp_file(const std::string& path, Model model);

/// As read_gmsh, with sets in place of physical groups; the ELSET named like the body holds its elements. Where there
/// is none, all elements are those of `body` if it is the scene's `only` one.
[[nodiscard]] Mesh read_inp(const std::string& path, Model model, const std::string& body, bool only);

/// Names of the cards that say nothing about a mesh and are left out, each once, as "*STEP".
[[nodiscard]] std::vector<std::string> ignored_inp_cards(const std::string& path);

/// Whether the file has a set of nodes of that name.
[[nodiscard]] bool inp_has_node_set(const std::string& path, const std::string& name);

/// The body of a file in either format.
[[nodiscard]] Mesh body_mesh(const GmshFile& file, Model model, const std::string& body);

}  // namespace ricochet::fem

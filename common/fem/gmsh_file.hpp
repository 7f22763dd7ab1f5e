#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

/// A Gmsh MSH 4.1 ASCII file as it stands, before it means anything to mechanics.
/// Format: https://gmsh.info/doc/texinfo/gmsh.html#MSH-file-format
namespace ricochet::fem {

using GmshTag = std::int64_t;
using GmshEntity = std::pair<int, int>;  ///< dimension, tag

struct GmshElement {
  GmshTag tag = 0;
  int line = 0;  ///< of the file, for error texts
  GmshEntity entity;
  int type = 0;                    ///< Gmsh's number of its kind
  std::array<GmshTag, 8> nodes{};  ///< as many as its kind has; one for a point
};

struct GmshFile {
  std::string path;
  bool sets = false;                                     ///< of an Abaqus file (inp_file.hpp), whose groups are sets
  std::map<GmshEntity, std::string> group_name;          ///< (dimension, physical tag) -> name
  std::map<GmshEntity, std::vector<int>> entity_groups;  ///< geometric entity -> its physical tags
  std::map<GmshTag, Eigen::Vector3d> nodes;              ///< [m]
  std::vector<GmshElement> elements;                     ///< points, lines, surfaces and volumes
};

/// Reads the sections MeshFormat, PhysicalNames, Entities, Nodes and Elements and skips the others. Throws ConfigError
/// "file:line: ..." for another version, a binary file, an element type other than 1 to 5 and 15, a tag given twice,
/// an unknown node or entity, a number that cannot be read, and a file that ends early.
[[nodiscard]] GmshFile read_gmsh_file(const std::string& path);

}  // namespace ricochet::fem

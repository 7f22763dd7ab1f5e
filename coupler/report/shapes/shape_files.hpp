#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "coupler/report/parts/chart.hpp"

namespace ricochet::report {

using Place = std::array<double, 3>;  ///< [m]; of models with fewer coordinates the rest is 0

/// A body as one participant drew it, or a rigid obstacle, which stands still and has no fields.
struct ShapePiece {
  int body = 0;                                       ///< index into Shapes::bodies
  std::vector<int> node;                              ///< number in the body
  std::vector<Place> position;                        ///< per node, undeformed
  std::vector<std::array<int, 4>> cells;              ///< indices into `node`, -1 beyond the two to four of a cell
  std::vector<std::vector<Place>> displacement;       ///< per window, per node
  std::vector<std::vector<double>> stress_pa;         ///< per window, per cell: von Mises, axial of a bar
  std::vector<std::vector<double>> plastic_strain{};  ///< the same, equivalent; empty: of a body that does not yield
  std::vector<std::vector<double>> temperature_rise_k{};   ///< the same since the start; empty: plastic work heats none
  std::vector<std::vector<double>> contact_pressure_pa{};  ///< the same; empty: somebody else enforces the contact
  bool rigid = false;
};

/// The elements of a run's bodies, deformed, at the windows that all who drew them kept.
struct Shapes {
  struct Body {
    std::string name;
    double strip_m = 0;    ///< of a bar: the width it is drawn with
    Place velocity_m_s{};  ///< at the start, mean over the body
  };
  std::string model;    ///< "bar", "plane_strain", "axisymmetric" or "solid"
  bool nose = false;    ///< the contact has a rounded nose, which is no part of the mesh
  bool uneven = false;  ///< gaps of the meshes differ over a contact, or its bodies slide
  std::vector<Body> bodies;
  std::vector<std::array<std::string, 2>> touching;  ///< bodies of each contact; "": what is rigid
  double largest_window_s = 0;
  std::vector<double> times_s;  ///< ascending
  std::vector<ShapePiece> pieces;
  std::vector<std::string> missing;  ///< sentences: whose elements are not there, and why
};

/// Adds to what is drawn a rigid obstacle; nodes of its own.
void add_obstacle(Shapes& shapes, const std::string& name, double strip_m, const std::vector<Place>& places,
                  const std::vector<std::array<int, 4>>& cells);

/// Reads every FOLDER/fields/NAME.shapes.json and, beside them, obstacles.json; participants that the summary names
/// without one are missing. Windows with numbers that are not finite are left out. Throws ConfigError that names a file
/// and what is wrong with it, Json::exception if it is not of the form that ShapeRecorder (common/solver) writes.
[[nodiscard]] Shapes read_shapes(const std::string& folder, const Json& summary);

}  // namespace ricochet::report

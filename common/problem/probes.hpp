#pragma once

#include <string>
#include <vector>

#include "common/fem/natural_point.hpp"
#include "common/problem/problem.hpp"

/// The places that [[output.probe]] and [[output.gauge]] name, in the meshes of the bodies.
namespace ricochet::scene {

/// A point of an element at which strain is looked at, and its share of a gauge's mean.
struct StrainPoint {
  int element = -1;  ///< of the body's mesh
  fem::NaturalPoint at{0.0, 0.0, 0.0};
  double share = 1.0;
};

/// A probe has one point; those of a gauge have shares that add up to 1.
struct MeasuredPlace {
  std::string name;
  bool gauge = false;
  int body = -1;  ///< index into Problem::bodies
  std::vector<StrainPoint> points;
};

/// Probes, then gauges, in the scene's order; none if the scene asks for no rows. A probe lies in the first element of
/// the mesh that holds its place. Throws ConfigError naming file, line and key if a body has nothing there.
[[nodiscard]] std::vector<MeasuredPlace> measured_places(const Problem& problem);

/// "x", "y", ... of the displacement; "xx", "yy", ... of strain and stress, in the order of element.hpp.
[[nodiscard]] std::vector<std::string> strain_names(Model model);

/// Names of the columns of a probe and of a gauge. A probe has displacement, velocity, acceleration, strain (shear as
/// the tensor's), stress, von Mises stress and, of a body that `yields`, equivalent plastic strain and, if that `heats`
/// it, temperature; a gauge has strain and stress along the axis.
[[nodiscard]] std::vector<std::string> columns_of_probe(Model model, const std::string& name, bool yields, bool heats);
[[nodiscard]] std::vector<std::string> columns_of_gauge(const std::string& name);

/// Names of the columns of probes.csv behind the time, in its order.
[[nodiscard]] std::vector<std::string> probe_columns(const Scene& scene);

}  // namespace ricochet::scene

#include "common/problem/probes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "common/base/error.hpp"
#include "common/fem/interval.hpp"
#include "common/problem/build.hpp"

namespace ricochet::scene {
namespace {

int body_named(const Problem& problem, const std::string& name) {
  const auto found =
      std::find_if(problem.bodies.begin(), problem.bodies.end(), [&](const auto& body) { return body.name == name; });
  return static_cast<int>(found - problem.bodies.begin());
}

std::string corners_text(const fem::Mesh& mesh) {
  Eigen::Vector3d low = mesh.position.front(), high = low;
  for (const auto& x : mesh.position) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  return fmt::format("between {} and {}", fem::place_text(mesh.model, low), fem::place_text(mesh.model, high));
}

MeasuredPlace place_of(const Problem& problem, const Probe& probe) {
  MeasuredPlace place{probe.name, false, body_named(problem, probe.body), {}};
  const auto& mesh = problem.bodies[fem::at(place.body)].mesh;
  Eigen::Vector3d x = Eigen::Vector3d::Zero();
  for (std::size_t c = 0; c < probe.at_m.size(); ++c) x[static_cast<Eigen::Index>(c)] = probe.at_m[c];
  for (int e = 0; e < static_cast<int>(mesh.elements.size()); ++e) {
    const auto element = fem::element_geometry(mesh, e);
    Eigen::Vector3d first = Eigen::Vector3d::Zero();
    for (Eigen::Index c = 0; c < element.x.cols(); ++c) first[c] = element.x(0, c);
    const auto natural = fem::natural_point(element, fem::nearest_image(mesh, x, first));
    if (!natural) continue;
    place.points.push_back({e, *natural, 1.0});
    return place;
  }
  throw ConfigError(
      fmt::format("{}: found the place {}, where body \"{}\" has no element; allowed: a place in the body, "
                  "which lies {}",
                  problem.scene.where("output.probe." + probe.name + ".at_m"), fem::place_text(mesh.model, x),
                  probe.body, corners_text(mesh)));
}

/// How much of an interval of the axis a gauge covers. A section is a stretch that is short against every element.
class Stretch {
 public:
  Stretch(const Gauge& gauge, double body_length_m)
      : low_(gauge.section_m - 0.5 * std::max(gauge.length_m, 1e-7 * body_length_m)),
        high_(2.0 * gauge.section_m - low_) {}

  /// A share of the interval's length; 1 of one without length that lies within.
  [[nodiscard]] double share_of(const fem::Interval& interval) const {
    if (interval.length() <= 0.0) return interval.low >= low_ && interval.high <= high_ ? 1.0 : 0.0;
    const double covered = std::min(high_, interval.high) - std::max(low_, interval.low);
    return std::max(0.0, covered) / interval.length();
  }

 private:
  double low_, high_;
};

template <class Nodes>
fem::Interval along_axis(const fem::Mesh& mesh, const Nodes& nodes) {
  fem::Interval interval;
  for (const int node : nodes) interval.add(fem::axis_coordinate(mesh.model, mesh.position[fem::at(node)]));
  return interval;
}

/// Gauss' points of two a direction, of elements whose strain is constant their centre; `share`: volume about it.
void add_volume(const BodyProblem& body, int e, double covered, MeasuredPlace& place) {
  const auto element = fem::element_geometry(body.mesh, e);
  const auto& traits = fem::traits(element.kind);
  const bool constant = element.kind == fem::ElementKind::triangle || element.kind == fem::ElementKind::tetrahedron;
  const double volume = fem::element_volume(body.section, element).sum();
  if (constant) {
    place.points.push_back({e, traits.centre, covered * volume});
    return;
  }
  std::vector<StrainPoint> points;
  double sum = 0.0;
  for (int i = 0; i < traits.nodes; ++i) {
    StrainPoint point{e, traits.corner[fem::at(i)] / std::sqrt(3.0), 0.0};
    point.share = traits.jacobian(element.x, point.at);
    if (body.mesh.model == Model::axisymmetric)
      point.share *= fem::shape_values(element.kind, point.at).dot(element.x.col(0));
    sum += point.share;
    points.push_back(point);
  }
  for (auto& point : points) {
    point.share *= covered * volume / sum;
    place.points.push_back(point);
  }
}

/// The middle of a face, in the element behind it.
fem::NaturalPoint middle_of(const fem::Element& element, const fem::Face& face) {
  fem::NaturalPoint middle = fem::NaturalPoint::Zero();
  for (std::size_t i = 0; i < element.size(); ++i) {
    if (std::find(face.begin(), face.end(), element[i]) != face.end())
      middle += fem::traits(element.kind).corner[i] / static_cast<double>(face.size());
  }
  return middle;
}

void add_surface(const BodyProblem& body, const std::string& surface, const Stretch& stretch, MeasuredPlace& place) {
  const auto& mesh = body.mesh;
  std::map<fem::Face, int> behind;
  for (const auto& face : mesh.surfaces.at(surface)) behind[fem::sorted(face)] = -1;
  for (int e = 0; e < static_cast<int>(mesh.elements.size()); ++e) {
    for (fem::Face face : fem::traits(mesh.elements[fem::at(e)].kind).faces) {
      for (int& node : face) node = mesh.elements[fem::at(e)][fem::at(node)];
      if (const auto found = behind.find(fem::sorted(face)); found != behind.end()) found->second = e;
    }
  }
  for (const auto& face : mesh.surfaces.at(surface)) {
    const double covered = stretch.share_of(along_axis(mesh, face));
    const int e = behind.at(fem::sorted(face));
    if (covered <= 0.0 || e < 0) continue;
    double area = 0.0;
    for (const double of_node : fem::face_area(body.section, mesh, face)) area += of_node;
    place.points.push_back({e, middle_of(mesh.elements[fem::at(e)], face), covered * area});
  }
}

MeasuredPlace place_of(const Problem& problem, const Gauge& gauge) {
  MeasuredPlace place{gauge.name, true, body_named(problem, gauge.body), {}};
  const auto& body = problem.bodies[fem::at(place.body)];
  const std::string key = "output.gauge." + gauge.name;
  fem::Interval whole;
  for (const auto& x : body.mesh.position) whole.add(fem::axis_coordinate(body.mesh.model, x));
  const Stretch stretch(gauge, whole.length());
  if (gauge.surface.empty()) {
    for (int e = 0; e < static_cast<int>(body.mesh.elements.size()); ++e) {
      const double covered = stretch.share_of(along_axis(body.mesh, body.mesh.elements[fem::at(e)]));
      if (covered > 0.0) add_volume(body, e, covered, place);
    }
  } else {
    require_surface(problem.scene, key + ".surface", body.mesh, gauge.surface);
    add_surface(body, gauge.surface, stretch, place);
  }
  double sum = 0.0;
  for (const auto& point : place.points) sum += point.share;
  if (!(sum > 0.0)) {
    const std::string nothing = gauge.surface.empty()
                                    ? fmt::format("body \"{}\" has no element", gauge.body)
                                    : fmt::format("surface \"{}.{}\" has no face", gauge.body, gauge.surface);
    throw ConfigError(fmt::format("{}: found {} m, where {}; allowed: a coordinate of its axis from {:.9g} to {:.9g} m",
                                  problem.scene.where(key + ".section_m"), gauge.section_m, nothing, whole.low,
                                  whole.high));
  }
  for (auto& point : place.points) point.share /= sum;
  return place;
}

std::vector<std::string> motion_names(Model model) {
  if (model == Model::bar) return {"x"};
  if (model == Model::plane_strain) return {"x", "y"};
  if (model == Model::axisymmetric) return {"r", "z"};
  return {"x", "y", "z"};
}

}  // namespace

std::vector<std::string> strain_names(Model model) {
  if (model == Model::bar) return {"xx"};
  if (model == Model::plane_strain) return {"xx", "yy", "zz", "xy"};
  if (model == Model::axisymmetric) return {"rr", "zz", "tt", "rz"};
  return {"xx", "yy", "zz", "xy", "yz", "zx"};
}

std::vector<MeasuredPlace> measured_places(const Problem& problem) {
  std::vector<MeasuredPlace> places;
  const Output& output = problem.scene.output;
  if (!output.wants_probes()) return places;
  for (const Probe& probe : output.probes) places.push_back(place_of(problem, probe));
  for (const Gauge& gauge : output.gauges) places.push_back(place_of(problem, gauge));
  return places;
}

std::vector<std::string> columns_of_probe(Model model, const std::string& name, bool yields, bool heats) {
  std::vector<std::string> columns;
  for (const auto& [quantity, unit] : {std::pair{"displacement", "m"}, {"velocity", "m_s"}, {"acceleration", "m_s2"}}) {
    for (const auto& component : motion_names(model))
      columns.push_back(fmt::format("{}.{}_{}_{}", name, quantity, component, unit));
  }
  for (const auto& component : strain_names(model)) columns.push_back(fmt::format("{}.strain_{}", name, component));
  for (const auto& component : strain_names(model)) columns.push_back(fmt::format("{}.stress_{}_pa", name, component));
  columns.push_back(name + ".von_mises_pa");
  if (yields) columns.push_back(name + ".equivalent_plastic_strain");
  if (heats) columns.push_back(name + ".temperature_k");
  return columns;
}

std::vector<std::string> columns_of_gauge(const std::string& name) { return {name + ".strain", name + ".stress_pa"}; }

std::vector<std::string> probe_columns(const Scene& scene) {
  std::vector<std::string> columns;
  if (!scene.output.wants_probes()) return columns;
  const auto add = [&columns](const std::vector<std::string>& more) {
    columns.insert(columns.end(), more.begin(), more.end());
  };
  for (const Probe& probe : scene.output.probes) {
    const Body& body = scene.body(probe.body);
    add(columns_of_probe(scene.model, probe.name, body.yields(), body.heats()));
  }
  for (const Gauge& gauge : scene.output.gauges) add(columns_of_gauge(gauge.name));
  return columns;
}

}  // namespace ricochet::scene

#include "common/fem/axial_stress.hpp"

#include <algorithm>
#include <cmath>

#include "common/fem/element_copies.hpp"
#include "common/fem/interval.hpp"

namespace ricochet::fem {
namespace {

Interval extent(const Mesh& mesh, int element) {
  Interval interval;
  for (const int node : mesh.elements[at(element)]) interval.add(axis_coordinate(mesh.model, mesh.position[at(node)]));
  return interval;
}

/// Calls action(layer, share of the element's extent in it) for every layer that the element reaches into.
template <class Action>
void for_each_layer(const std::vector<double>& border, const Interval& element, const Action& action) {
  const auto layers = static_cast<int>(border.size()) - 1;
  const double thickness = (border.back() - border.front()) / layers;
  const auto layer_at = [&](double z) {
    return std::clamp(static_cast<int>(std::floor((z - border.front()) / thickness)), 0, layers - 1);
  };
  for (int layer = layer_at(element.low); layer <= layer_at(element.high); ++layer) {
    const auto i = static_cast<std::size_t>(layer);
    const double inside = std::min(element.high, border[i + 1]) - std::max(element.low, border[i]);
    const double share = inside / element.length();
    if (share > 1e-9) action(layer, share);  // less is the rounding of a common border
  }
}

std::vector<double> volumes(const Mesh& mesh, const Section& section, const std::vector<double>& border) {
  std::vector<double> volume(border.size() - 1, 0.0);
  for (int e = 0; e < static_cast<int>(mesh.elements.size()); ++e) {
    const double own = element_volume(section, element_geometry(mesh, e)).sum();
    for_each_layer(border, extent(mesh, e),
                   [&](int layer, double share) { volume[static_cast<std::size_t>(layer)] += share * own; });
  }
  return volume;
}

/// z e_z at the nodes of an element.
ElementVector axial_field(const Mesh& mesh, const ElementCoordinates& x) {
  const int width = components(mesh.model);
  ElementVector field = ElementVector::Zero(x.rows() * width);
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    field[i * width + width - 1] = x(i, width - 1);
  }
  return field;
}

}  // namespace

AxialLayers axial_layers(const Mesh& whole, const Section& section, int most) {
  Interval body;
  double sum = 0.0;
  const auto elements = static_cast<int>(whole.elements.size());
  for (int e = 0; e < elements; ++e) {
    const auto element = extent(whole, e);
    body.add(element.low);
    body.add(element.high);
    sum += element.length();
  }
  const int along = std::max(1, static_cast<int>(std::lround(body.length() * elements / sum)));
  const int together = (along + most - 1) / most;
  const int layers = std::max(1, along / together);
  AxialLayers result;
  for (int i = 0; i <= layers; ++i) result.border.push_back(body.low + body.length() * i / layers);
  result.volume_m3 = volumes(whole, section, result.border);
  return result;
}

SparseMatrix axial_stress_shares(const Part& part, const AxialLayers& layers) {
  const Mesh& mesh = part.mesh;
  const int width = components(mesh.model);
  ElementCopies<ElementMatrix> copies(part.section.model);
  std::vector<Eigen::Triplet<double>> entries;
  for (int e = 0; e < static_cast<int>(mesh.elements.size()); ++e) {
    const ElementGeometry element = element_geometry(mesh, e);
    const auto make = [&](const ElementGeometry& geometry) {
      return element_stiffness(part.section, material_of(part, e), geometry);
    };
    const Eigen::VectorXd integral = copies.of(element, make, material_index(mesh, e)) * axial_field(mesh, element.x);
    const auto& nodes = mesh.elements[static_cast<std::size_t>(e)];
    for_each_layer(layers.border, extent(mesh, e), [&](int layer, double share) {
      const double scale = share / layers.volume_m3[static_cast<std::size_t>(layer)];
      for (Eigen::Index i = 0; i < integral.size(); ++i) {
        const int node = nodes[static_cast<std::size_t>(i / width)];
        entries.emplace_back(layer, node * width + static_cast<int>(i % width), scale * integral[i]);
      }
    });
  }
  SparseMatrix shares(layers.size(), part.dofs());
  shares.setFromTriplets(entries.begin(), entries.end());
  return shares;
}

SparseMatrix axial_element_shares(const Part& part, const AxialLayers& layers) {
  std::vector<Eigen::Triplet<double>> entries;
  for (int e = 0; e < static_cast<int>(part.mesh.elements.size()); ++e) {
    const double own = element_volume(part.section, element_geometry(part.mesh, e)).sum();
    for_each_layer(layers.border, extent(part.mesh, e), [&](int layer, double share) {
      entries.emplace_back(layer, e, share * own / layers.volume_m3[static_cast<std::size_t>(layer)]);
    });
  }
  SparseMatrix shares(layers.size(), static_cast<Eigen::Index>(part.mesh.elements.size()));
  shares.setFromTriplets(entries.begin(), entries.end());
  return shares;
}

std::vector<double> volume_shares(const Part& part, const AxialLayers& layers) {
  auto shares = volumes(part.mesh, part.section, layers.border);
  for (std::size_t i = 0; i < shares.size(); ++i) {
    if (shares[i] > 0.0) shares[i] /= layers.volume_m3[i];  // a body in two pieces has layers without any volume
  }
  return shares;
}

}  // namespace ricochet::fem

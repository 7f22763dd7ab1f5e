#pragma once

#include <vector>

#include "common/fem/part.hpp"

/// Axial stress of a body, mean over the cross section, along its axis: what an x-t diagram of stress waves draws.
namespace ricochet::fem {

/// Layers of equal thickness that cut a body across its axis, ascending.
struct AxialLayers {
  std::vector<double> border;     ///< axis coordinate, layers + 1 [m]
  std::vector<double> volume_m3;  ///< of the whole body in each layer

  [[nodiscard]] int size() const { return static_cast<int>(volume_m3.size()); }
};

/// As many layers as the body has elements along its axis (length over mean extent of the elements along it), or the
/// largest whole fraction of that number which is at most `most`: in an ungraded structured mesh their borders are
/// element borders.
[[nodiscard]] AxialLayers axial_layers(const Mesh& whole, const Section& section, int most);

/// S, layers x dofs of the part, with S u = (sum over the part's elements e of w_e integral of sigma_axial dV) /
/// V_layer [Pa]: the part's share of the mean axial stress of each layer; the shares of all parts add up to the mean.
/// w_e is the share of the element's extent along the axis that lies in the layer. The integral is exact for the
/// element, by virtual work with the displacement field z e_z, whose only strain is epsilon_axial = 1: integral of
/// sigma_axial dV = u . K_e z.
[[nodiscard]] SparseMatrix axial_stress_shares(const Part& part, const AxialLayers& layers);

/// The same of a stress that is constant in each element: layers x elements of the part.
[[nodiscard]] SparseMatrix axial_element_shares(const Part& part, const AxialLayers& layers);

/// Volume of the part's elements in each layer over the layer's volume, 0 to 1.
[[nodiscard]] std::vector<double> volume_shares(const Part& part, const AxialLayers& layers);

}  // namespace ricochet::fem

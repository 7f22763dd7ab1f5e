#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "common/fem/part.hpp"

/// Result files that ParaView opens.
namespace ricochet::fem {

/// A number per element of a part that yields; null where the part does not.
struct PlasticStrain {
  const Eigen::VectorXd* strain = nullptr;
  const Eigen::VectorXd* equivalent = nullptr;
};

/// Writes one VTU piece (XML, inline base64, little-endian) atomically (temporary name, then rename).
/// Point data: displacement [m], velocity [m/s] (3 components; bar along x; axisymmetric (r, z) drawn as (x, y)).
/// Cell data at the element centre: stress_axial, stress_radial, stress_hoop, stress_shear [Pa] (plane strain: xx, yy,
/// zz, xy as stress_xx .. ; solid: also yz, zx; bar: stress_axial), stress_principal_max/mid/min [Pa]; cell data `body`
/// (index in `parts`), `element` (number in the body) and, where a part yields, `equivalent_plastic_strain`. Parts of
/// one model; vectors node-major, one per part (std::invalid_argument otherwise). Throws what write_atomically throws
/// if the file cannot be written.
void write_vtu(const std::string& path, const std::vector<const Part*>& parts,
               const std::vector<const Eigen::VectorXd*>& displacement,
               const std::vector<const Eigen::VectorXd*>& velocity, const std::vector<PlasticStrain>& plastic = {});

/// Bytes of such a file, to some hundred: `corners` of all elements together.
[[nodiscard]] double vtu_bytes(Model model, double nodes, double elements, double corners);

}  // namespace ricochet::fem

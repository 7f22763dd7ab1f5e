#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "common/fem/part.hpp"

/// Result files that ParaView opens.
namespace ricochet::fem {

/// The plastic strain of a part that yields.
struct PlasticStrain {
  Eigen::MatrixXd stress_pa;      ///< a column per element: what its plastic strain takes off the elastic stress
  Eigen::VectorXd equivalent;     ///< per element
  Eigen::VectorXd temperature_k;  ///< per element; empty where plastic work does not heat the part
};

/// The contents of a file of one part; vectors node-major, one number per degree of freedom.
struct PartFields {
  const Part* part = nullptr;
  const Eigen::VectorXd *displacement = nullptr, *velocity = nullptr, *acceleration = nullptr;
  const PlasticStrain* plastic = nullptr;      ///< null where the part does not yield
  const Eigen::VectorXd* straining = nullptr;  ///< of a part in a frame that turns: what strains it there; else null
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  ///< of that frame
  int body = 0;                                            ///< its number in the scene
};

/// Contact at the nodes of one part.
struct ContactFields {
  Eigen::VectorXd force_n;             ///< on the body, 3 per node; 0 away from the surfaces
  Eigen::VectorXd pressure_pa, gap_m;  ///< per node; not a number where a node carries no row
  std::vector<std::int32_t> state;     ///< per node: 0 open, 1 stick, 2 slip, -1 where it carries no row
};

/// Writes one part as VTU (XML, inline base64, little-endian) atomically (temporary name, then rename), with the same
/// names in every model. Bar along x; axisymmetric (r, z) drawn as (x, y), with the hoop direction as zz.
/// Point data: displacement [m], velocity [m/s], acceleration [m/s^2] (3 components each); with `contact` also
/// contact_force [N] (3), contact_pressure [Pa], contact_gap [m] and contact_state.
/// Cell data at the element centre: stress [Pa] and strain (xx, yy, zz, xy, yz, xz, as VTK orders a symmetric tensor;
/// of a bar xx alone), von_mises [Pa], stress_principal_max/mid/min [Pa]; `body` (number in the scene), `element`
/// (number in the body) and, where the part yields, `equivalent_plastic_strain`, where it is heated `temperature` [K].
/// std::invalid_argument where lengths do not fit. Throws what write_atomically throws if the file cannot be written.
void write_vtu(const std::string& path, const PartFields& part, const ContactFields* contact = nullptr);

/// Bytes of such a file without contact, to some hundred: `corners` of all elements together.
[[nodiscard]] double vtu_bytes(double nodes, double elements, double corners);

}  // namespace ricochet::fem

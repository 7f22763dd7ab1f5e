#include "common/fem/vtk_output.hpp"

#include <fmt/format.h>

#include <array>
#include <bit>
#include <cstdint>
#include <stdexcept>
#include <string_view>

#include "common/base/base64.hpp"
#include "common/base/write_file.hpp"

namespace ricochet::fem {
namespace {

static_assert(std::endian::native == std::endian::little, "the file is declared little-endian and written as it lies");

using Parts = std::vector<const Part*>;
using Fields = std::vector<const Eigen::VectorXd*>;
using Plastic = std::vector<PlasticStrain>;

/// One DataArray: its length in bytes as UInt64, then the values, encoded in one go.
template <class Number>
std::string data_array(std::string_view type, std::string_view name, int width, const std::vector<Number>& values) {
  const std::uint64_t size = values.size() * sizeof(Number);
  std::string bytes(reinterpret_cast<const char*>(&size), sizeof size);
  bytes.append(reinterpret_cast<const char*>(values.data()), size);
  return fmt::format("<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"binary\">{}</DataArray>\n",
                     type, name, width, base64(bytes));
}

/// Nodal vectors as the three components VTK wants.
std::string nodal_vectors(std::string_view name, const Parts& parts, const Fields& fields) {
  std::vector<double> values;
  for (std::size_t p = 0; p < parts.size(); ++p) {
    const int width = components(parts[p]->mesh.model);
    for (int node = 0; node < parts[p]->nodes(); ++node) {
      for (int c = 0; c < 3; ++c) values.push_back(c < width ? (*fields[p])[node * width + c] : 0.0);
    }
  }
  return data_array("Float64", name, 3, values);
}

std::string points(const Parts& parts) {
  std::vector<double> values;
  for (const Part* part : parts) {
    for (const Eigen::Vector3d& x : part->mesh.position) values.insert(values.end(), x.begin(), x.end());
  }
  return "<Points>\n" + data_array("Float64", "Points", 3, values) + "</Points>\n";
}

std::string cells(const Parts& parts) {
  std::vector<std::int32_t> connectivity, offsets;
  std::vector<std::uint8_t> types;
  std::int32_t first_node = 0;
  for (const Part* part : parts) {
    for (const auto& element : part->mesh.elements) {
      for (const int node : element) connectivity.push_back(first_node + node);
      offsets.push_back(static_cast<std::int32_t>(connectivity.size()));
      types.push_back(traits(element.kind).vtk_type);
    }
    first_node += part->nodes();
  }
  return "<Cells>\n" + data_array("Int32", "connectivity", 1, connectivity) +
         data_array("Int32", "offsets", 1, offsets) + data_array("UInt8", "types", 1, types) + "</Cells>\n";
}

/// Names of the stress components in the order of `StressVector`.
std::vector<std::string_view> stress_names(Model model) {
  switch (model) {
    case Model::bar: return {"stress_axial"};
    case Model::plane_strain: return {"stress_xx", "stress_yy", "stress_zz", "stress_xy"};
    case Model::axisymmetric: return {"stress_radial", "stress_axial", "stress_hoop", "stress_shear"};
    case Model::solid: return {"stress_xx", "stress_yy", "stress_zz", "stress_xy", "stress_yz", "stress_zx"};
  }
  throw std::invalid_argument("unknown model");
}

std::string stresses(Model model, const Parts& parts, const Fields& displacement, const Plastic& plastic) {
  const std::vector<std::string_view> names = stress_names(model);
  constexpr std::array<std::string_view, 3> principal_names = {"stress_principal_max", "stress_principal_mid",
                                                               "stress_principal_min"};
  std::vector<std::vector<double>> stress_values(names.size()), principal_values(3);
  for (std::size_t p = 0; p < parts.size(); ++p) {
    const Part& part = *parts[p];
    for (int e = 0; e < static_cast<int>(part.mesh.elements.size()); ++e) {
      const ElementGeometry element = element_geometry(part.mesh, e);
      StressVector stress =
          element_stress(part.section, part.material, element, element_displacement(part.mesh, e, *displacement[p]),
                         traits(element.kind).centre);
      if (p < plastic.size() && plastic[p].strain)
        stress[0] -= part.material.youngs_modulus_pa * (*plastic[p].strain)[e];
      const Eigen::Vector3d principal = principal_stresses(model, stress);
      for (std::size_t c = 0; c < names.size(); ++c) stress_values[c].push_back(stress[static_cast<Eigen::Index>(c)]);
      for (std::size_t c = 0; c < 3; ++c) principal_values[c].push_back(principal[static_cast<Eigen::Index>(c)]);
    }
  }
  std::string text;
  for (std::size_t c = 0; c < names.size(); ++c) text += data_array("Float64", names[c], 1, stress_values[c]);
  for (std::size_t c = 0; c < 3; ++c) text += data_array("Float64", principal_names[c], 1, principal_values[c]);
  return text;
}

/// Empty where no part yields.
std::string equivalent_plastic_strains(const Parts& parts, const Plastic& plastic) {
  std::vector<double> values;
  bool any = false;
  for (std::size_t p = 0; p < parts.size(); ++p) {
    const bool yields = p < plastic.size() && plastic[p].equivalent != nullptr;
    any = any || yields;
    for (Eigen::Index e = 0; e < static_cast<Eigen::Index>(parts[p]->mesh.elements.size()); ++e)
      values.push_back(yields ? (*plastic[p].equivalent)[e] : 0.0);
  }
  return any ? data_array("Float64", "equivalent_plastic_strain", 1, values) : "";
}

std::string element_numbers(const Parts& parts) {
  std::vector<std::int32_t> body, element;
  for (std::size_t p = 0; p < parts.size(); ++p) {
    body.insert(body.end(), parts[p]->body_element.size(), static_cast<std::int32_t>(p));
    element.insert(element.end(), parts[p]->body_element.begin(), parts[p]->body_element.end());
  }
  return data_array("Int32", "body", 1, body) + data_array("Int32", "element", 1, element);
}

void check_sizes(const Parts& parts, const Fields& displacement, const Fields& velocity) {
  if (parts.empty() || displacement.size() != parts.size() || velocity.size() != parts.size()) {
    throw std::invalid_argument("write_vtu: one displacement and one velocity vector per part");
  }
  for (std::size_t p = 0; p < parts.size(); ++p) {
    if (parts[p]->mesh.model != parts[0]->mesh.model || displacement[p]->size() != parts[p]->dofs() ||
        velocity[p]->size() != parts[p]->dofs()) {
      throw std::invalid_argument("write_vtu: model or vector length of " + parts[p]->body + " does not fit");
    }
  }
}

}  // namespace

void write_vtu(const std::string& path, const Parts& parts, const Fields& displacement, const Fields& velocity,
               const Plastic& plastic) {
  check_sizes(parts, displacement, velocity);
  std::size_t nodes = 0, elements = 0;
  for (const Part* part : parts) {
    nodes += part->mesh.position.size();
    elements += part->mesh.elements.size();
  }
  std::string text =
      "<?xml version=\"1.0\"?>\n"
      "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n"
      "<UnstructuredGrid>\n";
  text += fmt::format("<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n", nodes, elements);
  text += points(parts) + cells(parts);
  text += "<PointData Vectors=\"displacement\">\n" + nodal_vectors("displacement", parts, displacement) +
          nodal_vectors("velocity", parts, velocity) + "</PointData>\n";
  text += "<CellData>\n" + stresses(parts[0]->mesh.model, parts, displacement, plastic) +
          equivalent_plastic_strains(parts, plastic) + element_numbers(parts) +
          "</CellData>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
  write_atomically(path, text);
}

double vtu_bytes(Model model, double nodes, double elements, double corners) {
  constexpr double in_base64 = 4.0 / 3.0, texts = 3000.0;
  const double of_node = 9.0 * sizeof(double);  // place, displacement, velocity
  const double of_element =
      sizeof(double) * (static_cast<double>(stress_names(model).size()) + 3.0) + 3.0 * sizeof(std::int32_t) + 1.0;
  return texts + in_base64 * (of_node * nodes + of_element * elements + sizeof(std::int32_t) * corners);
}

}  // namespace ricochet::fem

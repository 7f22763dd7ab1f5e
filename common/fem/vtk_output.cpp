#include "common/fem/vtk_output.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
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

/// One DataArray: its length in bytes as UInt64, then the values, encoded in one go.
template <class Number>
std::string data_array(std::string_view type, std::string_view name, int width, const std::vector<Number>& values,
                       std::string_view more = "") {
  const std::uint64_t size = values.size() * sizeof(Number);
  std::string bytes(reinterpret_cast<const char*>(&size), sizeof size);
  bytes.append(reinterpret_cast<const char*>(values.data()), size);
  return fmt::format(
      "<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\"{} format=\"binary\">{}</DataArray>\n", type, name,
      width, more, base64(bytes));
}

/// Nodal vectors as the three components VTK wants.
std::string nodal_vectors(std::string_view name, const Part& part, const Eigen::VectorXd& field) {
  std::vector<double> values;
  const int width = components(part.mesh.model);
  for (int node = 0; node < part.nodes(); ++node) {
    for (int c = 0; c < 3; ++c) values.push_back(c < width ? field[node * width + c] : 0.0);
  }
  return data_array("Float64", name, 3, values);
}

std::string points(const Part& part) {
  std::vector<double> values;
  for (const Eigen::Vector3d& x : part.mesh.position) values.insert(values.end(), x.begin(), x.end());
  return "<Points>\n" + data_array("Float64", "Points", 3, values) + "</Points>\n";
}

std::string cells(const Part& part) {
  std::vector<std::int32_t> connectivity, offsets;
  std::vector<std::uint8_t> types;
  for (const auto& element : part.mesh.elements) {
    connectivity.insert(connectivity.end(), element.begin(), element.end());
    offsets.push_back(static_cast<std::int32_t>(connectivity.size()));
    types.push_back(traits(element.kind).vtk_type);
  }
  return "<Cells>\n" + data_array("Int32", "connectivity", 1, connectivity) +
         data_array("Int32", "offsets", 1, offsets) + data_array("UInt8", "types", 1, types) + "</Cells>\n";
}

constexpr int tensor_width = 6;
constexpr std::string_view tensor_names =
    " ComponentName0=\"xx\" ComponentName1=\"yy\" ComponentName2=\"zz\" ComponentName3=\"xy\" ComponentName4=\"yz\" "
    "ComponentName5=\"xz\"";

/// Components in the order of `StressVector`, whose first four or six are VTK's.
void append_tensor(const StressVector& tensor, std::vector<double>& values) {
  for (Eigen::Index c = 0; c < tensor_width; ++c) values.push_back(c >= tensor.size() ? 0.0 : tensor[c]);
}

/// Stress and what follows from it, element by element.
struct Stresses {
  std::vector<double> stress, strain, von_mises;
  std::array<std::vector<double>, 3> principal;

  void append(const PartFields& of, int e, const Eigen::MatrixXd& compliance) {
    const Part& part = *of.part;
    const ElementGeometry element = element_geometry(part.mesh, e);
    const Model model = part.section.model;
    const Eigen::VectorXd& straining = of.straining ? *of.straining : *of.displacement;
    StressVector at_centre = element_stress(part.section, material_of(part, e), element,
                                            element_displacement(part.mesh, e, straining), traits(element.kind).centre);
    StressVector strain_at_centre = compliance * at_centre;
    if (strain_at_centre.size() > 3) strain_at_centre.tail(strain_at_centre.size() - 3) *= 0.5;  // from 2 e_xy
    if (of.plastic) at_centre -= of.plastic->stress_pa.col(e);
    if (of.straining) {
      strain_at_centre = turned(strain_at_centre, of.rotation);
      at_centre = turned(at_centre, of.rotation);
    }
    append_tensor(strain_at_centre, strain);
    append_tensor(at_centre, stress);
    von_mises.push_back(von_mises_stress(model, at_centre));
    const Eigen::Vector3d values = principal_stresses(model, at_centre);
    for (std::size_t c = 0; c < 3; ++c) principal[c].push_back(values[static_cast<Eigen::Index>(c)]);
  }
  [[nodiscard]] std::string text() const {
    return data_array("Float64", "stress", tensor_width, stress, tensor_names) +
           data_array("Float64", "strain", tensor_width, strain, tensor_names) +
           data_array("Float64", "von_mises", 1, von_mises) +
           data_array("Float64", "stress_principal_max", 1, principal[0]) +
           data_array("Float64", "stress_principal_mid", 1, principal[1]) +
           data_array("Float64", "stress_principal_min", 1, principal[2]);
  }
};

std::string stresses(const PartFields& of) {
  const auto compliance_of = [&](const Material& material) -> Eigen::MatrixXd {
    return elasticity(of.part->section.model, material).inverse();
  };
  std::vector<Eigen::MatrixXd> compliance{compliance_of(of.part->material)};
  for (const Material& material : of.part->mesh.materials) compliance.push_back(compliance_of(material));
  Stresses all;
  for (int e = 0; e < static_cast<int>(of.part->mesh.elements.size()); ++e)
    all.append(of, e, compliance[at(1 + material_index(of.part->mesh, e))]);
  return all.text();
}

template <class Numbers>
std::string scalars(const char* name, const Numbers& values) {
  return data_array("Float64", name, 1, std::vector<double>(values.begin(), values.end()));
}

std::string plastic_arrays(const PlasticStrain* plastic) {
  if (!plastic) return "";
  return scalars("equivalent_plastic_strain", plastic->equivalent) +
         (plastic->temperature_k.size() > 0 ? scalars("temperature", plastic->temperature_k) : "");
}

std::string element_numbers(const PartFields& of) {
  const auto& elements = of.part->body_element;
  return data_array("Int32", "body", 1, std::vector<std::int32_t>(elements.size(), of.body)) +
         data_array("Int32", "element", 1, std::vector<std::int32_t>(elements.begin(), elements.end()));
}

std::string contact_arrays(const ContactFields* contact) {
  if (!contact) return "";
  const std::vector<double> force_n(contact->force_n.begin(), contact->force_n.end());
  return data_array("Float64", "contact_force", 3, force_n) + scalars("contact_pressure", contact->pressure_pa) +
         scalars("contact_gap", contact->gap_m) + data_array("Int32", "contact_state", 1, contact->state);
}

}  // namespace

void write_vtu(const std::string& path, const PartFields& of, const ContactFields* contact) {
  const Part& part = *of.part;
  for (const auto* field : {of.displacement, of.velocity, of.acceleration}) {
    if (field == nullptr || field->size() != part.dofs())
      throw std::invalid_argument("write_vtu: a vector's length does not fit " + part.body);
  }
  std::string text =
      "<?xml version=\"1.0\"?>\n"
      "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n"
      "<UnstructuredGrid>\n";
  text += fmt::format("<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n", part.nodes(), part.mesh.elements.size());
  text += points(part) + cells(part);
  text += "<PointData Vectors=\"displacement\">\n" + nodal_vectors("displacement", part, *of.displacement) +
          nodal_vectors("velocity", part, *of.velocity) + nodal_vectors("acceleration", part, *of.acceleration) +
          contact_arrays(contact) + "</PointData>\n";
  text += "<CellData>\n" + stresses(of) + plastic_arrays(of.plastic) + element_numbers(of) +
          "</CellData>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
  write_atomically(path, text);
}

double vtu_bytes(double nodes, double elements, double corners) {
  constexpr double in_base64 = 4.0 / 3.0, texts = 3500.0;
  constexpr double of_node = 12.0 * sizeof(double);  // place, displacement, velocity, acceleration
  constexpr double of_element = sizeof(double) * (2.0 * tensor_width + 1.0 + 3.0) + 3.0 * sizeof(std::int32_t) + 1.0;
  return texts + in_base64 * (of_node * nodes + of_element * elements + sizeof(std::int32_t) * corners);
}

}  // namespace ricochet::fem

#include "common/fem/vtk_output.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <array>
#include <bit>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string_view>

#include "common/base/base64.hpp"
#include "common/base/write_file.hpp"

namespace ricochet::fem {
namespace {

static_assert(std::endian::native == std::endian::little, "the file is declared little-endian and written as it lies");

using Parts = std::vector<PartFields>;

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
std::string nodal_vectors(std::string_view name, const Parts& parts, const Eigen::VectorXd* PartFields::*field) {
  std::vector<double> values;
  for (const PartFields& of : parts) {
    const int width = components(of.part->mesh.model);
    for (int node = 0; node < of.part->nodes(); ++node) {
      for (int c = 0; c < 3; ++c) values.push_back(c < width ? (*(of.*field))[node * width + c] : 0.0);
    }
  }
  return data_array("Float64", name, 3, values);
}

std::string points(const Parts& parts) {
  std::vector<double> values;
  for (const PartFields& of : parts) {
    for (const Eigen::Vector3d& x : of.part->mesh.position) values.insert(values.end(), x.begin(), x.end());
  }
  return "<Points>\n" + data_array("Float64", "Points", 3, values) + "</Points>\n";
}

std::string cells(const Parts& parts) {
  std::vector<std::int32_t> connectivity, offsets;
  std::vector<std::uint8_t> types;
  std::int32_t first_node = 0;
  for (const PartFields& of : parts) {
    for (const auto& element : of.part->mesh.elements) {
      for (const int node : element) connectivity.push_back(first_node + node);
      offsets.push_back(static_cast<std::int32_t>(connectivity.size()));
      types.push_back(traits(element.kind).vtk_type);
    }
    first_node += of.part->nodes();
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

std::string stresses(const Parts& parts) {
  Stresses all;
  for (const PartFields& of : parts) {
    const auto compliance_of = [&](const Material& material) -> Eigen::MatrixXd {
      return elasticity(of.part->section.model, material).inverse();
    };
    std::vector<Eigen::MatrixXd> compliance{compliance_of(of.part->material)};
    for (const Material& material : of.part->mesh.materials) compliance.push_back(compliance_of(material));
    for (int e = 0; e < static_cast<int>(of.part->mesh.elements.size()); ++e)
      all.append(of, e, compliance[at(1 + material_index(of.part->mesh, e))]);
  }
  return all.text();
}

/// One number per element of the parts that yield, `elsewhere` in all others; empty where no part has it.
std::string plastic_values(const char* name, const Parts& parts, Eigen::VectorXd PlasticStrain::*values,
                           double elsewhere) {
  std::vector<double> all;
  bool any = false;
  for (const PartFields& of : parts) {
    const bool own = of.plastic && (of.plastic->*values).size() > 0;
    any = any || own;
    for (Eigen::Index e = 0; e < static_cast<Eigen::Index>(of.part->mesh.elements.size()); ++e)
      all.push_back(own ? (of.plastic->*values)[e] : elsewhere);
  }
  return any ? data_array("Float64", name, 1, all) : "";
}

std::string plastic_arrays(const Parts& parts) {
  return plastic_values("equivalent_plastic_strain", parts, &PlasticStrain::equivalent, 0.0) +
         plastic_values("temperature", parts, &PlasticStrain::temperature_k, std::numeric_limits<double>::quiet_NaN());
}

std::string element_numbers(const Parts& parts) {
  std::vector<std::int32_t> body, element;
  for (const PartFields& of : parts) {
    const auto& of_body = of.part->body_element;
    body.insert(body.end(), of_body.size(), of.body);
    element.insert(element.end(), of_body.begin(), of_body.end());
  }
  return data_array("Int32", "body", 1, body) + data_array("Int32", "element", 1, element);
}

std::string contact_arrays(const std::vector<ContactFields>& contact) {
  if (contact.empty()) return "";
  std::vector<double> force_n, pressure_pa, gap_m;
  std::vector<std::int32_t> state;
  for (const ContactFields& of : contact) {
    force_n.insert(force_n.end(), of.force_n.begin(), of.force_n.end());
    pressure_pa.insert(pressure_pa.end(), of.pressure_pa.begin(), of.pressure_pa.end());
    gap_m.insert(gap_m.end(), of.gap_m.begin(), of.gap_m.end());
    state.insert(state.end(), of.state.begin(), of.state.end());
  }
  return data_array("Float64", "contact_force", 3, force_n) +
         data_array("Float64", "contact_pressure", 1, pressure_pa) + data_array("Float64", "contact_gap", 1, gap_m) +
         data_array("Int32", "contact_state", 1, state);
}

void check_sizes(const Parts& parts, const std::vector<ContactFields>& contact) {
  if (parts.empty() || (!contact.empty() && contact.size() != parts.size()))
    throw std::invalid_argument("write_vtu: one part at least, and contact of each part or of none");
  for (const PartFields& of : parts) {
    for (const auto* field : {of.displacement, of.velocity, of.acceleration}) {
      if (of.part->mesh.model != parts[0].part->mesh.model || field == nullptr || field->size() != of.part->dofs())
        throw std::invalid_argument("write_vtu: model or vector length of " + of.part->body + " does not fit");
    }
  }
}

}  // namespace

void write_vtu(const std::string& path, const Parts& parts, const std::vector<ContactFields>& contact) {
  check_sizes(parts, contact);
  std::size_t nodes = 0, elements = 0;
  for (const PartFields& of : parts) {
    nodes += of.part->mesh.position.size();
    elements += of.part->mesh.elements.size();
  }
  std::string text =
      "<?xml version=\"1.0\"?>\n"
      "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n"
      "<UnstructuredGrid>\n";
  text += fmt::format("<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n", nodes, elements);
  text += points(parts) + cells(parts);
  text += "<PointData Vectors=\"displacement\">\n" + nodal_vectors("displacement", parts, &PartFields::displacement) +
          nodal_vectors("velocity", parts, &PartFields::velocity) +
          nodal_vectors("acceleration", parts, &PartFields::acceleration) + contact_arrays(contact) + "</PointData>\n";
  text += "<CellData>\n" + stresses(parts) + plastic_arrays(parts) + element_numbers(parts) +
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

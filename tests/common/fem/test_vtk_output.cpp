#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>

#include "common/fem/vtk_output.hpp"
#include "tests/common/fem/sample_elements.hpp"
#include "tests/common/fem/test_help.hpp"
#include "tests/support/places.hpp"

namespace ricochet::fem {
namespace {

using testing::HasSubstr;

/// Two elements of a distorted body with displacement and velocity, in a file.
struct Written {
  explicit Written(Model model)
      : model_(model),
        part(extract_part(sample::distorted_mesh(model), "body", sample::section(model), sample::steel,
                          std::vector<int>{1, 3})) {
    displacement = sample::nodal(part.mesh, [](const auto& x) {
      return Eigen::Vector3d(1e-3 * x[0] + x[0] * x[1], 2e-3 * x[1] - x[0] * x[0], x[2] * x[1]);
    });
    velocity = sample::nodal(part.mesh, [](const auto& x) { return Eigen::Vector3d(7.0 + x[0], -30.0, x[2]); });
    acceleration = -2.0 * velocity;
    PartFields fields{&part, &displacement, &velocity, &acceleration};
    fields.body = 3;
    const auto at_nodes = contact();
    write_vtu(path(), fields, &at_nodes);
  }
  /// Forces that tell the node.
  [[nodiscard]] ContactFields contact() const {
    const Eigen::Index nodes = part.nodes();
    return {Eigen::VectorXd::LinSpaced(3 * nodes, 1000.0, 1001.0), Eigen::VectorXd::Constant(nodes, 1e6),
            Eigen::VectorXd::Constant(nodes, -1e-9), std::vector<std::int32_t>(static_cast<std::size_t>(nodes), 2)};
  }
  ~Written() { std::filesystem::remove(path()); }
  Written(const Written&) = delete;
  Written& operator=(const Written&) = delete;

  [[nodiscard]] std::string path() const { return sample::temporary_path(sample::name(model_) + ".vtu"); }

  Model model_;
  Part part;
  Eigen::VectorXd displacement, velocity, acceleration;
};

/// Values per cell of a function of the stress in its middle.
std::vector<double> per_cell(const Written& written, const std::function<double(const StressVector&)>& value) {
  std::vector<double> values;
  const Part& part = written.part;
  for (int e = 0; e < static_cast<int>(part.mesh.elements.size()); ++e) {
    const ElementVector u = element_displacement(part.mesh, e, written.displacement);
    values.push_back(
        value(element_stress(part.section, part.material, element_geometry(part.mesh, e), u, NaturalPoint::Zero())));
  }
  return values;
}

std::vector<double> per_node(const Written& written, const Eigen::VectorXd& field) {
  std::vector<double> values;
  const int width = components(written.model_);
  for (int node = 0; node < written.part.nodes(); ++node) {
    for (int c = 0; c < 3; ++c) values.push_back(c < width ? field[node * width + c] : 0.0);
  }
  return values;
}

std::map<std::string, std::vector<double>> expected_fields(const Written& written) {
  const Model model = written.model_;
  std::map<std::string, std::vector<double>> fields;
  fields["displacement"] = per_node(written, written.displacement);
  fields["velocity"] = per_node(written, written.velocity);
  fields["acceleration"] = per_node(written, written.acceleration);
  const ContactFields contact = written.contact();
  fields["contact_force"].assign(contact.force_n.begin(), contact.force_n.end());
  fields["contact_pressure"].assign(contact.pressure_pa.begin(), contact.pressure_pa.end());
  fields["contact_gap"].assign(contact.gap_m.begin(), contact.gap_m.end());
  fields["contact_state"].assign(contact.state.begin(), contact.state.end());
  for (const auto* tensor : {"stress", "strain"}) {
    const Eigen::MatrixXd compliance = elasticity(model, sample::steel).inverse();
    for (Eigen::Index c = 0; c < 6; ++c) {
      const auto component = per_cell(written, [&](const StressVector& s) {
        if (c >= s.size()) return 0.0;
        return tensor[2] == 'r' && tensor[3] == 'e' ? s[c] : (c < 3 ? 1.0 : 0.5) * (compliance * s)[c];
      });
      auto& values = fields[tensor];
      values.resize(6 * component.size());
      for (std::size_t cell = 0; cell < component.size(); ++cell)
        values[6 * cell + static_cast<std::size_t>(c)] = component[cell];
    }
  }
  fields["von_mises"] = per_cell(written, [model](const StressVector& s) { return von_mises_stress(model, s); });
  const std::array<std::string, 3> principal = {"max", "mid", "min"};
  for (int c = 0; c < 3; ++c) {
    fields["stress_principal_" + principal[static_cast<std::size_t>(c)]] =
        per_cell(written, [c, model](const StressVector& s) { return principal_stresses(model, s)[c]; });
  }
  fields["body"] = {3.0, 3.0};
  fields["element"] = {1.0, 3.0};
  return fields;
}

/// The numbers that print_vtu.py prints, by name of the array.
std::map<std::string, std::vector<double>> read_with_meshio(const std::string& path) {
  const std::string command =
      "/usr/bin/python3 " + test::source_folder() + "/tests/common/fem/print_vtu.py '" + path + "' 2>&1";
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), pclose);
  std::string text;
  std::array<char, 4096> buffer{};
  while (const std::size_t count = std::fread(buffer.data(), 1, buffer.size(), pipe.get()))
    text.append(buffer.data(), count);
  std::map<std::string, std::vector<double>> arrays;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string kind, name, shape, colon;
    if (!(words >> kind >> name >> shape >> colon) || colon != ":") ADD_FAILURE() << "meshio: " << text;
    for (std::string value; words >> value;) arrays[name].push_back(std::stod(value));
  }
  return arrays;
}

TEST(WriteVtu, IsReadByAnIndependentReader) {
  for (const Model model : sample::every_model) {
    const Written written(model);
    const auto arrays = read_with_meshio(written.path());
    for (const auto& [name, values] : expected_fields(written)) {
      ASSERT_TRUE(arrays.contains(name)) << name;
      // The last bits of a product are the processor's.
      const double close = 1e-14 * std::abs(*std::max_element(values.begin(), values.end(), [](double a, double b) {
                             return std::abs(a) < std::abs(b);
                           }));
      EXPECT_THAT(arrays.at(name), testing::Pointwise(testing::DoubleNear(close), values))
          << sample::name(model) << " " << name;
    }
    std::vector<double> points, cells;
    for (const Eigen::Vector3d& x : written.part.mesh.position) points.insert(points.end(), x.begin(), x.end());
    for (const auto& element : written.part.mesh.elements) cells.insert(cells.end(), element.begin(), element.end());
    EXPECT_EQ(arrays.at("points"), points);
    EXPECT_EQ(arrays.at(model == Model::bar ? "line" : model == Model::solid ? "hexahedron" : "quad"), cells);
  }
}

std::string decode_base64(const std::string& text) {
  static const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  unsigned group = 0;
  int bits = 0;
  for (const char c : text) {
    if (c == '=') break;
    group = group << 6 | static_cast<unsigned>(digits.find(c));
    bits += 6;
    if (bits < 8) continue;
    bits -= 8;
    bytes += static_cast<char>(group >> bits & 0xffU);
  }
  return bytes;
}

TEST(WriteVtu, HoldsLengthAndValuesInOneBase64String) {
  for (const Model model : sample::every_model) {
    const Written written(model);
    const std::string text = sample::file_text(written.path());
    EXPECT_THAT(text, HasSubstr("byte_order=\"LittleEndian\" header_type=\"UInt64\""));
    const std::size_t tag = text.find("Name=\"velocity\" NumberOfComponents=\"3\" format=\"binary\">");
    ASSERT_NE(tag, std::string::npos);
    const std::size_t begin = text.find('>', tag) + 1;
    const std::string bytes = decode_base64(text.substr(begin, text.find('<', begin) - begin));
    const std::vector<double> expected = per_node(written, written.velocity);
    std::uint64_t length = 0;
    ASSERT_EQ(bytes.size(), sizeof length + expected.size() * sizeof(double));
    std::memcpy(&length, bytes.data(), sizeof length);
    EXPECT_EQ(length, expected.size() * sizeof(double));
    std::vector<double> values(expected.size());
    std::memcpy(values.data(), bytes.data() + sizeof length, length);
    EXPECT_EQ(values, expected);
  }
}

TEST(WriteVtu, ReplacesAnOldFileAndLeavesNoTemporaryOne) {
  const Written first(Model::bar);
  const Written second(Model::bar);
  EXPECT_TRUE(std::filesystem::exists(second.path()));
  EXPECT_FALSE(std::filesystem::exists(second.path() + ".part"));
}

TEST(WriteVtu, SaysWhereItCannotWrite) {
  const Part part = sample::distorted_part(Model::bar);
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(part.dofs());
  EXPECT_THAT(sample::message_of([&] {
                write_vtu("/nonexistent/folder/a.vtu", {&part, &zero, &zero, &zero});
              }),
              HasSubstr("cannot write /nonexistent/folder/a.vtu.part"));
}

TEST(WriteVtu, RefusesVectorsThatDoNotFit) {
  const Part part = sample::distorted_part(Model::bar);
  const Eigen::VectorXd fits = Eigen::VectorXd::Zero(part.dofs()), short_one = fits.head(2);
  const std::string path = sample::temporary_path("refused.vtu");
  EXPECT_THROW(write_vtu(path, {&part, &fits, &short_one, &fits}), std::invalid_argument);
  EXPECT_THROW(write_vtu(path, {&part, &fits, &fits, nullptr}), std::invalid_argument);
}

}  // namespace
}  // namespace ricochet::fem

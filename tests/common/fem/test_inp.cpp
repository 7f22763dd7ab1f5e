#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "common/base/error.hpp"
#include "common/fem/inp_file.hpp"
#include "common/fem/part.hpp"
#include "tests/common/fem/test_help.hpp"

// Meshes of Abaqus and CalculiX input files: what is read, and what is refused by line.

namespace ricochet::fem {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Key;

class InpFile {
 public:
  explicit InpFile(const std::string& text) : path_(sample::temporary_path("mesh.inp")) {
    std::ofstream(path_, std::ios::binary) << text;
  }
  ~InpFile() { std::remove(path_.c_str()); }
  InpFile(const InpFile&) = delete;
  InpFile& operator=(const InpFile&) = delete;
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_;
};

/// Two squares side by side, the second clockwise; lower and upper case, comments and a line that goes on.
const std::string squares = R"(*Heading
 two squares
** a comment
*NODE, NSET=Everything
1, 0., 0.
2, 1.D0, 0.0, 0.0
3, +2., 0.
4, 0., 1e0
5, 1., 1.
6, 2., 1.
*Element, type=cpe4r, elset=Plate
1, 1, 2, 5,
4
2, 2, 5, 6, 3
*Elset, elset=Right
2
*ELSET, ELSET=both, GENERATE
1, 2, 1
*NSET, NSET=corners
1, 3
*Surface, name=floor, type=element
1, S1
right, s4
*SURFACE, NAME=side
2, S3
*STEP
*STATIC
*END STEP
)";

std::string with(std::string text, const std::string& from, const std::string& to) {
  const auto place = text.find(from);
  EXPECT_NE(place, std::string::npos) << from;
  return place == std::string::npos ? text : text.replace(place, from.size(), to);
}

Mesh read(const std::string& text, Model model = Model::plane_strain, const std::string& body = "plate",
          bool only = false) {
  const InpFile file(text);
  Mesh mesh = read_inp(file.path(), model, body, only);
  check_mesh(mesh, body);
  return mesh;
}

std::string error_of(const std::string& text, Model model = Model::plane_strain, const std::string& body = "plate") {
  try {
    (void)read(text, model, body);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "no error";
}

double length_of(const Mesh& mesh, const std::string& surface) {
  double length = 0.0;
  for (const Face& face : mesh.surfaces.at(surface))
    length += (mesh.position[at(face[1])] - mesh.position[at(face[0])]).norm();
  return length;
}

TEST(ReadInp, ReadsNodesElementsSetsAndSurfaces) {
  const Mesh mesh = read(squares);
  EXPECT_EQ(mesh.position.size(), 6U);
  EXPECT_EQ(mesh.position[2], Eigen::Vector3d(2.0, 0.0, 0.0));
  EXPECT_THAT(mesh.element_groups, ElementsAre(Key("Right"), Key("both"), Key("plate")));
  EXPECT_THAT(mesh.element_groups.at("Right"), ElementsAre(1));
  EXPECT_THAT(mesh.element_groups.at("both"), ElementsAre(0, 1));
  EXPECT_THAT(mesh.surfaces, ElementsAre(Key("floor"), Key("side")));
  EXPECT_EQ(length_of(mesh, "floor"), 2.0);
  for (const Face& face : mesh.surfaces.at("floor"))
    EXPECT_EQ(face_normal(mesh, face), Eigen::Vector3d(0.0, -1.0, 0.0));
  EXPECT_EQ(face_normal(mesh, mesh.surfaces.at("side")[0]), Eigen::Vector3d(1.0, 0.0, 0.0));
}

TEST(ReadInp, ReadsLinesThatEndAsThoseOfWindows) {
  std::string text;
  for (const char c : squares) text += c == '\n' ? "\r\n" : std::string(1, c);
  EXPECT_EQ(read(text).elements, read(squares).elements);
  EXPECT_EQ(read(text).surfaces, read(squares).surfaces);
}

TEST(ReadInp, AllElementsAreOfTheOnlyBody) {
  EXPECT_EQ(read(squares, Model::plane_strain, "block", true).element_groups.at("block").size(), 2U);
  EXPECT_THAT(error_of(squares, Model::plane_strain, "block"), HasSubstr("no *ELSET \"block\""));
}

/// Each labelled face looks outwards, and all of them close the element.
TEST(ReadInp, KnowsTheFacesOfEveryType) {
  const std::string nodes =
      "*NODE\n1,0,0,0\n2,1,0,0\n3,1,1,0\n4,0,1,0\n5,0,0,1\n6,1,0,1\n7,1,1,1\n8,0,1,1\n*ELEMENT, ELSET=b, TYPE=";
  const auto normals = [&](const std::string& element, Model model, int faces) {
    std::string text = nodes + element + "\n";
    for (int f = 1; f <= faces; ++f)
      text += "*SURFACE, NAME=f" + std::to_string(f) + "\nb, S" + std::to_string(f) + "\n";
    const Mesh mesh = read(text, model, "b");
    std::vector<Eigen::Vector3d> of(at(faces));
    for (int f = 0; f < faces; ++f) of[at(f)] = face_normal(mesh, mesh.surfaces.at("f" + std::to_string(f + 1))[0]);
    return of;
  };
  using V = Eigen::Vector3d;
  const double h = std::sqrt(1.0 / 3.0);
  EXPECT_THAT(normals("C3D8R\n1, 1,2,3,4,5,6,7,8", Model::solid, 6),
              ElementsAre(-V::UnitZ(), V::UnitZ(), -V::UnitY(), V::UnitX(), V::UnitY(), -V::UnitX()));
  const auto tetrahedron = normals("C3D4\n1, 1,2,4,5", Model::solid, 4);
  EXPECT_EQ(tetrahedron[0], V(-V::UnitZ()));
  EXPECT_EQ(tetrahedron[1], V(-V::UnitY()));
  EXPECT_LT((tetrahedron[2] - V(h, h, h)).norm(), 1e-15);
  EXPECT_EQ(tetrahedron[3], V(-V::UnitX()));
  EXPECT_THAT(normals("CAX4\n1, 1,2,3,4", Model::axisymmetric, 4),
              ElementsAre(-V::UnitY(), V::UnitX(), V::UnitY(), -V::UnitX()));
  EXPECT_THAT(normals("CPE3\n1, 1,2,4", Model::plane_strain, 1), ElementsAre(-V::UnitY()));
}

TEST(ReadInp, ReadsABarWithItsEnds) {
  const Mesh mesh =
      read("*NODE\n1,0\n2,1\n3,2\n*ELEMENT, TYPE=T3D2, ELSET=rod\n1,1,2\n2,2,3\n*SURFACE, NAME=far\n2, END2\n",
           Model::bar, "rod");
  ASSERT_EQ(mesh.surfaces.at("far").size(), 1U);
  EXPECT_EQ(mesh.surfaces.at("far")[0][0], 2);
}

TEST(ReadInp, SaysWhichCardsItLeavesOut) {
  const InpFile file(squares);
  EXPECT_THAT(ignored_inp_cards(file.path()), ElementsAre("*HEADING", "*STEP", "*STATIC", "*ENDSTEP"));
  EXPECT_TRUE(inp_has_node_set(file.path(), "CORNERS"));
  EXPECT_TRUE(inp_has_node_set(file.path(), "everything"));
  EXPECT_FALSE(inp_has_node_set(file.path(), "plate"));
}

struct Wrong {
  const char* name;
  const char* from;
  const char* to;
  const char* error;
};

class WrongInp : public testing::TestWithParam<Wrong> {};

TEST_P(WrongInp, IsRefusedByLine) {
  EXPECT_THAT(error_of(with(squares, GetParam().from, GetParam().to)), HasSubstr(GetParam().error));
}

INSTANTIATE_TEST_SUITE_P(
    ReadInp, WrongInp,
    testing::Values(
        Wrong{"PlaneStress", "cpe4r", "CPS4",
              "mesh.inp:11: found element type CPS4; allowed in this model: CPE3, CPE4"},
        Wrong{"Quadratic", "cpe4r", "C3D10", "found element type C3D10"},
        Wrong{"NoType", "type=cpe4r, ", "", "mesh.inp:11: found *ELEMENT without TYPE="},
        Wrong{"OtherModel", "cpe4r", "CAX4", "found element type CAX4"},
        Wrong{"SurfaceOfNodes", "type=element", "type=node", "mesh.inp:21: found TYPE=node of *SURFACE floor"},
        Wrong{"SurfaceWithoutName", "name=floor, ", "", "mesh.inp:21: found *SURFACE without NAME="},
        Wrong{"SurfaceTwice", "NAME=side", "NAME=FLOOR", "mesh.inp:24: *SURFACE FLOOR is defined twice"},
        Wrong{"SurfaceParameter", "NAME=side", "NAME=side, COMBINE=UNION", "mesh.inp:24: found COMBINE of *SURFACE"},
        Wrong{"Face", "1, S1", "1, S5", "mesh.inp:22: found face S5 of element 1; allowed: S1 to S4"},
        Wrong{"NoFace", "1, S1", "1,", "mesh.inp:22: expected an element or *ELSET and one of its faces"},
        Wrong{"FaceTwice", "right, s4", "1, S1", "mesh.inp:23: element 1 is the same face of \"floor\" as element 1"},
        Wrong{"FaceInside", "right, s4", "1, S2", "mesh.inp:23: element 1 of \"floor\" lies inside the body"},
        Wrong{"FaceOfNoElement", "1, S1", "7, S1", "mesh.inp:22: found element 7, which is not defined before it"},
        Wrong{"UnknownSet", "right, s4", "rigth, s4", "did you mean \"Right\"?"},
        Wrong{"UnknownParameterOfNodes", "NSET=Everything", "SYSTEM=C", "mesh.inp:4: found SYSTEM of *NODE"},
        Wrong{"UnknownParameterOfElements", "elset=Plate", "INPUT=other.inp", "mesh.inp:11: found INPUT of *ELEMENT"},
        Wrong{"NodeTwice", "2, 1.D0", "1, 1.D0", "mesh.inp:6: node 1 is defined twice"},
        Wrong{"NodeWithoutPlace", "3, +2., 0.", "3", "mesh.inp:7: expected a node's number and its coordinates"},
        Wrong{"NoNumber", "+2.", "two", "mesh.inp:7: expected a coordinate, found \"two\""},
        Wrong{"OffThePlane", "0.0, 0.0", "0.0, 0.5", "node 2 has z = 0.5 m"},
        Wrong{"ElementTwice", "2, 2, 5, 6, 3", "1, 2, 5, 6, 3", "mesh.inp:14: element 1 is defined twice"},
        Wrong{"UnknownNode", "2, 2, 5, 6, 3", "2, 2, 5, 9, 3", "mesh.inp:14: element 2 uses node 9"},
        Wrong{"TooFewNodes", "2, 2, 5, 6, 3", "2, 2, 5, 6", "mesh.inp:14: element 2 has 3 nodes, its type 4"},
        Wrong{"TooManyNodes", "2, 2, 5, 6, 3", "2, 2, 5, 6, 3, 1", "mesh.inp:14: element 2 has 5 nodes, its type 4"},
        Wrong{"CutOff", "2, 2, 5, 6, 3", "2, 2, 5,", "the last element ends before all of its nodes are given"},
        Wrong{"Inverted", "2, 2, 5, 6, 3", "2, 2, 6, 5, 3", "mesh.inp:14: element 2"},
        Wrong{"WithoutName", "elset=Right", "GENERATE", "found *ELSET without ELSET="},
        Wrong{"BackwardRange", "1, 2, 1", "2, 1, 1", "mesh.inp:18: found 2, 1, 1 of GENERATE"},
        Wrong{"NoRange", "1, 2, 1", "1", "mesh.inp:18: expected first, last and step of GENERATE, found 1 values"},
        Wrong{"OfNoBody", ", elset=Plate", "", "no *ELSET \"plate\""},
        Wrong{"Include", "*STEP", "*INCLUDE, INPUT=more.inp",
              "mesh.inp:26: found *INCLUDE, which makes, moves or joins"},
        Wrong{"Tie", "*STEP", "*Tie, name=glue", "mesh.inp:26: found *TIE"},
        Wrong{"Part", "*Heading", "*Part, name=p", "mesh.inp:1: found *PART"},
        Wrong{"DataFirst", "*Heading", "Heading", "mesh.inp:1: found \"Heading\" before the first card"}),
    [](const auto& wrong) { return std::string(wrong.param.name); });

TEST(ReadInp, RefusesWhatIsNoMesh) {
  EXPECT_THAT(error_of("*HEADING\n"), HasSubstr("the file has no *NODE"));
  EXPECT_THAT(error_of("*NODE\n1, 0, 0\n"), HasSubstr("the file has no *ELEMENT"));
  EXPECT_THROW((void)read_inp("/nowhere/mesh.inp", Model::solid, "b", true), ConfigError);
}

TEST(ReadInp, RefusesABodyThatIsCutWhereTwoNodesAre) {
  const std::string text = with(with(squares, "6, 2., 1.", "6, 2., 1.\n7, 1., 0."), "2, 2, 5, 6, 3", "2, 7, 5, 6, 3");
  EXPECT_THAT(error_of(text), HasSubstr("nodes 2 and 7 of one body lie at the same place"));
  EXPECT_THAT(error_of(text), HasSubstr("merge them where the mesh is made"));
}

TEST(ReadInp, RefusesAnElementOfNoSetWhereOthersAreOfABody) {
  const std::string text = with(squares, "2, 2, 5, 6, 3", "*ELEMENT, TYPE=CPE4\n2, 2, 5, 6, 3");
  EXPECT_THAT(error_of(with(with(text, "elset=Right\n2", "elset=Right\n1"), "1, 2, 1", "1, 1, 1")),
              HasSubstr("mesh.inp:15: element 2 is in no *ELSET"));
}

}  // namespace
}  // namespace ricochet::fem

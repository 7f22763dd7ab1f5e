#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <fstream>

#include "common/fem/gmsh_file.hpp"
#include "tests/common/fem/sample_elements.hpp"
#include "tests/common/fem/test_help.hpp"
#include "tests/support/block_mesh.hpp"
#include "tests/support/places.hpp"
#include "tests/support/triangle_mesh.hpp"

namespace ricochet::fem {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Key;
using testing::Pair;

const std::string cylinders = test::source_folder() + "/tests/common/fem/data/two_cylinders.msh";
const std::string rod = test::source_folder() + "/tests/common/fem/data/rod.msh";

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t position = text.find(from);
  EXPECT_NE(position, std::string::npos) << "the sample does not hold: " << from;
  return position == std::string::npos ? text : text.replace(position, from.size(), to);
}

/// A mesh file that exists as long as the test.
class TemporaryMesh {
 public:
  explicit TemporaryMesh(const std::string& text) : path_(sample::temporary_path("mesh.msh")) {
    std::ofstream(path_, std::ios::binary) << text;
  }
  ~TemporaryMesh() { std::remove(path_.c_str()); }
  TemporaryMesh(const TemporaryMesh&) = delete;
  TemporaryMesh& operator=(const TemporaryMesh&) = delete;
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_;
};

struct SurfaceSum {
  double area = 0.0;
  Eigen::Vector3d normal_area{0.0, 0.0, 0.0};  // integral of the outward normal
};

SurfaceSum sum_of(const Mesh& mesh, const std::string& surface) {
  SurfaceSum sum;
  for (const Face& face : mesh.surfaces.at(surface)) {
    const FaceArea of_nodes = face_area(sample::section(mesh.model), mesh, face);
    const double area = std::accumulate(of_nodes.begin(), of_nodes.end(), 0.0);
    sum.area += area;
    sum.normal_area += area * face_normal(mesh, face);
  }
  return sum;
}

double volume_of(const Mesh& mesh) {
  return sample::whole_part(mesh, sample::section(mesh.model)).lumped_mass.sum() / sample::steel.density_kg_m3;
}

TEST(ReadGmsh, ReadsOneOfTwoBodiesWithItsSurfacesAndGroups) {
  const Mesh mesh = read_gmsh(cylinders, Model::axisymmetric, "striker");
  check_mesh(mesh, "striker");
  EXPECT_EQ(mesh.elements.size(), 17U);
  EXPECT_THAT(mesh.element_groups, ElementsAre(Key("contact zone"), Key("striker")));
  EXPECT_EQ(mesh.element_groups.at("contact zone").size(), 11U);
  EXPECT_EQ(mesh.element_groups.at("striker").size(), 17U);
  EXPECT_THAT(mesh.surfaces, ElementsAre(Key("axis"), Key("free"), Key("striker_face")));

  const double pi = std::numbers::pi;
  const SurfaceSum face = sum_of(mesh, "striker_face");
  EXPECT_NEAR(face.area, pi * 4e-3 * 4e-3, 1e-15);
  EXPECT_LT((face.normal_area - Eigen::Vector3d(0.0, -face.area, 0.0)).norm(), 1e-15);
  const SurfaceSum free = sum_of(mesh, "free");
  EXPECT_NEAR(free.area, 2.0 * pi * 5e-3 * 7e-3, 1e-15);
  EXPECT_NEAR(free.normal_area[0], free.area, 1e-15);
  EXPECT_EQ(sum_of(mesh, "axis").area, 0.0);
  EXPECT_THAT(surface_nodes(mesh, "striker_face"), testing::SizeIs(3));
  // The rounded rim takes 1 % off the cylinder.
  const double cylinder = pi * 5e-3 * 5e-3 * 8e-3;
  EXPECT_GT(volume_of(mesh), 0.985 * cylinder);
  EXPECT_LT(volume_of(mesh), 0.995 * cylinder);
}

TEST(ReadGmsh, TurnsClockwiseQuadrilateralsAndTheirSurfaces) {
  const GmshFile file = read_gmsh_file(cylinders);
  const GmshElement& first = file.elements[33];
  const auto at = [&](std::size_t i) { return file.nodes.at(first.nodes[i]); };
  ASSERT_LT((at(2) - at(0)).cross(at(3) - at(1))[2], 0.0) << "the sample's target is clockwise on purpose";

  const Mesh mesh = read_gmsh(cylinders, Model::axisymmetric, "target");
  check_mesh(mesh, "target");
  EXPECT_EQ(mesh.elements.size(), 4U);
  const double area = std::numbers::pi * 5e-3 * 5e-3;
  EXPECT_NEAR(volume_of(mesh), area * 4e-3, 1e-12 * area);
  EXPECT_LT((sum_of(mesh, "target_face").normal_area - Eigen::Vector3d(0.0, area, 0.0)).norm(), 1e-15);
}

TEST(ReadGmsh, ReadsTheSameFileInPlaneStrain) {
  const Mesh mesh = read_gmsh(cylinders, Model::plane_strain, "target");
  EXPECT_NEAR(volume_of(mesh), 5e-3 * 4e-3 * 0.03, 1e-16);
  EXPECT_LT((sum_of(mesh, "axis").normal_area - Eigen::Vector3d(-4e-3 * 0.03, 0.0, 0.0)).norm(), 1e-15);
}

TEST(ReadGmsh, ReadsABarWhoseCurvesRunEitherWay) {
  const Mesh mesh = read_gmsh(rod, Model::bar, "rod");
  check_mesh(mesh, "rod");
  EXPECT_EQ(mesh.elements.size(), 12U);
  EXPECT_NEAR(volume_of(mesh), 0.15 * 2.5e-4, 1e-15);
  EXPECT_EQ(mesh.element_groups.at("tip").size(), 5U);
  EXPECT_THAT(mesh.surfaces, ElementsAre(Pair("impact_end", testing::SizeIs(1)), Pair("support", testing::SizeIs(1))));
  const Face& end = mesh.surfaces.at("impact_end")[0];
  ASSERT_EQ(end.size(), 1U);
  EXPECT_EQ(mesh.position[static_cast<std::size_t>(end[0])], Eigen::Vector3d(0.25, 0.0, 0.0));
}

TEST(ReadGmsh, SkipsSectionsItDoesNotNeedAndTakesWindowsLineEnds) {
  std::string text =
      replaced(sample::file_text(rod), "$Entities", "$Comments\nmade by hand: $Nodes 3\n$EndComments\n$Entities");
  std::string windows;
  for (const char c : text) windows += c == '\n' ? std::string("\r\n") : std::string(1, c);
  const TemporaryMesh file(windows);
  const Mesh mesh = read_gmsh(file.path(), Model::bar, "rod");
  const Mesh original = read_gmsh(rod, Model::bar, "rod");
  EXPECT_EQ(mesh.elements, original.elements);
  EXPECT_EQ(mesh.position, original.position);
  EXPECT_EQ(mesh.surfaces, original.surfaces);
}

TEST(ReadGmsh, PutsNodesOnTheAxisThatGmshLeftBesideIt) {
  const TemporaryMesh file(
      replaced(sample::file_text(cylinders), "\n0 -0.002000000000004911 0\n", "\n-6.1e-19 -0.002 0\n"));
  const Mesh mesh = read_gmsh(file.path(), Model::axisymmetric, "target");
  for (const Eigen::Vector3d& x : mesh.position) EXPECT_GE(x[0], 0.0);
  EXPECT_EQ(surface_nodes(mesh, "axis").size(), 3U);
}

TEST(ReadGmsh, TakesAPhysicalTagOfReversedOrientation) {
  const TemporaryMesh file(replaced(sample::file_text(cylinders), "0.004 0 0 1 4 2 1 -2", "0.004 0 0 1 -4 2 1 -2"));
  EXPECT_EQ(read_gmsh(file.path(), Model::axisymmetric, "striker").surfaces,
            read_gmsh(cylinders, Model::axisymmetric, "striker").surfaces);
}

TEST(ReadGmsh, ReadsTrianglesBesideQuadrilaterals) {
  const TemporaryMesh file(test::rectangle_msh("plate", {.width_m = 0.03, .length_m = 0.04, .across = 3, .along = 4}));
  const Mesh mesh = read_gmsh(file.path(), Model::plane_strain, "plate");
  check_mesh(mesh, "plate");
  EXPECT_EQ(std::count_if(mesh.elements.begin(), mesh.elements.end(),
                          [](const Element& e) { return e.kind == ElementKind::triangle; }),
            2 * 3 * 4 - 2);
  EXPECT_EQ(mesh.elements.size(), 2U * 3U * 4U - 1U) << "the last cell is a quadrilateral";
  EXPECT_NEAR(volume_of(mesh), 0.03 * 0.04 * 0.03, 1e-15) << "some triangles of the file are clockwise";
  EXPECT_EQ(mesh.surfaces.at("end").size(), 3U);
  EXPECT_LT((sum_of(mesh, "end").normal_area - Eigen::Vector3d(0.0, 0.03 * 0.03, 0.0)).norm(), 1e-15);
}

TEST(ReadGmsh, ReadsVolumesAndTurnsWhatIsInsideOut) {
  for (const bool tetrahedra : {false, true}) {
    const TemporaryMesh file(test::block_msh(
        "block",
        {.size_m = 0.03, .start_m = 0.1, .length_m = 0.05, .across = 3, .along = 4, .tetrahedra = tetrahedra}));
    const Mesh mesh = read_gmsh(file.path(), Model::solid, "block");
    check_mesh(mesh, "block");
    EXPECT_EQ(mesh.elements.size(), tetrahedra ? 216U : 36U);
    EXPECT_NEAR(volume_of(mesh), 0.03 * 0.03 * 0.05, 1e-14);
    EXPECT_LT((sum_of(mesh, "start").normal_area - Eigen::Vector3d(0.0, 0.0, -9e-4)).norm(), 1e-15);
    EXPECT_LT((sum_of(mesh, "end").normal_area - Eigen::Vector3d(0.0, 0.0, 9e-4)).norm(), 1e-15);
    EXPECT_LT(sum_of(mesh, "sides").normal_area.norm(), 1e-15);
    EXPECT_NEAR(sum_of(mesh, "sides").area, 4 * 0.03 * 0.05, 1e-15);
  }
}

TEST(ReadGmsh, RefusesASolidWithoutVolume) {
  const std::string flat = replaced(test::block_msh("block", {}), "\n1 0 0\n", "\n-1 0 0\n");
  const TemporaryMesh file(flat);
  EXPECT_THAT(sample::message_of([&] { (void)read_gmsh(file.path(), Model::solid, "block"); }),
              AllOf(HasSubstr("is inverted, not convex or has no volume at (x, y, z) = ")));
}

TEST(ReadGmsh, RefusesASurfaceInsideASolid) {
  std::string text = test::block_msh("block", {.along = 2});  // face of nodes 1 2 4 3 of "start" moved up to 5 6 8 7
  text = replaced(text, "\n1 1 2 4 3\n", "\n1 5 6 8 7\n");
  const TemporaryMesh file(text);
  EXPECT_THAT(sample::message_of([&] { (void)read_gmsh(file.path(), Model::solid, "block"); }),
              HasSubstr("of \"start\" lies inside the body"));
}

TEST(ReadGmsh, SaysWhichFileItCannotRead) {
  EXPECT_THAT(sample::message_of([] { (void)read_gmsh("/nonexistent/a.msh", Model::bar, "rod"); }),
              HasSubstr("cannot read mesh file /nonexistent/a.msh"));
}

/// The sample cylinders with one thing changed, and what the refusal must say.
struct Broken {
  std::string name;
  std::string from, to;
  std::vector<std::string> expected;
  std::string body = "striker";

  friend void PrintTo(const Broken& broken, std::ostream* out) { *out << broken.from << " -> " << broken.to; }
};

class BrokenMesh : public testing::TestWithParam<Broken> {};

TEST_P(BrokenMesh, IsRefusedByName) {
  const Broken& broken = GetParam();
  const TemporaryMesh file(replaced(sample::file_text(cylinders), broken.from, broken.to));
  const std::string text = sample::message_of([&] { (void)read_gmsh(file.path(), Model::axisymmetric, broken.body); });
  EXPECT_THAT(text, HasSubstr(file.path()));
  for (const std::string& expected : broken.expected) EXPECT_THAT(text, HasSubstr(expected));
}

INSTANTIATE_TEST_SUITE_P(
    Format, BrokenMesh,
    testing::Values(
        Broken{"version_2", "4.1 0 8", "2.2 0 8", {":2: MSH format 2.2, needed is 4.1", "gmsh -format msh41"}},
        Broken{"binary", "4.1 0 8", "4.1 1 8", {":2: the file is binary, needed is ASCII", "Mesh.Binary = 0"}},
        Broken{"not_gmsh", "$MeshFormat", "solid cube", {":1: expected a section like $Nodes, found \"solid\""}},
        Broken{"no_format",
               "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n",
               "",
               {":1: $MeshFormat must come before $PhysicalNames"}},
        Broken{"letters_for_a_number",
               "0.00250000000000661 -0.004 0",
               "0.0025 minus 0",
               {":111: expected a node coordinate, found \"minus\""}},
        Broken{
            "nan", "0.00250000000000661 -0.004 0", "nan -0.004 0", {":111: expected a node coordinate, found \"nan\""}},
        Broken{"coordinate_missing",
               "0.00250000000000661 -0.004 0",
               "0.0025 -0.004",
               {":112: expected the dimension of a node block, 0 to 3, found 14"}},
        Broken{"negative_count", "\n26 34 1 34\n", "\n26 -34 1 34\n", {":45: expected the number of nodes, found -34"}},
        Broken{"huge_block", "\n2 1 0 7\n", "\n2 1 0 2000000000\n", {":123: expected a node tag"}},
        Broken{"node_count", "\n26 34 1 34\n", "\n26 35 1 34\n", {":139: 35 nodes are announced, the blocks hold 34"}},
        Broken{"element_count", "\n11 37 1 37\n", "\n11 38 1 37\n", {"38 elements are announced, the blocks hold 37"}},
        Broken{"name_without_quote", "\"axis\"", "\"axis", {":9: the name of a physical group has no closing quote"}},
        Broken{
            "name_without_quotes", "\"axis\"", "axis", {":9: expected the name of a physical group in double quotes"}},
        Broken{"group_of_no_dimension",
               "2 2 \"contact zone\"",
               "9 2 \"striker\"",
               {":11: expected the dimension of a physical group, 0 to 3, found 9"}},
        Broken{"block_of_no_dimension",
               "\n2 1 0 7\n",
               "\n-2 1 0 7\n",
               {":115: expected the dimension of a node block, 0 to 3, found -2"}},
        Broken{"tag_without_opposite",
               "2 0 0.004 0 0.005 0.008 0 1 1 4",
               "2 0 0.004 0 0.005 0.008 0 1 -2147483648 4",
               {"expected a physical tag, found -2147483648"}},
        Broken{"group_named_twice", "2 2 \"contact zone\"", "2 2 \"striker\"", {":11: physical group 2 \"striker\""}},
        Broken{"section_twice", "$Nodes\n", "$Entities\n0 0 0 0\n$EndEntities\n$Nodes\n", {":44: a second $Entities"}},
        Broken{"section_end_missing", "$EndEntities\n", "", {":43: expected $EndEntities, found \"$Nodes\""}}),
    [](const auto& tested) { return tested.param.name; });

INSTANTIATE_TEST_SUITE_P(
    Content, BrokenMesh,
    testing::Values(
        Broken{"triangles_of_four_nodes", "\n2 2 3 6\n", "\n2 2 2 6\n", {":182: element 15 is defined twice"}},
        Broken{"second_order",
               "\n2 2 3 6\n",
               "\n2 2 16 6\n",
               {"second-order elements (type 16)", "Mesh.ElementOrder = 1"}},
        Broken{"prisms", "\n2 2 3 6\n", "\n3 2 6 6\n", {"element type 6 in entity 2 of dimension 3; only 2-node"}},
        Broken{"unknown_entity", "\n2 2 3 6\n", "\n2 9 3 6\n", {"entity 9 of dimension 2 is not in $Entities"}},
        Broken{"type_of_another_dimension", "\n2 2 3 6\n", "\n2 2 1 6\n", {"does not fit its elements"}},
        Broken{"no_group_of_that_name",
               "2 1 \"striker\"",
               "2 1 \"stricker\"",
               {"no physical surface \"striker\"", "stricker, contact zone, target", "did you mean \"stricker\"?"}},
        Broken{"group_of_another_dimension", "2 1 \"striker\"", "1 1 \"striker\"", {"(it is a physical curve)"}},
        Broken{"group_without_elements", "2 3 \"target\"", "2 9 \"target\"", {"\"target\" has no elements"}, "target"},
        Broken{"element_without_group",
               "2 0 0.004 0 0.005 0.008 0 1 1 4",
               "2 0 0.004 0 0.005 0.008 0 0 4",
               {":180: element 28 in entity 2 belongs to no physical group"}},
        Broken{"unknown_node",
               "\n28 17 6 18 32 ",
               "\n28 17 6 18 99 ",
               {":180: element 28 uses node 99, which is not defined"}},
        Broken{"node_defined_twice", "\n26\n27\n28\n", "\n26\n26\n28\n", {":119: node 26 is defined twice"}},
        Broken{"element_defined_twice", "\n29 17 32 15 4 ", "\n28 17 32 15 4 ", {":181: element 28 is defined twice"}},
        Broken{"node_used_twice", "\n28 17 6 18 32 ", "\n28 17 6 18 18 ", {":180: element 28 uses a node twice"}},
        Broken{"crossed",
               "\n28 17 6 18 32 ",
               "\n28 17 18 6 32 ",
               {":180: element 28 is inverted, not convex", "(r, z) ="}},
        Broken{"same_face_twice",
               "\n2 12 2 \n",
               "\n2 12 1 \n",
               {":145: element 2 is the same face of \"striker_face\" as element 1: loads and contact would act there "
                "twice"}},
        Broken{"same_element_twice", "\n29 17 32 15 4 ", "\n29 17 6 18 32 ", {":181: element 29 overlaps element 28"}},
        Broken{"off_the_plane",
               "0.00250000000000661 -0.004 0",
               "0.0025 -0.004 1e-5",
               {"node 22 has z = 1e-05 m; the mesh must lie in z = 0"},
               "target"},
        Broken{"across_the_axis",
               "0 -0.002000000000004911 0",
               "-1e-4 -0.002 0",
               {"reaches across the axis", "element 34"},
               "target"},
        Broken{"surface_inside",
               "\n1 1 12 \n",
               "\n1 27 24 \n",
               {":144: element 1 of \"striker_face\" lies inside the body"}}),
    [](const auto& tested) { return tested.param.name; });

TEST(ReadGmsh, RefusesACrackThatNobodySees) {
  // Element 33 gets a node of its own at the place of node 33, which its neighbours share.
  const std::string moved = replaced(sample::file_text(cylinders), "\n0.00250000000000661 -0.004 0\n",
                                     "\n0.001205995708118331 0.00634011713973302 0\n");
  const TemporaryMesh file(replaced(moved, "\n33 5 31 33 19 ", "\n33 5 31 22 19 "));
  EXPECT_THAT(sample::message_of([&] { (void)read_gmsh(file.path(), Model::axisymmetric, "striker"); }),
              AllOf(HasSubstr("nodes 22 and 33 of one body lie at the same place (0.001206, 0.00634012) m"),
                    HasSubstr("'Coherence;'")));
}

TEST(ReadGmsh, RefusesAFileCutOffAnywhere) {
  const std::string whole = sample::file_text(cylinders);
  const std::size_t last = whole.find("$EndElements");
  int refused = 0;
  for (std::size_t length = 0; length < last + 11; length += 7) {
    const TemporaryMesh file(whole.substr(0, length));
    const std::string text = sample::message_of([&] { (void)read_gmsh(file.path(), Model::axisymmetric, "striker"); });
    EXPECT_THAT(text, HasSubstr(file.path())) << "cut off after " << length << " bytes";
    if (text.find("was it cut off?") != std::string::npos) ++refused;
  }
  EXPECT_GT(refused, 100);
}

TEST(ReadGmsh, RefusesABarOffItsAxisOrWithASurfaceInside) {
  const TemporaryMesh off(replaced(sample::file_text(rod), "\n0.25 0 0\n", "\n0.25 1e-3 0\n"));
  EXPECT_THAT(sample::message_of([&] { (void)read_gmsh(off.path(), Model::bar, "rod"); }),
              HasSubstr("node 3 has y = 0.001 m; bars lie on the x axis"));
  const TemporaryMesh inside(replaced(sample::file_text(rod), "\n0 3 15 1\n2 3 \n", "\n0 3 15 1\n2 12 \n"));
  EXPECT_THAT(sample::message_of([&] { (void)read_gmsh(inside.path(), Model::bar, "rod"); }),
              HasSubstr("element 2 of \"impact_end\" lies inside the body"));
  EXPECT_THAT(sample::message_of([&] { (void)read_gmsh(rod, Model::axisymmetric, "rod"); }),
              HasSubstr("no physical surface \"rod\" (it is a physical curve); the file has: none"));
}

}  // namespace
}  // namespace ricochet::fem

// The deformed bodies on the page: edges, places, stresses, and what is said of them.
#include <gmock/gmock.h>

#include <cstring>
#include <limits>

#include "common/base/base64.hpp"
#include "coupler/report/shapes/cell_looks.hpp"
#include "coupler/report/shapes/shape_viewer.hpp"

namespace ricochet::report {
namespace {

using testing::AllOf;
using testing::Each;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

constexpr double no_contact = std::numeric_limits<double>::quiet_NaN();

/// One piece of one body in these cells, at rest and then displaced by `u`; stress 0, then `stress` of every cell.
Shapes one_piece(const std::string& model, const std::vector<Place>& position,
                 const std::vector<std::array<int, 4>>& cells, const Place& u = {}, double stress = 1e6) {
  Shapes shapes;
  shapes.model = model;
  shapes.largest_window_s = 1e-6;
  shapes.times_s = {0.0, 1e-6};
  shapes.bodies = {{"block", 0.0, {}}};
  ShapePiece piece;
  for (std::size_t i = 0; i < position.size(); ++i) piece.node.push_back(static_cast<int>(i));
  piece.position = position;
  piece.cells = cells;
  piece.displacement = {std::vector<Place>(position.size()), std::vector<Place>(position.size(), u)};
  piece.stress_pa = {std::vector<double>(cells.size(), 0.0), std::vector<double>(cells.size(), stress)};
  shapes.pieces = {piece};
  return shapes;
}

/// Two squares of 1 m side by side.
Shapes two_squares(const Place& u = {}) {
  return one_piece("plane_strain", {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 1, 0}, {1, 1, 0}, {0, 1, 0}},
                   {{0, 1, 4, 5}, {1, 2, 3, 4}}, u);
}

/// The surface of a cube of 1 m; its nodes are numbered by x + 2 y + 4 z.
Shapes cube() {
  std::vector<Place> corners;
  for (int i = 0; i < 8; ++i) corners.push_back({1.0 * (i % 2), 1.0 * (i / 2 % 2), 1.0 * (i / 4)});
  return one_piece("solid", corners,
                   {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}});
}

TEST(CellLooks, OutlinesAreEdgesOfOneCellAlone) {
  const auto looks = cell_looks(two_squares())[0];
  const auto inner = EdgeKind::inner, outline = EdgeKind::outline;
  EXPECT_THAT(looks[0].edges, ElementsAre(outline, inner, outline, outline));
  EXPECT_THAT(looks[1].edges, ElementsAre(outline, outline, outline, inner));
}

TEST(CellLooks, WhatTwoParticipantsShareIsNoOutline) {
  auto shapes = two_squares();
  shapes.pieces.push_back(shapes.pieces[0]);
  shapes.pieces[0].cells.pop_back();
  shapes.pieces[1].cells.erase(shapes.pieces[1].cells.begin());
  EXPECT_EQ(cell_looks(shapes)[0][0].edges[1], EdgeKind::inner);
  shapes.bodies.push_back({"other", 0.0, {}});
  shapes.pieces[1].body = 1;
  EXPECT_EQ(cell_looks(shapes)[0][0].edges[1], EdgeKind::outline) << "of two bodies it is";
}

TEST(CellLooks, TheAxisIsNoOutline) {
  auto shapes = two_squares();
  shapes.model = "axisymmetric";
  EXPECT_THAT(cell_looks(shapes)[0][0].edges,
              ElementsAre(EdgeKind::outline, EdgeKind::inner, EdgeKind::outline, EdgeKind::none));
}

TEST(CellLooks, OfBarsTheEndsAreOutlines) {
  const auto looks =
      cell_looks(one_piece("bar", {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 1, -1, -1}, {1, 2, -1, -1}}))[0];
  const auto inner = EdgeKind::inner, outline = EdgeKind::outline;
  EXPECT_THAT(looks[0].edges, ElementsAre(outline, inner, outline, outline));
  EXPECT_THAT(looks[1].edges, ElementsAre(outline, outline, outline, inner));
}

TEST(CellLooks, OfSolidsOutlinesAreBendsAndInnerFacesAreHidden) {
  const auto alone = cell_looks(cube())[0];
  for (const auto& look : alone) {
    EXPECT_FALSE(look.hidden);
    EXPECT_THAT(look.edges, Each(EdgeKind::outline));
  }
  // A second cube on the first by another participant: the face between them is seen by nobody, the sides are flat.
  auto shapes = cube();
  shapes.pieces.push_back(shapes.pieces[0]);
  for (int& node : shapes.pieces[1].node) node += 4;
  for (auto& x : shapes.pieces[1].position) x[2] += 1.0;
  const auto looks = cell_looks(shapes);
  EXPECT_TRUE(looks[0][1].hidden);
  EXPECT_TRUE(looks[1][0].hidden);
  EXPECT_FALSE(looks[0][0].hidden);
  EXPECT_EQ(looks[0][2].edges[2], EdgeKind::inner) << "from node 5 to node 4";
  EXPECT_EQ(looks[0][2].edges[0], EdgeKind::outline);
}

HistoryTable history_of(const std::vector<double>& force_n) {
  HistoryTable history{{"time_s", "contact_force_n", "gap_min_m"}, {{}, force_n, {}}};
  for (std::size_t i = 0; i < force_n.size(); ++i) {
    history.columns[0].push_back(1e-7 * static_cast<double>(i));
    history.columns[2].push_back(0.0);
  }
  return history;
}

/// Numbers that the page holds in base64.
template <class Number>
std::vector<Number> unpacked(const Json& text) {
  const std::string bytes = from_base64(text.get<std::string>()).value();
  std::vector<Number> values(bytes.size() / sizeof(Number));
  std::memcpy(values.data(), bytes.data(), bytes.size());
  return values;
}

TEST(ShapeViewer, HoldsPlacesStressesCellsAndEdges) {
  const auto viewer = shape_viewer(two_squares({0.5, 0, 0}), history_of({0}), no_contact).value();
  EXPECT_THAT(viewer.html, AllOf(HasSubstr("<h2>Deformed bodies: von Mises stress at 2 times</h2>"),
                                 HasSubstr("Displacements are drawn to scale.")));
  EXPECT_EQ(viewer.data["times"], Json({"0 s", "1 µs"}));
  ASSERT_EQ(viewer.data["fields"].size(), 1U);
  EXPECT_EQ(viewer.data["fields"][0]["unit"], "MPa");
  EXPECT_EQ(viewer.data["fields"][0]["high"], 1e6);
  const auto& piece = viewer.data["pieces"][0];
  EXPECT_THAT(unpacked<int>(piece["cell"]), ElementsAre(0, 1, 4, 5, 1, 2, 3, 4));
  EXPECT_THAT(unpacked<std::uint8_t>(piece["edge"]), ElementsAre(2, 1, 2, 2, 2, 2, 2, 1));
  EXPECT_THAT(unpacked<float>(piece["place"][0]), ElementsAre(0, 0, 1, 0, 2, 0, 2, 1, 1, 1, 0, 1));
  EXPECT_THAT(unpacked<float>(piece["place"][1]), ElementsAre(0.5, 0, 1.5, 0, 2.5, 0, 2.5, 1, 1.5, 1, 0.5, 1));
  EXPECT_THAT(unpacked<float>(piece["stress"][1]), ElementsAre(1e6F, 1e6F));
  EXPECT_THAT(viewer.scripts, HasSubstr("The MIT License"));
}

TEST(ShapeViewer, LeavesOutFacesOfSolidsThatNobodySees) {
  auto shapes = cube();
  shapes.pieces.push_back(shapes.pieces[0]);
  for (int& node : shapes.pieces[1].node) node += 4;
  const auto viewer = shape_viewer(shapes, history_of({0}), no_contact).value();
  for (const auto& piece : viewer.data["pieces"]) {
    EXPECT_EQ(unpacked<int>(piece["cell"]).size(), 20U) << "five faces of six";
    EXPECT_EQ(unpacked<float>(piece["stress"][1]).size(), 5U);
  }
  EXPECT_THAT(viewer.html, HasSubstr("Solids are kept as their surfaces"));
}

TEST(ShapeViewer, BeginsWithTheTimeOfTheLargestStress) {
  auto shapes = two_squares();
  auto& piece = shapes.pieces[0];
  shapes.times_s.clear();
  for (int i = 0; i < 9; ++i) shapes.times_s.push_back(1e-6 * i);
  piece.displacement.resize(9, piece.displacement[0]);
  piece.stress_pa.resize(9, piece.stress_pa[0]);
  piece.stress_pa[7][0] = -9e9;
  EXPECT_EQ(shape_viewer(shapes, history_of({0}), 0.0)->data["first"], 7);
}

TEST(ShapeViewer, AFewLargeStressesDoNotTakeTheColours) {
  std::vector<Place> position = two_squares().pieces[0].position;
  auto shapes = one_piece("plane_strain", position, std::vector<std::array<int, 4>>(1000, {0, 1, 4, 5}));
  shapes.pieces[0].stress_pa[1][500] = 9e6;
  const auto viewer = shape_viewer(shapes, history_of({0}), no_contact).value();
  EXPECT_THAT(viewer.html, HasSubstr("The largest stress, 9 MPa at 1 µs, lies beyond the colours."));
  EXPECT_EQ(viewer.data["fields"][0]["high"], 1e6);
}

TEST(ShapeViewer, SaysWhatIsNotAsItIs) {
  const auto said = [](const Shapes& shapes, double first_contact_s = no_contact) {
    return shape_viewer(shapes, history_of({0}), first_contact_s).value().html;
  };
  auto shapes = two_squares({0.01, 0, 0});
  shapes.missing = {"The elements of <foreign> are not drawn."};
  shapes.pieces[0].node[5] = -1;
  EXPECT_THAT(said(shapes), AllOf(HasSubstr("The elements of &lt;foreign&gt; are not drawn."),
                                  HasSubstr("one period of it is drawn"), Not(HasSubstr("Both halves"))));
  shapes = two_squares({0.01, 0, 0});
  shapes.model = "axisymmetric";
  shapes.bodies[0].velocity_m_s = {0, 1, 0};
  EXPECT_THAT(said(shapes), AllOf(HasSubstr("Both halves of the section are drawn"),
                                  HasSubstr("Displacements beyond those of free flight are drawn 20 times as large")));
  EXPECT_THAT(said(shapes, 0.0), HasSubstr("Displacements from the first contact on are drawn 20 times as large"));
  shapes.nose = true;
  EXPECT_THAT(said(shapes, 0.0),
              AllOf(HasSubstr("The rounded nose is a gap of the contact"), HasSubstr("drawn to scale")));
  const auto bar = one_piece("bar", {{0, 0, 0}, {1, 0, 0}}, {{0, 1, -1, -1}});
  EXPECT_THAT(said(bar), HasSubstr("Blue: compression; red: tension."));
}

TEST(ShapeViewer, NothingToDrawOfNothing) {
  EXPECT_FALSE(shape_viewer({}, history_of({0}), no_contact));
  auto shapes = two_squares();
  shapes.times_s.clear();
  EXPECT_FALSE(shape_viewer(shapes, history_of({0}), no_contact)) << "no window that all have";
}

TEST(ShapeViewer, ABodyThatYieldsMayBeColouredByItsPlasticStrain) {
  auto shapes = two_squares();
  shapes.pieces[0].plastic_strain = {{0.0, 0.0}, {0.25, 0.125}};
  const auto data = shape_viewer(shapes, {}, no_contact)->data;
  ASSERT_EQ(data["fields"].size(), 2U);
  EXPECT_EQ(data["fields"][1]["key"], "plastic_strain");
  EXPECT_EQ(data["fields"][1]["high"], 0.25);
  EXPECT_EQ(data["fields"][1]["factor"], 100.0) << "in %";
  EXPECT_THAT(unpacked<float>(data["pieces"][0]["plastic_strain"][1]), ElementsAre(0.25F, 0.125F));
}

TEST(ShapeViewer, ABodyThatIsHeatedMayBeColouredByTheRiseOfItsTemperature) {
  auto shapes = two_squares();
  shapes.pieces[0].temperature_rise_k = {{0.0, 0.0}, {50.0, 25.0}};
  const auto data = shape_viewer(shapes, {}, no_contact)->data;
  ASSERT_EQ(data["fields"].size(), 2U);
  EXPECT_EQ(data["fields"][1]["key"], "temperature_rise_k");
  EXPECT_EQ(data["fields"][1]["high"], 50.0);
  EXPECT_EQ(data["fields"][1]["unit"], "K");
  EXPECT_THAT(unpacked<float>(data["pieces"][0]["temperature_rise_k"][1]), ElementsAre(50.0F, 25.0F));
}

TEST(ShapeViewer, BodiesThatPressEachOtherMayBeColouredByTheContactPressure) {
  auto shapes = two_squares();
  shapes.pieces[0].contact_pressure_pa = {{0.0, 0.0}, {0.0, 0.0}};
  EXPECT_EQ(shape_viewer(shapes, {}, no_contact)->data["fields"].size(), 1U) << "nothing is pressed";
  shapes.pieces[0].contact_pressure_pa[1] = {4e6, 0.0};
  const auto data = shape_viewer(shapes, {}, no_contact)->data;
  ASSERT_EQ(data["fields"].size(), 2U);
  EXPECT_EQ(data["fields"][1]["key"], "contact_pressure_pa");
  EXPECT_EQ(data["fields"][1]["high"], 4e6);
  EXPECT_THAT(unpacked<float>(data["pieces"][0]["contact_pressure_pa"][1]), ElementsAre(4e6F, 0.0F));
}

}  // namespace
}  // namespace ricochet::report

// The picture of the deformed bodies: edges, view, panels, pixels, and what is said of it.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "coupler/report/shapes/canvas.hpp"
#include "coupler/report/shapes/shape_layout.hpp"
#include "coupler/report/shapes/shape_picture.hpp"
#include "coupler/report/shapes/shape_view.hpp"

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

std::vector<SeenCell> seen_cells(const Shapes& shapes, bool turned) {
  std::vector<SeenCell> cells;
  const auto& piece = shapes.pieces[0];
  ShapeView(shapes.model, turned).add(piece, piece.position, cell_looks(shapes)[0], 1, 0.5, cells);
  return cells;
}

TEST(ShapeViews, LookAtThePlaneAndMayTurnIt) {
  const auto upright = seen_cells(two_squares(), false), turned = seen_cells(two_squares(), true);
  EXPECT_THAT(upright[1].corners(), ElementsAre(Pixel{1, 0}, Pixel{2, 0}, Pixel{2, 1}, Pixel{1, 1}));
  EXPECT_THAT(turned[1].corners(), ElementsAre(Pixel{0, -1}, Pixel{0, -2}, Pixel{1, -2}, Pixel{1, -1}));
  EXPECT_EQ(upright[1].stress_pa, 1e6);
}

TEST(ShapeViews, ABarIsAStrip) {
  const auto bar = one_piece("bar", {{0, 0, 0}, {2, 0, 0}}, {{0, 1, -1, -1}});
  EXPECT_THAT(seen_cells(bar, false)[0].corners(),
              ElementsAre(Pixel{0, -0.25}, Pixel{2, -0.25}, Pixel{2, 0.25}, Pixel{0, 0.25}));
  EXPECT_EQ(ShapeView("bar", false).axes().size(), 1U);
}

TEST(ShapeViews, OfAnAxisymmetricSectionBothHalvesAreSeen) {
  auto shapes = two_squares();
  shapes.model = "axisymmetric";
  const auto cells = seen_cells(shapes, false), turned = seen_cells(shapes, true);
  ASSERT_EQ(cells.size(), 4U);
  EXPECT_THAT(cells[3].corners(), ElementsAre(Pixel{-1, 0}, Pixel{-2, 0}, Pixel{-2, 1}, Pixel{-1, 1}));
  EXPECT_THAT(turned[2].corners(), ElementsAre(Pixel{0, 1}, Pixel{0, 2}, Pixel{1, 2}, Pixel{1, 1}));
  EXPECT_THAT(turned[3].corners(), ElementsAre(Pixel{0, -1}, Pixel{0, -2}, Pixel{1, -2}, Pixel{1, -1}));
  EXPECT_EQ(ShapeView("axisymmetric", true).axes()[1].letter, "z");
}

TEST(ShapeViews, OfACubeThreeFacesAreSeenInThreeShades) {
  for (const bool turned : {false, true}) {
    const auto cells = seen_cells(cube(), turned);
    ASSERT_EQ(cells.size(), 3U);
    EXPECT_EQ((std::set<int>{cells[0].shade, cells[1].shade, cells[2].shade}).size(), 3U);
    // The three axes point to the reader's side and are seen at right angles to nothing but themselves: a projection
    // along a direction e has sum over the axes of |projection|^2 = 3 - |e|^2 = 2.
    double sum = 0;
    for (const auto& axis : ShapeView("solid", turned).axes())
      sum += axis.direction[0] * axis.direction[0] + axis.direction[1] * axis.direction[1];
    EXPECT_NEAR(sum, 2.0, 1e-12);
    const auto z = ShapeView("solid", turned).seen({0, 0, 1});
    EXPECT_GT(turned ? z[0] : z[1], 0.7) << "along z";
  }
}

TEST(Layout, ShowsPanelsAsLargeAsTheyGo) {
  const Extent wide{{0, 0}, {10, 1}}, high{{0, 0}, {1, 10}};
  const auto rows = layout_of(6, wide, 880, 720, 0), columns = layout_of(6, high, 880, 720, 0);
  EXPECT_EQ(rows.columns, 1U);
  EXPECT_EQ(rows.rows, 6U);
  EXPECT_NEAR(rows.scale_px_m, 87.2, 1e-9) << "the whole width but for a margin";
  EXPECT_EQ(columns.columns, 6U);
  EXPECT_LE(columns.height_px(), 720 + 1e-9);
  for (const auto& layout : {rows, columns}) {
    for (std::size_t panel = 0; panel < 6; ++panel) {
      const auto low = layout.at(panel, layout.extent.low), up = layout.at(panel, layout.extent.high);
      const auto corner = layout.corner(panel);
      EXPECT_GE(low[0], corner[0]);
      EXPECT_LE(up[0], corner[0] + layout.panel_width_px);
      EXPECT_LE(low[1], corner[1] + layout.panel_height_px);
      EXPECT_GE(up[1], corner[1]);
      EXPECT_NEAR(low[1] - up[1], layout.scale_px_m * layout.extent.height(), 1e-9) << "up is up";
    }
  }
  EXPECT_GE(layout_of(1, {{0, 0}, {1, 0}}, 880, 720, 12).panel_height_px, 12) << "a bar has no height of its own";
}

TEST(Canvas, PolygonsThatShareAnEdgeCoverEachPixelOnce) {
  const std::vector<Pixel> corners = {{1.3, 2.2}, {17.9, 4.4}, {15.1, 18.6}, {2.7, 13.3}};
  Canvas whole(20, 20), halves(20, 20), other(20, 20);
  whole.fill(corners, 5, 7);
  halves.fill(std::vector<Pixel>{corners[0], corners[1], corners[2]}, 5, 7);
  other.fill(std::vector<Pixel>{corners[0], corners[2], corners[3]}, 5, 7);
  int covered = 0;
  for (int y = 0; y < 20; ++y) {
    for (int x = 0; x < 20; ++x) {
      EXPECT_EQ((halves.cell(x, y) == 7) + (other.cell(x, y) == 7), whole.cell(x, y) == 7 ? 1 : 0) << x << ' ' << y;
      covered += whole.cell(x, y) == 7 ? 1 : 0;
      EXPECT_EQ(whole.colour(x, y), whole.cell(x, y) == 7 ? 5 : ShadedPalette::background);
    }
  }
  EXPECT_NEAR(covered, 186.1, 3) << "the area";
}

TEST(Canvas, DrawsWhatReachesBeyondItAndNothingThatIsFarAway) {
  Canvas canvas(4, 4);
  canvas.fill(std::vector<Pixel>{{-10, -10}, {30, -10}, {30, 30}, {-10, 30}}, 9, 0);
  canvas.draw({-3, 1.5}, {9, 1.5}, 1);
  canvas.draw({-1e300, 0}, {1e300, 0}, 1);
  for (int x = 0; x < 4; ++x) {
    EXPECT_EQ(canvas.colour(x, 0), 9);
    EXPECT_EQ(canvas.colour(x, 1), ShadedPalette::line);
  }
}

TEST(Canvas, EdgesInsideAreDarkerAndDotsAreInAGrid) {
  Canvas canvas(32, 32);
  const auto colour = ShadedPalette::index(0.5, 0);
  const std::vector<Pixel> square = {{0, 0}, {32, 0}, {32, 32}, {0, 32}};
  canvas.fill(square, colour, 0);
  canvas.darken({8.5, 0.5}, {8.5, 31.5}, 1);
  EXPECT_EQ(canvas.colour(8, 16), ShadedPalette::index(0.5, 3));
  EXPECT_EQ(ShadedPalette::darkest(ShadedPalette::line), ShadedPalette::line);
  EXPECT_EQ(ShadedPalette::darkest(ShadedPalette::index(0.5, 3)), ShadedPalette::index(0.5, 3));
  canvas.dot(square, 16, 3);
  EXPECT_EQ(canvas.colour(16, 16), ShadedPalette::line);
  EXPECT_EQ(canvas.colour(13, 16), colour);
}

TEST(ShadedPalettes, ReachFromTheFirstColourToTheLast) {
  const ShadedPalette palette({{255, 0, 0}, {0, 255, 0}, {0, 0, 255}});
  EXPECT_LE(palette.colours().size(), 256U);
  const auto colour = [&](double share) { return palette.colours()[ShadedPalette::index(share, 0)]; };
  EXPECT_EQ(colour(0), (Rgb{255, 0, 0}));
  EXPECT_EQ(colour(-1), (Rgb{255, 0, 0}));
  EXPECT_EQ(colour(0.5), (Rgb{0, 255, 0}));
  EXPECT_EQ(colour(1), (Rgb{0, 0, 255}));
  EXPECT_EQ(colour(7), (Rgb{0, 0, 255}));
  EXPECT_LT(palette.colours()[ShadedPalette::index(1, 3)][2], 160);
}

HistoryTable history_of(const std::vector<double>& force_n) {
  HistoryTable history{{"time_s", "contact_force_n", "gap_min_m"}, {{}, force_n, {}}};
  for (std::size_t i = 0; i < force_n.size(); ++i) {
    history.columns[0].push_back(1e-7 * static_cast<double>(i));
    history.columns[2].push_back(0.0);
  }
  return history;
}

/// Smallest and largest x of what the pointer finds at a time [px].
std::pair<double, double> reach(const Chart& chart, double time) {
  double low = 1e9, high = -1e9;
  for (const auto& row : chart.rows) {
    if (row[2] != time) continue;
    low = std::min(low, row[0].get<double>());
    high = std::max(high, row[0].get<double>());
  }
  return {low, high};
}

TEST(ShapePicture, BodiesAreWhereTheyAreDisplacedTo) {
  const auto chart = shape_picture(two_squares({0.5, 0, 0}), history_of({0}), no_contact).value();
  EXPECT_EQ(chart.id, "deformed_bodies");
  EXPECT_EQ(chart.title, "Deformed bodies: von Mises stress at 2 times");
  EXPECT_THAT(chart.note, HasSubstr("Displacements are drawn to scale."));
  EXPECT_THAT(chart.columns, ElementsAre("x", "y", "time", "stress", "body"));
  const auto spec = Json::parse(chart.spec);
  const auto times = spec["layer"][2]["data"]["values"];
  EXPECT_EQ(times[0]["text"], "0 s, contact force 0 N");
  EXPECT_EQ(times[1]["text"], "1 µs, contact force 0 N");
  // The length at the foot says how many pixels a metre has.
  const auto lines = spec["layer"][5]["data"]["values"];
  const auto length = lines[2];
  EXPECT_EQ(spec["layer"][6]["data"]["values"][2]["text"], "200 mm");
  const double px_m = (length["x2"].get<double>() - length["x"].get<double>()) / 0.2;
  const auto first = reach(chart, 0.0), second = reach(chart, 1.0);
  const double panel_px = times[1]["x"].get<double>() - times[0]["x"].get<double>(), grid_px = 20;
  EXPECT_NEAR(first.second - first.first, 2 * px_m, grid_px);
  EXPECT_NEAR(second.first - first.first, panel_px + 0.5 * px_m, grid_px);
  EXPECT_NEAR(second.second - second.first, 2 * px_m, grid_px);
}

TEST(ShapePicture, ThePointerFindsStressesAndTheColoursReachToTheLargest) {
  const auto chart = shape_picture(two_squares(), history_of({0}), no_contact).value();
  ASSERT_GT(chart.rows.size(), 100U);
  for (const auto& row : chart.rows) {
    EXPECT_EQ(row[3], row[2] == 0.0 ? 0.0 : 1.0) << "MPa";
    EXPECT_EQ(row[4], "block");
  }
  const auto spec = Json::parse(chart.spec);
  const auto colour = spec["layer"][1]["encoding"]["color"];
  EXPECT_EQ(colour["legend"]["title"], "von Mises stress [MPa]");
  EXPECT_EQ(colour["scale"]["domain"].front(), 0.0);
  EXPECT_EQ(colour["scale"]["domain"].back(), 1.0);
  EXPECT_EQ(colour["scale"]["domain"].size(), colour["scale"]["range"].size());
  EXPECT_EQ(chart.spec.find("{{"), std::string::npos);
  EXPECT_EQ(spec["layer"].back()["name"], "pointer") << "which picture files leave out";
}

TEST(ShapePicture, OfBarsShowsTensionAndCompression) {
  auto shapes = one_piece("bar", {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 1, -1, -1}, {1, 2, -1, -1}}, {0.01, 0, 0});
  shapes.pieces[0].stress_pa[1] = {-3e6, 2e6};
  const auto chart = shape_picture(shapes, history_of({0}), no_contact).value();
  EXPECT_THAT(chart.title, HasSubstr("axial stress"));
  EXPECT_THAT(chart.note, AllOf(HasSubstr("Blue: compression; red with dots: tension"),
                                HasSubstr("Bars are drawn thicker than they are."),
                                HasSubstr("Displacements are drawn 20 times as large as they are.")));
  const auto domain = Json::parse(chart.spec)["layer"][1]["encoding"]["color"]["scale"]["domain"];
  EXPECT_EQ(domain.front(), -3.0);
  EXPECT_EQ(domain.back(), 3.0);
  shapes.bodies[0].strip_m = 0.5;
  EXPECT_THAT(shape_picture(shapes, history_of({0}), no_contact).value().note,
              HasSubstr("as thick as a square of their cross section is wide"));
}

TEST(ShapePicture, AFewLargeStressesDoNotTakeTheColours) {
  std::vector<Place> position;
  std::vector<std::array<int, 4>> cells;
  for (int i = 0; i < 1000; ++i) {
    for (const Place& corner : {Place{0, 0, 0}, Place{1, 0, 0}, Place{1, 1, 0}, Place{0, 1, 0}})
      position.push_back({corner[0] + i % 100, corner[1] + i / 100, 0});
    cells.push_back({4 * i, 4 * i + 1, 4 * i + 2, 4 * i + 3});
  }
  auto shapes = one_piece("plane_strain", position, cells);
  shapes.pieces[0].stress_pa[1][500] = 9e6;
  const auto chart = shape_picture(shapes, history_of({0}), no_contact).value();
  EXPECT_THAT(chart.note, HasSubstr("The largest stress, 9 MPa at 1 µs, lies beyond the colours."));
  EXPECT_EQ(Json::parse(chart.spec)["layer"][1]["encoding"]["color"]["scale"]["domain"].back(), 1.0);
}

TEST(ShapePicture, SaysWhatIsNotAsItIs) {
  auto shapes = two_squares({0.01, 0, 0});
  shapes.missing = {"The elements of 'foreign' are not drawn."};
  shapes.pieces[0].node[5] = -1;
  EXPECT_THAT(shape_picture(shapes, history_of({0}), no_contact)->note,
              AllOf(HasSubstr("The elements of 'foreign' are not drawn."), HasSubstr("one period of it is drawn"),
                    Not(HasSubstr("Both halves")), Not(HasSubstr("edges"))));
  shapes = two_squares({0.01, 0, 0});
  shapes.model = "axisymmetric";
  shapes.bodies[0].velocity_m_s = {0, 1, 0};
  EXPECT_THAT(shape_picture(shapes, history_of({0}), no_contact)->note,
              AllOf(HasSubstr("Both halves of the section are drawn, one computed, the other its mirror image."),
                    HasSubstr("Displacements beyond those of free flight are drawn 20 times as large")));
  EXPECT_THAT(shape_picture(shapes, history_of({0}), 0.0)->note,
              HasSubstr("Displacements from the first contact on are drawn 20 times as large"));
  shapes.nose = true;
  EXPECT_THAT(shape_picture(shapes, history_of({0}), 0.0)->note,
              AllOf(HasSubstr("The rounded nose is a gap of the contact"), HasSubstr("drawn to scale")));
  EXPECT_THAT(shape_picture(cube(), history_of({0}), no_contact)->note, HasSubstr("Of solids their surface is seen."));
}

TEST(ShapePicture, EdgesTooCloseToBeSeenAreLeftOut) {
  std::vector<Place> position;
  std::vector<std::array<int, 4>> cells;
  constexpr int columns = 300;
  for (int i = 0; i <= columns; ++i) {
    position.push_back({1.0 * i, 0, 0});
    position.push_back({1.0 * i, 100, 0});
    if (i > 0) cells.push_back({2 * i - 2, 2 * i, 2 * i + 1, 2 * i - 1});
  }
  EXPECT_THAT(shape_picture(one_piece("plane_strain", position, cells), history_of({0}), no_contact)->note,
              HasSubstr("Element edges would lie too close to be seen and are left out."));
}

TEST(ShapePicture, HasTheTimeOfTheLargestForceAmongAtMostSix) {
  auto shapes = two_squares();
  auto& piece = shapes.pieces[0];
  shapes.times_s.clear();
  for (int i = 0; i < 9; ++i) shapes.times_s.push_back(1e-6 * i);
  piece.displacement.resize(9, piece.displacement[0]);
  piece.stress_pa.resize(9, piece.stress_pa[0]);
  std::vector<double> force(81, 1.0);
  force[69] = 5.0;
  const auto chart = shape_picture(shapes, history_of(force), 0.0).value();
  std::set<double> times;
  for (const auto& row : chart.rows) times.insert(row[2].get<double>());
  EXPECT_EQ(times.size(), 6U);
  EXPECT_EQ(times.count(7.0), 1U);
}

TEST(ShapePicture, NothingToDrawOfNothing) {
  EXPECT_FALSE(shape_picture({}, history_of({0}), no_contact));
  auto shapes = two_squares();
  shapes.times_s.clear();
  EXPECT_FALSE(shape_picture(shapes, history_of({0}), no_contact)) << "no window that all have";
}

TEST(ShapePicture, ManyElementsMakeNoLargePage) {
  std::vector<Place> position;
  std::vector<std::array<int, 4>> cells;
  constexpr int n = 150;
  for (int i = 0; i <= n; ++i) {
    for (int k = 0; k <= n; ++k) position.push_back({1.0 * i, 1.0 * k, 0});
  }
  for (int i = 0; i < n; ++i) {
    for (int k = 0; k < n; ++k) {
      const int a = i * (n + 1) + k, b = a + n + 1;
      cells.push_back({a, b, b + 1, a + 1});
    }
  }
  auto shapes = one_piece("plane_strain", position, cells);
  for (std::size_t c = 0; c < cells.size(); ++c)
    shapes.pieces[0].stress_pa[1][c] = 1e6 * static_cast<double>(c * 7919 % 1000);
  EXPECT_LT(to_json(*shape_picture(shapes, history_of({0}), no_contact)).size(), 2'000'000U);
}

}  // namespace
}  // namespace ricochet::report

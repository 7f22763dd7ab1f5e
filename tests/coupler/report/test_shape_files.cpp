// The sources of the picture of the deformed bodies: files of participants, times, magnification.
#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "coupler/report/report.hpp"
#include "coupler/report/shapes/shape_files.hpp"
#include "coupler/report/shapes/shape_motion.hpp"
#include "coupler/report/shapes/shape_viewer.hpp"
#include "tests/coupler/report/sample_run.hpp"
#include "tests/coupler/report/sample_shapes.hpp"

namespace ricochet::report {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

constexpr double nan_s = std::numeric_limits<double>::quiet_NaN();

class ShapeFiles : public SampleRun {
 protected:
  void SetUp() override {
    SampleRun::SetUp();
    std::filesystem::create_directories(path("fields"));
  }
  void leave(const std::string& participant, const Json& file) const {
    write("fields/" + participant + ".shapes.json", file.dump());
  }
  [[nodiscard]] Shapes read_shapes_of(const std::vector<std::string>& participants) const {
    return read_shapes(folder_, summary_of(participants));
  }
  static Json summary_of(const std::vector<std::string>& participants) {
    Json summary = {{"processes", {{{"name", "coupler"}}}}};
    for (const auto& name : participants) summary["processes"].push_back({{"name", name}});
    return summary;
  }
};

TEST_F(ShapeFiles, OfAllParticipantsAreOneAtTheWindowsThatAllHave) {
  leave("a", square_file({0, 4, 8, 10}, {{"left", 0.0, {0, 1, 2, 3}}}));
  leave("b", square_file({0, 8, 10, 12}, {{"left", 1.0, {1, 4, 5, 2}}, {"right", 2.0, {0, 1, 2, 3}}}));
  const auto shapes = read_shapes_of({"a", "b"});
  EXPECT_EQ(shapes.model, "plane_strain");
  EXPECT_THAT(shapes.times_s, ElementsAre(0.0, 4.0, 5.0)) << "a window is half a second";
  ASSERT_EQ(shapes.bodies.size(), 2U);
  EXPECT_EQ(shapes.bodies[1].name, "right");
  ASSERT_EQ(shapes.pieces.size(), 3U);
  EXPECT_EQ(shapes.pieces[1].body, 0);
  EXPECT_EQ(shapes.pieces[2].body, 1);
  EXPECT_THAT(shapes.pieces[1].node, ElementsAre(1, 4, 5, 2));
  EXPECT_EQ(shapes.pieces[2].position[1], (Place{3.0, 0.0, 0.0}));
  EXPECT_EQ(shapes.pieces[0].displacement[1][2], (Place{0.1F * 8.0F, 0.0, 0.0})) << "a tenth of the window's number";
  EXPECT_THAT(shapes.pieces[0].stress_pa[2], ElementsAre(10.0));
  EXPECT_THAT(shapes.missing, IsEmpty());
}

TEST_F(ShapeFiles, WhatIsRigidStandsStill) {
  leave("a", square_file({0, 4}, {{"left", 0.0, {0, 1, 2, 3}}}));
  const auto plate = [](int last) {
    return Json{{"format", "ricochet obstacles 1"},
                {"obstacles",
                 {{{"name", "rigid plane"},
                   {"strip_m", 0.0},
                   {"place_m", {{-1, -2, 0}, {3, -2, 0}, {3, -1, 0}, {-1, -1, 0}}},
                   {"cell", {{0, 1, 2, last}}}}}}};
  };
  write("fields/obstacles.json", plate(3).dump());
  const auto shapes = read_shapes_of({"a"});
  ASSERT_EQ(shapes.pieces.size(), 2U);
  EXPECT_TRUE(shapes.pieces[1].rigid);
  EXPECT_EQ(shapes.bodies[1].name, "rigid plane");
  EXPECT_EQ(shapes.pieces[1].position[2], (Place{3.0, -1.0, 0.0}));
  const auto viewer = shape_viewer(shapes, HistoryTable{}, nan_s);
  const auto& drawn = viewer->data.at("pieces")[1];
  EXPECT_EQ(drawn.at("place")[0], drawn.at("place")[1]);
  EXPECT_FALSE(drawn.contains("stress"));
  EXPECT_THAT(viewer->html, HasSubstr("Grey bodies are rigid and go on beyond what is drawn of them."));
  write("fields/obstacles.json", plate(4).dump());
  EXPECT_THAT(config_error([this] { static_cast<void>(read_shapes_of({"a"})); }),
              HasSubstr("obstacles.json: found the node 4"));
  auto other = plate(3);
  other["format"] = "ricochet obstacles 2";
  write("fields/obstacles.json", other.dump());
  EXPECT_THAT(config_error([this] { static_cast<void>(read_shapes_of({"a"})); }),
              HasSubstr("obstacles.json: found another format"));
}

TEST_F(ShapeFiles, AWindowWithANumberThatIsNotFiniteIsLeftOut) {
  auto file = square_file({0, 4, 8}, {{"left", 0.0, {0, 1, 2, 3}}});
  file["bodies"][0]["stress_pa"][1] = packed_floats({std::numeric_limits<float>::infinity()});
  leave("a", file);
  EXPECT_THAT(read_shapes_of({"a"}).times_s, ElementsAre(0.0, 4.0));
  file["bodies"][0]["displacement_m"][2] = packed_floats(std::vector<float>(8, std::nanf("")));
  leave("a", file);
  EXPECT_THAT(read_shapes_of({"a"}).times_s, ElementsAre(0.0));
}

TEST_F(ShapeFiles, WhoLeftNoneIsNamed) {
  leave("a", square_file({0}, {{"left", 0.0, {0, 1, 2, 3}}}));
  auto many = square_file({0}, {});
  many["too_many_cells"] = 123456;
  leave("many", many);
  const auto shapes = read_shapes_of({"a", "foreign", "many"});
  EXPECT_EQ(shapes.pieces.size(), 1U);
  EXPECT_THAT(shapes.missing,
              ElementsAre("The elements of 'foreign' are not drawn: it left no fields/foreign.shapes.json.",
                          "The elements of 'many' are not drawn: they are too many, 123456."));
  EXPECT_EQ(read_shapes_of({}).pieces.size(), 1U) << "of a killed coupler's run, whose summary names nobody";
  std::filesystem::remove_all(path("fields"));
  EXPECT_THAT(read_shapes_of({"a"}).pieces, IsEmpty());
}

TEST_F(ShapeFiles, ABodyWithoutElementsIsNotDrawn) {
  auto file = square_file({0}, {{"left", 0.0, {0, 1, 2, 3}}, {"nodes_only", 0.0, {0, 1, 2, 3}}});
  auto& body = file["bodies"][1];
  for (const char* key : {"node", "position_m", "cell"}) body[key] = "";
  body["displacement_m"][0] = body["stress_pa"][0] = "";
  leave("a", file);
  EXPECT_EQ(read_shapes_of({"a"}).bodies.size(), 1U);
}

TEST_F(ShapeFiles, WrongOnesAreNamed) {
  const auto good = square_file({0, 1}, {{"left", 0.0, {0, 1, 2, 3}}});
  const auto refused = [this, &good](const char* key, const Json& value) {
    auto file = good;
    if (file.contains(key)) {
      file[key] = value;
    } else {
      file["bodies"][0][key] = value;
    }
    leave("a", file);
    return config_error([this] { (void)read_shapes_of({"a"}); });
  };
  EXPECT_THAT(refused("format", "ricochet shapes 3"),
              AllOf(HasSubstr("fields/a.shapes.json: found another format"), HasSubstr("delete it")));
  EXPECT_THAT(refused("model", "shell"), HasSubstr("found the model \"shell\""));
  EXPECT_THAT(refused("position_m", packed_floats({1, 2})), HasSubstr("\"position_m\" holds 2 numbers, expected 8"));
  EXPECT_THAT(refused("node", "AAA="), HasSubstr("\"node\" holds 0 numbers, expected any number of them"));
  EXPECT_THAT(refused("node", "?"), HasSubstr("\"node\" holds no numbers"));
  EXPECT_THAT(refused("cell", packed_ints({0, 1, 2, 4})), HasSubstr("found the node 4"));
  EXPECT_THAT(refused("cell", packed_ints({0, 1, -1, 3})), HasSubstr("found the node -1"));
  EXPECT_THAT(refused("cell", packed_ints({0, 1, 2})), HasSubstr("3 numbers, not four for each cell"));
  EXPECT_THAT(refused("stress_pa", Json::array()), HasSubstr("fields of another number of windows"));
  EXPECT_THAT(refused("stress_pa", Json({"", ""})), HasSubstr("\"stress_pa\" holds 0 numbers, expected 1"));
  EXPECT_THAT(refused("plastic_strain", Json::array()), HasSubstr("fields of another number of windows"));
  EXPECT_THAT(refused("plastic_strain", Json({"", ""})), HasSubstr("\"plastic_strain\" holds 0 numbers, expected 1"));
  EXPECT_THAT(refused("temperature_rise_k", Json({"", ""})),
              HasSubstr("\"temperature_rise_k\" holds 0 numbers, expected 1"));
  EXPECT_THAT(refused("contact_pressure_pa", Json({"", ""})),
              HasSubstr("\"contact_pressure_pa\" holds 0 numbers, expected 1"));
}

TEST_F(ShapeFiles, OfAnotherRunAreNamed) {
  leave("a", square_file({0, 1}, {{"left", 0.0, {0, 1, 2, 3}}}));
  auto other = square_file({0, 1}, {{"left", 0.0, {0, 1, 2, 3}}});
  other["largest_window_s"] = 0.25;
  leave("b", other);
  EXPECT_THAT(config_error([this] {
                (void)read_shapes_of({"a", "b"});
              }),
              AllOf(HasSubstr("b.shapes.json: it is of another run than "), HasSubstr("a.shapes.json")));
}

TEST_F(ShapeFiles, APageHasThePictureFirstOrSaysWhoIsMissing) {
  auto summary = summary_of({"a"});
  summary["status"] = "done";
  write("summary.json", summary.dump());
  leave("a", square_file({0, 1}, {{"left", 0.0, {0, 1, 2, 3}}}));
  write_report(folder_);
  EXPECT_THAT(read("report.html"), HasSubstr("<figure>\n<figcaption><h2>Deformed bodies: von Mises stress at 2 times"));
  EXPECT_LT(read("report.html").find("Deformed bodies"), read("report.html").find("id=\"contact_stress\""));
  std::filesystem::remove(path("fields/a.shapes.json"));
  write_report(folder_);
  EXPECT_THAT(read("report.html"),
              AllOf(Not(HasSubstr("Deformed bodies")),
                    HasSubstr("<p>The elements of &#39;a&#39; are not drawn: it left no fields/")));
  write("fields/a.shapes.json", "{}");
  EXPECT_THAT(config_error([this] { write_report(folder_); }), HasSubstr("fields/*.shapes.json"));
}

/// Two bodies of 1 m, `gap` apart, the left one coming at 1 m/s; then both are pressed together by `press`.
Shapes pressed_bodies(double gap, double contact_s, double press) {
  Shapes shapes;
  shapes.model = "bar";
  shapes.largest_window_s = 0.001;
  shapes.times_s = {0.0, contact_s + 0.1};
  shapes.bodies = {{"left", 0.1, {1, 0, 0}}, {"right", 0.1, {0, 0, 0}}};
  const double left = 1.0 * contact_s;
  shapes.pieces = {{0, {0, 1}, {{-1, 0, 0}, {0, 0, 0}}, {{0, 1, -1, -1}}, {}, {{0}, {0}}},
                   {1, {0, 1}, {{gap, 0, 0}, {gap + 1, 0, 0}}, {{0, 1, -1, -1}}, {}, {{0}, {0}}}};
  shapes.pieces[0].displacement = {{{}, {}}, {{left + press, 0, 0}, {left + 0.5 * press, 0, 0}}};
  shapes.pieces[1].displacement = {{{}, {}}, {{0.5 * press, 0, 0}, {0, 0, 0}}};
  return shapes;
}

TEST(Magnification, IsOneTwoOrFiveTimesAPowerOfTenUpToAShareOfTheExtent) {
  for (const auto& [press, factor] : {std::pair{0.005, 50.0}, {0.011, 20.0}, {0.03, 10.0}, {0.2, 1.0}, {3.0, 1.0}}) {
    const auto m = magnification_of(pressed_bodies(0.0, 0.0, press), {0, 1}, 0.0, 0.0);
    EXPECT_DOUBLE_EQ(m.factor, factor) << press;
  }
  EXPECT_EQ(magnification_of(pressed_bodies(0.0, 0.0, 0.0), {0, 1}, 0.0, 0.0).factor, 1.0) << "nothing moves";
}

TEST(Magnification, LeavesTheFlightToScaleAndBodiesThatTouchTouching) {
  const auto shapes = pressed_bodies(0.25, 0.25, 0.01);
  const auto m = magnification_of(shapes, {0, 1}, 0.2505, 0.25);  // the window in which contact begins
  EXPECT_EQ(m.factor, 20.0);
  EXPECT_DOUBLE_EQ(m.flight_s, 0.25);
  const auto &left = shapes.pieces[0], &right = shapes.pieces[1];
  const auto at = [&](const ShapePiece& piece, std::size_t node) {
    const auto& v = shapes.bodies[static_cast<std::size_t>(piece.body)].velocity_m_s;
    return m.place(piece.position[node], piece.displacement[1][node], v, shapes.times_s[1])[0];
  };
  EXPECT_NEAR(at(left, 1), at(right, 0), 1e-12);
  EXPECT_NEAR(at(left, 0), -1 + 0.25 + 20 * 0.01, 1e-12);
  EXPECT_NEAR(at(right, 1), 1.25, 1e-12);
  EXPECT_NEAR(m.place({-1, 0, 0}, {0.125, 0, 0}, {1, 0, 0}, 0.125)[0], -0.875, 1e-12) << "on its way";
}

TEST(Magnification, IsNoneWhereBodiesWouldNotTouch) {
  EXPECT_EQ(magnification_of(pressed_bodies(0.25, 0.25, 0.01), {0, 1}, 0.4, 0.25).factor, 1.0) << "closed by another";
  auto shapes = pressed_bodies(0.0, 0.0, 0.01);
  EXPECT_GT(magnification_of(shapes, {0, 1}, 0.0, 0.0).factor, 1.0);
  shapes.nose = true;
  EXPECT_EQ(magnification_of(shapes, {0, 1}, 0.0, 0.0).factor, 1.0);
  shapes.nose = false;
  shapes.uneven = true;
  EXPECT_EQ(magnification_of(shapes, {0, 1}, 0.0, 0.0).factor, 1.0) << "curved, or sliding";
}

TEST(Magnification, WithoutContactIsOfWhatGoesBeyondTheFlight) {
  auto shapes = pressed_bodies(0.25, 0.25, 0.01);
  shapes.times_s[1] = 0.25;
  const auto m = magnification_of(shapes, {0, 1}, nan_s, 0.25);
  EXPECT_TRUE(std::isinf(m.flight_s));
  EXPECT_EQ(m.factor, 20.0);
  EXPECT_NEAR(m.place({0, 0, 0}, {0.26, 0, 0}, {1, 0, 0}, 0.25)[0], 0.25 + 20 * 0.01, 1e-12);
}

}  // namespace
}  // namespace ricochet::report

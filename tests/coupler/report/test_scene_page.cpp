// A scene drawn before it runs: whose elements are whose, and which nodes are marked.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <regex>
#include <set>

#include "common/base/base64.hpp"
#include "common/problem/drawn_obstacles.hpp"
#include "coupler/report/parts/chart.hpp"
#include "coupler/report/scene_page/scene_page.hpp"
#include "tests/coupler/report/sample_run.hpp"
#include "tests/support/scene_file.hpp"

namespace ricochet::report {
namespace {

using scene::drawn_obstacles;
using scene::DrawnObstacle;
using testing::ElementsAre;
using testing::HasSubstr;

/// Two blocks of four elements each, 1 m high, the lower supported; the upper comes down and is pressed at its end.
const char* const blocks = R"(model = "plane_strain"
[[body]]
name = "lower"
material = { youngs_modulus_pa = 1e9, poisson_ratio = 0.3, density_kg_m3 = 1e3 }
mesh = { start_m = -4.0, length_m = 4.0, height_m = 1.0, elements = [1, 4] }
support = [{ surface = "start", fixed = ["y"] }]
[[body]]
name = "upper"
material = { youngs_modulus_pa = 1e9, poisson_ratio = 0.3, density_kg_m3 = 1e3 }
mesh = { length_m = 4.0, height_m = 1.0, elements = [1, 4] }
initial_velocity_m_s = [0.0, -1.0]
traction = [{ surface = "end", pressure_pa = 1e3 }]
[contact]
surfaces = ["lower.end", "upper.start"]
initial_gap_m = 0.25
[partition]
implicit_length_m = { lower = 1.0, upper = 2.0 }
[time]
end_s = 1e-2
[[output.probe]]
name = "tip"
body = "upper"
at_m = [0.5, 3.5]
)";

scene::Problem problem_of(const std::string& text) {
  const test::TemporaryFolder folder;
  return scene::build_problem(scene::load_scene(folder.write(text)));
}

Json data_on(const std::string& page) {
  std::smatch found;
  if (!std::regex_search(page, found, std::regex(R"(id="bodies">([^<]*)</script>)")))
    throw std::runtime_error("no data");
  return Json::parse(found[1].str());
}

template <class Number>
std::vector<Number> numbers(const Json& packed) {
  const auto bytes = from_base64(packed.get<std::string>());
  std::vector<Number> values(bytes.value().size() / sizeof(Number));
  std::memcpy(values.data(), bytes->data(), bytes->size());
  return values;
}

/// Heights of the nodes with dots, by the name of the mark.
std::map<std::string, std::set<float>> marked_heights(const Json& data) {
  std::map<std::string, std::set<float>> heights;
  for (const auto& mark : data.at("marks")) {
    const auto places = numbers<float>(mark.at("place"));
    for (std::size_t i = 1; i < places.size(); i += 2) heights[mark.at("name")].insert(places[i]);
  }
  return heights;
}

TEST(ScenePage, ColoursElementsByWhoIntegratesThem) {
  const auto data = data_on(scene_page(problem_of(blocks), "said"));
  std::map<std::string, std::vector<std::string>> kinds;  // of the elements of a body, upwards
  for (const auto& piece : data.at("pieces")) {
    const auto cells = numbers<int>(piece.at("cell"));
    const auto places = numbers<float>(piece.at("place").at(0));
    const auto kind = numbers<std::uint8_t>(piece.at("kind"));
    ASSERT_EQ(cells.size(), 4 * kind.size());
    std::map<float, std::string> by_height;
    for (std::size_t c = 0; c < kind.size(); ++c)
      by_height[places[2 * static_cast<std::size_t>(cells[4 * c]) + 1]] =
          data.at("kinds").at(std::size_t{kind[c]}).at("name");
    for (const auto& [height, name] : by_height)
      kinds[data.at("bodies").at(piece.at("body").get<std::size_t>()).at("name")].push_back(name);
  }
  const std::string implicit = "implicit: integrated implicitly", other = "explicit: integrated explicitly";
  EXPECT_THAT(kinds["lower"], ElementsAre(other, other, other, implicit));
  EXPECT_THAT(kinds["upper"], ElementsAre(implicit, implicit, other, other));
}

TEST(ScenePage, MarksWhatHoldsOnNodes) {
  const auto heights = marked_heights(data_on(scene_page(problem_of(blocks), "")));
  const std::map<std::string, std::set<float>> expected{{"contact", {0.0F}},
                                                        {"supports", {-4.0F}},
                                                        {"loads on surfaces", {4.0F}},
                                                        {"interface of explicit and implicit elements", {-1.0F, 2.0F}},
                                                        {"probes", {3.5F}}};
  EXPECT_EQ(heights, expected);
}

/// The nodes that carry a rigid body lie inside it.
TEST(ScenePage, MarksTheContactOfARigidBodyOnItsSurface) {
  const auto rigid = test::replaced(test::replaced(blocks, "name = \"upper\"\n", "name = \"upper\"\nrigid = true\n"),
                                    "lower = 1.0, upper = 2.0", "lower = 1.0");
  auto heights = marked_heights(data_on(scene_page(problem_of(rigid), "")));
  EXPECT_THAT(heights["contact"], ElementsAre(0.0F));
  EXPECT_THAT(heights["interface of explicit and implicit elements"], ElementsAre(-1.0F));
}

TEST(ScenePage, SaysWhatTheSceneIsAndWhatIsNotDrawn) {
  const auto page = scene_page(problem_of(blocks), "2 < 3 windows\n");
  EXPECT_THAT(page, HasSubstr("2 &lt; 3 windows"));
  EXPECT_THAT(page, HasSubstr("In the contact initial_gap_m adds 0.25 m, which is not drawn."));
}

std::string on_obstacle(const std::string& obstacle) {
  const auto text = test::replaced(blocks, "[\"lower.end\", \"upper.start\"]", "[\"upper.start\", " + obstacle);
  return test::replaced(text, "lower = 1.0, ", "");
}

/// The largest of one coordinate.
double farthest_m(const DrawnObstacle& drawn, std::size_t coordinate) {
  double most_m = -std::numeric_limits<double>::infinity();
  for (const auto& x : drawn.place) most_m = std::max(most_m, x[coordinate]);
  return most_m;
}

/// A plate below the upper block, as far from it as the initial gap.
TEST(ScenePage, DrawsARigidPlaneWhereTheGapHasIt) {
  const auto problem = problem_of(on_obstacle("\"rigid_plane\"]"));
  const auto drawn = drawn_obstacles(problem);
  ASSERT_EQ(drawn.size(), 1U);
  EXPECT_EQ(drawn[0].name, "rigid plane");
  EXPECT_EQ(drawn[0].cells.size(), 1U);
  double left_m = 0.0;
  for (const auto& x : drawn[0].place) left_m = std::min(left_m, x[0]);
  EXPECT_NEAR(farthest_m(drawn[0], 1), -0.25, 1e-12);
  EXPECT_NEAR(left_m, -0.1, 1e-12);
  EXPECT_NEAR(farthest_m(drawn[0], 0), 1.1, 1e-12);
  const auto page = scene_page(problem, "");
  EXPECT_THAT(page, HasSubstr("The rigid obstacle of the contact goes on beyond what is drawn of it."));
  const auto data = data_on(page);
  EXPECT_EQ(data.at("bodies").back().at("name"), "rigid plane");
  const auto kind = numbers<std::uint8_t>(data.at("pieces").back().at("kind")).at(0);
  EXPECT_EQ(data.at("kinds").at(kind).at("name"), "rigid obstacles");
}

TEST(ScenePage, DrawsACylinderOnItsRadiusAboutItsMiddle) {
  const auto text = on_obstacle("\"rigid_cylinder\"]\nrigid_radius_m = 2.0\nrigid_place_m = [1.0, -5.0]");
  const auto drawn =
      drawn_obstacles(problem_of(test::replaced(text, "traction = [{ surface = \"end\", pressure_pa = 1e3 }]\n", "")));
  ASSERT_EQ(drawn.size(), 1U);
  EXPECT_EQ(drawn[0].name, "rigid cylinder");
  for (std::size_t i = 0; i <= drawn[0].place.size() / 2 - 1; ++i) {
    const auto& x = drawn[0].place[i];
    EXPECT_NEAR(std::hypot(x[0] - 1.0, x[1] + 2.25), 2.0, 1e-12) << "lifted to the block, then lowered by the gap";
  }
  EXPECT_NEAR(farthest_m(drawn[0], 1), -0.25, 1e-12);
}

/// The point nearest to the block is the pole; all places of the sphere lie on it.
TEST(ScenePage, DrawsTheCapOfASphereAndTheShellOfACylinderUnderASolid) {
  const std::string text = R"(model = "solid"
[[body]]
name = "block"
material = { youngs_modulus_pa = 1e9, poisson_ratio = 0.3, density_kg_m3 = 1e3 }
mesh = { length_m = 1.0, height_m = 2.0, width_m = 2.0, elements = [2, 2, 1] }
initial_velocity_m_s = [0.0, 0.0, -1.0]
[contact]
surfaces = ["block.start", "rigid_sphere"]
rigid_radius_m = 3.0
rigid_place_m = [1.0, 1.0, -7.0]
initial_gap_m = 0.5
[coupling]
protocol = "all_explicit"
[time]
end_s = 1e-2
)";
  const auto sphere = drawn_obstacles(problem_of(text)).at(0);
  for (const auto& x : sphere.place) EXPECT_NEAR(std::hypot(x[0] - 1.0, x[1] - 1.0, x[2] + 3.5), 3.0, 1e-12);
  EXPECT_NEAR(farthest_m(sphere, 2), -0.5, 1e-12);
  const auto divided =
      test::replaced(text, "elements = [2, 2, 1] }",
                     "elements = [2, 2, 1], refine = [{ from_m = [0, 0, 0], to_m = [1, 1, 1], ratio = 2 }] }");
  EXPECT_NEAR(farthest_m(drawn_obstacles(problem_of(divided)).at(0), 2), -0.5, 1e-12) << "hanging nodes touch it, too";
  const auto lying = test::replaced(text, "rigid_sphere\"]\n", "rigid_cylinder\"]\nrigid_axis = \"x\"\n");
  const auto cylinder = drawn_obstacles(problem_of(lying)).at(0);
  for (const auto& x : cylinder.place) EXPECT_NEAR(std::hypot(x[1] - 1.0, x[2] + 3.5), 3.0, 1e-12);
  EXPECT_NEAR(cylinder.place.front()[0] + cylinder.place.back()[0], 2.0, 1e-12) << "as far on both sides";
}

TEST(ScenePage, DrawsTheStopOfABarAndThePlateUnderADisc) {
  const std::string text = R"(model = "bar"
[[body]]
name = "rod"
material = { youngs_modulus_pa = 1e9, density_kg_m3 = 1e3 }
area_m2 = 0.04
mesh = { start_m = 1.0, length_m = 1.0, elements = 4 }
[contact]
surfaces = ["rod.start", "rigid_plane"]
[coupling]
protocol = "all_explicit"
[time]
end_s = 1e-2
)";
  const auto stop = drawn_obstacles(problem_of(text)).at(0);
  ASSERT_EQ(stop.place.size(), 2U);
  EXPECT_EQ(stop.place[0][0], 1.0);
  EXPECT_LT(stop.place[1][0], 1.0);
  EXPECT_NEAR(stop.strip_m, 0.6, 1e-12);
  auto disc = test::replaced(text, "\"bar\"", "\"axisymmetric\"");
  disc = test::replaced(disc, "area_m2 = 0.04\n", "");
  disc = test::replaced(disc, "length_m = 1.0, elements = 4", "length_m = 1.0, radius_m = 2.0, elements = [2, 4]");
  disc = test::replaced(disc, "youngs_modulus_pa = 1e9,", "youngs_modulus_pa = 1e9, poisson_ratio = 0.3,");
  std::set<double> radii;
  const auto plate = drawn_obstacles(problem_of(disc)).at(0);
  for (const auto& x : plate.place) radii.insert(x[0]);
  EXPECT_THAT(radii, ElementsAre(0.0, testing::DoubleNear(2.4, 1e-12)));
}

TEST(ScenePage, RefusesMoreElementsThanABrowserDraws) {
  const std::string many = R"(model = "bar"
[[body]]
name = "long"
material = { youngs_modulus_pa = 1e9, density_kg_m3 = 1e3 }
area_m2 = 1e-4
mesh = { length_m = 1.0, elements = 100001 }
[coupling]
protocol = "all_explicit"
[time]
end_s = 1e-3
)";
  const auto error = config_error([&] { static_cast<void>(scene_page(problem_of(many), "")); });
  EXPECT_THAT(error, HasSubstr("--picture: found 100001 elements (of solids: faces of the surface) in "));
  EXPECT_THAT(error, HasSubstr("allowed: 100000"));
}

}  // namespace
}  // namespace ricochet::report

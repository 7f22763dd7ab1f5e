#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <map>
#include <sstream>

#include "common/base/error.hpp"
#include "tests/bench/calculix_deck.hpp"
#include "tests/bench/line_picture.hpp"
#include "tests/support/scene_file.hpp"

// The deck that CalculiX is given is our scene: volume, faces, ties; and what it answers is read right.

namespace ricochet::bench {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

const std::string two_cylinders = R"(
model = "axisymmetric"
[[body]]
name = "steel"
material = { youngs_modulus_pa = 200e9, poisson_ratio = 0.3, density_kg_m3 = 8000.0 }
mesh = { start_m = -0.004, length_m = 0.004, radius_m = 0.002, elements = [2, 2] }
initial_velocity_m_s = [0.0, 30.0]
[[body]]
name = "stone"
material = { youngs_modulus_pa = 50e9, poisson_ratio = 0.2, density_kg_m3 = 3000.0 }
mesh = { length_m = 0.004, radius_m = 0.002, elements = [2, 2] }
[contact]
surfaces = ["steel.end", "stone.start"]
friction_coefficient = 0.1
[partition]
implicit_length_m = { steel = 0.002, stone = 0.002 }
[time]
step_s = 1e-8
end_s = 1e-6
)";

std::string deck_of(const std::string& text, long steps = 10) {
  const test::TemporaryFolder folder;
  return calculix_deck(scene::build_problem(scene::load_scene(folder.write(text))), steps);
}

/// Lines under every keyword line that begins with `keyword`, cells split at commas.
std::vector<std::vector<double>> cards(const std::string& deck, const std::string& keyword) {
  std::vector<std::vector<double>> result;
  std::istringstream lines(deck);
  bool inside = false;
  for (std::string line; std::getline(lines, line);) {
    if (line[0] == '*') {
      inside = line.rfind(keyword, 0) == 0;
      continue;
    }
    if (!inside) continue;
    auto& row = result.emplace_back();
    std::istringstream cells(line);
    for (std::string cell; std::getline(cells, cell, ',');) row.push_back(std::atof(cell.c_str()));
  }
  return result;
}

using Point = std::array<double, 3>;

double tetrahedron(const Point& a, const Point& b, const Point& c, const Point& d) {
  const auto minus = [](const Point& p, const Point& q) { return Point{p[0] - q[0], p[1] - q[1], p[2] - q[2]}; };
  const Point u = minus(b, a), v = minus(c, a), w = minus(d, a);
  return (u[0] * (v[1] * w[2] - v[2] * w[1]) - u[1] * (v[0] * w[2] - v[2] * w[0]) +
          u[2] * (v[0] * w[1] - v[1] * w[0])) /
         6.0;
}

TEST(CalculixDeck, ElementsFillTheWedgeAndNoneIsInsideOut) {
  const std::string deck = deck_of(two_cylinders);
  std::map<int, Point> nodes;
  for (const auto& n : cards(deck, "*NODE")) nodes[static_cast<int>(n.at(0))] = {n.at(1), n.at(2), n.at(3)};
  double volume = 0.0;
  const auto add = [&](const std::vector<double>& element, const std::array<std::size_t, 4>& corners) {
    const auto at = [&](std::size_t k) { return nodes.at(static_cast<int>(element.at(1 + k))); };
    const double part = tetrahedron(at(corners[0]), at(corners[1]), at(corners[2]), at(corners[3]));
    EXPECT_GT(part, 0.0) << "element " << element[0];
    volume += part;
  };
  for (const auto& e : cards(deck, "*ELEMENT, TYPE=C3D6")) {
    for (const auto& t : {std::array<std::size_t, 4>{0, 1, 2, 3}, {1, 2, 3, 4}, {2, 3, 4, 5}}) add(e, t);
  }
  for (const auto& e : cards(deck, "*ELEMENT, TYPE=C3D8")) {
    for (const auto& t :
         {std::array<std::size_t, 4>{0, 1, 2, 5}, {0, 2, 3, 7}, {0, 5, 7, 4}, {2, 7, 5, 6}, {0, 2, 7, 5}})
      add(e, t);
  }
  const double chord = 0.5 * std::sin(M_PI / 90.0);  // area of the flat sector over r^2
  EXPECT_NEAR(volume, chord * 0.002 * 0.002 * 0.008, 1e-6 * volume);
}

TEST(CalculixDeck, HoldsTheContactTheStepAndTheVelocity) {
  const std::string deck = deck_of(two_cylinders);
  EXPECT_THAT(deck, HasSubstr("*SURFACE, NAME=FIRST\n3, S2\n4, S5\n*SURFACE, NAME=SECOND\n5, S1\n6, S3\n"));
  EXPECT_THAT(deck, HasSubstr("PRESSURE-OVERCLOSURE=LINEAR\n5.000000000000e+13\n")) << "50 GPa / 1 mm";
  EXPECT_THAT(deck, HasSubstr("*FRICTION\n1.000000000000e-01,"));
  EXPECT_THAT(deck, HasSubstr("*DYNAMIC, DIRECT, ALPHA=0.\n1.000000000000e-08, 1.000000000000e-07\n"));
  const auto velocities = cards(deck, "*INITIAL CONDITIONS");
  EXPECT_EQ(velocities.size(), 3U * 5U) << "steel: a column of nodes on the axis, two off it, in front and at the back";
  for (const auto& v : velocities) EXPECT_THAT(v, ElementsAre(testing::Lt(20.0), 2.0, 30.0));
}

TEST(CalculixDeck, RefusesScenesThatItDoesNotWrite) {
  const auto complaint = [](const std::string& from, const std::string& to) {
    try {
      static_cast<void>(deck_of(test::replaced(two_cylinders, from, to)));
    } catch (const ConfigError& error) {
      return std::string(error.what());
    }
    return std::string("none");
  };
  EXPECT_THAT(complaint("friction_coefficient = 0.1", "initial_gap_m = 1e-6"), HasSubstr("contact without a gap only"));
  EXPECT_THAT(complaint("initial_velocity_m_s = [0.0, 30.0]", "gravity_m_s2 = [0.0, 9.81]"),
              HasSubstr("bodies without loads only"));
}

TEST(CalculixPressure, IsForceOverAreaAtEveryStep) {
  const std::string block =
      "\n statistics for slave set FIRST, master set SECOND and time  0.{}400000E-07\n\n"
      "   area,  normal force (+ = tension) and shear force (size)\n\n    2.0E-07 {} 2.0E-01\n";
  const auto step = [&block](const std::string& digit, const std::string& force) {
    return test::replaced(test::replaced(block, "{}", digit), "{}", force);
  };
  const auto history = calculix_pressure(step("5", "-1.0E+02") + step("6", "-3.0E+02"));
  EXPECT_THAT(history.time_s, ElementsAre(0.54e-7, 0.64e-7));
  EXPECT_THAT(history.pressure_pa, ElementsAre(testing::DoubleEq(5e8), testing::DoubleEq(1.5e9)));
  EXPECT_THROW(static_cast<void>(calculix_pressure(step("5", "nothing"))), ParticipantError);
}

TEST(LinePicture, HoldsLabelsTicksAndWhatItCutsOff) {
  const auto svg = line_picture(
      "a title", "time [s]", "force [N]",
      {{"ours", "#0072b2", "", {1.0, 2.0}, {3.0, 12.0}}, {"theirs", "#000000", "2 3", {1.0, 2.0}, {3.0, 4.0}}}, 10.0);
  for (const char* part : {">a title<", ">time [s]<", ">force [N]<", ">ours<", ">theirs<", ">1.5<", ">10<",
                           "stroke-dasharray=\"2 3\"", "above the picture: ours: 12 at 2"}) {
    EXPECT_THAT(svg, HasSubstr(part));
  }
}

}  // namespace
}  // namespace ricochet::bench

// Ways out of the model: said with place, time and size, and the run stopped where results would be wrong.
#include <gmock/gmock.h>

#include "tests/support/plane_grid.hpp"
#include "tests/support/run.hpp"

namespace ricochet::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

std::string body(const std::string& name, const std::string& mesh, const std::string& velocity,
                 const std::string& more = "") {
  return "[[body]]\nname = \"" + name +
         "\"\nmaterial = { youngs_modulus_pa = 1e9, poisson_ratio = 0.25, density_kg_m3 = 1000.0 }\n" + "mesh = { " +
         mesh + " }\ninitial_velocity_m_s = " + velocity + "\n" + more;
}

/// "[x, more]", and without more "[x]".
std::string list(double x, const std::string& more = "") {
  std::ostringstream text;
  text << '[' << std::to_string(x) << more << ']';
  return text.str();
}

std::string settings(double step_s, double end_s, const std::string& protocol) {
  return "[time]\nstep_s = " + std::to_string(step_s * 1e6) + "e-6\nend_s = " + std::to_string(end_s * 1e6) +
         "e-6\n[coupling]\nprotocol = \"" + protocol + "\"\n";
}

const nlohmann::json* find(const RunResult& run, const std::string& kind) {
  for (const auto& entry : run.summary.at("outside_model"))
    if (entry.at("kind") == kind) return &entry;
  return nullptr;
}

/// Exit code, status, what is said where, and that the history ends where it is valid.
void expect_left(const RunResult& run, const std::string& kind, const std::string& text) {
  EXPECT_EQ(run.outcome.code, 6) << run.outcome.error;
  EXPECT_EQ(run.summary.at("status"), "left_model");
  EXPECT_EQ(run.summary.at("exit_code"), 6);
  EXPECT_THAT(run.outcome.error, HasSubstr("warning: "));
  EXPECT_THAT(run.outcome.error, HasSubstr("left the model: "));
  EXPECT_THAT(run.outcome.error, HasSubstr("is valid"));
  EXPECT_THAT(run.outcome.error, HasSubstr(text));
  ASSERT_TRUE(find(run, kind)) << run.summary.at("outside_model");
  EXPECT_TRUE(find(run, kind)->at("results_wrong").get<bool>());
  EXPECT_GE(find(run, kind)->at("first_s").get<double>(), run.summary.at("valid_until_s").get<double>());
  EXPECT_LE(run.last("time_s"),
            std::max(run.summary.at("valid_until_s").get<double>(), run.column("time_s").front()) + 2e-4);
  EXPECT_THAT(file_text(run.folder + "/report.html"), HasSubstr("outside the model"));
}

Outcome check(const std::string& text, const TemporaryFolder& folder) {
  return run_command({ricochet_binary(), "check", folder.write(text, "check.toml")}, folder.path().string());
}

/// A block that flies 100 mm to the side of its 50 mm partner before it comes down. The law "massless" keeps the pairs
/// of nodes that it starts with.
std::string sideways(const std::string& protocol, double velocity_m_s, const std::string& law = "massless") {
  const std::string mesh = "height_m = 0.05, elements = [5, 4], length_m = 0.04";
  return "model = \"plane_strain\"\n" + body("lower", "start_m = -0.04, " + mesh, "[0.0, 0.0]") +
         body("upper", mesh, list(velocity_m_s, ", -1.0")) +
         "[contact]\nsurfaces = [\"lower.end\", \"upper.start\"]\ninitial_gap_m = 1e-3\nmultiplier_update = \"" + law +
         "\"\n"
         "[partition]\nimplicit_length_m = { lower = 0.011, upper = 0.011 }\n" +
         settings(5e-6, 1.3e-3, protocol);
}

class OffPartner : public testing::TestWithParam<std::string> {};

TEST_P(OffPartner, IsNoContact) {
  const TemporaryFolder folder;
  const auto run = run_file(folder.write(sideways(GetParam(), 100.0)), folder);
  expect_left(run, "off_partner", "past the end of its partner's surface");
  EXPECT_NEAR(find(run, "off_partner")->at("first_s").get<double>(), 1e-3, 1.5e-5)
      << "in the first window of the contact, or the next";
  EXPECT_NEAR(run.summary.at("valid_until_s").get<double>(), 1e-3, 1e-4);
  EXPECT_LE(run.last("time_s"), 1e-3 + 2e-4);
}

/// Other laws follow it: nothing lies below, so that nothing is hit, and nothing leaves the model.
TEST_P(OffPartner, IsMissedWhereRowsFollow) {
  const TemporaryFolder folder;
  const auto run = run_text(sideways(GetParam(), 100.0, "trapezoidal_reset"), folder);
  EXPECT_EQ(run.largest("contact_force_n"), 0.0);
  EXPECT_TRUE(run.summary.at("outside_model").empty()) << run.summary.at("outside_model");
  EXPECT_THAT(check(sideways(GetParam(), 100.0, "trapezoidal_reset"), folder).out, Not(HasSubstr("element edges")));
}

TEST(Flight, AsideOfThePartnerIsPredicted) {
  const TemporaryFolder folder;
  EXPECT_THAT(check(sideways("hughes_liu", 100.0), folder).out,
              HasSubstr("moved 0.1 m along the contact surface, 10 element edges: nodes are past"));
  EXPECT_THAT(check(sideways("hughes_liu", 7.0), folder).out,
              HasSubstr("0.7 element edges: pressure and friction act"));
  EXPECT_THAT(check(sideways("hughes_liu", 3.0), folder).out, Not(HasSubstr("element edges")));
}

TEST_P(OffPartner, SlipOfLessIsSaidWithItsSize) {
  const TemporaryFolder folder;
  const auto run = run_text(sideways(GetParam(), 7.0), folder);  // 7 mm along edges of 10 mm when they touch
  ASSERT_TRUE(find(run, "slip")) << run.summary.at("outside_model");
  EXPECT_NEAR(find(run, "slip")->at("size").get<double>(), 0.75, 0.1);
  EXPECT_FALSE(find(run, "slip")->at("results_wrong").get<bool>());
  EXPECT_TRUE(run_text(sideways(GetParam(), 3.0), folder, "less").summary.at("outside_model").empty());
}

INSTANTIATE_TEST_SUITE_P(Outside, OffPartner, testing::Values("hughes_liu", "all_implicit", "all_explicit"),
                         [](const auto& test) { return test.param; });

/// Two bars of 1 m with c = 1000 m/s; each is strained by half the closing speed over c.
std::string bars(double closing_m_s, double step_s, const std::string& protocol = "hughes_liu") {
  return "model = \"bar\"\n" + body("left", "start_m = -1.0, length_m = 1.0, elements = 50", list(closing_m_s)) +
         body("right", "length_m = 1.0, elements = 50", "[0.0]") +
         "[contact]\nsurfaces = [\"left.end\", \"right.start\"]\n[partition]\nimplicit_length_m = { left = 0.1, right "
         "= 0.1 }\n" +
         settings(step_s, 1.5e-3, protocol);
}

TEST(Strain, AboveTwoPercentIsSaidWithTheErrorToExpect) {
  const TemporaryFolder folder;
  const auto run = run_text(bars(60.0, 1.8e-5), folder);
  ASSERT_TRUE(find(run, "strain"));
  EXPECT_NEAR(find(run, "strain")->at("size").get<double>(), 0.034, 0.006);  // 0.03, and what the front overshoots
  EXPECT_FALSE(find(run, "strain")->at("results_wrong").get<bool>());
  EXPECT_TRUE(run.summary.at("valid_until_s").is_null());
  EXPECT_THAT(run.outcome.error, HasSubstr("expect errors of stresses and forces of about 3"));
  EXPECT_THAT(run.outcome.out, HasSubstr("outside the model"));
  EXPECT_THAT(check(bars(60.0, 1.8e-5), folder).out, HasSubstr("strains body \"left\" by about 3 %"));
  EXPECT_TRUE(run_text(bars(30.0, 1.8e-5), folder, "small").summary.at("outside_model").empty());
  EXPECT_THAT(check(bars(30.0, 1.8e-5), folder).out, Not(HasSubstr("strains body")));
}

TEST(InvertedElement, StopsTheRun) {
  const TemporaryFolder folder;
  const auto run = run_file(folder.write(bars(2400.0, 4e-6)), folder);
  expect_left(run, "inverted_element", "is turned inside out");
}

TEST(Step, ThatMovesTheBodiesThroughEachOtherIsRefused) {
  const TemporaryFolder folder;
  const auto refused = check(bars(60000.0, 1.8e-5), folder);
  EXPECT_EQ(refused.code, 2);
  EXPECT_THAT(refused.error,
              HasSubstr("54 of the depth of an element of body \"left\" at the contact: more than its thickness"));
  EXPECT_THAT(check(bars(800.0, 1.8e-5), folder).out, HasSubstr("nearly inside out"));
}

/// "left" hits "right" at 1 mm/ms, which then flies on to a third bar that no contact keeps away.
std::string third_bar(const std::string& protocol, double velocity_m_s) {
  return replaced(bars(2.0, 1.8e-5, protocol), "[contact]",
                  body("third", "start_m = 1.002, length_m = 0.02, elements = 1", list(velocity_m_s)) + "[contact]");
}

class ThirdBody : public testing::TestWithParam<std::string> {};

TEST_P(ThirdBody, ThatAnotherMeetsWithoutAContactStopsTheRun) {
  const TemporaryFolder folder;
  const std::string text = replaced(third_bar(GetParam(), 0.0), "end_s = 1500", "end_s = 6000");
  EXPECT_THAT(check(text, folder).out, Not(HasSubstr("no contact"))) << "not on a straight flight from the start";
  const auto run = run_file(folder.write(text), folder);
  expect_left(run, "overlap", "with no contact between them");
  // The far end of "right" moves with 2 m/s from 1 ms on for 1 ms, and its middle with 1 m/s: 2 mm are gone at about 2
  // ms.
  EXPECT_NEAR(find(run, "overlap")->at("first_s").get<double>(), 2e-3, 4e-4);
}

TEST_P(ThirdBody, ThatFliesThroughAThinOneBetweenTwoLooksIsSeen) {
  const TemporaryFolder folder;  // 0.58 m in 32 windows, through 0.02 m into the bar of 1 m
  std::string text = replaced(third_bar(GetParam(), -1000.0), "start_m = 1.002", "start_m = 1.4");
  text = replaced(text, "start_m = -1.0", "start_m = -1.002");  // "left" comes later
  EXPECT_THAT(check(text, folder).out, HasSubstr("meet at about 0.0004"));
  const auto run = run_file(folder.write(text), folder);
  expect_left(run, "overlap", "bodies 'right' and 'third' overlap");
  EXPECT_NEAR(find(run, "overlap")->at("first_s").get<double>(), 4e-4, 2e-5);
}

INSTANTIATE_TEST_SUITE_P(Outside, ThirdBody,
                         testing::Values("hughes_liu", "all_implicit", "all_explicit", "prakash_hjelmstad"),
                         [](const auto& test) { return test.param; });

TEST(Overlap, AtTheStartIsRefused) {
  const TemporaryFolder folder;
  const auto refused = check(replaced(third_bar("hughes_liu", 0.0), "start_m = 1.002", "start_m = 0.99"), folder);
  EXPECT_EQ(refused.code, 2);
  EXPECT_THAT(refused.error, HasSubstr("overlaps body \"right\" by 0.01 m"));
}

class PostOnAPlate : public testing::TestWithParam<std::string> {};

/// A post of 1 mm stands on the plate that a block falls to, and the contact names the plate alone.
TEST_P(PostOnAPlate, ThatTheBlockMeetsFirstStopsTheRun) {
  const std::string text =
      "model = \"plane_strain\"\n[[body]]\nname = \"low\"\nmaterial = \"steel_a36\"\n"
      "[[body.support]]\nsurface = \"plate.start\"\nfixed = [\"x\", \"y\"]\n[body.mesh]\n"
      "tie = [{ surfaces = [\"plate.end\", \"post.start\"] }]\npiece = [\n"
      "{ name = \"plate\", height_m = 0.01, length_m = 0.004, elements = [20, 8] },\n"
      "{ name = \"post\", height_m = 0.002, length_m = 0.001, start_m = 0.004, elements = [4, 2] }]\n"
      "[[body]]\nname = \"high\"\nmaterial = \"steel_a36\"\ninitial_velocity_m_s = [0.0, -10.0]\n"
      "mesh = { height_m = 0.01, length_m = 0.004, start_m = 0.0051, elements = [20, 8] }\n"
      "[contact]\nsurfaces = [\"low.plate.end\", \"high.start\"]\n[partition]\n"
      "implicit_length_m = { low = 0.001, high = 0.001 }\n" +
      settings(3e-8, 1.3e-4, GetParam());
  const TemporaryFolder folder;
  const auto run = run_file(folder.write(text), folder);
  expect_left(run, "overlap", "beside the surfaces that the contact names");
  // 0.1 mm of way, and a quarter of an edge of the plate's 0.5 mm.
  EXPECT_NEAR(find(run, "overlap")->at("first_s").get<double>(), 22.5e-6, 0.5e-6);
  EXPECT_EQ(run_file(folder.write(replaced(text, "start_m = 0.0051, ",
                                           "start_m = 0.0041, place = { moved_m = [0.003, "
                                           "0.0] }, "),
                                  "beside.toml"),
                     folder, "beside")
                .outcome.code,
            0);
}

INSTANTIATE_TEST_SUITE_P(Outside, PostOnAPlate, testing::Values("hughes_liu", "all_implicit", "all_explicit"),
                         [](const auto& test) { return test.param; });

/// A striker with a round nose of 4 mm whose collar reaches 0.1 mm further, at `high_m` above y = 0.
std::string striker_with_collar(double high_m) {
  const PlaneGrid striker(20, 8, [&](double a, double b) {
    const double x = 0.01 * a, low = x < 0.005 ? x * x / 0.2 : 1.25e-4 - (x - 0.005) * 0.045;
    return PlaneGrid::Place(x, high_m + low + (0.004 - low) * b);
  });
  PlaneGrid::Edges nose = striker.low();
  nose.resize(8);
  return striker.msh("striker", {{"nose", nose}, {"axis", striker.left()}});
}

class CollarOfAStriker : public testing::TestWithParam<const char*> {};

TEST_P(CollarOfAStriker, ThatThePlateMeetsFirstStopsTheRun) {
  const TemporaryFolder folder;
  (void)folder.write(striker_with_collar(2e-4), "striker.msh");
  const std::string model = GetParam();
  const bool plane = model == "plane_strain";
  const std::string text =
      "model = \"" + model + "\"\n[[body]]\nname = \"plate\"\nmaterial = \"steel_a36\"\n" +
      "support = [{ surface = \"start\", fixed = [\"" + (plane ? "y" : "z") + "\"] }]\n" + "mesh = { " +
      (plane ? "height_m" : "radius_m") + " = 0.012, length_m = 0.004, start_m = -0.004, " +
      "elements = [24, 8] }\n[[body]]\nname = \"striker\"\nmaterial = \"steel_a36\"\n" +
      "initial_velocity_m_s = [0.0, -10.0]\nmesh.gmsh = \"striker.msh\"\n" +
      (plane ? "support = [{ surface = \"axis\", fixed = [\"x\"] }]\n" : "") +
      "[contact]\nsurfaces = [\"plate.end\", \"striker.nose\"]\n[partition]\n" +
      "implicit_length_m = { plate = 0.001, striker = 0.001 }\n" + settings(3e-8, 6e-5, "hughes_liu");
  const auto run = run_file(folder.write(text), folder);
  expect_left(run, "overlap", "beside the surfaces that the contact names");
  // The collar is 0.1 mm above the plate, and a quarter of an edge of 0.5 mm counts.
  EXPECT_NEAR(find(run, "overlap")->at("first_s").get<double>(), 22.5e-6, 1.5e-6);
}

INSTANTIATE_TEST_SUITE_P(Outside, CollarOfAStriker, testing::Values("axisymmetric", "plane_strain"),
                         [](const auto& test) { return std::string(test.param); });

/// A block that stands 0.2 mm above a rigid plane, on which only its surface "block.start" is named, and a post of it
/// that reaches down by `post_m`.
std::string post_above_a_plane(double post_m) {
  return "model = \"plane_strain\"\n[[body]]\nname = \"block\"\nmaterial = \"steel_a36\"\n"
         "initial_velocity_m_s = [0.0, -10.0]\n[body.mesh]\n"
         "tie = [{ surfaces = [\"block.start\", \"post.end\"] }]\npiece = [\n"
         "{ name = \"block\", height_m = 0.01, length_m = 0.004, elements = [20, 8] },\n" +
         fmt::format("{{ name = \"post\", height_m = 0.002, length_m = {0}, start_m = -{0}, elements = [4, 2] }}]\n",
                     post_m) +
         "[contact]\nsurfaces = [\"block.block.start\", \"rigid_plane\"]\ninitial_gap_m = 2e-4\n[partition]\n"
         "implicit_length_m = { block = 0.001 }\n" +
         settings(5e-9, 5e-5, "hughes_liu");
}

TEST(PostAboveARigidPlane, StopsTheRunUnlessItIsInAHoleFromTheStart) {
  const TemporaryFolder folder;
  const auto run = run_file(folder.write(post_above_a_plane(1e-4)), folder);
  expect_left(run, "overlap", "beside the surfaces that the contact names");
  // 0.1 mm of way, and a quarter of an edge of the post's 0.05 mm.
  EXPECT_NEAR(find(run, "overlap")->at("first_s").get<double>(), 11.25e-6, 0.5e-6);
  const auto in_a_hole = run_file(folder.write(post_above_a_plane(1e-3), "hole.toml"), folder, "hole");
  EXPECT_EQ(in_a_hole.outcome.code, 0) << in_a_hole.outcome.error;
}

// The corner of the post has 0.21 mm to go, and sinks by 0.66 of its way: a quarter of an edge of 0.25 mm after 0.1 mm.
TEST(PostBesideARigidCylinder, StopsTheRun) {
  const TemporaryFolder folder;
  const auto run = run_file(
      folder.write("model = \"plane_strain\"\n[[body]]\nname = \"block\"\nmaterial = \"steel_a36\"\n"
                   "initial_velocity_m_s = [0.0, -10.0]\n[body.mesh]\n"
                   "tie = [{ surfaces = [\"block.start\", \"post.end\"] }]\npiece = [\n"
                   "{ name = \"block\", height_m = 0.016, length_m = 0.004, elements = [32, 8] },\n"
                   "{ name = \"post\", height_m = 0.002, length_m = 0.0029, start_m = -0.0029, elements = [8, 12] }]\n"
                   "[contact]\nsurfaces = [\"block.block.start\", \"rigid_cylinder\"]\nrigid_radius_m = 0.008\n"
                   "rigid_place_m = [0.008, 0.0]\ninitial_gap_m = 4e-4\n[partition]\n"
                   "implicit_length_m = { block = 0.001 }\n" +
                   settings(5e-9, 5e-5, "hughes_liu")),
      folder);
  expect_left(run, "overlap", "'block' and 'rigid_cylinder' overlap");
  EXPECT_NEAR(find(run, "overlap")->at("first_s").get<double>(), 30.4e-6, 1e-6);
}

TEST(Rotation, AboveTwoDegreesIsSaid) {
  const TemporaryFolder folder;  // a cantilever that bends
  const std::string text = "model = \"plane_strain\"\n" +
                           body("beam", "height_m = 0.05, length_m = 1.0, elements = [4, 40]", "[0.0, 0.0]",
                                "support = [{ surface = \"start\", fixed = [\"x\", \"y\"] }]\n"
                                "traction = [{ surface = \"end\", traction_pa = [4e4, 0.0] }]\n") +
                           settings(2.5e-4, 0.06, "all_implicit");
  const auto run = run_text(text, folder);
  ASSERT_TRUE(find(run, "rotation")) << run.summary.at("outside_model");
  EXPECT_NEAR(find(run, "rotation")->at("size").get<double>(), 0.16,
              0.03);  // nearly twice the static 6 p L^2 (1 - nu^2)/(E h^2)
  EXPECT_THAT(run.outcome.error, HasSubstr("the body grows there by "));
}

/// A free block that a couple sets turning for 4 ms: then every node goes straight on, so that w = tan(angle) grows
/// evenly and the block with it, by 1/cos - 1. It turns by 10 degrees in 10 ms.
std::string turning_rod(const std::string& model, double end_s, const std::string& more = "") {
  const bool solid = model == "solid";
  const auto ends = [&](const std::string& surface, const std::string& sign) {
    return "{ surface = \"" + surface + "\", traction_pa = [" + sign + "4e4, 0.0" + (solid ? ", 0.0" : "") +
           "], amplitude = { time_s = [0.0, 2e-3, 4e-3], factor = [0.0, 1.0, 0.0] } }";
  };
  return "model = \"" + model + "\"\n" +
         body("rod",
              solid ? "height_m = 0.05, width_m = 0.05, length_m = 0.2, elements = [2, 2, 8]"
                    : "height_m = 0.05, length_m = 0.2, elements = [2, 8]",
              solid ? "[0.0, 0.0, 0.0]" : "[0.0, 0.0]",
              "traction = [" + ends("start", "-") + ", " + ends("end", "") + "]\n") +
         settings(1.2e-5, end_s, "all_explicit") + more;
}

class TurningRod : public testing::TestWithParam<std::string> {};

TEST_P(TurningRod, GrowsByOneOverTheCosineAndHasNoStress) {
  const TemporaryFolder folder;
  const auto run = run_text(turning_rod(GetParam(), 0.02, "outside_model = \"go_on\"\n"), folder);
  EXPECT_EQ(run.summary.at("status"), "left_model");
  EXPECT_EQ(run.summary.at("exit_code"), 0);
  const auto* rotation = find(run, "rotation");
  ASSERT_TRUE(rotation);
  EXPECT_GT(rotation->at("size").get<double>(), 15.0 * 3.14159 / 180.0);
  EXPECT_FALSE(rotation->at("results_wrong").get<bool>());
  const double w = std::tan(rotation->at("size").get<double>());
  char grows[64];
  std::snprintf(grows, sizeof grows, "grows there by %.2g %%", 100.0 * (std::sqrt(1.0 + w * w) - 1.0));
  EXPECT_THAT(rotation->at("text").get<std::string>(), AllOf(HasSubstr(grows), HasSubstr("no stress of it")));
  EXPECT_EQ(rotation->at("place_m").size(), GetParam() == "solid" ? 3U : 2U);
  EXPECT_LT(run.last("energy_strain_j"), 1e-3 * run.last("energy_kinetic_j"));
  EXPECT_THAT(run.outcome.out, HasSubstr("left the model: "));
  EXPECT_THAT(file_text(run.folder + "/report.html"), HasSubstr("<strong>left the model</strong>"));
}

TEST_P(TurningRod, FromTenDegreesOnTheRunStops) {
  const TemporaryFolder folder;
  const auto run = run_file(folder.write(turning_rod(GetParam(), 0.1)), folder);
  EXPECT_EQ(run.outcome.code, 6);
  EXPECT_THAT(run.outcome.error, AllOf(HasSubstr("left the model: rotation of "),
                                       HasSubstr("to go on for all that: coupling.outside_model = \"go_on\"")));
  ASSERT_TRUE(find(run, "rotation"));
  EXPECT_TRUE(find(run, "rotation")->at("results_wrong").get<bool>());
  EXPECT_GT(find(run, "rotation")->at("size").get<double>(), 10.0 * 3.14159 / 180.0);
  const double valid_s = run.summary.at("valid_until_s");
  EXPECT_GT(valid_s, find(run, "rotation")->at("first_s").get<double>()) << "from 2 to 10 degrees it is";
  EXPECT_LT(valid_s, 0.0105);
  EXPECT_LE(run.last("time_s"), valid_s + 1e-9);
}

TEST_P(TurningRod, BelowItIsNotDoneEither) {
  const TemporaryFolder folder;
  const auto run = run_text(turning_rod(GetParam(), 0.006), folder);
  ASSERT_TRUE(find(run, "rotation"));
  EXPECT_EQ(run.summary.at("status"), "left_model");
  EXPECT_THAT(run.outcome.out, AllOf(HasSubstr("left the model: "), Not(HasSubstr("done"))));
}

INSTANTIATE_TEST_SUITE_P(Outside, TurningRod, testing::Values("plane_strain", "solid"),
                         [](const auto& test) { return test.param; });

TEST(Strain, FromTenPercentOnTheRunStopsUnlessItIsToGoOn) {
  const TemporaryFolder folder;
  const auto run = run_file(folder.write(bars(240.0, 1.2e-5)), folder);
  expect_left(run, "strain", "coupling.outside_model = \"go_on\"");
  const auto on = run_text(bars(240.0, 1.2e-5) + "outside_model = \"go_on\"\n", folder, "on");
  EXPECT_FALSE(find(on, "strain")->at("results_wrong").get<bool>());
}

}  // namespace
}  // namespace ricochet::test

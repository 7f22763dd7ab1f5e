// The lines of `ricochet check` on a scene before anything is computed.
#include <gmock/gmock.h>

#include <chrono>
#include <filesystem>
#include <sstream>

#include "tests/support/places.hpp"
#include "tests/support/run.hpp"

namespace ricochet::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

Outcome checked(const std::string& text, const TemporaryFolder& folder) {
  return run_command({ricochet_binary(), "check", folder.write(text, "checked.toml")}, folder.path().string(), 300.0);
}

/// The number behind a text.
double number_after(const std::string& text, const std::string& words) {
  const auto at = text.find(words);
  if (at == std::string::npos) throw std::runtime_error("'" + words + "' is not in:\n" + text);
  return std::stod(text.substr(at + words.size()));
}

/// The words of a row of the table of bodies.
std::vector<std::string> row_of(const std::string& text, const std::string& body) {
  const auto at = text.find("\n" + body + " ");
  if (at == std::string::npos) throw std::runtime_error("no row of " + body + " in:\n" + text);
  std::istringstream row(text.substr(at + 1, text.find('\n', at + 1) - at - 1));
  return {std::istream_iterator<std::string>(row), {}};
}

TEST(CheckedBodies, HaveTheirMassSizeSpeedAndEnergy) {
  const TemporaryFolder folder;
  const auto out = checked(with_absolute_meshes(config_text("kim_impact")), folder).out;
  const auto row = row_of(out, "steel");  // steel, r, 0.005,, z, 0.08, volume, mass, speed, energy
  ASSERT_EQ(row.size(), 9U) << out;
  constexpr double volume_m3 = 3.14159265 * 25e-6 * 0.08, mass_kg = 7860.0 * volume_m3;
  EXPECT_THAT(row[2] + row[4], "0.005,0.08");
  EXPECT_NEAR(std::stod(row[5]), volume_m3, 1e-3 * volume_m3);
  EXPECT_NEAR(std::stod(row[6]), mass_kg, 1e-3 * mass_kg);
  EXPECT_EQ(std::stod(row[7]), 30.0);
  EXPECT_NEAR(std::stod(row[8]), 0.5 * mass_kg * 900.0, 1e-3 * 0.5 * mass_kg * 900.0);
  EXPECT_THAT(out, HasSubstr("impact of \"steel\" on \"carbide\" at 30 m/s: about "));
  EXPECT_NEAR(number_after(out, "at 30 m/s: about "), 853.75e6 * 3.14159265 * 25e-6, 70.0);
  EXPECT_NEAR(number_after(out, " N for "), 31.18e-6, 0.02e-6);
  EXPECT_THAT(out, HasSubstr("by impedance theory"));
}

class CheckedHertz : public testing::TestWithParam<std::string> {};

/// For the rings of axisymmetry and of quarters of balls, whatever the mesh: within what the run itself finds.
TEST_P(CheckedHertz, IsTheForceAndTheDurationOfTheRun) {
  const TemporaryFolder folder;
  const std::string text = with_absolute_meshes(config_text(GetParam()));
  const auto out = checked(text, folder).out;
  const auto run = run_text(text, folder);
  ASSERT_THAT(out, HasSubstr("by Hertz' theory"));
  const double force_n = number_after(out, "m/s: about "), duration_s = number_after(out, " N for ");
  EXPECT_NEAR(force_n / run.summary.at("peak_contact_force_n").get<double>(), 1.0, 0.12);
  const double first_s = run.summary.at("first_contact_s"), last_s = run.summary.at("separation_time_s");
  EXPECT_NEAR(duration_s / (last_s - first_s), 1.0, 0.12);
}

INSTANTIATE_TEST_SUITE_P(Checked, CheckedHertz, testing::Values("two_balls", "two_balls_solid"),
                         [](const auto& test) { return test.param; });

std::string rod(const std::string& length_m, const std::string& modulus_pa, const std::string& density) {
  return "model = \"axisymmetric\"\n[[body]]\nname = \"rod\"\nmaterial = { youngs_modulus_pa = " + modulus_pa +
         ", poisson_ratio = 0.3, density_kg_m3 = " + density + " }\nmesh = { length_m = " + length_m +
         ", radius_m = 5e-3, elements = [2, 20] }\ninitial_velocity_m_s = [0.0, -10.0]\n"
         "[contact]\nsurfaces = [\"rod.start\", \"rigid_plane\"]\n[time]\nsafety_factor = 0.9\nend_s = 1e-4\n"
         "[coupling]\nprotocol = \"all_explicit\"\n";
}

TEST(AnotherUnit, IsAskedFor) {
  const TemporaryFolder folder;
  EXPECT_THAT(checked(rod("80e-3", "206.8e9", "7850.0"), folder).out, Not(HasSubstr("warning")));
  const std::string longer = checked(replaced(rod("80.0", "206.8e9", "7850.0"), "1e-4", "5e-4"), folder).out;
  EXPECT_THAT(longer, AllOf(HasSubstr("warning: body \"rod\" is 80 m large"), HasSubstr("is it in millimetres?")));
  EXPECT_THAT(checked(replaced(rod("80e-3", "206.8e3", "7850.0"), "1e-4", "1e-1"), folder).out,
              HasSubstr("a wave speed of 5."));
  EXPECT_THAT(checked(replaced(rod("80e-3", "206.8e9", "7.85e-9"), "1e-4", "1e-9"), folder).out,
              HasSubstr("a density of 7.85e-09 kg/m^3"));
}

/// The mesh of a scene, its lengths in millimetres.
TEST(AnotherUnit, OfAMeshIsAskedFor) {
  const TemporaryFolder folder;
  std::istringstream metres(file_text(source_folder() + "/configs/striker.msh"));
  std::ostringstream millimetres;
  bool nodes = false;
  for (std::string line; std::getline(metres, line);) {
    if (line == "$Nodes" || line == "$EndNodes") nodes = line == "$Nodes";
    std::istringstream words(line);
    double x = 0.0, y = 0.0, z = 0.0;
    const bool place = nodes && line.find('.') != std::string::npos && words >> x >> y >> z;
    place ? millimetres << 1e3 * x << ' ' << 1e3 * y << ' ' << 1e3 * z << '\n' : millimetres << line << '\n';
  }
  (void)folder.write(millimetres.str(), "striker.msh");
  const std::string text = with_key(config_text("striker_gmsh"), "time", "end_s", "1e-3");
  const auto scaled = checked(text, folder);
  EXPECT_THAT(scaled.out + scaled.error,
              HasSubstr("is it in millimetres? Lengths are metres, in a mesh file too, unless mesh.length_unit says"));
  EXPECT_THAT(checked(with_absolute_meshes(text), folder).out, Not(HasSubstr("millimetres")));
}

TEST(CheckedDisk, IsWhatTheFieldsTake) {
  const TemporaryFolder folder;
  const std::string text = with_key(with_absolute_meshes(config_text("kim_impact")), "output", "fields_every", "20");
  const auto out = checked(text, folder).out;
  const auto run = run_text(text, folder);
  double bytes = 0.0, files = 0.0;
  for (const auto& entry : std::filesystem::directory_iterator(run.folder + "/fields")) {
    if (entry.path().extension() != ".vtu") continue;
    bytes += static_cast<double>(entry.file_size());
    files += 1.0;
  }
  EXPECT_NEAR(number_after(out, ", of it "), 1e-6 * bytes, 0.06 * 1e-6 * bytes) << "two digits, and the last step";
  EXPECT_NEAR(number_after(out, " MB in "), files, 4.0);
}

TEST(LargeScene, IsFoundSoonOrSaysWhatItIsDoing) {
  const TemporaryFolder folder;
  const auto begin = std::chrono::steady_clock::now();
  const auto outcome = checked(replaced(rod("80e-3", "206.8e9", "7850.0"), "[2, 20]", "[400, 1000]"), folder);
  const double s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  EXPECT_EQ(outcome.code, 0) << outcome.error;
  if (s > 2.5) {
    EXPECT_THAT(outcome.error, HasSubstr("2 s: ")) << s;
  }
  EXPECT_THAT(outcome.out, HasSubstr("set-up before the first step: about "));
}

Outcome drawn(const TemporaryFolder& folder, const std::vector<std::string>& options) {
  std::vector<std::string> words{"/usr/bin/env",    "-C",    folder.path().string(),
                                 ricochet_binary(), "check", folder.write(config_text("two_bars"), "bars.toml")};
  words.insert(words.end(), options.begin(), options.end());
  return run_command(words, folder.path().string(), 300.0);
}

TEST(CheckedScene, IsDrawnBesideWhatARunHasLeft) {
  const TemporaryFolder folder;
  const auto out = folder.path() / "out" / "bars_scene";
  for (int again = 0; again < 2; ++again) {
    const auto outcome = drawn(folder, {"--picture"});
    EXPECT_EQ(outcome.code, 0) << outcome.error;
    EXPECT_THAT(outcome.out, HasSubstr("wrote " + (out / "scene.html").string()));
  }
  const auto page = file_text((out / "scene.html").string());
  EXPECT_THAT(page, AllOf(HasSubstr("The scene bars.toml before it runs."), HasSubstr("by impedance theory")));
  const auto run = run_command(
      {ricochet_binary(), "run", (folder.path() / "bars.toml").string(), "--out", (folder.path() / "results").string()},
      folder.path().string(), 300.0);
  ASSERT_EQ(run.code, 0) << run.error;
  EXPECT_EQ(drawn(folder, {"--picture", "--out", "results", "--set", "time.step_s=1e-6"}).code, 0);
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "results" / "summary.json"));
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "results" / "scene.html"));
}

TEST(CheckedScene, IsNotDrawnOverAFileOfSomebodyElse) {
  const TemporaryFolder folder;
  const auto mine = folder.write("mine", "scene.html");
  const auto outcome = drawn(folder, {"--picture", "--out", "."});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.error, HasSubstr("scene.html"));
  EXPECT_EQ(file_text(mine), "mine");
  const auto alone = drawn(folder, {"--out", "."});
  EXPECT_EQ(alone.code, 2);
  EXPECT_THAT(alone.error, HasSubstr("--out: found without --picture, allowed: with it"));
  const auto below = drawn(folder, {"--picture", "--out", "bars.toml/below"});
  EXPECT_EQ(below.code, 2);
  EXPECT_THAT(below.error, HasSubstr("cannot create the folder"));
}

}  // namespace
}  // namespace ricochet::test

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/places.hpp"
#include "tests/support/run.hpp"
#include "tests/support/vtu.hpp"

// The files that a whole run leaves for the picture of the deformed bodies on its page, without a key that asks for it.

namespace ricochet::test {
namespace {

nlohmann::json shapes_of(const RunResult& run, const std::string& participant) {
  return nlohmann::json::parse(file_text(run.folder + "/fields/" + participant + ".shapes.json"));
}

std::vector<float> floats(const nlohmann::json& packed) {
  const std::string bytes = decode_base64(packed.get<std::string>());
  std::vector<float> values(bytes.size() / sizeof(float));
  std::memcpy(values.data(), bytes.data(), values.size() * sizeof(float));
  return values;
}

class PictureOfProtocols : public testing::TestWithParam<const char*> {};

// The same displacements and stresses as in the fields that ParaView opens, at windows that all participants have.
TEST_P(PictureOfProtocols, IsOfTheFieldsOfTheRun) {
  const TemporaryFolder folder;
  const std::string text = with_protocol(config_text("two_bars"), GetParam());
  const RunResult run = run_text(with_key(text, "output", "fields_every", "1"), folder);
  const int steps = run.summary.at("windows").get<int>();
  std::vector<int> windows;
  for (const auto& process : run.summary.at("processes")) {
    const auto name = process.at("name").get<std::string>();
    if (name == "coupler") continue;
    const auto shapes = shapes_of(run, name);
    const auto kept = shapes.at("windows").get<std::vector<int>>();
    if (windows.empty()) windows = kept;
    EXPECT_EQ(kept, windows) << name;
    for (std::size_t w = 0; w < kept.size(); ++w) {
      const auto files = field_files(run.folder, name, kept[w]);
      const auto u = vtu_array(files, "displacement"), stress = vtu_component(files, "stress", "xx");
      std::size_t nodes = 0, cells = 0;
      for (const auto& body : shapes.at("bodies")) {
        for (const float value : floats(body.at("displacement_m")[w]))
          EXPECT_FLOAT_EQ(value, static_cast<float>(u[3 * nodes++]));
        for (const float value : floats(body.at("stress_pa")[w]))
          EXPECT_FLOAT_EQ(value, static_cast<float>(stress[cells++]));
      }
      EXPECT_EQ(nodes, u.size() / 3);
      EXPECT_EQ(cells, stress.size());
    }
  }
  ASSERT_GE(windows.size(), 5U);
  EXPECT_EQ(windows.front(), 0);
  EXPECT_EQ(windows.back(), steps);
  EXPECT_THAT(file_text(run.folder + "/report.html"), testing::HasSubstr("<h2>Deformed bodies: axial stress at "));
}

INSTANTIATE_TEST_SUITE_P(Protocols, PictureOfProtocols,
                         testing::Values("hughes_liu", "prakash_hjelmstad", "fixed_point", "all_implicit",
                                         "all_explicit"));

/// A flight 500 times as long as the impact, which would fall between windows that are spread evenly over the run.
TEST_P(PictureOfProtocols, ShowsAnImpactAfterALongFlight) {
  const TemporaryFolder folder;
  const std::string text =
      replaced(with_protocol(config_text("two_bars"), GetParam()), "[contact]\n", "[contact]\ninitial_gap_m = 0.5\n");
  const RunResult run = run_text(with_key(text, "time", "end_s", "0.0512"), folder);
  const auto& force = run.column("contact_force_n");
  for (const auto& process : run.summary.at("processes")) {
    const auto name = process.at("name").get<std::string>();
    if (name == "coupler") continue;
    int in_contact = 0;
    const auto shapes = shapes_of(run, name);
    for (const auto& window : shapes.at("windows")) in_contact += force.at(window.get<std::size_t>()) > 0.0;
    EXPECT_GE(in_contact, 3) << name;
    EXPECT_EQ(shapes.at("touching"), nlohmann::json::parse(R"([["left", "right"]])"));
  }
}

/// The largest of each kept window, of the picture of the contact's owner and of its fields. Plates press evenly.
TEST(BodiesPicture, HasTheContactPressureOfTheFields) {
  const TemporaryFolder folder;
  for (const auto& [protocol, owner] : {std::pair{"hughes_liu", "implicit"}, {"all_explicit", "explicit"}}) {
    const std::string text =
        with_protocol(with_key(config_text("sticking_plates"), "output", "fields_every", "1"), protocol);
    const RunResult run = run_text(text, folder, protocol);
    const auto shapes = shapes_of(run, owner);
    const auto windows = shapes.at("windows").get<std::vector<int>>();
    int pressed = 0;
    for (std::size_t w = 0; w < windows.size(); ++w) {
      double expected_pa = 0.0;
      for (const double pa : vtu_array(field_files(run.folder, owner, windows[w]), "contact_pressure"))
        expected_pa = std::max(expected_pa, pa);  // of a node without a row it is not a number
      for (const auto& body : shapes.at("bodies")) {
        const auto found = floats(body.at("contact_pressure_pa")[w]);
        EXPECT_NEAR(*std::max_element(found.begin(), found.end()), expected_pa, 1e-6 * expected_pa)
            << protocol << windows[w];
      }
      pressed += expected_pa > 0.0;
    }
    EXPECT_GE(pressed, 2) << protocol;
    EXPECT_THAT(file_text(run.folder + "/report.html"), testing::HasSubstr("\"name\":\"contact pressure\""))
        << protocol;
  }
}

TEST(BodiesPicture, OfARunThatFailsShowsItUpToThere) {
  const TemporaryFolder folder;
  const RunResult run = run_file(source_folder() + "/tests/coupler/report/stopped.toml", folder);
  EXPECT_EQ(run.outcome.code, 3);
  EXPECT_EQ(shapes_of(run, "explicit").at("windows").front(), 0);
  EXPECT_GE(shapes_of(run, "implicit").at("windows").size(), 4U);
  EXPECT_THAT(file_text(run.folder + "/report.html"), testing::HasSubstr("<h2>Deformed bodies: axial stress at "));
}

// As one on another machine, or one of another maker, would.
TEST(BodiesPicture, SaysWhoLeftNothingToDraw) {
  const TemporaryFolder folder;
  const RunResult run = run_text(config_text("two_bars"), folder);
  std::filesystem::remove(run.folder + "/fields/explicit.shapes.json");
  EXPECT_EQ(run_command({ricochet_binary(), "report", run.folder}, folder.path().string()).code, 0);
  EXPECT_THAT(
      file_text(run.folder + "/report.html"),
      testing::HasSubstr("The elements of &#39;explicit&#39; are not drawn: it left no fields/explicit.shapes.json."));
}

TEST(BodiesPicture, HasTheRigidObstacle) {
  const TemporaryFolder folder;
  const RunResult run = run_text(replaced(config_text("rod_on_stop"), "end_s = 12.0", "end_s = 0.5"), folder);
  const auto drawn = nlohmann::json::parse(file_text(run.folder + "/fields/obstacles.json")).at("obstacles");
  ASSERT_EQ(drawn.size(), 1U);
  EXPECT_EQ(drawn[0].at("name"), "rigid plane");
  EXPECT_EQ(drawn[0].at("place_m")[0][0], 0.0) << "where the rod's end is without its displacement";
  EXPECT_LT(drawn[0].at("place_m")[1][0], 0.0);
  EXPECT_THAT(file_text(run.folder + "/report.html"), testing::HasSubstr("Grey bodies are rigid"));
}

TEST(BodiesPicture, OfAFormerRunIsRemovedByTheNext) {
  const TemporaryFolder folder;
  const RunResult first = run_text(config_text("two_bars"), folder);
  EXPECT_TRUE(std::filesystem::exists(first.folder + "/fields/explicit.shapes.json"));
  const RunResult second = run_text(with_protocol(config_text("two_bars"), "all_implicit"), folder);
  EXPECT_EQ(first.folder, second.folder);
  EXPECT_TRUE(std::filesystem::exists(first.folder + "/fields/implicit.shapes.json"));
  EXPECT_FALSE(std::filesystem::exists(first.folder + "/fields/explicit.shapes.json"));
}

}  // namespace
}  // namespace ricochet::test

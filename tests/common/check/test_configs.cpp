#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "common/base/error.hpp"
#include "common/check/check.hpp"
#include "common/scene/loaders.hpp"
#include "common/scene/material_library.hpp"
#include "common/scene/protocols.hpp"
#include "common/scene/schema.hpp"
#include "tests/support/places.hpp"

namespace ricochet::scene {
namespace {

std::string read(const std::string& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::vector<std::string> configs() {
  std::vector<std::string> result;
  for (const auto& entry : std::filesystem::directory_iterator(test::source_folder() + "/configs"))
    if (entry.path().extension() == ".toml") result.push_back(entry.path().stem().string());
  std::sort(result.begin(), result.end());
  return result;
}

class Config : public testing::TestWithParam<std::string> {};

TEST_P(Config, LoadsAndPlansWithoutAWarning) {
  const Scene scene = load_scene(test::source_folder() + "/configs/" + GetParam() + ".toml");
  const Plan result = plan(build_problem(scene));
  EXPECT_THAT(result.warnings, testing::IsEmpty());
  EXPECT_GT(result.contact_pairs, 0);
  EXPECT_GT(result.windows, 50);
  EXPECT_LT(result.windows, 15000);
}

TEST_P(Config, PlansWithoutAWarningUnderEveryStableProtocol) {
  Scene scene = load_scene(test::source_folder() + "/configs/" + GetParam() + ".toml");
  for (const ProtocolTraits& protocol : protocols()) {
    if (!protocol.warning.empty()) continue;
    scene.coupling.protocol = protocol;
    scene.participants = participants_of(scene, {});
    // The automatic rule makes implicit what the step is too long for, and modes bear any: nothing that all-explicit
    // could do with that step.
    const bool automatic = scene.partition.rule == PartitionRule::automatic && !protocol.local_steps;
    // These take the answer of the start for all windows (docs/protocols.md).
    const bool elastic_only = protocol.name == "belytschko_mullen" || protocol.name == "gravouil_combescure";
    const bool yields = std::ranges::any_of(scene.bodies, [](const Body& body) { return body.yields(); });
    if ((protocol.layout == Layout::all_explicit && (automatic || !scene.partition.reduced_modes.empty())) ||
        (yields && elastic_only)) {
      EXPECT_THROW(static_cast<void>(plan(build_problem(scene))), ConfigError);
      continue;
    }
    EXPECT_THAT(plan(build_problem(scene)).warnings, testing::IsEmpty()) << protocol.name;
  }
}

INSTANTIATE_TEST_SUITE_P(All, Config, testing::ValuesIn(configs()), [](const auto& config) { return config.param; });

/// The part of docs/scene.md under a table's heading ("## name"; the top level is "## Top level").
std::string section(const std::string& page, const std::string& table) {
  const std::string heading = "\n## " + (table == "scene" ? std::string("Top level") : table) + "\n";
  const std::size_t start = page.find(heading);
  if (start == std::string::npos) return "";
  return page.substr(start, page.find("\n## ", start + 1) - start);
}

TEST(SceneDocs, EveryKeyStandsInItsTable) {
  const std::string page = read(test::source_folder() + "/docs/scene.md");
  for (const auto& [table, keys] : scene_schema()) {
    const std::string text = section(page, table);
    for (const std::string& key : keys) EXPECT_THAT(text, testing::HasSubstr("\n| `" + key + "` |")) << table;
    EXPECT_EQ(std::ranges::count(text, '`') % 2, 0) << table;
    std::size_t rows = 0;
    for (std::size_t at = text.find("\n| `"); at != std::string::npos; at = text.find("\n| `", at + 1)) ++rows;
    EXPECT_EQ(rows, keys.size()) << "keys of " << table << " that do not exist";
  }
}

TEST(SceneDocs, TellsTheMaterialsOfTheLibrary) {
  const std::string text = section(read(test::source_folder() + "/docs/scene.md"), "Materials of the library");
  const auto mega = [](double stress_pa) {
    return std::isfinite(stress_pa) ? fmt::format("{:g} ", stress_pa / 1e6) : "";
  };
  for (const auto& [name, material, source] : material_library())
    EXPECT_THAT(text, testing::HasSubstr(fmt::format("\n| `{}` | {:g} | {:g} | {:g} | {}| {}| {} |\n", name,
                                                     material.youngs_modulus_pa / 1e9, material.poisson_ratio,
                                                     material.density_kg_m3, mega(material.yield_stress_pa),
                                                     mega(material.strength_pa), source)));
}

TEST(SceneDocs, EveryProtocolIsNamed) {
  const std::string text = section(read(test::source_folder() + "/docs/scene.md"), "coupling");
  for (const std::string& name : protocol_names()) EXPECT_THAT(text, testing::HasSubstr("`\"" + name + "\"`"));
}

}  // namespace
}  // namespace ricochet::scene

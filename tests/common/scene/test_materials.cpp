#include <gmock/gmock.h>

#include <limits>

#include "common/base/error.hpp"
#include "tests/common/scene/scene_text.hpp"

namespace ricochet::scene {
namespace {

using testing::AllOf;
using testing::HasSubstr;

const std::string steel_table = "{ youngs_modulus_pa = 207e9, poisson_ratio = 0.3, density_kg_m3 = 7860.0 }";

/// The cylinders, the first one of a material by its name.
std::string named(const std::string& name, const std::string& tables = "") {
  return replaced(cylinders, steel_table, "\"" + name + "\"") + tables;
}

std::string refusal(const std::string& text) {
  try {
    (void)load_text(text);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(NamedMaterial, IsSharedByBodies) {
  const std::string both =
      replaced(named("shared",
                     "[material.shared]\nyoungs_modulus_pa = 1e9\npoisson_ratio = 0.2\ndensity_kg_m3 = 1e3\n"
                     "yield_stress_pa = 1e6\n"),
               "{ youngs_modulus_pa = 626.8e9, poisson_ratio = 0.207, density_kg_m3 = 14900.0 }", "\"shared\"");
  for (const Body& body : load_text(both).bodies) {
    EXPECT_EQ(body.material.youngs_modulus_pa, 1e9) << body.name;
    EXPECT_EQ(body.material.poisson_ratio, 0.2) << body.name;
    EXPECT_EQ(body.material.density_kg_m3, 1e3) << body.name;
    EXPECT_EQ(body.material.yield_stress_pa, 1e6) << body.name;
  }
}

TEST(NamedMaterial, IsTheScenesBeforeTheLibrarys) {
  EXPECT_EQ(load_text(named("steel_a36")).bodies[0].material.density_kg_m3, 7850.0);
  const std::string own = "[material.steel_a36]\nyoungs_modulus_pa = 1e9\npoisson_ratio = 0.2\ndensity_kg_m3 = 1e3\n";
  EXPECT_EQ(load_text(named("steel_a36", own)).bodies[0].material.density_kg_m3, 1e3);
}

TEST(NamedMaterial, IsRefusedByNameAndLine) {
  EXPECT_THAT(refusal(named("stele_a36")), AllOf(HasSubstr(":4: body.steel.material: found \"stele_a36\""),
                                                 HasSubstr("did you mean \"steel_a36\"?")));
  const std::string own = "[material.mine]\nyoungs_modulus_pa = 1e9\npoisson_ratio = 0.2\ndensity_kg_m3 = -1\n";
  EXPECT_THAT(refusal(named("mine", own)), HasSubstr("material.mine.density_kg_m3: found -1"));
  EXPECT_THAT(refusal("material = 3\n" + cylinders),
              AllOf(HasSubstr(":1: material: found 3"), HasSubstr("[material.NAME]")));
  EXPECT_THAT(refusal(cylinders + "[material]\nmine = 3\n"), HasSubstr("material.mine: found 3; allowed: a table"));
}

TEST(Pressure, StandsInPlaceOfATraction) {
  const std::string velocity = "initial_velocity_m_s = [0.0, 30.0]\n", surface = "traction = [{ surface = \"start\"";
  const Scene scene = load_text(replaced(cylinders, velocity, velocity + surface + ", pressure_pa = 2e5 }]\n"));
  EXPECT_EQ(scene.bodies[0].tractions[0].pressure_pa, 2e5);
  EXPECT_THAT(scene.bodies[0].tractions[0].traction_pa, testing::ElementsAre(0.0, 0.0));
  EXPECT_THAT(
      refusal(replaced(cylinders, velocity, velocity + surface + ", pressure_pa = 1, traction_pa = [0, 1] }]\n")),
      AllOf(HasSubstr("traction[0].traction_pa"), HasSubstr("an entry has one of them")));
  EXPECT_THAT(refusal(replaced(cylinders, velocity, velocity + surface + " }]\n")),
              AllOf(HasSubstr("traction_pa: found nothing"), HasSubstr("or pressure_pa in their place")));
  const std::string of_bar = "initial_velocity_m_s = [5.13588]\n";
  EXPECT_THAT(refusal(replaced(bars, of_bar, of_bar + surface + ", pressure_pa = 1 }]\n")),
              AllOf(HasSubstr("traction[0].pressure_pa"), HasSubstr("of a bar, traction_pa")));
}

TEST(LengthUnit, BelongsToAGmshFile) {
  EXPECT_THAT(refusal(replaced(cylinders, "start_m = -0.02,", "length_unit = \"mm\", start_m = -0.02,")),
              AllOf(HasSubstr("body.steel.mesh.length_unit"), HasSubstr("lengths of a structured mesh are metres")));
}

}  // namespace
}  // namespace ricochet::scene

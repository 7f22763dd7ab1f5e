#include <gmock/gmock.h>

#include <filesystem>

#include "common/base/error.hpp"
#include "common/problem/problem.hpp"
#include "common/scene/variant.hpp"
#include "tests/common/scene/scene_text.hpp"
#include "tests/support/places.hpp"
#include "tests/support/scene_file.hpp"

namespace ricochet::scene {
namespace {

using testing::HasSubstr;
namespace fs = std::filesystem;

std::string config(const std::string& name) { return test::source_folder() + "/configs/" + name + ".toml"; }

class Variant : public testing::Test {
 protected:
  Scene load(const std::string& path, const std::vector<Override>& overrides) {
    const std::string out = (folder_.path() / "variant.toml").string();
    write_variant(path, overrides, out);
    return load_scene(out);
  }
  std::string refused(const std::vector<Override>& overrides) {
    try {
      load(config("two_bars"), overrides);
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "not refused";
  }
  test::TemporaryFolder folder_;
};

TEST_F(Variant, ChangesNumbersAndWordsAndNothingElse) {
  const Scene before = load_scene(config("two_bars"));
  const Scene after = load(config("two_bars"), {{"time.step_s", 1.0 / 3e6},
                                                {"body.right.material.youngs_modulus_pa", 7e10},
                                                {"partition.implicit_length_m.left", 0.1},
                                                {"coupling.protocol", "kim"}});
  EXPECT_EQ(after.time.step_s, 1.0 / 3e6) << "to the last bit";
  EXPECT_EQ(after.bodies[1].material.youngs_modulus_pa, 7e10);
  EXPECT_EQ(after.partition.implicit_length_m.at("left"), 0.1);
  EXPECT_EQ(after.coupling.protocol.name, "kim") << "in a table that the scene does not have";
  EXPECT_EQ(after.bodies[0].material.youngs_modulus_pa, before.bodies[0].material.youngs_modulus_pa);
  EXPECT_EQ(after.partition.implicit_length_m.at("right"), before.partition.implicit_length_m.at("right"));
  EXPECT_EQ(after.time.end_s, before.time.end_s);
  EXPECT_EQ(after.bodies[0].initial_velocity_m_s, before.bodies[0].initial_velocity_m_s);
}

template <class T>
T value_of(const std::string& argument) {
  return std::get<T>(parse_override(argument).value);
}

TEST(Override, IsReadFromAnArgument) {
  EXPECT_EQ(parse_override(" time.step_s = 2e-8").key, "time.step_s");
  EXPECT_EQ(value_of<double>("time.step_s=2e-8"), 2e-8);
  EXPECT_EQ(value_of<double>("coupling.substeps=4"), 4.0);
  EXPECT_EQ(value_of<std::string>("coupling.protocol=kim"), "kim") << "without quotes";
  EXPECT_EQ(value_of<std::string>("coupling.protocol=\"kim\""), "kim");
  EXPECT_EQ(value_of<bool>("body.a.mesh.periodic_across=true"), true);
  EXPECT_EQ(value_of<std::vector<double>>("body.a.mesh.elements=[4, 8]"), (std::vector<double>{4, 8}));
  EXPECT_EQ(value_of<std::vector<std::string>>("participant.a.bodies=[\"x\", \"y\"]"),
            (std::vector<std::string>{"x", "y"}));
}

TEST(Override, IsRefusedByTheArgument) {
  for (const auto& [argument, says] : {std::pair<std::string, std::string>{"time.step_s", "allowed: KEY=VALUE"},
                                       {"=3", "allowed: KEY=VALUE"},
                                       {"a.b=", "allowed: KEY=VALUE"},
                                       {"a.b=[1, \"x\"]", "--set a.b=[1, \"x\"]: found a list of several kinds"},
                                       {"a.b={c = 1}", "found a table"},
                                       {"a.b=2020-01-01", "found a date"}}) {
    try {
      (void)parse_override(argument);
      ADD_FAILURE() << argument;
    } catch (const ConfigError& error) {
      EXPECT_THAT(error.what(), HasSubstr(says));
    }
  }
}

TEST_F(Variant, FindsTheInterfaceNodesOfAForeignBody) {
  const auto nodes = folder_.write("-0.127\n", "nodes.csv");
  const auto text = replaced(joined_bars, "surface = \"start\"", "interface_nodes = \"nodes.csv\"");
  fs::create_directory(folder_.path() / "elsewhere");
  const std::string out = (folder_.path() / "elsewhere/variant.toml").string();
  write_variant(folder_.write(text, "joined.toml"), {{"body.tail.mass_kg", 0.5}}, out);
  const Scene after = load_scene(out);
  EXPECT_EQ(after.foreign_bodies.front().interface_nodes, nodes);
  EXPECT_EQ(after.foreign_bodies.front().mass_kg, 0.5);
}

TEST_F(Variant, ChangesOneOfSeveralContactsByItsName) {
  const auto text = replaced(cylinders, "[contact]\n",
                             "[[contact]]\nname = \"other\"\nsurfaces = [\"steel.start\", \"rigid_plane\"]\n"
                             "[[contact]]\nname = \"impact\"\n");
  const auto path = folder_.write(text, "two_contacts.toml");
  const Scene after = load(path, {{"contact.impact.friction_coefficient", 0.35}});
  EXPECT_EQ(after.contacts[0].friction_coefficient, load_scene(path).contacts[0].friction_coefficient);
  EXPECT_EQ(after.contacts[1].friction_coefficient, 0.35);
  try {
    (void)load(path, {{"contact.impct.friction_coefficient", 0.35}});
    ADD_FAILURE() << "there is none of that name";
  } catch (const ConfigError& error) {
    EXPECT_NE(std::string(error.what()).find("did you mean \"impact\"?"), std::string::npos) << error.what();
  }
}

TEST_F(Variant, ChangesLists) {
  const Scene after = load(config("kim_impact"), {{"body.steel.mesh.elements", std::vector<double>{4, 64}},
                                                  {"body.carbide.initial_velocity_m_s", std::vector<double>{0, -1.5}}});
  const auto& mesh = *after.bodies[0].structured();
  EXPECT_EQ(mesh.elements_across, 4);
  EXPECT_EQ(mesh.elements_along, 64);
  EXPECT_EQ(after.bodies[1].initial_velocity_m_s[1], -1.5);
}

TEST_F(Variant, OfEveryConfigBuildsTheSameProblem) {
  int configs = 0;
  for (const auto& entry : fs::directory_iterator(test::source_folder() + "/configs")) {
    if (entry.path().extension() != ".toml") continue;
    ++configs;
    const Problem before = build_problem(load_scene(entry.path().string()));
    const Problem after = build_problem(load(entry.path().string(), {}));
    EXPECT_EQ(after.clock.size_s(), before.clock.size_s()) << entry.path();
    ASSERT_EQ(after.bodies.size(), before.bodies.size());
    for (std::size_t b = 0; b < before.bodies.size(); ++b) {
      EXPECT_EQ(after.bodies[b].mesh.position, before.bodies[b].mesh.position) << entry.path();
      EXPECT_EQ(after.bodies[b].implicit_element, before.bodies[b].implicit_element) << entry.path();
    }
  }
  EXPECT_GE(configs, 6) << "one of them with a Gmsh mesh beside it";
}

TEST_F(Variant, CountsChangedPathsFromTheFolderOfTheScene) {
  const auto coarse = load_scene(config("rounded_striker"));
  const auto fine = load(config("rounded_striker"), {{"body.steel.mesh.gmsh", "rounded_striker_fine.msh"},
                                                     {"body.carbide.mesh.gmsh", "rounded_striker_fine.msh"}});
  EXPECT_GT(build_problem(fine).bodies[0].mesh.elements.size(),
            3 * build_problem(coarse).bodies[0].mesh.elements.size());
}

TEST_F(Variant, FindsAnAbaqusMeshThatItChanges) {
  const std::string mesh = "*NODE\n1, 0.\n2, 1.\n3, 2.\n*ELEMENT, TYPE=T3D2\n1, 1, 2\n";
  (void)folder_.write(mesh, "one.inp");
  (void)folder_.write(mesh + "2, 2, 3\n", "two.inp");
  const auto scene = folder_.write(
      "model = \"bar\"\n[[body]]\nname = \"rod\"\nmaterial = \"steel_a36\"\nmesh = { inp = \"one.inp\" }\n[time]\n"
      "end_s = 1.0\n[coupling]\nprotocol = \"all_explicit\"\n",
      "rod.toml");
  fs::create_directory(folder_.path() / "elsewhere");
  const std::string out = (folder_.path() / "elsewhere/variant.toml").string();
  write_variant(scene, {}, out);
  EXPECT_EQ(build_problem(load_scene(out)).bodies[0].mesh.elements.size(), 1U);
  write_variant(scene, {{"body.rod.mesh.inp", "two.inp"}}, out);
  EXPECT_EQ(build_problem(load_scene(out)).bodies[0].mesh.elements.size(), 2U);
}

TEST_F(Variant, PutsAStepInThePlaceOfASafetyFactor) {
  const std::string text =
      "model = \"bar\"\n[[body]]\nname = \"rod\"\nmaterial = { youngs_modulus_pa = 1e9, density_kg_m3 "
      "= 1e3 }\narea_m2 = 1e-4\nmesh = { length_m = 1.0, elements = 4 }\n[time]\nsafety_factor = "
      "0.8\nend_s = 1.0\n[coupling]\nprotocol = \"all_explicit\"\n";
  EXPECT_EQ(load(folder_.write(text), {{"time.step_s", 1e-5}, {"body.rod.mesh.elements", 7.0}}).time.step_s, 1e-5);
}

TEST_F(Variant, PutsAStepInThePlaceOfALargestOne) {
  const std::string automatic =
      replaced(bars, "implicit_length_m = { left = 0.0635, right = 0.0635 }", "rule = \"auto\"");
  const std::string text = replaced(automatic, "step_s", "largest_step_s");
  const std::string path = folder_.write(text);
  EXPECT_TRUE(load_scene(path).time.largest_step_s.has_value());
  const Scene changed = load(path, {{"time.step_s", 1e-6}});
  EXPECT_EQ(changed.time.step_s, 1e-6);
  EXPECT_FALSE(changed.time.largest_step_s.has_value());
}

TEST_F(Variant, RefusesKeysThatLeadNowhere) {
  EXPECT_THAT(refused({{"step_s", 1.0}}), HasSubstr("found the key \"step_s\", allowed: TABLE.KEY"));
  EXPECT_THAT(refused({{"body.lefft.area_m2", 1.0}}), HasSubstr("body.lefft.area_m2: found \"lefft\""));
  EXPECT_THAT(refused({{"body.lefft.area_m2", 1.0}}), HasSubstr("did you mean \"left\""));
  EXPECT_THAT(refused({{"time.step_s.more", 1.0}}), HasSubstr("\"step_s\" is no table"));
  EXPECT_THAT(refused({{"time.stepp_s", 1.0}}), HasSubstr("stepp_s")) << "by the loader";
  EXPECT_THROW(write_variant((folder_.path() / "none.toml").string(), {}, "x.toml"), ConfigError);
  EXPECT_THROW(write_variant(folder_.write("a = = 1"), {}, (folder_.path() / "x.toml").string()), ConfigError);
}

}  // namespace
}  // namespace ricochet::scene

#include <gmock/gmock.h>

#include <map>

#include "tests/support/run.hpp"

// One body over three participants that meet at a node: quadrants of a plate, two explicit, the other two implicit.

namespace ricochet::test {
namespace {

constexpr int half = 3;         // elements along a quadrant's edge
constexpr double edge_m = 0.1;  // of an element
constexpr double density_kg_m3 = 1000.0;

/// Square plate: quadrants "low" (explicit, at the origin), "high" (explicit, opposite) and "rest". With `strip` "rest"
/// is only the quadrant on the lower right, so that the other explicit elements touch without an implicit one between.
std::string plate_mesh(bool strip) {
  const int n = 2 * half;
  std::ostringstream text;
  text << "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n4\n2 1 \"plate\"\n2 2 \"low\"\n2 3 \"high\"\n2 4 "
          "\"rest\"\n"
       << "$EndPhysicalNames\n$Entities\n0 0 3 0\n";
  for (int group = 2; group <= 4; ++group) text << group << " 0 0 0 1 1 0 2 1 " << group << " 0\n";
  text << "$EndEntities\n$Nodes\n1 " << (n + 1) * (n + 1) << " 1 " << (n + 1) * (n + 1) << "\n2 2 0 "
       << (n + 1) * (n + 1) << "\n";
  for (int i = 1; i <= (n + 1) * (n + 1); ++i) text << i << "\n";
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) text << edge_m * i << " " << edge_m * j << " 0\n";
  std::map<int, std::vector<std::string>> elements;
  int number = 0;
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      const bool right = i >= half, top = j >= half;
      const int group = !right && !top ? 2 : right && top ? 3 : strip && !right ? 3 : 4;
      const int a = j * (n + 1) + i + 1, b = a + n + 1;
      std::ostringstream line;
      line << ++number << " " << a << " " << a + 1 << " " << b + 1 << " " << b << "\n";
      elements[group].push_back(line.str());
    }
  }
  text << "$EndNodes\n$Elements\n3 " << n * n << " 1 " << n * n << "\n";
  for (const auto& [group, lines] : elements) {
    text << "2 " << group << " 3 " << lines.size() << "\n";
    for (const auto& line : lines) text << line;
  }
  text << "$EndElements\n";
  return text.str();
}

std::string scene(const std::string& participants, const std::string& protocol) {
  return "model = \"plane_strain\"\n[[body]]\nname = \"plate\"\n"
         "material = { youngs_modulus_pa = 1e9, poisson_ratio = 0.25, density_kg_m3 = 1000.0 }\nmesh = { gmsh = "
         "\"plate.msh\" }\n"
         "initial_velocity_m_s = [3.0, -2.0]\ninitial_displacement_m = { start = [1e-3, 0.0], end = [-1e-3, 2e-3] }\n"
         "[partition]\nimplicit_groups = { plate = [\"rest\"] }\n[time]\nsafety_factor = 0.5\nend_s = 0.02\n"
         "[coupling]\nprotocol = \"" +
         protocol + "\"\n" + participants;
}

std::string explicit_one(const std::string& name, const std::string& groups) {
  return "[[participant]]\nname = \"" + name + "\"\nrole = \"explicit\"\nbodies = [\"plate\"]\n" +
         (groups.empty() ? "" : std::string("groups = ") + groups + "\n");
}
const std::string implicit_one = "[[participant]]\nname = \"middle\"\nrole = \"implicit\"\n";

class CornerNode : public testing::TestWithParam<const char*> {
 protected:
  CornerNode() { (void)folder_.write(plate_mesh(false), "plate.msh"); }
  TemporaryFolder folder_;
};

TEST_P(CornerNode, ThreePartitionsGiveWhatTwoGive) {
  const RunResult two = run_text(scene(explicit_one("outside", "") + implicit_one, GetParam()), folder_, "two");
  const RunResult three = run_text(
      scene(explicit_one("first", "[\"low\"]") + implicit_one + explicit_one("second", "[\"high\"]"), GetParam()),
      folder_, "three");
  EXPECT_EQ(three.summary.at("processes").size(), two.summary.at("processes").size() + 1);
  ASSERT_GT(two.column("time_s").size(), 300U);
  double strain = 0.0;
  for (const char* name :
       {"energy_kinetic_j", "energy_strain_j", "momentum_n_kg_m_s", "momentum_t_kg_m_s", "energy_interface_j"}) {
    const auto &a = two.column(name), &b = three.column(name);
    ASSERT_EQ(a.size(), b.size());
    const double scale = two.largest("energy_kinetic_j");
    for (std::size_t i = 0; i < a.size(); ++i) ASSERT_NEAR(a[i], b[i], 1e-11 * scale) << name << " " << i;
    if (std::string(name) == "energy_strain_j") strain = two.largest(name) / scale;
  }
  EXPECT_GT(strain, 0.1) << "it vibrates";
}

TEST_P(CornerNode, MassesAddUpAndMomentumIsKept) {
  const RunResult run = run_text(
      scene(explicit_one("first", "[\"low\"]") + implicit_one + explicit_one("second", "[\"high\"]"), GetParam()),
      folder_);
  const double mass_kg = density_kg_m3 * std::pow(2 * half * edge_m, 2);
  EXPECT_NEAR(run.column("momentum_n_kg_m_s").front(), -2.0 * mass_kg, 1e-9 * mass_kg)
      << "along the axis, the last coordinate";
  const bool exact = std::string(GetParam()) != "kim";
  EXPECT_LT(run.summary.at("momentum_error_max").get<double>(), exact ? 1e-11 : 1e-2);
}

INSTANTIATE_TEST_SUITE_P(Protocols, CornerNode, testing::Values("hughes_liu", "kim"),
                         [](const auto& test) { return std::string(test.param); });

struct Refusal {
  const char* name;
  bool strip;
  std::string participants;
  std::vector<const char*> parts;
};

class GroupsRefused : public testing::TestWithParam<Refusal> {};

TEST_P(GroupsRefused, BeforeAProcessStarts) {
  const Refusal& refusal = GetParam();
  const TemporaryFolder folder;
  (void)folder.write(plate_mesh(refusal.strip), "plate.msh");
  const std::string file = folder.write(scene(refusal.participants + implicit_one, "hughes_liu"));
  const Outcome outcome = run_command({ricochet_binary(), "check", file}, folder.path().string());
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.error, testing::HasSubstr("scene.toml:"));
  for (const char* part : refusal.parts) EXPECT_THAT(outcome.error, testing::HasSubstr(part));
}

INSTANTIATE_TEST_SUITE_P(
    Scenes, GroupsRefused,
    testing::Values(Refusal{"explicit_ones_meet_without_the_implicit_one",
                            true,
                            explicit_one("first", "[\"low\"]") + explicit_one("second", "[\"high\"]"),
                            {"participant.second", "(0, 0.3) m of body \"plate\" shared by \"first\" and \"second\"",
                             "belongs to no implicit participant; make its elements implicit"}},
                    Refusal{"unknown_group",
                            false,
                            explicit_one("first", "[\"lo\"]") + explicit_one("second", "[\"high\"]"),
                            {"participant.first.groups: found group \"lo\"", "did you mean \"low\"", "allowed: "}},
                    Refusal{"an_element_twice",
                            false,
                            explicit_one("first", "[\"low\"]") + explicit_one("second", "[\"low\", \"high\"]"),
                            {"participant.second.groups", "in the groups of \"first\", too", "each element in one"}},
                    Refusal{"elements_of_nobody",
                            false,
                            explicit_one("first", "[\"low\"]"),
                            {"found no explicit participant for the element at (0.3, 0.3) m of body \"plate\""}},
                    Refusal{"nothing_explicit_in_it",
                            false,
                            explicit_one("first", "[\"low\", \"high\"]") + explicit_one("second", "[\"rest\"]"),
                            {"participant.second: found no explicit element"}},
                    Refusal{"a_body_whole_and_in_groups",
                            false,
                            explicit_one("first", "[\"low\"]") + explicit_one("second", ""),
                            {"\"plate\", which \"first\" has already", "its element groups"}},
                    Refusal{"no_group",
                            false,
                            explicit_one("first", "[]") + explicit_one("second", "[\"high\"]"),
                            {"participant.first.groups: found an array of 0", "a non-empty array of texts"}}),
    [](const auto& test) { return std::string(test.param.name); });

TEST(Groups, OfAStructuredMeshAreRefused) {
  const TemporaryFolder folder;
  const std::string text = config_text("two_bars") +
                           "[[participant]]\nname = \"e\"\nrole = \"explicit\"\nbodies = [\"left\"]\n"
                           "groups = [\"tip\"]\n" +
                           implicit_one;
  const Outcome outcome = run_command({ricochet_binary(), "check", folder.write(text)}, folder.path().string());
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.error, testing::HasSubstr("read from a mesh file"));
}

TEST(Groups, OfTheImplicitParticipantAreRefused) {
  const TemporaryFolder folder;
  const std::string text =
      config_text("two_bars") + "[[participant]]\nname = \"i\"\nrole = \"implicit\"\ngroups = [\"tip\"]\n";
  const Outcome outcome = run_command({ricochet_binary(), "check", folder.write(text)}, folder.path().string());
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.error, testing::HasSubstr("the implicit participant owns all implicit elements"));
}

}  // namespace
}  // namespace ricochet::test

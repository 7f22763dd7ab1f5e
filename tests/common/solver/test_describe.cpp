#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>

#include "common/base/error.hpp"
#include "common/contact/contact_record.hpp"
#include "common/solver/describe.hpp"
#include "tests/support/rods.hpp"

namespace ricochet::solver {
namespace {

using testing::ElementsAre;

participant::Description described(const test::SceneStates& scene, bool contact_owner) {
  return describe(scene.problem, scene.participant, scene.states, contact_owner);
}

// The rods touch at x = 0 and the element of each beside it is implicit: 1 kg of the node at -1 and 1 m is of either
// participant.
TEST(Describe, NamesTheInterfaceBodyByBodyWithPlacesAndOwnMasses) {
  for (const char* name : {"explicit", "implicit"}) {
    const test::SceneStates scene(test::two_rods("hughes_liu"), name);
    const auto d = described(scene, false);
    EXPECT_EQ(d.name, name);
    EXPECT_EQ(d.role, scene.participant.role);
    EXPECT_EQ(d.scene_sha256, scene.problem.scene.sha256);
    EXPECT_EQ(d.components, 1);
    EXPECT_THAT(d.bodies, ElementsAre("left", "right"));
    EXPECT_THAT(d.interface_body, ElementsAre(0, 1)) << name;
    EXPECT_THAT(d.interface_position_m, ElementsAre(-1.0, 1.0)) << name;
    EXPECT_THAT(d.interface_mass_kg, ElementsAre(1.0, 1.0)) << name;
  }
}

TEST(Describe, HasAColumnForEveryNumberOfARow) {
  test::SceneStates scene(test::two_rods("all_explicit"));
  for (std::size_t b = 0; b < 2; ++b) scene.states[b].totals.energy_strain_j = 5.0 + static_cast<double>(b);
  const auto d = described(scene, false);
  std::vector<double> row;
  record_bodies(scene.states, row);
  ASSERT_EQ(d.record_columns.size(), row.size());
  for (const auto& [column, value] :
       {std::pair{"mass_kg/left", 8.0}, {"energy_strain_j/left", 5.0}, {"energy_strain_j/right", 6.0}}) {
    const auto at = std::find(d.record_columns.begin(), d.record_columns.end(), column) - d.record_columns.begin();
    ASSERT_LT(static_cast<std::size_t>(at), row.size()) << column;
    EXPECT_EQ(row[static_cast<std::size_t>(at)], value) << column;
  }
}

TEST(Describe, OfTheContactsOwnerHasItsColumnsAfterThoseOfTheBodies) {
  const test::SceneStates scene(test::two_rods("all_explicit"));
  const auto other = described(scene, false), owner = described(scene, true);
  EXPECT_FALSE(other.contact_owner);
  EXPECT_TRUE(owner.contact_owner);
  auto expected = other.record_columns;
  for (const auto& quantity : contact_quantities) expected.emplace_back(quantity.first);
  EXPECT_EQ(owner.record_columns, expected);
}

TEST(Describe, OfSeveralContactsHasColumnsOfEachByName) {
  const std::string rods = test::two_rods("all_explicit");
  const test::SceneStates one(rods);
  const auto again = "[[contact]]\nname = \"again\"\nsurfaces = [\"right.end\", \"rigid_plane\"]\n[time]";
  const auto several =
      test::replaced(test::replaced(rods, "[contact]", "[[contact]]\nname = \"touch\""), "[time]", again);
  auto expected = described(one, true).record_columns;
  for (const char* contact : {"touch", "again"}) {
    for (const auto& quantity : named_contact_quantities)
      expected.push_back(std::string(quantity.first) + "/" + contact);
  }
  EXPECT_EQ(described(test::SceneStates(several), true).record_columns, expected);
}

// Two masses of 1 kg on a spring of 8 N/m swing against each other at omega = 4 rad/s.
TEST(Describe, TellsTheCriticalStepOfItsElements) {
  const test::SceneStates scene(test::rod(1));
  EXPECT_NEAR(described(scene, false).critical_time_step_s, 2.0 / 4.0, 1e-6);
}

double declared(const test::SceneStates& scene, double told_s) {
  return describe(scene.problem, scene.participant, scene.states, false, told_s).critical_time_step_s;
}

TEST(Describe, DeclaresTheCriticalStepThatItWasTold) {
  const test::SceneStates scene(test::rod(1));
  EXPECT_EQ(declared(scene, 0.5), 0.5);
  EXPECT_EQ(declared(scene, 0.3), 0.3) << "it was not found anew";
}

// Two masses of 1 kg on a spring of 8 N/m stand no more than 0.5 s.
TEST(Describe, RefusesACriticalStepThatItsElementsDoNotHave) {
  const test::SceneStates scene(test::rod(1));
  for (const double told_s : {0.51, 1e3, 0.0}) {
    try {
      ADD_FAILURE() << declared(scene, told_s);
    } catch (const ConfigError& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr("participant 'explicit' was told the critical time step"));
      EXPECT_THAT(error.what(), testing::HasSubstr("its elements of body 'rod' have at most 0.5 s"));
    }
  }
}

/// Several participants of one body keep one critical step, that of all elements that are explicit.
TEST(Describe, TakesTheCriticalStepOfElementsOfWhichSomeAreAnotherParticipants) {
  const std::string rods = test::two_rods("hughes_liu") +
                           "[[participant]]\nname = \"left\"\nrole = \"explicit\"\nbodies = [\"left\"]\n"
                           "[[participant]]\nname = \"right\"\nrole = \"explicit\"\nbodies = [\"right\"]\n"
                           "[[participant]]\nname = \"implicit\"\nrole = \"implicit\"\n";
  const test::SceneStates scene(rods, "left");
  const double critical_s = described(scene, false).critical_time_step_s;
  EXPECT_EQ(declared(scene, critical_s), critical_s);
  EXPECT_THROW(static_cast<void>(declared(scene, 1.2 * critical_s)), ConfigError);
}

TEST(Describe, OfAnImplicitParticipantNeedsNoCriticalStep) {
  const test::SceneStates scene(test::two_rods("hughes_liu"), "implicit");
  EXPECT_GT(described(scene, false).critical_time_step_s, 0.0);
  EXPECT_EQ(declared(scene, 0.0), 0.0);
}

TEST(InterfaceMass, IsTakenNodeByNodeInTheOrderOfTheInterface) {
  test::SceneStates scene(test::two_rods("hughes_liu"), "implicit");
  take_interface_mass({5.0, 7.0}, scene.states);
  const auto& left = scene.states[0];
  const auto& right = scene.states[1];
  EXPECT_EQ(left.mass[left.shared_dofs.at(0)], 5.0);
  EXPECT_EQ(right.mass[right.shared_dofs.at(0)], 7.0);
  EXPECT_EQ(left.totals.mass_kg, 6.0) << "with the contact node's 1 kg";
  EXPECT_EQ(right.totals.mass_kg, 8.0);
}

TEST(Fields, AreOneFilePerBodyAndWindow) {
  const test::SceneStates scene(test::two_rods("all_explicit"));
  const test::TemporaryFolder folder;
  write_fields(folder.path().string(), "outside", 12, scene.states, {}, false);
  for (const auto& state : scene.states)
    EXPECT_TRUE(std::filesystem::exists(folder.path() / ("outside." + state.name + "_00000012.vtu")));
}

}  // namespace
}  // namespace ricochet::solver

#include <gmock/gmock.h>

#include "common/base/error.hpp"
#include "common/base/sha256.hpp"
#include "common/scene/toml_file.hpp"
#include "tests/common/scene/scene_text.hpp"

namespace ricochet::scene {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

/// Every key that goes together in one axisymmetric scene.
const std::string full = R"(model = "axisymmetric"
[[body]]
name = "steel"
material = { youngs_modulus_pa = 207e9, poisson_ratio = 0.3, density_kg_m3 = 7860 }
mesh = { start_m = -0.02, length_m = 0.02, radius_m = 0.004, elements = [4, 8], grading = [0.5, 2.0] }
initial_velocity_m_s = [0.0, 30]
initial_displacement_m = { start = [0.0, 1e-6], end = [0.0, 2e-6] }
gravity_m_s2 = [0.0, -9.81]
support = [{ surface = "outer", fixed = ["r"] }, { surface = "start", fixed = ["r", "z"] }]
traction = [{ surface = "start", traction_pa = [0.0, 1e6], amplitude = { time_s = [0.0, 1e-5], factor = [0.0, 1.0] } }]
[[body.prescribed]]
surface = "end"
component = "z"
displacement_m = 1e-4
amplitude = { time_s = [0.0], factor = [0.5] }
[[body]]
name = "carbide"
material = { youngs_modulus_pa = 626.8e9, poisson_ratio = 0.207, density_kg_m3 = 14900.0 }
mesh = { length_m = 0.02, radius_m = 0.004, elements = [4, 8] }
[contact]
surfaces = ["steel.end", "carbide.start"]
initial_gap_m = 1e-6
nose_radius_m = 0.01
enforcement = "penalty"
penalty_pa_m = 1e16
impact_update = "impedance"
friction_coefficient = 0.2
friction_law = "regularised"
friction_regularisation_s_m = 0.5
[partition]
implicit_length_m = { steel = 0.010, carbide = 0 }
[time]
step_s = 5.4e-8
changes = [{ from_s = 10e-6, step_s = 1e-8 }, { from_s = 20e-6, step_s = 5.4e-8 }]
end_s = 60e-6
until_separated_plus_s = 10e-6
[coupling]
protocol = "kim"
resynchronise_every = 0
after_separation = "implicit"
separation_windows = 7
timeout_s = 5
start_timeout_s = 50
transport = "tcp"
address = "0.0.0.0"
port = 5555
energy_growth_limit = 0.01
energy_loss_limit = 0.5
[[participant]]
name = "front"
role = "explicit"
bodies = ["steel"]
executable = "bin/my_solver"
differing_bodies = ["steel"]
start = "by_hand"
[[participant]]
name = "back"
role = "explicit"
bodies = ["carbide"]
executable = "my_solver"
[[participant]]
name = "contact"
role = "implicit"
launch = ["srun", "-n", "1", "--exact"]
threads = 12
[output]
history_every = 2
fields_every = 50
axial_stress_every = 5
)";

// The parser would look at the last element of none.
TEST(LoadScene, AKeyOfAnArrayWithoutElementsIsRefused) {
  for (const std::string keys : {"t = []\nt.x = 1\n", "[t]\nu = []\n[t.u.v]\nx = 1\n"}) {
    try {
      (void)parse_toml("scene.toml", keys);
      ADD_FAILURE() << keys;
    } catch (const ConfigError& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr("a key of an array without elements"));
    }
  }
}

// Whether there is such a file cannot even be asked; that is no fault of the program.
TEST(LoadScene, ANameThatNoFileCanHaveIsNoSceneFile) {
  EXPECT_THROW((void)load_scene(std::string(300, 'n')), ConfigError);
}

TEST(LoadScene, BodyFieldByField) {
  const Scene scene = load_text(full);
  ASSERT_EQ(scene.bodies.size(), 2U);
  EXPECT_EQ(scene.model, Model::axisymmetric);
  EXPECT_EQ(scene.components(), 2);
  const Body& steel = scene.body("steel");
  EXPECT_EQ(steel.material.youngs_modulus_pa, 207e9);
  EXPECT_EQ(steel.material.poisson_ratio, 0.3);
  EXPECT_EQ(steel.material.density_kg_m3, 7860.0);
  EXPECT_TRUE(std::isinf(steel.material.yield_stress_pa));
  EXPECT_TRUE(std::isinf(steel.material.strength_pa));
  const auto& mesh = *steel.structured();
  EXPECT_EQ(mesh.start_m, -0.02);
  EXPECT_EQ(mesh.length_m, 0.02);
  EXPECT_EQ(mesh.across_m, 0.004);
  EXPECT_EQ(mesh.elements_across, 4);
  EXPECT_EQ(mesh.elements_along, 8);
  EXPECT_EQ(mesh.grading_across, 0.5);
  EXPECT_EQ(mesh.grading_along, 2.0);
  EXPECT_FALSE(mesh.periodic_across);
  EXPECT_THAT(steel.initial_velocity_m_s, ElementsAre(0.0, 30.0));
  EXPECT_THAT(steel.initial_displacement_start_m, ElementsAre(0.0, 1e-6));
  EXPECT_THAT(steel.initial_displacement_end_m, ElementsAre(0.0, 2e-6));
  EXPECT_THAT(steel.gravity_m_s2, ElementsAre(0.0, -9.81));
}

TEST(LoadScene, ASolidWithARadiusIsACylinder) {
  const Scene scene = load_text(replaced(blocks, "height_m = 0.2, width_m = 0.3, elements = [2, 3, 6] }\n[[body]]",
                                         "radius_m = 0.1, elements = [5, 6], grading = [2.0, 3.0] }\n[[body]]"));
  const auto& mesh = *scene.bodies[0].structured();
  EXPECT_TRUE(mesh.cylinder);
  EXPECT_EQ(mesh.across_m, 0.1);
  EXPECT_EQ(mesh.elements_across, 5);
  EXPECT_EQ(mesh.elements_along, 6);
  EXPECT_EQ(mesh.grading_across, 2.0);
  EXPECT_EQ(mesh.grading_along, 3.0);
  EXPECT_EQ(mesh.elements_in_layer(), 84.0) << "a core of 6 x 6 and 2 rings of 24";
  EXPECT_EQ(mesh.nodes_in_layer(), 97.0);
  const auto& block = *scene.bodies[1].structured();
  EXPECT_FALSE(block.cylinder);
  EXPECT_EQ(block.elements_in_layer(), 6.0);
  EXPECT_EQ(block.nodes_in_layer(), 12.0);
}

TEST(LoadScene, RigidObstacles) {
  const std::string one = replaced(blocks, ", upper = 0.05", "");
  const Contact plane = load_text(replaced(one, "\"upper.start\"", "\"rigid_plane\"")).contacts.front();
  EXPECT_FALSE(plane.second);
  EXPECT_EQ(plane.obstacle, Obstacle::plane);
  const Contact sphere =
      load_text(replaced(one, "\"upper.start\"]", "\"rigid_sphere\"]\nrigid_radius_m = 0.3")).contacts.front();
  EXPECT_FALSE(sphere.second);
  EXPECT_EQ(sphere.obstacle, Obstacle::sphere);
  EXPECT_EQ(sphere.rigid_radius_m, 0.3);
  EXPECT_TRUE(sphere.rigid_place_m.empty());
  const Contact cylinder =
      load_text(
          replaced(one, "\"upper.start\"]",
                   "\"rigid_cylinder\"]\nrigid_radius_m = 0.3\nrigid_axis = \"y\"\nrigid_place_m = [0.1, 0.2, 0.3]"))
          .contacts.front();
  EXPECT_EQ(cylinder.obstacle, Obstacle::cylinder);
  EXPECT_EQ(cylinder.rigid_axis, 1);
  EXPECT_THAT(cylinder.rigid_place_m, ElementsAre(0.1, 0.2, 0.3));
}

TEST(LoadScene, SupportsAndLoadsFieldByField) {
  const Scene scene = load_text(full);
  const Body& steel = scene.body("steel");
  ASSERT_EQ(steel.supports.size(), 2U);
  EXPECT_EQ(steel.supports[0].surface, "outer");
  EXPECT_THAT(steel.supports[0].components, ElementsAre(0));
  EXPECT_THAT(steel.supports[1].components, ElementsAre(0, 1));
  ASSERT_EQ(steel.tractions.size(), 1U);
  EXPECT_EQ(steel.tractions[0].surface, "start");
  EXPECT_THAT(steel.tractions[0].traction_pa, ElementsAre(0.0, 1e6));
  EXPECT_THAT(steel.tractions[0].amplitude.time_s, ElementsAre(0.0, 1e-5));
  EXPECT_THAT(steel.tractions[0].amplitude.factor, ElementsAre(0.0, 1.0));
  ASSERT_EQ(steel.prescribed.size(), 1U);
  EXPECT_EQ(steel.prescribed[0].surface, "end");
  EXPECT_EQ(steel.prescribed[0].component, 1);
  EXPECT_EQ(steel.prescribed[0].displacement_m, 1e-4);
  EXPECT_THAT(steel.prescribed[0].amplitude.factor, ElementsAre(0.5));
}

TEST(LoadScene, ContactFieldByField) {
  const Contact contact = load_text(full).contacts.at(0);
  EXPECT_EQ(contact.first.body, "steel");
  EXPECT_EQ(contact.first.surface, "end");
  EXPECT_EQ(contact.second->body, "carbide");
  EXPECT_EQ(contact.second->surface, "start");
  EXPECT_EQ(contact.initial_gap_m, 1e-6);
  EXPECT_EQ(contact.nose_radius_m, 0.01);
  EXPECT_EQ(contact.enforcement, Enforcement::penalty);
  EXPECT_EQ(contact.penalty_pa_m, 1e16);
  EXPECT_EQ(contact.impact_update, ImpactUpdate::impedance);
  EXPECT_EQ(contact.friction_coefficient, 0.2);
  EXPECT_EQ(contact.friction_law, FrictionLaw::regularised);
  EXPECT_EQ(contact.friction_regularisation_s_m, 0.5);
}

TEST(LoadScene, EachOfSeveralContactsHasItsOwnFrictionCoefficient) {
  const auto further = [](const std::string& name, const std::string& keys) {
    return "[[contact]]\nname = \"" + name + "\"\nsurfaces = [\"steel.start\", \"rigid_plane\"]\n" + keys;
  };
  const std::string text =
      replaced(replaced(full, "[contact]\n", "[[contact]]\nname = \"first\"\n"), "[partition]",
               further("second", "friction_coefficient = 0.5\n") + further("none", "friction_coefficient = 0\n") +
                   further("as_first", "") + "[partition]");
  const Scene scene = load_text(text);
  ASSERT_EQ(scene.contacts.size(), 4U);
  EXPECT_EQ(scene.contacts[0].friction_coefficient, 0.2);
  EXPECT_EQ(scene.contacts[1].friction_coefficient, 0.5);
  EXPECT_EQ(scene.contacts[2].friction_coefficient, 0.0);
  EXPECT_EQ(scene.contacts[3].friction_coefficient, 0.2) << "left out, it is that of the first";
  EXPECT_EQ(scene.contacts[1].friction_law, FrictionLaw::regularised) << "which is the same in all";
  EXPECT_TRUE(scene.friction());
  EXPECT_EQ(scene.contact_names(), (std::vector<std::string>{"first", "second", "none", "as_first"}));
  EXPECT_TRUE(load_text(full).contact_names().empty()) << "there is but one";
}

TEST(LoadScene, PartitionTimeCouplingAndOutputFieldByField) {
  const Scene scene = load_text(full);
  EXPECT_EQ(scene.partition.rule, PartitionRule::implicit_length);
  EXPECT_EQ(scene.partition.implicit_length_m.at("steel"), 0.010);
  EXPECT_EQ(scene.partition.implicit_length_m.at("carbide"), 0.0);
  EXPECT_EQ(scene.time.step_s, 5.4e-8);
  ASSERT_EQ(scene.time.changes.size(), 2U);
  EXPECT_EQ(scene.time.changes[0].from_s, 10e-6);
  EXPECT_EQ(scene.time.changes[0].step_s, 1e-8);
  EXPECT_EQ(scene.time.changes[1].from_s, 20e-6);
  EXPECT_EQ(scene.time.end_s, 60e-6);
  EXPECT_EQ(scene.time.until_separated_plus_s, 10e-6);
  EXPECT_EQ(scene.coupling.protocol.name, "kim");
  EXPECT_EQ(scene.coupling.resynchronise_every, 0);
  EXPECT_EQ(scene.coupling.after_separation, AfterSeparation::stay_implicit);
  EXPECT_EQ(scene.coupling.separation_windows, 7);
  EXPECT_EQ(scene.coupling.timeout_s, 5.0);
  EXPECT_EQ(scene.coupling.start_timeout_s, 50.0);
  EXPECT_EQ(scene.coupling.transport, Transport::tcp);
  EXPECT_EQ(scene.coupling.address, "0.0.0.0");
  EXPECT_EQ(scene.coupling.port, 5555);
  EXPECT_EQ(scene.coupling.energy_growth_limit, 0.01);
  EXPECT_EQ(scene.coupling.energy_loss_limit, 0.5);
  EXPECT_EQ(scene.output.history_every, 2);
  EXPECT_EQ(scene.output.fields_every, 50);
  EXPECT_EQ(scene.output.axial_stress_every, 5);
}

TEST(LoadScene, ParticipantsFieldByField) {
  const SceneFolder folder;
  const std::string path = folder.write(full);
  const Scene scene = load_scene(path);
  ASSERT_EQ(scene.participants.size(), 3U);
  const ParticipantSpec& front = scene.participant("front");
  EXPECT_EQ(front.role, Role::explicit_solver);
  EXPECT_THAT(front.bodies, ElementsAre("steel"));
  EXPECT_EQ(front.executable, path.substr(0, path.rfind('/')) + "/bin/my_solver");
  EXPECT_EQ(front.start, Start::by_hand);
  EXPECT_THAT(front.differing_bodies, ElementsAre("steel"));
  EXPECT_TRUE(front.foreign());
  EXPECT_EQ(scene.participant("back").executable, "my_solver");
  EXPECT_EQ(scene.participant("back").start, Start::launch);
  EXPECT_EQ(scene.participant("contact").role, Role::implicit_solver);
  EXPECT_THAT(scene.participant("contact").launch, ElementsAre("srun", "-n", "1", "--exact"));
  EXPECT_EQ(scene.participant("contact").threads, 12);
  EXPECT_FALSE(scene.participant("front").threads.has_value());
  EXPECT_THROW((void)scene.participant("contacts"), ConfigError);
}

TEST(LoadScene, ForeignBodiesFieldByField) {
  const Scene scene = load_text(joined_bars);
  ASSERT_EQ(scene.foreign_bodies.size(), 1U);
  const ForeignBody& tail = scene.foreign_bodies.front();
  EXPECT_EQ(tail.name, "tail");
  EXPECT_EQ(tail.joined_to, "left");
  EXPECT_EQ(tail.surface, "start");
  EXPECT_TRUE(tail.interface_nodes.empty());
  EXPECT_EQ(tail.mass_kg, 0.64);
  EXPECT_EQ(scene.bodies.size(), 2U);
  EXPECT_THAT(scene.body_names(), ElementsAre("left", "right", "tail")) << "meshed ones first";
  EXPECT_TRUE(scene.is_foreign("tail"));
  EXPECT_FALSE(scene.is_foreign("left"));
  EXPECT_THAT(scene.participant("far").bodies, ElementsAre("tail"));
  EXPECT_EQ(scene.lines.at("body.tail.joined_to"), 5);
  EXPECT_FALSE(load_text(replaced(joined_bars, "mass_kg = 0.64\n", "")).foreign_bodies.front().mass_kg.has_value());
  EXPECT_TRUE(load_text(replaced(bars, "name = \"left\"", "name = \"left\"\nforeign = false")).foreign_bodies.empty());
}

TEST(LoadScene, InterfaceNodesComeFromAFileBesideTheScene) {
  const SceneFolder folder;
  const std::string text = replaced(joined_bars, "surface = \"start\"", "interface_nodes = \"nodes.csv\"");
  const std::string file = folder.write("# x [m]\n\n -0.127 \r\n", "nodes.csv");
  const Scene scene = load_scene(folder.write(text));
  const ForeignBody& tail = scene.foreign_bodies.front();
  EXPECT_EQ(tail.interface_nodes, file);
  EXPECT_THAT(tail.interface_position_m, ElementsAre(-0.127));
  EXPECT_TRUE(tail.surface.empty());
  folder.write("-0.127", "nodes.csv");
  EXPECT_NE(load_scene(scene.path).sha256, scene.sha256) << "it is a part of the scene";
}

TEST(LoadScene, RefusesAFileOfInterfaceNodesByItsLine) {
  const SceneFolder folder;
  const std::string scene =
      folder.write(replaced(joined_bars, "surface = \"start\"", "interface_nodes = \"nodes.csv\""));
  const auto refused = [&](const std::string& nodes) -> std::string {
    folder.write(nodes, "nodes.csv");
    try {
      (void)load_scene(scene);
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "accepted";
  };
  for (const std::string row : {"x", "-0.127, 0", "nan", "1e999", "-0.127,", "0x1"}) {
    const std::string said = refused("# x [m]\n" + row + "\n");
    EXPECT_THAT(said, HasSubstr("nodes.csv:2: found \"" + row + "\"; allowed: x [m] of one node, finite")) << row;
  }
  EXPECT_THAT(refused("# x [m]\n"), HasSubstr("nodes.csv:1: found no node; allowed: a row for each node with its x"));
}

TEST(LoadScene, UnderSlurmParticipantsMayBeOnAnyMachine) {
  const std::string coupling = cylinders.substr(0, cylinders.find("[coupling]")) + "[coupling]\nlauncher = \"slurm\"\n";
  const CouplingSettings slurm = load_text(coupling).coupling;
  EXPECT_EQ(slurm.launcher, LaunchedBy::slurm);
  EXPECT_EQ(slurm.transport, Transport::tcp);
  EXPECT_EQ(slurm.address, "0.0.0.0");
  EXPECT_EQ(load_text(coupling + "address = \"10.0.0.1\"\n").coupling.address, "10.0.0.1");
}

TEST(LoadScene, DefaultsStandInTheStructs) {
  const Scene scene = load_text(cylinders.substr(0, cylinders.find("[coupling]")));
  const CouplingSettings defaults;
  EXPECT_EQ(scene.coupling.protocol.name, "hughes_liu");
  EXPECT_EQ(scene.coupling.resynchronise_every, defaults.resynchronise_every);
  EXPECT_EQ(scene.coupling.transport, Transport::automatic);
  EXPECT_EQ(scene.output.history_every, 1);
  EXPECT_EQ(scene.output.axial_stress_every, 0);
  EXPECT_EQ(scene.contacts.front().enforcement, Enforcement::multiplier);
  EXPECT_EQ(scene.contacts.front().multiplier_update, Contact{}.multiplier_update);
  EXPECT_THAT(scene.body("carbide").initial_velocity_m_s, ElementsAre(0.0, 0.0));
  EXPECT_FALSE(scene.time.until_separated_plus_s.has_value());
}

TEST(LoadScene, AMaterialMayHaveLimits) {
  const Scene scene = load_text(
      replaced(full, "density_kg_m3 = 7860", "density_kg_m3 = 7860, yield_stress_pa = 4e8, strength_pa = 9e8"));
  EXPECT_EQ(scene.body("steel").material.yield_stress_pa, 4e8);
  EXPECT_EQ(scene.body("steel").material.strength_pa, 9e8);
  EXPECT_TRUE(std::isinf(scene.body("carbide").material.yield_stress_pa));
}

TEST(LoadScene, ABarMayYield) {
  EXPECT_FALSE(load_text(bars).body("left").material.plasticity.has_value());
  for (const double hardening : {0.0, 1e9}) {
    const std::string more = hardening > 0.0 ? ", hardening_pa = 1e9" : "";
    const Scene yields =
        load_text(replaced(bars, "density_kg_m3 = 7844.066",
                           "density_kg_m3 = 7844.066, plasticity = { yield_stress_pa = 4e8" + more + " }"));
    EXPECT_EQ(yields.body("left").material.plasticity->yield_stress_pa, 4e8);
    EXPECT_EQ(yields.body("left").material.plasticity->hardening_pa, hardening);
    EXPECT_EQ(yields.body("left").material.plasticity->hardening_exponent, 1.0);
    EXPECT_FALSE(yields.body("left").material.plasticity->heat.has_value());
  }
  const Scene heats = load_text(replaced(
      bars, "density_kg_m3 = 7844.066",
      "density_kg_m3 = 7844.066, plasticity = { yield_stress_pa = 4e8, hardening_pa = 5e8, hardening_exponent = 0.26, "
      "rate_factor = 0.014, reference_rate_per_s = 2.0, heat = { specific_heat_j_kg_k = 100.0, work_fraction = 0.8, "
      "reference_k = 300.0, melting_k = 1800.0, softening_exponent = 1.03 } }"));
  const fem::Plasticity& law = *heats.body("left").material.plasticity;
  EXPECT_EQ(law.hardening_exponent, 0.26);
  EXPECT_EQ(law.rate_factor, 0.014);
  EXPECT_EQ(law.reference_rate_per_s, 2.0);
  EXPECT_EQ(law.heat->capacity_j_m3_k, 784406.6);
  EXPECT_EQ(law.heat->fraction, 0.8);
  EXPECT_EQ(law.heat->reference_k, 300.0);
  EXPECT_EQ(law.heat->melting_k, 1800.0);
  EXPECT_EQ(law.heat->exponent, 1.03);
}

TEST(LoadScene, BarsNeedNoPoissonRatioAndOneNumberPerVector) {
  const Scene scene = load_text(replaced(bars, "elements = 20", "elements = 20, grading = 3.0"));
  EXPECT_EQ(scene.components(), 1);
  EXPECT_EQ(scene.body("left").material.poisson_ratio, 0.0);
  EXPECT_EQ(scene.body("left").area_m2, 6.4516e-4);
  EXPECT_EQ(scene.body("left").structured()->grading_along, 3.0);
  EXPECT_THAT(scene.body("left").initial_velocity_m_s, ElementsAre(5.13588));
}

TEST(LoadScene, RigidPlaneIsAContactWithoutSecondSurface) {
  const Scene scene = load_text(replaced(replaced(bars, "\"right.start\"", "\"rigid_plane\""), ", right = 0.0635", ""));
  EXPECT_EQ(scene.contacts.front().first.surface, "end");
  EXPECT_FALSE(scene.contacts.front().second.has_value());
}

TEST(LoadScene, HashIsOfTheText) {
  EXPECT_EQ(load_text(bars).sha256, sha256_hex(bars));
  EXPECT_NE(load_text(bars).sha256, load_text(bars + "\n").sha256);
}

TEST(LoadScene, KnowsTheLineOfEachKey) {
  const Scene scene = load_text(cylinders);
  EXPECT_EQ(scene.lines.at("body.steel.mesh.length_m"), 5);
  EXPECT_EQ(scene.lines.at("contact.surfaces"), 12);
  EXPECT_THAT(scene.where("contact.surfaces[1]"), HasSubstr("scene.toml:12: contact.surfaces[1]"));
  EXPECT_THAT(scene.where("participant.explicit"), HasSubstr("participant.explicit"));
}

TEST(LoadScene, RefusesAMissingAndAnEmptyFile) {
  const SceneFolder folder;
  const std::string comment = folder.write("# nothing\n"), empty = folder.write("", "empty.toml");
  for (const std::string& path : {std::string("/nowhere/scene.toml"), comment, empty}) {
    try {
      (void)load_scene(path);
      FAIL() << path;
    } catch (const ConfigError& error) {
      EXPECT_THAT(error.what(), HasSubstr(path));
      EXPECT_EQ(error.code(), ExitCode::config);
    }
  }
}

std::vector<std::string> names(const Scene& scene) {
  std::vector<std::string> result;
  for (const ParticipantSpec& participant : scene.participants) result.push_back(participant.name);
  return result;
}

TEST(DefaultParticipants, FollowTheProtocol) {
  EXPECT_THAT(names(load_text(cylinders)), ElementsAre("explicit", "implicit"));
  EXPECT_THAT(load_text(cylinders).participant("explicit").bodies, ElementsAre("steel", "carbide"));
  EXPECT_THAT(names(load_text(replaced(cylinders, "hughes_liu", "all_implicit"))), ElementsAre("implicit"));
  const Scene all_explicit = load_text(replaced(cylinders, "hughes_liu", "all_explicit"));
  EXPECT_THAT(names(all_explicit), ElementsAre("explicit"));
  EXPECT_THAT(all_explicit.participants[0].bodies, ElementsAre("steel", "carbide"));
}

TEST(GivenParticipants, ABaselineTakesTheOneOfItsRole) {
  const std::string no_update = replaced(full, "impact_update = \"impedance\"\n", "");
  const Scene all_explicit = load_text(replaced(no_update, "\"kim\"", "\"all_explicit\""));
  EXPECT_THAT(names(all_explicit), ElementsAre("explicit"));
  EXPECT_THAT(all_explicit.participants[0].bodies, ElementsAre("steel", "carbide"));
  EXPECT_THAT(all_explicit.participants[0].executable, HasSubstr("bin/my_solver"));
  EXPECT_THAT(names(load_text(replaced(full, "\"kim\"", "\"all_implicit\""))), ElementsAre("contact"));
}

TEST(Amplitude, IsLinearBetweenAndConstantOutside) {
  const Amplitude ramp{{1.0, 2.0, 4.0}, {0.0, 1.0, -1.0}};
  EXPECT_EQ(ramp.at(0.0), 0.0);
  EXPECT_EQ(ramp.at(1.0), 0.0);
  EXPECT_DOUBLE_EQ(ramp.at(1.25), 0.25);
  EXPECT_DOUBLE_EQ(ramp.at(3.0), 0.0);
  EXPECT_EQ(ramp.at(4.0), -1.0);
  EXPECT_EQ(ramp.at(9.0), -1.0);
  EXPECT_EQ(Amplitude{}.at(3.0), 1.0);
}

}  // namespace
}  // namespace ricochet::scene

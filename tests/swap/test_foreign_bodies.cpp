// A body of which the scene knows no mesh and no material, computed by a program that nobody here wrote: the whole run
// is that of a scene which knows all of it. tests/swap/foreign_body.py is the program; it reads its own file.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>

#include "tests/support/places.hpp"
#include "tests/support/run.hpp"
#include "tests/support/same_history.hpp"

namespace ricochet::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

const std::string foreign_program = source_folder() + "/tests/swap/foreign_body.py";
const std::string foreign_material = "{ youngs_modulus_pa = 210e9, poisson_ratio = 0.3, density_kg_m3 = 7800.0 }";

/// The keys of a model for a body 0.02 m across; `size`, `elements`: across, of the foreign program.
struct ForeignModel {
  const char* name;
  int components;
  const char *section, *section_key, *across, *elements, *size, *counts;
};
const ForeignModel bar_model{"bar", 1, "2e-4", "area_m2 = 2e-4\n", "", "", "", ""};
const ForeignModel plane_model{"plane_strain",      2,     "0.5",    "thickness_m = 0.5\n",
                               "height_m = 0.02, ", "2, ", "0.02, ", "2, "};
const ForeignModel round_model{"axisymmetric", 2, "1", "", "radius_m = 0.02, ", "2, ", "0.02, ", "2, "};
const ForeignModel solid_model{"solid",        3,       "1", "", "height_m = 0.02, width_m = 0.03, ", "2, 2, ",
                               "0.02, 0.03, ", "2, 2, "};

/// A vector along the last coordinate.
std::string along(const ForeignModel& model, const std::string& last) {
  return "[" + std::string(model.components == 1 ? "" : model.components == 2 ? "0.0, " : "0.0, 0.0, ") + last + "]";
}

std::string fixed_all(const ForeignModel& model) {
  const std::string name = model.name;
  return name == "bar"            ? "\"x\""
         : name == "plane_strain" ? "\"x\", \"y\""
         : name == "solid"        ? "\"x\", \"y\", \"z\""
                                  : "\"r\", \"z\"";
}

std::string meshed_body(const ForeignModel& model, const std::string& name, double start_m, int along_axis,
                        const std::string& more) {
  const std::string counts =
      model.components == 1 ? fmt::format("{}", along_axis) : fmt::format("[{}{}]", model.elements, along_axis);
  return fmt::format(
      "[[body]]\nname = \"{}\"\nmaterial = {}\n{}mesh = {{ start_m = {}, length_m = {}, {}elements = {} }}\n{}", name,
      foreign_material, model.section_key, start_m, 0.01 * along_axis, model.across, counts, more);
}

/// A body at rest, held at its low end, and one that flies onto it; of the first all but 0.04 m is explicit.
std::string whole_scene(const ForeignModel& model, const std::string& protocol, int substeps) {
  const std::string coupling = substeps > 1 ? fmt::format("substeps = {}\n", substeps) : "";
  return fmt::format("model = \"{}\"\n", model.name) +
         meshed_body(model, "lower", -0.1, 10,
                     fmt::format("support = [{{ surface = \"start\", fixed = [{}] }}]\n", fixed_all(model))) +
         meshed_body(model, "upper", 1e-6, 5, "initial_velocity_m_s = " + along(model, "-5.0") + "\n") +
         fmt::format(
             "[contact]\nsurfaces = [\"lower.end\", \"upper.start\"]\n[partition]\nimplicit_length_m = {{ lower "
             "= 0.04, upper = 0.02 }}\n[time]\nstep_s = {}\nend_s = 60e-6\n[coupling]\nprotocol = "
             "\"{}\"\n{}",
             5e-7 * substeps, protocol, coupling);
}

/// The same with everything behind those 0.04 m foreign; `joint`: the keys that say where.
std::string joined_scene(const ForeignModel& model, const std::string& protocol, int substeps,
                         const std::string& joint = "surface = \"start\"") {
  const std::string whole = whole_scene(model, protocol, substeps);
  return fmt::format("model = \"{}\"\n[[body]]\nname = \"tail\"\nforeign = true\njoined_to = \"lower\"\n{}\n",
                     model.name, joint) +
         meshed_body(model, "lower", -0.04, 4, "") + whole.substr(whole.find("[[body]]\nname = \"upper\"")) +
         "[[participant]]\nname = \"ours\"\nrole = \"explicit\"\nbodies = [\"upper\"]\n"
         "[[participant]]\nname = \"theirs\"\nrole = \"explicit\"\nbodies = [\"tail\"]\n"
         "executable = \"./foreign_body.py\"\n"
         "[[participant]]\nname = \"implicit\"\nrole = \"implicit\"\n";
}

/// The program and what it reads; `more` stands at its end.
void write_foreign_file(const TemporaryFolder& folder, const ForeignModel& model, const std::string& more = "") {
  const std::string origin = model.components == 1 ? "" : model.components == 2 ? "0.0, " : "0.0, 0.0, ";
  (void)folder.write(
      fmt::format("body = \"tail\"\nmodel = \"{}\"\nmaterial = {}\nsection = {}\nstart = [{}-0.1]\nsize = "
                  "[{}0.06]\nelements = [{}6]\nshared = \"high\"\nheld = \"low\"\n{}",
                  model.name, foreign_material, model.section, origin, model.size, model.counts, more),
      "theirs.toml");
  fs::create_symlink(foreign_program, folder.path() / "foreign_body.py");
}

struct ForeignCase {
  const ForeignModel* model;
  const char* protocol;
  int substeps;
};

std::string name_of_foreign(const testing::TestParamInfo<ForeignCase>& test) {
  return fmt::format("{}_{}_{}", test.param.model->name, test.param.protocol, test.param.substeps);
}

class ForeignBodies : public testing::TestWithParam<ForeignCase> {};

TEST_P(ForeignBodies, GiveTheHistoryOfTheWholeScene) {
  const auto& [model, protocol, substeps] = GetParam();
  TemporaryFolder folder;
  write_foreign_file(folder, *model);
  auto joined = run_text(joined_scene(*model, protocol, substeps), folder, "joined");
  auto whole = run_text(whole_scene(*model, protocol, substeps), folder, "whole");
  ASSERT_EQ(joined.history.count("velocity_mean_tail_m_s"), 1U);
  EXPECT_GT(joined.largest("velocity_mean_tail_m_s") - joined.smallest("velocity_mean_tail_m_s"), 0.1)
      << "the wave went through it";
  whole.history.erase("velocity_mean_lower_m_s");  // of another part of it
  expect_same_history(joined, whole, 1e-11);
  EXPECT_GT(whole.largest("contact_force_n"), 1e3);
  EXPECT_LT(joined.summary.at("momentum_error_max").get<double>(), 1e-12);
}

INSTANTIATE_TEST_SUITE_P(
    Models, ForeignBodies,
    testing::Values(ForeignCase{&bar_model, "hughes_liu", 1}, ForeignCase{&bar_model, "belytschko_mullen", 1},
                    ForeignCase{&bar_model, "prakash_hjelmstad", 2}, ForeignCase{&plane_model, "hughes_liu", 1},
                    ForeignCase{&plane_model, "prakash_hjelmstad", 2}, ForeignCase{&round_model, "hughes_liu", 1},
                    ForeignCase{&solid_model, "hughes_liu", 1}, ForeignCase{&solid_model, "fixed_point", 1}),
    name_of_foreign);

/// A bar of 0.01 m elements as a Gmsh mesh, whose group "implicit" has those that are `chosen`.
std::string bar_msh(const std::string& body, double start_m, int elements, const std::vector<int>& chosen) {
  std::string text = fmt::format(
      "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n4\n0 1 \"start\"\n0 2 \"end\"\n1 3 \"{0}\"\n1 4 "
      "\"implicit\"\n$EndPhysicalNames\n$Entities\n2 2 0 0\n1 {1} 0 0 1 1\n2 {2} 0 0 1 2\n1 {1} 0 0 {2} 0 0 1 3 0\n"
      "2 {1} 0 0 {2} 0 0 2 3 4 0\n$EndEntities\n$Nodes\n1 {3} 1 {3}\n1 1 0 {3}\n",
      body, start_m, start_m + 0.01 * elements, elements + 1);
  for (int node = 1; node <= elements + 1; ++node) text += fmt::format("{}\n", node);
  for (int node = 0; node <= elements; ++node) text += fmt::format("{:.17g} 0 0\n", start_m + 0.01 * node);
  const auto count = static_cast<int>(chosen.size());
  text += fmt::format("$EndNodes\n$Elements\n4 {0} 1 {0}\n0 1 15 1\n{1} 1\n0 2 15 1\n{0} {1}\n", elements + 2,
                      elements + 1);
  std::string of_entity[2];
  for (int e = 0; e < elements; ++e) {
    const bool is_chosen = std::find(chosen.begin(), chosen.end(), e) != chosen.end();
    of_entity[is_chosen ? 1 : 0] += fmt::format("{} {} {}\n", e + 1, e + 1, e + 2);
  }
  return text +
         fmt::format("1 1 1 {}\n{}1 2 1 {}\n{}$EndElements\n", elements - count, of_entity[0], count, of_entity[1]);
}

/// Between contact and joint an element is explicit, and ours; the layer at the joint is implicit all the same.
TEST(ForeignBody, MayBeJoinedToABodyThatIsPartitioned) {
  TemporaryFolder folder;
  write_foreign_file(folder, bar_model);
  (void)folder.write(bar_msh("lower", -0.1, 10, {6, 8, 9}), "whole.msh");
  (void)folder.write(bar_msh("lower", -0.04, 4, {2, 3}), "near.msh");
  (void)folder.write(bar_msh("upper", 1e-6, 5, {0, 1}), "upper.msh");
  const auto meshed = [](const std::string& text, const std::string& lower, const std::string& mesh) {
    auto changed = replaced(text, "implicit_length_m = { lower = 0.04, upper = 0.02 }",
                            "implicit_groups = { lower = [\"implicit\"], upper = [\"implicit\"] }");
    changed = replaced(changed, "mesh = { " + lower + " }", "mesh = { gmsh = \"" + mesh + "\" }");
    return replaced(changed, "mesh = { start_m = 1e-06, length_m = 0.05, elements = 5 }",
                    "mesh = { gmsh = \"upper.msh\" }");
  };
  for (const auto* protocol : {"hughes_liu", "kim", "prakash_hjelmstad"}) {
    const auto near = replaced(
        meshed(joined_scene(bar_model, protocol, 1), "start_m = -0.04, length_m = 0.04, elements = 4", "near.msh"),
        "bodies = [\"upper\"]", "bodies = [\"lower\", \"upper\"]");
    auto joined = run_text(near, folder, std::string("joined_") + protocol);
    auto whole = run_text(
        meshed(whole_scene(bar_model, protocol, 1), "start_m = -0.1, length_m = 0.1, elements = 10", "whole.msh"),
        folder, std::string("whole_") + protocol);
    whole.history.erase("velocity_mean_lower_m_s");
    expect_same_history(joined, whole, 1e-11);
  }
}

/// Half as wide as what it is joined to: a file says at which nodes.
TEST(ForeignBody, MayBeJoinedAtSomeNodesOfASide) {
  TemporaryFolder folder;
  write_foreign_file(folder, plane_model);
  const auto path = folder.path() / "theirs.toml";
  (void)folder.write(
      replaced(replaced(file_text(path.string()), "size = [0.02", "size = [0.01"), "elements = [2", "elements = [1"),
      "theirs.toml");
  const auto nodes = (folder.path() / "nodes.csv").string();
  const auto asked = run_command({ricochet_binary(), "check-participant", "--interface-nodes", nodes, "--",
                                  (folder.path() / "foreign_body.py").string(), "--name", "theirs"},
                                 folder.path().string());
  EXPECT_EQ(asked.code, 0) << asked.out << asked.error;
  EXPECT_THAT(asked.out, HasSubstr("nodes.csv: 2 interface nodes of \"tail\"\n"));
  EXPECT_THAT(file_text(nodes), testing::StartsWith("# interface nodes of \"tail\" [m]\n0, -0.04"));
  const auto run = run_text(joined_scene(plane_model, "hughes_liu", 1, "interface_nodes = \"nodes.csv\""), folder);
  EXPECT_LT(run.summary.at("momentum_error_max").get<double>(), 1e-12);
  EXPECT_LT(run.largest("energy_error"), 1e-3);
  const auto side = run_file(folder.write(joined_scene(plane_model, "hughes_liu", 1), "side.toml"), folder, "side");
  EXPECT_EQ(side.outcome.code, 2);
  EXPECT_THAT(
      side.outcome.error,
      HasSubstr("participant 'theirs', body 'tail': it has no interface node at (0.02, -0.04) m, where \"tail\" "
                "is joined to \"lower\" (1 of 3 are missing); allowed: all of them, or "
                "interface_nodes of [[body]] \"tail\", a file with those that it has"));
}

/// Its nodes at the interface are none of the scene's: the run is that of a scene that knows both meshes, tied there.
class ForeignMeshes : public testing::TestWithParam<ForeignCase> {};

TEST_P(ForeignMeshes, MayDifferAtTheInterface) {
  const auto& [model, protocol, substeps] = GetParam();
  TemporaryFolder folder;
  write_foreign_file(folder, *model);
  const bool solid = model->components == 3;
  const auto path = folder.path() / "theirs.toml";
  (void)folder.write(replaced(file_text(path.string()), std::string("elements = [") + model->counts,
                              solid ? "elements = [3, 1, " : "elements = [3, "),
                     "theirs.toml");
  std::string nodes = "# x, y [m]\n", faces;
  for (int i = 0; i <= 3; ++i) {
    const double x = 0.02 * i / 3;
    nodes += solid ? fmt::format("{0:.17g}, 0, -0.04\n{0:.17g}, 0.03, -0.04\n", x) : fmt::format("{:.17g}, -0.04\n", x);
    if (i < 3)
      faces += solid ? fmt::format("{}, {}, {}, {}\n", 2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1)
                     : fmt::format("{}, {}\n", i, i + 1);
  }
  (void)folder.write(nodes, "nodes.csv");
  (void)folder.write(faces, "faces.csv");
  const std::string near = solid ? "[5, 2, " : "[5, ";
  auto joined_text =
      joined_scene(*model, protocol, substeps,
                   "surface = \"start\"\ninterface_nodes = \"nodes.csv\"\ninterface_faces = \"faces.csv\"");
  joined_text =
      replaced(joined_text, std::string("elements = [") + model->elements + "4]", "elements = " + near + "4]");
  auto whole_text = whole_scene(*model, protocol, substeps);
  const auto mesh = whole_text.find("mesh = { start_m = -0.1");
  const auto after = whole_text.find('\n', mesh);
  const auto piece = [&](const std::string& name, double start_m, const std::string& elements, int along_axis) {
    return fmt::format("[[body.mesh.piece]]\nname = \"{}\"\nstart_m = {}\nlength_m = {}\n{}elements = {}{}]\n", name,
                       start_m, 0.01 * along_axis,
                       solid ? "height_m = 0.02\nwidth_m = 0.03\n"
                             : (std::string(model->name) == "axisymmetric" ? "radius_m = 0.02\n" : "height_m = 0.02\n"),
                       elements, along_axis);
  };
  const auto support = whole_text.substr(after + 1, whole_text.find('\n', after + 1) - after);
  whole_text = whole_text.substr(0, mesh) + replaced(support, "\"start\"", "\"far.start\"") +
               piece("far", -0.1, solid ? "[3, 1, " : "[3, ", 6) + piece("near", -0.04, near, 4) +
               "[[body.mesh.tie]]\nsurfaces = [\"far.end\", \"near.start\"]\n" +
               whole_text.substr(whole_text.find("[[body]]\nname = \"upper\""));
  whole_text = replaced(whole_text, "\"lower.end\"", "\"lower.near.end\"");
  auto joined = run_text(joined_text, folder, "joined");
  auto whole = run_text(whole_text, folder, "whole");
  whole.history.erase("velocity_mean_lower_m_s");  // of another part of it
  expect_same_history(joined, whole, std::string(protocol) == "fixed_point" ? 1e-9 : 1e-11);
  EXPECT_GT(whole.largest("contact_force_n"), 1e3);
  EXPECT_LT(joined.summary.at("momentum_error_max").get<double>(), 1e-12);
}

INSTANTIATE_TEST_SUITE_P(
    Models, ForeignMeshes,
    testing::Values(ForeignCase{&plane_model, "hughes_liu", 1}, ForeignCase{&plane_model, "belytschko_mullen", 1},
                    ForeignCase{&plane_model, "prakash_hjelmstad", 2}, ForeignCase{&plane_model, "fixed_point", 1},
                    ForeignCase{&round_model, "hughes_liu", 1}, ForeignCase{&solid_model, "hughes_liu", 1}),
    name_of_foreign);

/// Nodes of the foreign side that lie between those of the scene's surface get their share of its mass and stiffness.
TEST(ForeignMesh, MayBeFinerThanTheSurface) {
  TemporaryFolder folder;
  write_foreign_file(folder, plane_model);
  const auto path = folder.path() / "theirs.toml";
  (void)folder.write(replaced(file_text(path.string()), "elements = [2, 6]", "elements = [5, 15]"), "theirs.toml");
  std::string nodes, faces;
  for (int i = 0; i <= 5; ++i) nodes += fmt::format("{:.17g}, -0.04\n", 0.004 * i);
  for (int i = 0; i < 5; ++i) faces += fmt::format("{}, {}\n", i, i + 1);
  (void)folder.write(nodes, "nodes.csv");
  (void)folder.write(faces, "faces.csv");
  for (const auto* protocol : {"hughes_liu", "prakash_hjelmstad"}) {
    const auto run = run_text(
        replaced(joined_scene(plane_model, protocol, 1,
                              "surface = \"start\"\ninterface_nodes = \"nodes.csv\"\ninterface_faces = \"faces.csv\""),
                 "step_s = 5e-07", "step_s = 3.5e-07"),
        folder, protocol);
    EXPECT_LT(run.summary.at("momentum_error_max").get<double>(), 1e-11);
    EXPECT_LT(run.summary.at("energy_error_highest").get<double>(), 1e-6);
    EXPECT_GT(run.largest("velocity_mean_tail_m_s") - run.smallest("velocity_mean_tail_m_s"), 0.1);
  }
}

TEST(ForeignMesh, IsRefusedByFileAndLine) {
  TemporaryFolder folder;
  const auto refused = [&](const std::string& nodes, const std::string& faces, const std::string& keys = "") {
    (void)folder.write(nodes, "nodes.csv");
    (void)folder.write(faces, "faces.csv");
    const std::string all = "surface = \"start\"\ninterface_nodes = \"nodes.csv\"\ninterface_faces = \"faces.csv\"";
    const Outcome outcome =
        run_command({ricochet_binary(), "check",
                     folder.write(joined_scene(plane_model, "hughes_liu", 1, keys.empty() ? all : keys))},
                    folder.path().string());
    EXPECT_EQ(outcome.code, 2);
    return outcome.error;
  };
  const std::string nodes = "0, -0.04\n0.015, -0.04\n0.02, -0.04\n", faces = "0, 1\n1, 2\n";
  EXPECT_THAT(refused(nodes, "0, 0\n1, 2\n"), HasSubstr("faces.csv:1: found \"0, 0\"; allowed: two rows"));
  EXPECT_THAT(refused(nodes, "0, 1\n\n1, 3\n"), HasSubstr("faces.csv:3: found \"1, 3\"; allowed: two rows of nodes"));
  EXPECT_THAT(refused(nodes, "# none\n"), HasSubstr("faces.csv:1: found no face"));
  EXPECT_THAT(refused(nodes, "0, 1\n"), HasSubstr("found no face with the node of row 2"));
  EXPECT_THAT(refused("0, -0.04\n0.015, -0.041\n0.02, -0.04\n", faces), HasSubstr("m away from the faces of"));
  EXPECT_THAT(refused("0, 1.0\n0.015, 1.0\n0.02, 1.0\n", faces), HasSubstr("faces that lie on \"start\""));
  EXPECT_THAT(refused(nodes, faces, "surface = \"start\"\ninterface_faces = \"faces.csv\""),
              HasSubstr("only with interface_nodes"));
  EXPECT_THAT(refused(nodes, faces, "interface_nodes = \"nodes.csv\"\ninterface_faces = \"faces.csv\""),
              HasSubstr("body.tail.surface: found nothing"));
  EXPECT_THAT(
      refused(nodes, faces, "surface = \"start\"\ninterface_nodes = \"nodes.csv\"\ninterface_faces = \"no.csv\""),
      HasSubstr("there is no file"));
}

/// The whole run's mass, of the full circle; a mass per radian is known by its factor.
TEST(ForeignBody, IsComparedByItsMassIfTheSceneGivesIt) {
  const double mass_kg = 7800.0 * M_PI * 0.02 * 0.02 * 0.06;
  for (const auto* protocol : {"hughes_liu", "prakash_hjelmstad"}) {
    TemporaryFolder folder;
    write_foreign_file(folder, round_model);
    const auto text = [&](double kg) {
      return joined_scene(round_model, protocol, 1, fmt::format("surface = \"start\"\nmass_kg = {}", kg));
    };
    run_text(text(mass_kg), folder, "right");
    const auto wrong = run_file(folder.write(text(2.0 * M_PI * mass_kg), "wrong.toml"), folder, "wrong");
    EXPECT_EQ(wrong.outcome.code, 2);
    EXPECT_THAT(wrong.outcome.error,
                testing::AllOf(HasSubstr("participant 'theirs', body 'tail': its mass is 0.588106 kg"),
                               HasSubstr("wrong.toml:7: body.tail.mass_kg is 3.69518 kg (0.1592 times); likely cause: "
                                         "it is per radian")));
  }
}

/// The error of a run for a program whose file has this in place of that.
std::string refusal(const std::string& from, const std::string& to, int code = 2) {
  TemporaryFolder folder;
  write_foreign_file(folder, plane_model);
  const auto text = file_text((folder.path() / "theirs.toml").string());
  (void)folder.write(replaced(text, from, to), "theirs.toml");
  const auto run = run_file(folder.write(joined_scene(plane_model, "hughes_liu", 1)), folder);
  EXPECT_EQ(run.outcome.code, code) << run.outcome.error;
  return run.outcome.error;
}

TEST(ForeignBody, ElsewhereIsRefusedByItsNode) {
  EXPECT_THAT(
      refusal("start = [0.0, -0.1]", "start = [0.0, -0.101]"),
      HasSubstr("participant 'theirs', body 'tail', interface node 0 at (0, -0.041) m: \"tail\" is joined to no "
                "node there; the nearest is at (0, -0.04) m, 0.001 m away, allowed are 6e-11 m"));
  EXPECT_THAT(refusal("body = \"tail\"", "body = \"tale\""), HasSubstr("the scene has no such body"));
}

TEST(ForeignBody, OfAnotherParticipantIsRefused) {
  TemporaryFolder folder;
  write_foreign_file(folder, plane_model);
  const auto own = file_text((folder.path() / "theirs.toml").string());
  (void)folder.write(replaced(own, "\"tail\"", "\"side\""), "theirs.toml");
  (void)folder.write(replaced(own, "\"tail\"", "\"side\""), "others.toml");
  const auto scene = joined_scene(plane_model, "hughes_liu", 1) +
                     "[[body]]\nname = \"side\"\nforeign = true\njoined_to = \"lower\"\nsurface = \"start\"\n"
                     "[[participant]]\nname = \"others\"\nrole = \"explicit\"\nbodies = [\"side\"]\n"
                     "executable = \"./foreign_body.py\"\n";
  const auto run = run_file(folder.write(scene), folder);
  EXPECT_EQ(run.outcome.code, 2);
  EXPECT_THAT(run.outcome.error,
              HasSubstr("participant 'theirs', body 'side', interface node 0 at (0, -0.04) m: found a "
                        "foreign body of another participant; allowed: tail"));
}

TEST(ForeignBody, IsNotJoinedToARigidOne) {
  TemporaryFolder folder;
  write_foreign_file(folder, plane_model);
  const auto scene = replaced(
      replaced(joined_scene(plane_model, "hughes_liu", 1), "name = \"lower\"\n", "name = \"lower\"\nrigid = true\n"),
      "lower = 0.04, ", "");
  const auto run = run_file(folder.write(scene), folder);
  EXPECT_EQ(run.outcome.code, 2);
  EXPECT_THAT(run.outcome.error, HasSubstr("body.lower.rigid: found a body that foreign body \"tail\" is joined to"));
}

/// Two foreign bodies that share the nodes of one side: forces and masses of both are summed there.
TEST(ForeignBody, MayShareItsNodesWithAnother) {
  TemporaryFolder folder;
  write_foreign_file(folder, plane_model);
  const auto own = file_text((folder.path() / "theirs.toml").string());
  (void)folder.write(replaced(own, "\"tail\"", "\"side\""), "others.toml");
  const auto scene = joined_scene(plane_model, "hughes_liu", 1) +
                     "[[body]]\nname = \"side\"\nforeign = true\njoined_to = \"lower\"\nsurface = \"start\"\n"
                     "[[participant]]\nname = \"others\"\nrole = \"explicit\"\nbodies = [\"side\"]\n"
                     "executable = \"./foreign_body.py\"\n";
  const auto run = run_text(scene, folder);
  EXPECT_EQ(run.column("velocity_mean_side_m_s"), run.column("velocity_mean_tail_m_s")) << "they are twins";
  EXPECT_LT(run.summary.at("momentum_error_max").get<double>(), 1e-12);
}

/// The foreign program with a force K d + alpha d^2 in each element of a bar: 10 % more in the waves of the impact.
std::string scene_of_a_stiffening_tail(const TemporaryFolder& folder, const std::string& protocol, int substeps) {
  write_foreign_file(folder, bar_model);
  auto text = file_text(foreign_program);
  text =
      replaced(text, "os.path.join(os.path.dirname(os.path.realpath(__file__)), \"../../common/participant/python\")",
               "\"" + source_folder() + "/common/participant/python\"");
  text = replaced(text, "            s[\"internal\"] = self.k @ s[\"u\"]\n",
                  "            s[\"internal\"] = self.k @ s[\"u\"]\n            n = 8.4e13 * np.diff(s[\"u\"])**2\n"
                  "            s[\"internal\"][:-1] -= n\n            s[\"internal\"][1:] += n\n");
  text = replaced(text, "0.5 * s[\"u\"] @ s[\"internal\"]",
                  "0.5 * s[\"u\"] @ s[\"internal\"] - 8.4e13 / 6 * np.sum(np.diff(s[\"u\"])**3)");
  const auto program = folder.write(text, "stiffening_body.py");
  fs::permissions(program, fs::perms::owner_all);
  return replaced(joined_scene(bar_model, protocol, substeps), "./foreign_body.py", "./stiffening_body.py");
}

/// A protocol that measures a response at the start would take that of small strains for all that come.
TEST(ForeignBody, ThatIsNotLinearIsRefusedByNameWhereLinesAreAskedFor) {
  for (const auto& [protocol, substeps] : {std::pair{"belytschko_mullen", 1}, std::pair{"prakash_hjelmstad", 2}}) {
    TemporaryFolder folder;
    const auto run = run_file(folder.write(scene_of_a_stiffening_tail(folder, protocol, substeps)), folder);
    EXPECT_EQ(run.outcome.code, 2) << protocol << run.outcome.error;
    EXPECT_THAT(
        run.outcome.error,
        testing::AllOf(HasSubstr("participant 'theirs', interface node 0, component 0: it does not answer its link "
                                 "input linearly"),
                       HasSubstr("prakash_hjelmstad and gravouil_combescure with coupling.substeps = 1")));
  }
}

/// With one substep the response of a dual protocol is that of the masses: a body that is not linear is as good as one
/// that is: momentum is exact, and the two kinds of protocol lie as far apart as their order has them (measured: up to
/// twice what they do with the linear body, whose waves are slower).
TEST(ForeignBody, ThatIsNotLinearMayTakePartUnderADualProtocolWithOneSubstep) {
  const auto stiffening = [](const char* protocol) {
    TemporaryFolder folder;
    return run_text(scene_of_a_stiffening_tail(folder, protocol, 1), folder);
  };
  const auto linear = [](const char* protocol) {
    TemporaryFolder folder;
    write_foreign_file(folder, bar_model);
    return run_text(joined_scene(bar_model, protocol, 1), folder);
  };
  const auto primal = stiffening("hughes_liu"), dual = stiffening("prakash_hjelmstad");
  const auto linear_primal = linear("hughes_liu"), linear_dual = linear("prakash_hjelmstad");
  EXPECT_GT(column_difference(linear_primal, primal, "contact_force_n"), 1e-2) << "it is not linear";
  EXPECT_LT(dual.summary.at("momentum_error_max").get<double>(), 1e-12);
  for (const auto* column : {"contact_force_n", "momentum_n_kg_m_s", "energy_strain_j"})
    EXPECT_LT(column_difference(dual, primal, column),
              3.0 * column_difference(linear_dual, linear_primal, column) + 1e-9)
        << column;
}

/// The file of nodes is a part of the scene: who reads that in Python finds the hash that the coupler has.
TEST(ForeignBody, StandsInASceneThatParticipantsInPythonRead) {
  TemporaryFolder folder;
  write_foreign_file(folder, bar_model);
  (void)folder.write("-0.04\n", "nodes.csv");
  const auto text = joined_scene(bar_model, "hughes_liu", 1, "interface_nodes = \"nodes.csv\"");
  const auto ours = run_text(text, folder, "ours");
  const auto python = run_text(replaced(text, "bodies = [\"upper\"]",
                                        "bodies = [\"upper\"]\nexecutable = \"" + source_folder() +
                                            "/common/participant/python/explicit_bar.py\""),
                               folder, "python");
  expect_same_history(python, ours, 1e-11);
}

TEST(ForeignBody, WritesNoFileOfSeveralBodies) {
  TemporaryFolder folder;
  const auto outcome = run_command({ricochet_binary(), "check-participant", "--interface-nodes",
                                    (folder.path() / "nodes.csv").string(), "--", build_folder() + "/implicit_solver",
                                    "--scene", source_folder() + "/configs/two_bars.toml", "--name", "implicit"},
                                   folder.path().string());
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.error,
              HasSubstr("--interface-nodes: found interface nodes of several bodies of 'implicit', allowed: "
                        "a participant with interface nodes of one body"));
  EXPECT_FALSE(fs::exists(folder.path() / "nodes.csv"));
}

TEST(ForeignBody, DeclaresTheStepThatItStands) {
  EXPECT_THAT(refusal("held =", "critical = 4e-7\nheld ="),
              HasSubstr("participant 'theirs' declares the critical time step 4e-07 s, found a step of 5e-07 s; "
                        "allowed: time.step_s = 3.6e-07 or less"));
}

TEST(ForeignBody, HasNoClauseThatNeedsItsElements) {
  TemporaryFolder folder;
  write_foreign_file(folder, plane_model);
  const auto scene = folder.write(joined_scene(plane_model, "hughes_liu", 1));
  const auto outcome = run_command({ricochet_binary(), "check-participant", "--scene", scene, "--name", "theirs"},
                                   folder.path().string());
  EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.error;
  EXPECT_THAT(outcome.out, HasSubstr("passed   declares the scene's own masses and places"));
  EXPECT_THAT(outcome.out, HasSubstr("\"tail\" is foreign: the scene has no elements of it"));
}

TEST(ForeignBody, HasAStabilityByStepsNotByCourantNumbers) {
  TemporaryFolder folder;
  write_foreign_file(folder, bar_model);
  const auto scene = folder.write(joined_scene(bar_model, "hughes_liu", 1));
  const auto stability = [&](const std::string& sweep) {
    return run_command(
        {ricochet_binary(), "stability", scene, "--out", (folder.path() / "out").string(), "--sweep", sweep},
        folder.path().string());
  };
  const auto by_steps = stability("time.step_s=1.5e-6,2.1e-6");  // a bar's c is 5189 m/s: h/c = 1.93e-6 s
  EXPECT_EQ(by_steps.code, 0) << by_steps.error;
  EXPECT_THAT(by_steps.out, HasSubstr("critical time step of the scene without its foreign bodies"));
  EXPECT_THAT(by_steps.out, testing::ContainsRegex("1.5e-06[^\n]*open[^\n]* stable"));
  EXPECT_THAT(by_steps.out, testing::ContainsRegex("2.1e-06[^\n]*open[^\n]* unstable"));
  const auto by_courant = stability("courant=0.5,1.0");
  EXPECT_EQ(by_courant.code, 2);
  EXPECT_THAT(by_courant.error,
              HasSubstr("the foreign body \"tail\", whose critical time step the scene does not know; "
                        "allowed: time.step_s=LOW:HIGH:COUNT"));
}

}  // namespace
}  // namespace ricochet::test

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "common/base/error.hpp"
#include "common/scene/check.hpp"
#include "tests/scene/scene_text.hpp"

namespace ricochet::scene {
namespace {

/// One edit that spoils a good scene, the line the error must name (0: none) and what it must say.
struct Wrong {
  std::string name;
  const std::string* good;
  std::string from, to;
  int line;
  std::vector<std::string> says;
};

void PrintTo(const Wrong& wrong, std::ostream* out) { *out << wrong.name; }

class WrongScene : public testing::TestWithParam<Wrong> {};

TEST_P(WrongScene, IsRefusedWithPlaceFoundAndAllowed) {
  const Wrong& wrong = GetParam();
  const SceneFolder folder;
  const std::string file = folder.write(replaced(*wrong.good, wrong.from, wrong.to));
  try {
    (void)plan(build_problem(load_scene(file)));
    FAIL() << "accepted";
  } catch (const ConfigError& error) {
    const std::string text = error.what();
    if (wrong.line > 0) {
      EXPECT_THAT(text, testing::StartsWith(fmt::format("{}:{}: ", file, wrong.line)));
    }
    for (const std::string& part : wrong.says) EXPECT_THAT(text, testing::HasSubstr(part));
    EXPECT_THAT(text, testing::HasSubstr("allowed:"));
  }
}

std::string many(const std::string& text, int count) {
  std::string all;
  for (int i = 0; i < count; ++i) all += text;
  return all;
}

const std::string* const c = &cylinders;
const std::string* const b = &bars;
const std::string* const p = &plates;

const std::vector<Wrong> file_and_keys{
    {"syntax", c, "model = \"axisymmetric\"", "model = \"axisymmetric", 0, {"not a TOML file", " 1 | model"}},
    {"duplicate_key", c, "end_s = 1e-5", "end_s = 1e-5\nend_s = 2e-5", 0, {"not a TOML file", "end_s"}},
    {"unknown_key", c, "friction_coefficient", "frictoin_coefficient", 13,
     {"contact.frictoin_coefficient: found unknown key", "did you mean \"friction_coefficient\"?",
      "13 | frictoin_coefficient = 0.1", "~~~"}},
    {"unknown_table", c, "[output]", "[outputs]", 21, {"did you mean \"output\"?"}},
    {"unknown_nested_key", c, "density_kg_m3 = 7860.0", "density_kg_m3 = 7860.0, colour = 1", 4, {"material.colour"}},
    {"missing_model", c, "model = \"axisymmetric\"", "", 0, {"model: found nothing", "\"plane_strain\""}},
    {"wrong_model", c, "\"axisymmetric\"", "\"axisymetric\"", 1, {"did you mean \"axisymmetric\"?", "\"bar\""}},
    {"model_not_text", c, "\"axisymmetric\"", "3", 1, {"model: found 3", "a text"}},
    {"nested_brackets", c, "model = \"axisymmetric\"", "model = " + std::string(20'000, '['), 1,
     {"brackets nested: found 33 or more", "at most 32"}},
    {"nested_tables", c, "model = \"axisymmetric\"", "model = " + many("{a = ", 20'000), 1, {"brackets nested"}},
    {"dotted_key", c, "model = \"axisymmetric\"", "a" + many(".a", 100'000) + " = 1", 1, {"parts of a key: found 33 or more"}},
    {"dotted_quoted_key", c, "model = \"axisymmetric\"", "\n[a" + many(". \"a\"", 100'000) + "]", 2, {"parts of a key"}},
    {"giant_array", c, "model = \"axisymmetric\"", "model = [" + many("0,", 1'000'000) + "]", 0,
     {"found a file of 2000", "at most 1048576"}},
    {"missing_time", c, "[time]\nstep_s = 1e-7\nend_s = 1e-5", "", 0, {"time: found nothing"}},
};

const std::vector<Wrong> bodies{
    {"density_of_nothing", c, "density_kg_m3 = 7860.0", "density_kg_m3 = 1e-300", 4, {"a number >= 1e-15 and <= 1e+20"}},
    {"missing_name", c, "name = \"steel\"", "", 2, {"body[0].name: found nothing"}},
    {"bad_name", c, "name = \"steel\"", "name = \"steel bar\"", 3, {"letters, digits"}},
    {"duplicate_body", c, "name = \"carbide\"", "name = \"steel\"", 8, {"\"steel\" a second time"}},
    {"missing_density", c, ", density_kg_m3 = 7860.0", "", 4, {"body.steel.material.density_kg_m3: found nothing",
     "a number >= 1e-15"}},
    {"density_zero", c, "7860.0", "0.0", 4, {"body.steel.material.density_kg_m3: found 0", "a number >= 1e-15"}},
    {"modulus_negative", c, "207e9", "-207e9", 4, {"youngs_modulus_pa: found -2.07e+11", "> 0"}},
    {"modulus_text", c, "207e9", "\"steel\"", 4, {"found \"steel\"", "a number > 0"}},
    {"modulus_nan", c, "207e9", "nan", 4, {"found nan", "finite"}},
    {"modulus_inf", c, "207e9", "inf", 4, {"found inf", "finite"}},
    {"modulus_overflow", c, "207e9", "1e999", 4, {"finite"}},
    {"incompressible", c, "poisson_ratio = 0.3", "poisson_ratio = 0.5", 4, {"found 0.5", "> -1 and < 0.5"}},
    {"poisson_missing", c, "poisson_ratio = 0.3, ", "", 4, {"poisson_ratio: found nothing"}},
    {"length_negative", c, "length_m = 0.02, radius", "length_m = -0.02, radius", 5,
     {"body.steel.mesh.length_m: found -0.02"}},
    {"no_elements", c, "elements = [4, 8] }\ninitial", "elements = [0, 8] }\ninitial", 5, {"elements[0]: found 0",
     "an integer from 1"}},
    {"too_many_elements", c, "elements = [4, 8] }\ninitial", "elements = [40000, 80000] }\ninitial", 5,
     {"40000 x 80000"}},
    {"one_division", c, "elements = [4, 8] }\ninitial", "elements = [4] }\ninitial", 5, {"an array of 1",
     "an array of 2 integers"}},
    {"fractional_elements", b, "elements = 20", "elements = 2.5", 6, {"found 2.5", "an integer"}},
    {"grading_zero", b, "elements = 20", "elements = 20, grading = 0.0", 6, {"grading: found 0", "> 0"}},
    {"radius_of_bar", b, "elements = 20", "elements = 20, radius_m = 1.0", 6, {"only with model = \"axisymmetric\""}},
    {"height_in_axisymmetry", c, "radius_m = 0.004, elements = [4, 8] }\ninitial",
     "height_m = 1.0, elements = [4, 8] }\ninitial", 5, {"only with model = \"plane_strain\""}},
    {"area_in_axisymmetry", c, "initial_velocity", "area_m2 = 1.0\ninitial_velocity", 6,
     {"only with model = \"bar\""}},
    {"thickness_of_bar", b, "area_m2 = 6.4516e-4", "thickness_m = 1.0", 5, {"only with model = \"plane_strain\""}},
    {"periodic_axisymmetry", c, "elements = [4, 8]", "elements = [4, 8], periodic_across = true", 5,
     {"only with model = \"plane_strain\""}},
    {"periodic_too_narrow", p, "elements = [4, 6]", "elements = [2, 6], periodic_across = true", 5,
     {"3 or more across"}},
    {"periodic_graded", p, "elements = [4, 6]", "elements = [4, 6], grading = [2.0, 1.0], periodic_across = true", 5,
     {"1 across a periodic mesh"}},
    {"periodic_not_boolean", p, "elements = [4, 6]", "elements = [4, 6], periodic_across = 1", 5, {"true or false"}},
    {"missing_mesh_file", c, "start_m = -0.02, length_m = 0.02, radius_m = 0.004, elements = [4, 8]",
     "gmsh = \"none.msh\"", 5, {"body.steel.mesh.gmsh", "no file", "none.msh"}},
    {"mesh_both_ways", c, "length_m = 0.02, radius", "gmsh = \"a.msh\", length_m = 0.02, radius", 5,
     {"only with a structured mesh"}},
    {"velocity_size", c, "[0.0, 30.0]", "[30.0]", 6, {"an array of 1", "an array of 2 numbers"}},
    {"velocity_entry", c, "[0.0, 30.0]", "[0.0, true]", 6, {"initial_velocity_m_s[1]: found true"}},
    {"gravity_scalar", c, "initial_velocity_m_s = [0.0, 30.0]", "gravity_m_s2 = -9.81", 6, {"found -9.81",
     "an array of 2 numbers"}},
    {"moved_support", b, "initial_velocity_m_s = [5.13588]", "support = [{ surface = \"start\", fixed = [\"x\"] }]\n"
     "initial_displacement_m = { start = [-0.1], end = [0.0] }", 8, {"body.left.initial_displacement_m: found -0.1 m",
     "which is held"}},
};

const std::vector<Wrong> loads{
    {"support_surface", c, "initial_velocity_m_s = [0.0, 30.0]",
     "support = [{ surface = \"strat\", fixed = [\"z\"] }]", 6,
     {"support[0].surface: found \"strat\"; did you mean \"start\"?", "\"outer\""}},
    {"support_component", c, "initial_velocity_m_s = [0.0, 30.0]",
     "support = [{ surface = \"start\", fixed = [\"x\"] }]", 6, {"found \"x\"", "\"r\" or \"z\""}},
    {"support_twice", c, "initial_velocity_m_s = [0.0, 30.0]",
     "support = [{ surface = \"start\", fixed = [\"z\", \"z\"] }]", 6, {"\"z\" twice"}},
    {"support_empty", c, "initial_velocity_m_s = [0.0, 30.0]", "support = [{ surface = \"start\", fixed = [] }]", 6,
     {"a non-empty array"}},
    {"traction_size", c, "initial_velocity_m_s = [0.0, 30.0]",
     "traction = [{ surface = \"start\", traction_pa = [1.0] }]", 6, {"an array of 2 numbers"}},
    {"amplitude_size", c, "initial_velocity_m_s = [0.0, 30.0]",
     "traction = [{ surface = \"start\", traction_pa = [0.0, 1.0], "
      "amplitude = { time_s = [0.0, 1.0], factor = [1.0] } }]",
     6, {"amplitude.factor: found an array of 1", "2 numbers"}},
    {"amplitude_order", c, "initial_velocity_m_s = [0.0, 30.0]",
     "traction = [{ surface = \"start\", traction_pa = [0.0, 1.0], "
      "amplitude = { time_s = [0.0, 0.0], factor = [1.0, 2.0] } }]",
     6, {"times that do not grow"}},
    {"prescribed_on_support", c, "initial_velocity_m_s = [0.0, 30.0]",
     "support = [{ surface = \"start\", fixed = [\"z\"] }]\n"
     "prescribed = [{ surface = \"start\", component = \"z\", displacement_m = 1e-4 }]", 7,
     {"body.steel.prescribed[0]: found node", "held by body.steel.support[0] already"}},
    {"prescribed_on_axis", c, "initial_velocity_m_s = [0.0, 30.0]",
     "prescribed = [{ surface = \"start\", component = \"r\", displacement_m = 1e-4 }]", 6, {"the axis r = 0"}},
    {"prescribed_component", b, "initial_velocity_m_s = [5.13588]",
     "prescribed = [{ surface = \"start\", component = \"z\", displacement_m = 1e-4 }]", 7, {"found \"z\"", "\"x\""}},
};

const std::vector<Wrong> contacts{
    {"one_surface", c, "[\"steel.end\", \"carbide.start\"]", "[\"steel.end\"]", 12, {"1 surfaces", "two surfaces"}},
    {"unknown_body", c, "\"steel.end\"", "\"steal.end\"", 12, {"did you mean \"steel\"?",
     "a surface of \"steel\" or \"carbide\""}},
    {"unknown_surface", c, "\"steel.end\"", "\"steel.edn\"", 12, {"did you mean \"end\"?"}},
    {"surface_without_body", c, "\"steel.end\"", "\"end\"", 12, {"\"body.surface\""}},
    {"plane_first", c, "[\"steel.end\", \"carbide.start\"]", "[\"rigid_plane\", \"steel.end\"]", 12,
     {"\"rigid_plane\" as the second"}},
    {"self_contact", c, "\"carbide.start\"", "\"steel.start\"", 12, {"surfaces of two bodies"}},
    {"negative_gap", c, "friction_coefficient", "initial_gap_m = -1e-6\nfriction_coefficient", 13,
     {"initial_gap_m: found -1e-06", ">= 0"}},
    {"negative_friction", c, "friction_coefficient = 0.1", "friction_coefficient = -0.1", 13, {"found -0.1", ">= 0"}},
    {"penalty_without_enforcement", c, "friction_coefficient", "penalty_pa_m = 1e16\nfriction_coefficient", 13,
     {"penalty_pa_m: found", "only with enforcement = \"penalty\""}},
    {"penalty_missing", c, "friction_coefficient", "enforcement = \"penalty\"\nfriction_coefficient", 11,
     {"contact.penalty_pa_m: found nothing"}},
    {"impact_update_of_multiplier", c, "friction_coefficient", "impact_update = \"mass\"\nfriction_coefficient", 13,
     {"only with enforcement = \"penalty\""}},
    {"multiplier_update_of_penalty", c, "friction_coefficient",
     "enforcement = \"penalty\"\npenalty_pa_m = 1e12\nmultiplier_update = \"fully_implicit\"\n"
     "friction_coefficient", 15, {"only with enforcement = \"multiplier\""}},
    {"wrong_enforcement", c, "friction_coefficient", "enforcement = \"penatly\"\nfriction_coefficient", 13,
     {"did you mean \"penalty\"?"}},
    {"law_without_friction", c, "friction_coefficient = 0.1", "friction_law = \"regularised\"", 13,
     {"only with friction_coefficient"}},
    {"regularisation_without_law", c, "friction_coefficient = 0.1",
     "friction_coefficient = 0.1\nfriction_regularisation_s_m = 0.5", 14,
     {"only with friction_law = \"regularised\""}},
    {"regularisation_range", c, "friction_coefficient = 0.1",
     "friction_coefficient = 0.1\nfriction_law = \"regularised\"\nfriction_regularisation_s_m = 1.5", 15,
     {"> 0 and <= 1"}},
    {"friction_of_bars", b, "surfaces =", "friction_coefficient = 0.1\nsurfaces =", 15, {"a two-dimensional model"}},
    {"nose_of_bars", b, "surfaces =", "nose_radius_m = 0.1\nsurfaces =", 15, {"a two-dimensional model"}},
    {"nose_zero", c, "friction_coefficient", "nose_radius_m = 0.0\nfriction_coefficient", 13, {"> 0"}},
    {"same_direction", b, "\"right.start\"", "\"right.end\"", 15, {"outward normals", "face each other"}},
    {"overlap", b, "start_m = 0.508e-3", "start_m = -0.01", 15, {"overlap by 0.01 m", "start_m"}},
    {"initial_overlap", b, "initial_velocity_m_s = [5.13588]",
     "initial_displacement_m = { start = [0.0], end = [0.001] }", 15, {"after the initial displacement"}},
    {"nodes_do_not_match", c, "length_m = 0.02, radius_m = 0.004, elements = [4, 8] }\n[contact]",
     "length_m = 0.02, radius_m = 0.004, elements = [5, 8] }\n[contact]", 12, {"7 nodes without a partner",
     "steel.end (0.003, 0) m", "carbide.start (0.0032, 0) m"}},
    {"not_perpendicular", p, "\"upper.start\"", "\"upper.inner\"", 13, {"face each other"}},
};

const std::vector<Wrong> partitions{
    {"two_rules", c, "implicit_length_m =", "rule = \"auto\"\nimplicit_length_m =", 14,
     {"partition: found 2 of its keys", "exactly one"}},
    {"no_rule", c, "implicit_length_m = { steel = 0.005, carbide = 0.0075 }", "", 14, {"found 0 of its keys"}},
    {"unknown_rule", c, "implicit_length_m = { steel = 0.005, carbide = 0.0075 }", "rule = \"automatic\"", 15,
     {"\"auto\""}},
    {"length_of_unknown_body", c, "{ steel = 0.005,", "{ steal = 0.005,", 15, {"\"steal\"; did you mean \"steel\"?"}},
    {"length_missing", c, ", carbide = 0.0075", "", 15, {"no length for body \"carbide\""}},
    {"length_below_zero", c, "carbide = 0.0075", "carbide = -1.0", 15, {"implicit_length_m.carbide: found -1"}},
    {"length_without_contact", b, "[contact]\nsurfaces = [\"left.end\", \"right.start\"]\n", "", 15,
     {"only with a [contact]"}},
    {"groups_of_structured", c, "implicit_length_m = { steel = 0.005, carbide = 0.0075 }",
     "implicit_groups = { steel = [\"tip\"] }", 15, {"structured mesh has none"}},
    {"auto_without_step", c, "implicit_length_m = { steel = 0.005, carbide = 0.0075 }\n[time]\nstep_s = 1e-7",
     "rule = \"auto\"\n[time]", 16, {"automatic partition needs", "largest_step_s"}},
    {"all_of_it_implicit", c, "{ steel = 0.005, carbide = 0.0075 }", "{ steel = 1.0, carbide = 1.0 }", 14,
     {"every element implicit", "\"all_implicit\""}},
    {"nothing_implicit", b, "[contact]\nsurfaces = [\"left.end\", \"right.start\"]\n[partition]\n"
     "implicit_length_m = { left = 0.0635, right = 0.0635 }", "", 0, {"nothing implicit", "\"all_explicit\""}},
};

const std::vector<Wrong> runs{
    {"step_and_factor", c, "step_s = 1e-7", "step_s = 1e-7\nsafety_factor = 0.8", 18,
     {"both step_s and safety_factor"}},
    {"step_and_largest", c, "step_s = 1e-7", "step_s = 1e-7\nlargest_step_s = 2e-7", 18,
     {"both step_s and largest_step_s"}},
    {"factor_and_largest", c, "step_s = 1e-7", "safety_factor = 0.5\nlargest_step_s = 2e-7", 18,
     {"both safety_factor and largest_step_s"}},
    {"largest_with_lengths", c, "step_s = 1e-7", "largest_step_s = 1e-7", 17,
     {"a largest step where the [partition] is given", "rule = \"auto\""}},
    {"end_below_largest", b, "step_s = 2.226e-6\nend_s = 200e-6", "largest_step_s = 2e-6\nend_s = 1e-7", 20,
     {"at least largest_step_s = 2e-06"}},
    {"step_zero", c, "step_s = 1e-7", "step_s = 0.0", 17, {"> 0"}},
    {"factor_range", c, "step_s = 1e-7", "safety_factor = 1.1", 17, {"> 0 and <= 1"}},
    {"end_missing", c, "end_s = 1e-5", "", 16, {"time.end_s: found nothing"}},
    {"end_too_short", c, "end_s = 1e-5", "end_s = 1e-8", 18, {"shorter than one step"}},
    {"end_below_safe_step", b, "step_s = 2.226e-6\nend_s = 200e-6", "safety_factor = 0.9\nend_s = 1e-7", 20,
     {"shorter than one step of 2.2"}},
    {"separation_without_contact", b, "[contact]\nsurfaces = [\"left.end\", \"right.start\"]\n[partition]\n"
     "implicit_length_m = { left = 0.0635, right = 0.0635 }\n[time]", "[time]\nuntil_separated_plus_s = 1e-6", 15,
     {"only with a [contact]"}},
    {"step_above_critical", c, "step_s = 1e-7", "step_s = 1e-6", 17, {"time.step_s: found a step of 1e-06 s",
     "times the critical time step", "participant \"explicit\"", "step_s ="}},
    {"unknown_protocol", c, "\"hughes_liu\"", "\"hughes_lui\"", 20, {"did you mean \"hughes_liu\"?",
     "\"all_explicit\""}},
    {"address_without_tcp", c, "protocol = \"hughes_liu\"", "address = \"0.0.0.0\"", 20,
     {"only with transport = \"tcp\""}},
    {"port_without_tcp", c, "protocol = \"hughes_liu\"", "port = 5555", 20, {"only with transport = \"tcp\""}},
    {"unknown_transport", c, "protocol = \"hughes_liu\"", "transport = \"ipc\"", 20,
     {"\"ipc\"", "\"auto\", \"shm\", \"zmq\" or \"tcp\""}},
    {"port_range", c, "protocol = \"hughes_liu\"", "transport = \"tcp\"\nport = 70000", 21, {"from 0 to 65535"}},
    {"timeout_zero", c, "protocol = \"hughes_liu\"", "timeout_s = 0", 20, {"timeout_s: found 0", "> 0"}},
    {"history_never", c, "fields_every = 0", "history_every = 0", 22, {"an integer from 1"}},
    {"axial_stress_negative", c, "fields_every = 0", "axial_stress_every = -1", 22, {"an integer from 0"}},
};

const std::string coupling_end = "[output]\nfields_every = 0\n";
const std::vector<Wrong> participants{
    {"participant_role", c, coupling_end, "[[participant]]\nname = \"a\"\nrole = \"explict\"\nbodies = [\"steel\"]\n",
     23, {"did you mean \"explicit\"?"}},
    {"participant_body", c, coupling_end,
     "[[participant]]\nname = \"a\"\nrole = \"explicit\"\nbodies = [\"steal\"]\n", 24, {"did you mean \"steel\"?"}},
    {"participant_name_twice", c, coupling_end,
     "[[participant]]\nname = \"a\"\nrole = \"explicit\"\nbodies = [\"steel\", \"carbide\"]\n"
     "[[participant]]\nname = \"a\"\nrole = \"implicit\"\n", 26, {"\"a\" a second time"}},
    {"two_implicit", c, coupling_end,
     "[[participant]]\nname = \"a\"\nrole = \"implicit\"\n[[participant]]\nname = \"b\"\nrole = \"implicit\"\n", 26,
     {"a second implicit participant"}},
    {"no_implicit", c, coupling_end,
     "[[participant]]\nname = \"a\"\nrole = \"explicit\"\nbodies = [\"steel\", \"carbide\"]\n", 23,
     {"no implicit participant"}},
    {"bodies_of_implicit", c, coupling_end,
     "[[participant]]\nname = \"a\"\nrole = \"implicit\"\nbodies = [\"steel\"]\n", 24,
     {"only with role = \"explicit\""}},
    {"body_owned_twice", c, coupling_end,
     "[[participant]]\nname = \"a\"\nrole = \"explicit\"\nbodies = [\"steel\"]\n[[participant]]\n"
     "name = \"b\"\nrole = \"explicit\"\nbodies = [\"steel\", \"carbide\"]\n", 28,
     {"\"steel\", which \"a\" has already"}},
    {"body_not_owned", c, coupling_end,
     "[[participant]]\nname = \"a\"\nrole = \"explicit\"\nbodies = [\"steel\"]\n[[participant]]\n"
     "name = \"b\"\nrole = \"implicit\"\n", 0, {"no explicit participant for the element at", "of body \"carbide\""}},
    {"no_elements_to_own", c, "[partition]\nimplicit_length_m = { steel = 0.005,",
     "[[participant]]\nname = \"a\"\nrole = \"explicit\"\nbodies = [\"steel\"]\n[[participant]]\n"
     "name = \"b\"\nrole = \"explicit\"\nbodies = [\"carbide\"]\n[[participant]]\nname = \"i\"\n"
     "role = \"implicit\"\n[partition]\nimplicit_length_m = { steel = 1.0,", 14,
     {"participant.a: found no explicit element"}},
    {"start_word", c, coupling_end, "[[participant]]\nname = \"a\"\nrole = \"implicit\"\nstart = \"hand\"\n", 24,
     {"\"by_hand\""}},
};

/// Scenes that differ from a good one in more than one place.
std::vector<Wrong> with_more_edits() {
  static const std::string held = replaced(
      replaced(bars, "initial_velocity_m_s = [5.13588]", "support = [{ surface = \"end\", fixed = [\"x\"] }]"),
      "initial_velocity_m_s = [-5.13588]", "support = [{ surface = \"start\", fixed = [\"x\"] }]");
  static const std::string on_plane = replaced(
      replaced(bars, "\"right.start\"", "\"rigid_plane\""), ", right = 0.0635", "");
  static const std::string penalty = replaced(
      replaced(bars, "surfaces =", "enforcement = \"penalty\"\npenalty_pa_m = 1e15\nsurfaces ="),
      "end_s = 200e-6", "end_s = 200e-6\n[coupling]\nprotocol = \"all_explicit\"");
  return {
      {"body_in_another_galaxy", b, "start_m = -0.254", "start_m = 1e12", 0, {"m from the origin"}},
      {"held_on_both_sides", &held, "", "", 15, {"held along the normal by supports on every side"}},
    {"plane_against_held_node", &on_plane, "initial_velocity_m_s = [5.13588]",
     "support = [{ surface = \"end\", fixed = [\"x\"] }]", 15, {"held along the normal"}},
    {"explicit_penalty_too_stiff", &penalty, "", "", 16, {"contact.penalty_pa_m: found 1e+15 Pa/m",
     "times the critical time step", "step_s ="}},
    {"no_body_at_all", b, bars.substr(bars.find("[[body]]"), bars.find("[contact]") - bars.find("[[body]]")), "", 1,
     {"one [[body]] table or more"}},
    {"body_is_a_table", b, bars.substr(bars.find("[[body]]"), bars.find("[contact]") - bars.find("[[body]]")),
     "[body]\nname = \"left\"\n", 2, {"array of tables"}},
  };
}

std::string name_of(const testing::TestParamInfo<Wrong>& info) { return info.param.name; }

INSTANTIATE_TEST_SUITE_P(FileAndKeys, WrongScene, testing::ValuesIn(file_and_keys), name_of);
INSTANTIATE_TEST_SUITE_P(Bodies, WrongScene, testing::ValuesIn(bodies), name_of);
INSTANTIATE_TEST_SUITE_P(Loads, WrongScene, testing::ValuesIn(loads), name_of);
INSTANTIATE_TEST_SUITE_P(Contacts, WrongScene, testing::ValuesIn(contacts), name_of);
INSTANTIATE_TEST_SUITE_P(Partitions, WrongScene, testing::ValuesIn(partitions), name_of);
INSTANTIATE_TEST_SUITE_P(Runs, WrongScene, testing::ValuesIn(runs), name_of);
INSTANTIATE_TEST_SUITE_P(Participants, WrongScene, testing::ValuesIn(participants), name_of);
INSTANTIATE_TEST_SUITE_P(MoreEdits, WrongScene, testing::ValuesIn(with_more_edits()), name_of);

}  // namespace
}  // namespace ricochet::scene

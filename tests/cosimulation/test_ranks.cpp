// The explicit participant as several processes that OpenMPI starts: the bytes of one process without MPI.
#include <fmt/format.h>

#include <csignal>

#include "tests/support/process_table.hpp"
#include "tests/support/same_results.hpp"

namespace ricochet::test {
namespace {

using testing::HasSubstr;

/// The scene with its explicit participant in so many ranks; 0: without MPI.
std::string with_ranks(const std::string& text, int ranks, const std::string& more = "") {
  std::string bodies;
  const std::string key = "[[body]]\nname = ";
  for (auto at = text.find(key); at != std::string::npos; at = text.find(key, at + 1)) {
    const auto begin = at + key.size();
    bodies += (bodies.empty() ? "" : ", ") + text.substr(begin, text.find('\n', begin) - begin);
  }
  const std::string given = ranks > 0 ? fmt::format("ranks = {}\n", ranks) : "";
  return text + fmt::format(
                    "\n[[participant]]\nname = \"explicit\"\nrole = \"explicit\"\nbodies = [{}]\n{}{}"
                    "[[participant]]\nname = \"implicit\"\nrole = \"implicit\"\n",
                    bodies, given, more);
}

struct RankedRun {
  std::string name, text;
  std::vector<int> ranks;
};

void PrintTo(const RankedRun& run, std::ostream* out) { *out << run.name; }

/// The paper's impact of a steel that yields, hardens, follows the rate and is heated, with what tells of it.
std::string yielding_impact() {
  const std::string
      elastic = "density_kg_m3 = 7860.0 }",
      plastic =
          "density_kg_m3 = 7860.0, plasticity = { yield_stress_pa = 300e6, hardening_pa = 2e9, rate_factor = 0.014, "
          "heat = { specific_heat_j_kg_k = 477.0, melting_k = 1793.0 } } }";
  return replaced(with_key(config_text("kim_impact"), "time", "end_s", "12e-6"), elastic, plastic) +
         "\n[[output.probe]]\nname = \"place\"\nbody = \"steel\"\nat_m = [0.0025, -0.02]\n"
         "[[output.gauge]]\nname = \"gauge\"\nbody = \"steel\"\nsection_m = -0.015\nlength_m = 0.004\n";
}

constexpr const char* soft_steel =
    "{ youngs_modulus_pa = 200e9, poisson_ratio = 0.3, density_kg_m3 = 7800.0, plasticity = { yield_stress_pa = 100e6, "
    "hardening_pa = 2e9 } }";

/// Blocks of hexahedra that yield and slide on nodes that hang.
std::string refined_blocks() {
  std::string text = "model = \"solid\"\n";
  for (const bool upper : {true, false})
    text += fmt::format(
        "[[body]]\nname = \"{}\"\nmaterial = {}\ninitial_velocity_m_s = [{}]\n[body.mesh]\nlength_m = 0.004\n"
        "height_m = {}\nwidth_m = {}\nstart_m = {}\nelements = {}\n[[body.mesh.refine]]\nfrom_m = {}\nto_m = {}\n"
        "ratio = 2\n",
        upper ? "upper" : "lower", soft_steel, upper ? "3.0, 2.0, -10.0" : "0.0, 0.0, 0.0", upper ? 0.004 : 0.006,
        upper ? 0.004 : 0.006, upper ? 0.0 : -0.004, upper ? "[4, 4, 4]" : "[6, 6, 4]",
        upper ? "[0.001, 0.001, 0.0]" : "[0.0, 0.0, -0.002]", upper ? "[0.003, 0.003, 0.002]" : "[0.004, 0.004, 0.0]");
  return text + "[contact]\nsurfaces = [\"lower.end\", \"upper.start\"]\nfriction_coefficient = 0.2\n" +
         "[time]\nstep_s = 6e-8\nend_s = 3e-6\n[output]\nfields_every = 20\n";
}

/// Strips of two meshes each, tied, that yield.
std::string tied_strips() {
  std::string text = "model = \"plane_strain\"\n";
  for (const bool striker : {true, false}) {
    text += fmt::format("[[body]]\nname = \"{}\"\nmaterial = {}\ninitial_velocity_m_s = [1.0, {}]\n",
                        striker ? "striker" : "strip", soft_steel, striker ? 10.0 : 0.0);
    for (const bool first : {true, false})
      text += fmt::format(
          "[[body.mesh.piece]]\nname = \"{}\"\nstart_m = {}\nlength_m = 0.01\nheight_m = 0.004\nelements = {}\n",
          first ? "before" : "behind", (striker ? 0.0 : 0.02) + (first ? 0.0 : 0.01), first ? "[4, 10]" : "[7, 17]");
    text += "[[body.mesh.tie]]\nsurfaces = [\"before.end\", \"behind.start\"]\n";
  }
  return text + "[contact]\nsurfaces = [\"striker.behind.end\", \"strip.before.start\"]\nfriction_coefficient = 0.1\n" +
         "[partition]\nimplicit_length_m = { striker = 0.003, strip = 0.003 }\n" +
         "[time]\nsafety_factor = 0.7\nend_s = 8e-6\n";
}

/// Plates that yield and spin, one onto the other.
std::string turning_plates() {
  std::string text = "model = \"plane_strain\"\n";
  for (const bool high : {true, false})
    text += fmt::format(
        "[[body]]\nname = \"{}\"\nmaterial = {}\nlarge_rotation = true\ninitial_angular_velocity_rad_s = {}\n"
        "initial_velocity_m_s = [{}]\nmesh = {{ start_m = {}, length_m = 0.03, height_m = 0.005, elements = {} }}\n",
        high ? "high" : "low", soft_steel, high ? -3000.0 : 200.0, high ? "3.0, -10.0" : "0.0, 0.0",
        high ? 2e-5 : -0.03, high ? "[7, 41]" : "[5, 30]");
  return text + "[contact]\nsurfaces = [\"low.end\", \"high.start\"]\nfriction_coefficient = 0.3\n" +
         "[partition]\nimplicit_length_m = { low = 0.004, high = 0.004 }\n[time]\nstep_s = 8e-8\nend_s = 2e-5\n";
}

/// The blocks spin, too.
std::string turning_blocks() {
  return replaced(refined_blocks(), "initial_velocity_m_s = [3.0",
                  "large_rotation = true\ninitial_angular_velocity_rad_s = [500.0, 2000.0, 300.0]\n"
                  "initial_velocity_m_s = [3.0");
}

/// The upper block is rigid, spins, and strikes the lower one.
std::string rigid_block() {
  constexpr const char* plastic = ", plasticity = { yield_stress_pa = 100e6, hardening_pa = 2e9 }";
  const std::string both = refined_blocks();
  const auto boxes = both.find("[[body.mesh.refine]]");
  const std::string upper = both.substr(0, boxes), lower = both.substr(both.find("[[body]]", boxes));
  return replaced(replaced(upper, plastic, ""), "name = \"upper\"",
                  "name = \"upper\"\nrigid = true\nlarge_rotation = true\n"
                  "initial_angular_velocity_rad_s = [500.0, 2000.0, 300.0]") +
         replaced(lower, plastic, "");
}

/// A cylinder on the middle of a plate, most of whose surface nothing can touch.
std::string cylinder_on_plate() {
  const std::string body =
      "[[body]]\nname = \"{}\"\nmaterial = \"steel_a36\"\ninitial_velocity_m_s = [0.0, {}]\n"
      "mesh = {{ start_m = {}, length_m = {}, radius_m = {}, elements = {} }}\n";
  return "model = \"axisymmetric\"\n" + fmt::format(fmt::runtime(body), "plate", 0.0, -0.004, 0.004, 0.03, "[90, 12]") +
         fmt::format(fmt::runtime(body), "cylinder", -10.0, 0.0, 0.006, 0.003, "[6, 12]") +
         "[contact]\nsurfaces = [\"plate.end\", \"cylinder.start\"]\n[time]\nend_s = 4e-6\n";
}

/// Each kind of scene is tried with few and with many ranks; no scene with all numbers, which would take minutes.
std::vector<RankedRun> ranked_runs() {
  std::vector<RankedRun> runs;
  const auto add = [&](const std::string& name, std::string text, std::vector<int> ranks) {
    runs.push_back({name, std::move(text), std::move(ranks)});
  };
  const auto cylinders = [](const std::string& protocol) {
    return with_protocol_of_two_steps(config_text("kim_impact"), protocol);
  };
  add("cylinders_hughes_liu", cylinders("hughes_liu"), {1, 4});
  add("cylinders_prakash_hjelmstad", cylinders("prakash_hjelmstad"), {7});
  add("cylinders_all_explicit", cylinders("all_explicit"), {3});
  const std::string yielding = yielding_impact();
  add("yielding_hughes_liu", with_protocol(yielding, "hughes_liu"), {2});
  add("yielding_prakash_hjelmstad", with_protocol(yielding, "prakash_hjelmstad"), {3});
  add("yielding_fixed_point", with_protocol(yielding, "fixed_point"), {2});
  add("yielding_all_explicit", with_protocol(yielding, "all_explicit"), {7});
  add("balls_of_tetrahedra", with_absolute_meshes(config_text("two_balls_solid")), {2, 7});
  add("ball_of_hexahedra_on_plate",
      with_key(with_absolute_meshes(config_text("ball_on_plate")), "time", "end_s", "2e-6"), {3});
  const std::string striker =
      with_key(with_key(with_absolute_meshes(config_text("rounded_striker")), "time", "step_s", "25e-9"), "time",
               "end_s", "5e-6");
  add("cylinder_on_plate", with_protocol(cylinder_on_plate(), "all_explicit"), {3});
  add("small_steps", with_protocol(striker, "local_explicit"), {2, 5});
  const std::pair<std::string, int> protocols[] = {{"hughes_liu", 2}, {"prakash_hjelmstad", 3}, {"all_explicit", 5}};
  for (const auto& [protocol, ranks] : protocols) {
    const std::string slipping = with_protocol_of_two_steps(config_text("slipping_plates"), protocol);
    add("slipping_" + protocol, with_key(slipping, "output", "fields_every", "50"), {ranks});
    add("refined_" + protocol, with_protocol(refined_blocks(), protocol), {ranks});
    add("tied_" + protocol, with_protocol(tied_strips(), protocol), {ranks});
    add("rigid_" + protocol, with_protocol(rigid_block(), protocol), {ranks});
    add("turning_plates_" + protocol, with_protocol(turning_plates(), protocol), {ranks});
    add("turning_blocks_" + protocol, with_protocol(turning_blocks(), protocol), {ranks});
  }
  return runs;
}

class Ranks : public testing::TestWithParam<RankedRun> {};

TEST_P(Ranks, OfAnyNumberGiveTheSameBytes) {
  const TemporaryFolder folder;
  const RunResult one = run_text(with_ranks(GetParam().text, 0), folder);
  for (const int ranks : GetParam().ranks) {
    const TemporaryFolder other_folder;
    const RunResult many = run_text(with_ranks(GetParam().text, ranks), other_folder);
    expect_same_results(many.folder, one.folder, {"scene", "scene_sha256"});  // in which the numbers stand
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, Ranks, testing::ValuesIn(ranked_runs()),
                         [](const testing::TestParamInfo<RankedRun>& test) { return test.param.name; });

// The implicit side has the elements at the contact alone. All of the plate's surface would have a thirtieth.
TEST(StressAtTheContact, IsThatOfAllExplicitUnderAHybrid) {
  const TemporaryFolder folder;
  const auto peak = [&](const std::string& protocol) {
    return run_text(with_protocol(cylinder_on_plate(), protocol), folder, protocol).largest("principal_stress_mean_pa");
  };
  const double explicit_pa = peak("all_explicit");
  EXPECT_GT(explicit_pa, 1e8);
  EXPECT_NEAR(peak("hughes_liu"), explicit_pa, 0.1 * explicit_pa);
}

TEST(Rank, ThatWasSavedGoesOnToTheSameBytes) {
  for (const std::string& scene : {config_text("kim_impact"), yielding_impact(), turning_plates()}) {
    const TemporaryFolder folder;
    const RunResult whole = run_text(with_key(with_ranks(scene, 3), "checkpoint", "every_windows", "80"), folder);
    (void)expect_the_same_from_the_earlier_checkpoint(whole, folder);
  }
}

/// Elements that yield in a share of a part have the force of the whole, and every joule has an owner.
TEST(Rank, ThatYieldsKeepsTheBooks) {
  const TemporaryFolder folder;
  const RunResult run = run_text(with_ranks(with_protocol(yielding_impact(), "all_explicit"), 4), folder);
  EXPECT_GT(run.last("plastic_work_j"), 0.0);
  EXPECT_LT(run.summary.at("energy_error_highest").get<double>(), 1e-10);
  EXPECT_LT(run.summary.at("momentum_error_max").get<double>(), 1e-10);
}

TEST(Rank, OfABodyThatTurnsInSmallStepsIsRefused) {
  EXPECT_THAT(check_refusal(with_ranks(with_protocol(turning_plates(), "local_explicit"), 2)),
              testing::AllOf(HasSubstr("body.high.large_rotation: found large_rotation in small steps with 2 ranks of "
                                       "\"explicit\""),
                             HasSubstr("allowed: no ranks (and threads), or \"all_explicit\"")));
}

/// No rank knows how the whole spins but by the sums of all.
TEST(Rank, ThatTurnsKeepsTheBooks) {
  const TemporaryFolder folder;
  const std::string apart =
      replaced(with_protocol(turning_plates(), "all_explicit"), "start_m = 2e-05", "start_m = 1.0");
  const RunResult run = run_text(with_ranks(apart, 4), folder);
  EXPECT_LT(run.summary.at("angular_momentum_error_max").get<double>(), 1e-12);
  EXPECT_LT(run.summary.at("momentum_error_max").get<double>(), 1e-12);
  EXPECT_LT(run.summary.at("energy_error_max").get<double>(), 1e-5);
}

Outcome refused(const std::string& text, const TemporaryFolder& folder) {
  return run_file(folder.write(text), folder).outcome;
}

/// Started by hand it would have the number that somebody typed.
TEST(Rank, OfAnotherNumberThanTheScenesIsRefused) {
  const TemporaryFolder folder;
  const auto outcome =
      refused(with_ranks(config_text("two_bars"), 3,
                         "launch = [\"mpirun\", \"--allow-run-as-root\", \"--oversubscribe\", \"-n\", \"2\"]\n"),
              folder);
  EXPECT_EQ(outcome.code, 4) << outcome.error;
  EXPECT_THAT(outcome.error, HasSubstr("participant 'explicit' has ranks = 3, and 2 were started"));
}

TEST(Rank, IsForTheShippedExplicitSolver) {
  const TemporaryFolder folder;
  const std::string wrong[] = {
      replaced(with_ranks(config_text("two_bars"), 2), "ranks = 2", "ranks = 2\nexecutable = \"mine\""),
      replaced(with_ranks(config_text("two_bars"), 2), "ranks = 2", "ranks = 2\nstart = \"by_hand\""),
      with_ranks(config_text("two_bars"), 0) + "ranks = 2\n"};
  for (const auto& text : wrong) {
    const auto outcome = refused(text, folder);
    EXPECT_EQ(outcome.code, 2) << outcome.error;
    EXPECT_THAT(outcome.error, HasSubstr("ranks: found 2; allowed: only with role = \"explicit\", the shipped solver"));
  }
  const auto none = refused(replaced(with_ranks(config_text("two_bars"), 2), "ranks = 2", "ranks = 0"), folder);
  EXPECT_THAT(none.error, HasSubstr("ranks: found 0; allowed: an integer from 1 to 100000"));
}

}  // namespace
}  // namespace ricochet::test

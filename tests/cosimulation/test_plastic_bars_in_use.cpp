// Bars that yield: after kills, by the contract of participants, beside a program of its own, with other bars, and
// where they are refused.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <signal.h>

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/places.hpp"
#include "tests/support/plastic_bar_scenes.hpp"
#include "tests/support/process_table.hpp"
#include "tests/support/same_results.hpp"

namespace ricochet::test::plastic {
namespace {

using testing::AllOf;
using testing::HasSubstr;

/// The law of Johnson and Cook, with a rate and a temperature that matter.
const std::string hot_law =
    ", hardening_exponent = 0.5, rate_factor = 0.02, reference_rate_per_s = 10.0, heat = { specific_heat_j_kg_k = "
    "50.0, "
    "melting_k = 600.0, softening_exponent = 0.8 }";

TEST(PlasticBar, GoesOnAfterAKillToTheSameBytes) {
  const TemporaryFolder folder;
  const Impact impact{.elements = 400,
                      .end_s = 2e-3,
                      .hardening = 1e9,
                      .more =
                          "[checkpoint]\nevery_windows = 300\n[output]\n"
                          "fields_every = 1000\naxial_stress_every = 100\n",
                      .law = hot_law};
  const RunResult whole = run_text(scene_of(impact), folder, "whole");
  EXPECT_GT(whole.last("plastic_work_j"), 0.0);
  EXPECT_GT(whole.last("temperature_max_k"), 300.0);
  const auto scene = folder.write(scene_of(impact), "whole.toml");
  const auto out = (folder.path() / "out").string();
  Process run({ricochet_binary(), "run", scene, "--out", out}, folder.path() / "o", folder.path() / "e");
  ASSERT_TRUE(wait_until([&] { return !checkpoints_in(out).empty(); }, 20.0));
  kill(run.pid(), SIGKILL);
  run.wait(10.0);
  const auto windows = checkpoints_in(out);
  ASSERT_FALSE(windows.empty());
  EXPECT_LT(windows.back(), whole.summary.at("windows").get<int>());
  const auto outcome = resume(out, folder);
  EXPECT_EQ(outcome.code, 0) << outcome.error;
  expect_same_results(out, whole.folder);
}

/// From each checkpoint of a run, among them those in the midst of the plastic wave.
TEST(PlasticBar, GoesOnFromACheckpointInThePlasticWaveToTheSameBytes) {
  const TemporaryFolder folder;
  for (const char* protocol : {"hughes_liu", "prakash_hjelmstad", "fixed_point", "local_explicit"}) {
    const double finer = protocol == std::string("local_explicit") ? 4.0 : 1.0;
    const Impact impact{.protocol = protocol, .more = "[checkpoint]\nevery_windows = 40\n", .finer = finer};
    const RunResult whole = run_text(scene_of(impact), folder, protocol);
    (void)expect_the_same_from_the_earlier_checkpoint(whole, folder);
  }
}

TEST(PlasticBar, IsASoundParticipantOfEitherSide) {
  const TemporaryFolder folder;
  const std::string scene = folder.write(scene_of({}));
  for (const char* name : {"explicit", "implicit"}) {
    const Outcome checked =
        run_command({ricochet_binary(), "check-participant", "--scene", scene, "--name", name}, folder.path().string());
    EXPECT_EQ(checked.code, 0) << checked.out << checked.error;
    EXPECT_THAT(checked.out,
                AllOf(HasSubstr("passed   a repeated trial of a window gives the same bits"),
                      HasSubstr("passed   another process goes on from its saved state to the same bits")));
  }
}

/// tests/swap/plastic_bar.py has the law and central differences of its own.
class PlasticBarOfTwoLanguages : public testing::TestWithParam<bool> {};

TEST_P(PlasticBarOfTwoLanguages, MovesAlike) {
  const TemporaryFolder folder;
  const auto with = [](const std::string& program) {
    const bool hot = GetParam();
    return Impact{.hardening = hot ? 1e9 : hardening_pa,
                  .participants = "[[participant]]\nname = \"explicit\"\nrole = \"explicit\"\nbodies = [\"rod\"]\n" +
                                  program + "[[participant]]\nname = \"implicit\"\nrole = \"implicit\"\n",
                  .law = hot ? hot_law : ""};
  };
  const RunResult ours = run_text(scene_of(with("")), folder, "ours");
  const RunResult theirs =
      run_text(scene_of(with(fmt::format("executable = \"{}/tests/swap/plastic_bar.py\"\n", source_folder()))), folder,
               "theirs");
  EXPECT_GT(ours.last("equivalent_plastic_strain_max"), 1e-3);
  std::vector<std::string> names = {"contact_pressure_mean_pa", "plastic_work_j",  "equivalent_plastic_strain_max",
                                    "energy_kinetic_j",         "energy_strain_j", "momentum_n_kg_m_s"};
  if (GetParam()) names.emplace_back("temperature_max_k");
  for (const auto& name : names) {
    const auto &a = ours.column(name), &b = theirs.column(name);
    ASSERT_EQ(a.size(), b.size());
    const double largest = std::max(ours.largest(name), -ours.smallest(name));
    for (std::size_t n = 0; n < a.size(); ++n) ASSERT_NEAR(a[n], b[n], 1e-9 * largest) << name << ", row " << n;
  }
}

INSTANTIATE_TEST_SUITE_P(Laws, PlasticBarOfTwoLanguages, testing::Bool(),
                         [](const auto& info) { return info.param ? "johnson_cook" : "linear"; });

/// A bar flies onto one twice as long; both yield, rebound and, where the protocol may, go on explicitly.
std::string two_plastic_bars(const std::string& protocol, const std::string& coupling) {
  std::string text =
      scene_of({.protocol = protocol, .end_s = 2.5e-3, .implicit = "0.1, far = 0.1", .coupling = coupling});
  text = replaced(text, "[contact]\nsurfaces = [\"rod.end\", \"rigid_plane\"]", R"([[body]]
name = "far"
material = { youngs_modulus_pa = 2e11, density_kg_m3 = 8000.0, plasticity = { yield_stress_pa = 4e8, hardening_pa = 2e10 } }
mesh = { length_m = 2.0, elements = 200, start_m = 1.0 }
area_m2 = 1e-4
[contact]
surfaces = ["rod.end", "far.start"])");
  return replaced(text, "initial_velocity_m_s = [20]", "initial_velocity_m_s = [40]");
}

TEST(PlasticBar, KeepsTheMomentumOfTwoThatYieldAndPart) {
  const TemporaryFolder folder;
  const std::vector<std::pair<std::string, std::string>> methods = {
      {"all_explicit", ""}, {"all_implicit", ""}, {"hughes_liu", ""}, {"fixed_point", "acceleration = \"aitken\"\n"}};
  std::vector<double> work_j;
  for (const auto& [protocol, coupling] : methods) {
    const RunResult run = run_text(two_plastic_bars(protocol, coupling), folder, protocol);
    EXPECT_LT(run.summary.at("momentum_error_max").get<double>(), 1e-8) << protocol;
    EXPECT_LT(largest_error(run), 6e-3) << protocol;
    EXPECT_TRUE(run.summary.at("separation_time_s").is_number()) << protocol;
    work_j.push_back(run.last("plastic_work_j"));
    EXPECT_NEAR(work_j.back() / work_j.front(), 1.0, 1e-2) << protocol;
  }
}

struct Refusal {
  const char* name;
  Impact impact;
  const char* found;
};

class RefusedPlasticBar : public testing::TestWithParam<Refusal> {};

TEST_P(RefusedPlasticBar, IsNamed) {
  const auto& [name, impact, found] = GetParam();
  const TemporaryFolder folder;
  for (const char* command : {"check", "run"}) {
    const auto outcome =
        run_command({ricochet_binary(), command, folder.write(scene_of(impact))}, folder.path().string());
    EXPECT_EQ(outcome.code, 2) << outcome.out;
    EXPECT_THAT(outcome.error, AllOf(HasSubstr("body.rod.material.plasticity: found plasticity"), HasSubstr(found),
                                     HasSubstr("allowed: ")));
  }
}

INSTANTIATE_TEST_SUITE_P(
    Methods, RefusedPlasticBar,
    testing::Values(
        Refusal{"belytschko_mullen", {.protocol = "belytschko_mullen"}, "under \"belytschko_mullen\" on the side of"},
        Refusal{"gravouil_combescure", {.protocol = "gravouil_combescure"}, "on the implicit side"},
        Refusal{"substeps",
                {.protocol = "prakash_hjelmstad", .coupling = "substeps = 2\n"},
                "with 2 substeps of \"explicit\""},
        Refusal{"massless", {.contact = "multiplier_update = \"massless\"\n"}, "multiplier_update = \"massless\""},
        Refusal{"penalty",
                {.contact = "enforcement = \"penalty\"\npenalty_pa_m = 1e12\n"},
                "enforcement = \"penalty\" on the implicit side"}),
    [](const auto& info) { return std::string(info.param.name); });

TEST(PlasticBar, IsRefusedByTheStudyOfStability) {
  const TemporaryFolder folder;
  const auto outcome =
      run_command({ricochet_binary(), "stability", folder.write(scene_of({.elements = 10}))}, folder.path().string());
  EXPECT_EQ(outcome.code, 2) << outcome.out;
  EXPECT_THAT(outcome.error, AllOf(HasSubstr("as no body that yields or turns goes on"), HasSubstr("load_state")));
}

/// Under belytschko_mullen and with substeps, where the implicit side alone yields; penalty where all is explicit.
TEST(PlasticBar, YieldsWhereTheOtherSideAloneIsElastic) {
  const TemporaryFolder folder;
  const std::string elastic = R"([[body]]
name = "far"
material = { youngs_modulus_pa = 2e11, density_kg_m3 = 8000.0 }
mesh = { length_m = 1.0, elements = 100, start_m = 1.0 }
area_m2 = 1e-4
[contact]
surfaces = ["rod.end", "far.start"])";
  for (const std::string protocol : {"belytschko_mullen", "prakash_hjelmstad"}) {
    std::string text = scene_of({.protocol = protocol, .implicit = "2.0, far = 0.1"});
    text = replaced(text, "[contact]\nsurfaces = [\"rod.end\", \"rigid_plane\"]", elastic);
    text = replaced(text, "initial_velocity_m_s = [20]", "initial_velocity_m_s = [40]");
    if (protocol == "prakash_hjelmstad") text = with_key(text, "coupling", "substeps", "2");
    const RunResult run = run_text(text, folder, protocol);
    EXPECT_GT(run.last("plastic_work_j"), 1.0) << protocol;
    EXPECT_LT(largest_error(run), 2e-2) << protocol;
  }
  const Impact penalty{.protocol = "all_explicit", .contact = "enforcement = \"penalty\"\npenalty_pa_m = 1e13\n"};
  const RunResult run = run_text(scene_of(penalty), folder, "penalty");
  EXPECT_NEAR(run.last("plastic_work_j") / Plateau{}.work_j(run.last("time_s")), 1.0, 5e-2);
}

}  // namespace
}  // namespace ricochet::test::plastic

// partition.reduced_modes: bodies whose explicit elements are their lowest modes (reduced_solver).
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "tests/support/run.hpp"

namespace ricochet::test {
namespace {

using testing::HasSubstr;

/// A bar flies onto one twice as long; `modes`: of the short one, twice as many of the other, 0: none, all explicit
/// elements.
std::string two_bars(int modes, const std::string& protocol = "belytschko_mullen") {
  return fmt::format(R"(model = "bar"
[[body]]
name = "left"
material = {{ youngs_modulus_pa = 200e9, density_kg_m3 = 8000.0 }}
area_m2 = 1e-4
mesh = {{ start_m = -0.1, length_m = 0.1, elements = 50 }}
initial_velocity_m_s = [5.0]
[[body]]
name = "right"
material = {{ youngs_modulus_pa = 200e9, density_kg_m3 = 8000.0 }}
area_m2 = 1e-4
mesh = {{ length_m = 0.2, elements = 100 }}
[contact]
surfaces = ["left.end", "right.start"]
[partition]
implicit_length_m = {{ left = 0.01, right = 0.01 }}
{}
[time]
step_s = 3.6e-7
end_s = 8e-5
[coupling]
protocol = "{}"
)",
                     modes > 0 ? fmt::format("reduced_modes = {{ left = {}, right = {} }}", modes, 2 * modes) : "",
                     protocol);
}

/// A block with a round nose falls on the middle of a beam that is held at its ends; what `reduced` says of both.
std::string beam(bool solid, const std::string& protocol, const std::string& reduced, double step_s) {
  const std::string beam_mesh =
      solid ? "height_m = 0.2, width_m = 0.01, elements = [40, 2, 4]" : "height_m = 0.2, elements = [80, 4]";
  const std::string striker_mesh =
      solid ? "height_m = 0.02, width_m = 0.01, elements = [8, 2, 10]" : "height_m = 0.02, elements = [16, 20]";
  const std::string zero = solid ? ", 0.0" : "";
  std::string text = fmt::format(R"(model = "{}"
[material.steel]
youngs_modulus_pa = 210e9
poisson_ratio = 0.3
density_kg_m3 = 7850.0
[[body]]
name = "beam"
material = "steel"
mesh = {{ start_m = -0.01, length_m = 0.01, {}, place = {{ moved_m = [-0.1{}, 0.0] }} }}
[[body.support]]
surface = "inner"
fixed = ["x", "{}"]
[[body.support]]
surface = "outer"
fixed = ["x", "{}"]
[[body]]
name = "striker"
material = "steel"
mesh = {{ length_m = 0.03, {}, place = {{ moved_m = [-0.01{}, 0.0] }} }}
initial_velocity_m_s = [0.3{}, -1.0]
[contact]
surfaces = ["striker.start", "beam.end"]
nose_radius_m = 0.05
[partition]
implicit_length_m = {{ striker = 0.003, beam = 0.0025 }}
{}
[time]
step_s = {}
end_s = 3e-4
[coupling]
protocol = "{}"
)",
                                 solid ? "solid" : "plane_strain", beam_mesh, zero, solid ? "z" : "y",
                                 solid ? "z" : "y", striker_mesh, zero, zero, reduced, step_s, protocol);
  return text;
}

const std::string both_reduced = "reduced_modes = { beam = 40, striker = 40 }";

TEST(ReducedBodies, AreAllImplicitOnesInTheEnd) {
  const TemporaryFolder folder;
  const RunResult whole = run_text(two_bars(0, "all_implicit"), folder);
  const auto furthest = [&](int modes) {
    const RunResult run = run_text(two_bars(modes), folder);
    EXPECT_LT(run.summary["momentum_error_max"].get<double>(), 1e-10) << modes;
    EXPECT_NEAR(run.mean("contact_force_n", 8e-6, 32e-6) / whole.mean("contact_force_n", 8e-6, 32e-6), 1.0, 0.01);
    EXPECT_NEAR(run.last("contact_impulse_n_s") / whole.last("contact_impulse_n_s"), 1.0, 2e-3);
    double furthest_n = 0.0;
    const auto &expected = whole.column("contact_force_n"), &found = run.column("contact_force_n");
    for (std::size_t i = 0; i < expected.size(); ++i)
      furthest_n = std::max(furthest_n, std::abs(found[i] - expected[i]));
    return furthest_n / whole.largest("contact_force_n");
  };
  const double few = furthest(10), some = furthest(20), many = furthest(42);
  EXPECT_GT(few, 0.3) << "a front has no room in ten modes";
  EXPECT_LT(some, 0.5 * few);
  EXPECT_LT(many, 0.006) << "45 are all";
}

struct StruckBeam {
  bool solid;
  std::string reduced;
};

class ReducedBeam : public testing::TestWithParam<StruckBeam> {};

// Against all explicit elements: force, end of the contact, what the beam keeps; and what has to be kept.
TEST_P(ReducedBeam, IsStruckAsTheWholeOne) {
  const TemporaryFolder folder;
  const auto& [solid, reduced] = GetParam();
  const RunResult whole = run_text(beam(solid, "all_explicit", "", 5e-8), folder);
  const RunResult implicit = run_text(beam(solid, "all_implicit", "", 5e-7), folder);
  const RunResult run = run_text(beam(solid, "belytschko_mullen", reduced, 5e-7), folder);
  EXPECT_NEAR(run.largest("contact_force_n") / whole.largest("contact_force_n"), 1.0, 0.01);
  const auto parted_s = [](const RunResult& r) { return r.summary["separation_time_s"].get<double>(); };
  EXPECT_NEAR(parted_s(run) / parted_s(whole), 1.0, 0.01);
  const double before_j = whole.column("energy_kinetic_j").front();
  for (const char* quantity : {"energy_kinetic_j", "energy_strain_j"})
    EXPECT_NEAR(run.last(quantity), whole.last(quantity), 0.01 * before_j) << quantity;
  EXPECT_NEAR(run.last("velocity_mean_striker_m_s"), whole.last("velocity_mean_striker_m_s"), 0.01);
  EXPECT_LT(run.summary["momentum_error_max"].get<double>(), 1e-9);
  EXPECT_LT(run.summary["angular_momentum_error_max"].get<double>(),
            2.5 * implicit.summary["angular_momentum_error_max"].get<double>() + 1e-9);
  EXPECT_NEAR(run.last("energy_error"), implicit.last("energy_error"), 3e-4);
  EXPECT_GT(run.largest("energy_highest_modes_j"), 0.0);
  EXPECT_LT(run.summary["highest_modes_energy_max"].get<double>(), 0.01);
}

INSTANTIATE_TEST_SUITE_P(Bodies, ReducedBeam,
                         testing::Values(StruckBeam{false, both_reduced}, StruckBeam{true, both_reduced},
                                         StruckBeam{true, "reduced_modes = { striker = 40, beam = 60 }"}),
                         [](const auto& test) {
                           return fmt::format("{}_{}", test.param.solid ? "solid" : "plane", test.index);
                         });

TEST(ReducedBodies, AreTheSameIterated) {
  const TemporaryFolder folder;
  const RunResult direct = run_text(beam(false, "belytschko_mullen", both_reduced, 1e-6), folder);
  const RunResult iterated = run_text(beam(false, "fixed_point", both_reduced, 1e-6), folder);
  const double peak_n = direct.largest("contact_force_n");
  for (std::size_t i = 0; i < direct.column("contact_force_n").size(); ++i)
    EXPECT_NEAR(iterated.column("contact_force_n")[i], direct.column("contact_force_n")[i], 1e-4 * peak_n) << i;
}

// Windows of other sizes: the answer of modes depends on them.
TEST(ReducedBodies, TakeWindowsThatChange) {
  const TemporaryFolder folder;
  const std::string text = beam(false, "belytschko_mullen", both_reduced, 1e-6);
  const RunResult constant = run_text(beam(false, "belytschko_mullen", both_reduced, 5e-7), folder);
  const RunResult changing = run_text(
      replaced(text, "end_s = 3e-4\n",
               "end_s = 3e-4\nchanges = [{ from_s = 5e-5, step_s = 2.5e-7 }, { from_s = 1e-4, step_s = 1e-6 }]\n"),
      folder);
  EXPECT_NEAR(changing.largest("contact_force_n") / constant.largest("contact_force_n"), 1.0, 0.01);
  EXPECT_NEAR(changing.last("velocity_mean_striker_m_s"), constant.last("velocity_mean_striker_m_s"), 5e-3);
  EXPECT_LT(changing.summary["momentum_error_max"].get<double>(), 1e-9);
  EXPECT_NEAR(changing.last("energy_error"), constant.last("energy_error"), 1e-3);
}

// Displacements that only probes, fields and pictures show.
TEST(ReducedBodies, AreShownAsWhatTheyWere) {
  const TemporaryFolder folder;
  const std::string probes =
      "[output]\nprobes_every = 1\n[[output.probe]]\nname = \"p\"\nbody = \"beam\"\nat_m = [-0.05, 0.0]\n";
  const auto probes_of = [&](const std::string& protocol) {
    return read_history(run_text(beam(false, protocol, both_reduced, 5e-7) + probes, folder).folder + "/probes.csv");
  };
  const History whole = probes_of("all_implicit"), run = probes_of("belytschko_mullen");
  for (const auto& [name, share] : {std::pair{"p.displacement_y_m", 0.01}, std::pair{"p.velocity_y_m_s", 0.15},
                                    std::pair{"p.stress_xx_pa", 0.15}}) {
    const auto &expected = whole.at(name), &found = run.at(name);
    const double largest = *std::max_element(expected.begin(), expected.end(),
                                             [](double a, double b) { return std::abs(a) < std::abs(b); });
    for (std::size_t i = 0; i < expected.size(); i += 20)
      EXPECT_NEAR(found[i], expected[i], share * std::abs(largest)) << name << i;
  }
}

// Bodies with elements and bodies of modes side by side, as the scene lists their programs.
TEST(ReducedBodies, StandBesideExplicitOnes) {
  const TemporaryFolder folder;
  const std::string one = beam(false, "belytschko_mullen", "reduced_modes = { beam = 40 }", 5e-8);
  const RunResult run = run_text(one, folder);
  const RunResult listed = run_text(one + R"([[participant]]
name = "far"
role = "explicit"
bodies = ["beam"]
[[participant]]
name = "steps"
role = "explicit"
bodies = ["striker"]
[[participant]]
name = "near"
role = "implicit"
)",
                                    folder);
  EXPECT_EQ(run.column("contact_force_n"), listed.column("contact_force_n"));
  EXPECT_LT(run.summary["momentum_error_max"].get<double>(), 1e-9);
  const RunResult whole = run_text(beam(false, "all_explicit", "", 5e-8), folder);
  EXPECT_NEAR(run.largest("contact_force_n") / whole.largest("contact_force_n"), 1.0, 0.01);
}

/// All modes of one warping of the section are among the lowest 60 of 189: what is left of it is round-off, which may
/// be of either sign.
TEST(ReducedBodies, AreRefusedWhereNothingIsLeftOfThem) {
  const TemporaryFolder folder;
  for (const int modes : {60, 80}) {
    const auto run = run_file(
        folder.write(fmt::format(
            "model = \"solid\"\n[[body]]\nname = \"rod\"\nmaterial = {{ youngs_modulus_pa = 200e9, poisson_ratio = "
            "0.3, density_kg_m3 = 2700.0 }}\ninitial_velocity_m_s = [0.0, 0.0, -2.0]\nmesh = {{ length_m = 0.02, "
            "height_m = 0.004, width_m = 0.004, elements = [2, 2, 8] }}\n[contact]\nsurfaces = [\"rod.start\", "
            "\"rigid_plane\"]\n[partition]\nrule = \"auto\"\nreduced_modes = {{ rod = {} }}\n[time]\nstep_s = "
            "3e-8\nend_s = 2.4e-6\n[coupling]\nprotocol = \"belytschko_mullen\"\n",
            modes)),
        folder);
    EXPECT_EQ(run.outcome.code, 3);
    EXPECT_THAT(run.outcome.error, HasSubstr(fmt::format("its {} modes leave its shared nodes no flexibility", modes)));
    EXPECT_THAT(run.outcome.error, Not(HasSubstr("likely cause")));
  }
}

TEST(ReducedBodies, CheckSaysHowManyModes) {
  const TemporaryFolder folder;
  const std::string scene = folder.write(beam(false, "belytschko_mullen", both_reduced, 5e-7));
  const std::string out = run_command({ricochet_binary(), "check", scene}, folder.path().string()).out;
  EXPECT_THAT(out, HasSubstr("reduced          explicit"));
  EXPECT_THAT(out, HasSubstr("        80 "));
  EXPECT_THAT(out, HasSubstr("none"));
}

}  // namespace
}  // namespace ricochet::test

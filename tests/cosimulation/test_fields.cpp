// Accelerations and contact in the VTU files, against the history and exact answers.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "tests/support/places.hpp"
#include "tests/support/plane_grid.hpp"
#include "tests/support/vtu.hpp"

namespace ricochet::test {
namespace {

std::vector<std::int32_t> states_in(const std::vector<std::string>& files) {
  return vtu_array<std::int32_t>(files, "contact_state");
}

class ContactFieldsOf : public testing::TestWithParam<const char*> {};

/// Two plates that slip: pressure 1.09545e7 Pa everywhere, friction 0.3 times that, action and reaction.
TEST_P(ContactFieldsOf, SlippingPlatesHaveTheExactPressureAndForcesInBalance) {
  const TemporaryFolder folder;
  const bool all_explicit = std::string(GetParam()) == "all_explicit";
  const RunResult run = run_text(
      with_key(with_protocol(config_text("slipping_plates"), GetParam()), "output", "fields_every", "20"), folder);
  const auto file = field_files(run.folder, all_explicit ? "explicit" : "implicit", 100);
  const auto pressure = vtu_array(file, "contact_pressure"), gap = vtu_array(file, "contact_gap"),
             force = vtu_array(file, "contact_force");
  const auto state = states_in(file);
  ASSERT_EQ(state.size(), pressure.size());
  ASSERT_EQ(force.size(), 3 * state.size());
  int carrying = 0;
  for (std::size_t n = 0; n < state.size(); ++n) {
    if (state[n] < 0) {
      EXPECT_TRUE(std::isnan(pressure[n]) && std::isnan(gap[n])) << n;
      continue;
    }
    ++carrying;
    EXPECT_EQ(state[n], 2) << "slips";
    EXPECT_NEAR(pressure[n] / 1.09545e7, 1.0, 2e-2);
    EXPECT_NEAR(gap[n], 0.0, 1e-9);
  }
  EXPECT_GE(carrying, 3);
  std::map<bool, std::array<double, 2>> sums;  // of the nodes above and below the contact
  const auto cut = state.size() / 2;           // equal meshes
  for (std::size_t n = 0; n < state.size(); ++n)
    for (std::size_t c = 0; c < 2; ++c) sums[n >= cut][c] += force[3 * n + c];
  const double normal_n = run.column("contact_force_n")[100], friction_n = run.column("friction_force_n")[100];
  EXPECT_NEAR(sums[true][1] / normal_n, 1.0, 1e-12);
  EXPECT_NEAR(sums[false][1] / normal_n, -1.0, 1e-12);
  EXPECT_NEAR(std::abs(sums[true][0] / friction_n), 1.0, 1e-12);
  EXPECT_NEAR(sums[false][0], -sums[true][0], 1e-12 * std::abs(friction_n));
}

INSTANTIATE_TEST_SUITE_P(Protocols, ContactFieldsOf,
                         testing::Values("hughes_liu", "prakash_hjelmstad", "all_implicit", "all_explicit"),
                         [](const auto& test) { return std::string(test.param); });

std::string falling_bar(const std::string& protocol) {
  return with_protocol(
      "model = \"bar\"\n[[body]]\nname = \"rod\"\nmaterial = \"steel_a36\"\narea_m2 = 1e-4\n"
      "mesh = { length_m = 0.1, elements = 20 }\ngravity_m_s2 = [-9.81]\n[partition]\n"
      "implicit_length_m = { rod = 0.05 }\n[contact]\nsurfaces = [\"rod.start\", \"rigid_plane\"]\ninitial_gap_m = "
      "1.0\n[time]\nstep_s = 8.9e-7\nend_s = 2e-5\n[output]\nfields_every = 5\n",
      protocol);
}

/// Over gravity, node by node; those of shared nodes that the link moves are not a number.
std::vector<double> accelerations(const RunResult& run, const char* participant, int window) {
  const auto a = vtu_array(field_files(run.folder, participant, window), "acceleration");
  std::vector<double> values;
  for (std::size_t n = 0; n < a.size(); n += 3) values.push_back(a[n] / -9.81);
  return values;
}

class FreeFall : public testing::TestWithParam<const char*> {};

/// A bar that falls freely has the acceleration of gravity everywhere, on either side of the interface.
TEST_P(FreeFall, HasOneAcceleration) {
  const TemporaryFolder folder;
  const RunResult run = run_text(falling_bar(GetParam()), folder);
  int known = 0;
  for (const char* participant : {"explicit", "implicit"}) {
    for (const double a : accelerations(run, participant, 5)) {
      if (std::isnan(a)) continue;
      EXPECT_NEAR(a, 1.0, 1e-9) << participant;
      ++known;
    }
  }
  EXPECT_GE(known, 21);
}

INSTANTIATE_TEST_SUITE_P(Protocols, FreeFall,
                         testing::Values("kim", "kim_predicted", "belytschko_mullen", "fixed_point",
                                         "gravouil_combescure", "prakash_hjelmstad"),
                         [](const auto& test) { return std::string(test.param); });

/// The predictor of hughes_liu lacks a dt^2/4 of the shared node's motion, which strains the explicit element beside it
/// by a dt^2/(4 h): in the first window the neighbour's acceleration is short by C^2/4, C = c dt/h its Courant number.
TEST(FreeFall, IsDisturbedByThePredictorOfHughesAndLiu) {
  const TemporaryFolder folder;
  const RunResult run = run_text(replaced(falling_bar("hughes_liu"), "fields_every = 5", "fields_every = 1"), folder);
  const double courant = std::sqrt(200e9 / 7850.0) * 8.9e-7 / 0.005;
  const auto a = accelerations(run, "explicit", 1);
  EXPECT_TRUE(std::isnan(a[0]));
  EXPECT_NEAR(a[1], 1.0 - 0.25 * courant * courant, 1e-6);
  EXPECT_NEAR(a[2], 1.0, 1e-9);
  EXPECT_NEAR(run.summary.at("energy_error_max").get<double>(), 0.0137, 2e-4);
  const RunResult longer =
      run_text(replaced(falling_bar("hughes_liu"), "end_s = 2e-5", "end_s = 8.9e-5"), folder, "longer");
  EXPECT_NEAR(longer.last("energy_strain_j") / longer.last("energy_kinetic_j"), 2e-7, 1e-7) << "after 100 windows";
}

/// VTK reads what the run wrote: each body by its name, each participant that has some of it.
TEST(Fields, AreReadByVtkAsOneDataSetATimeWithBodiesByName) {
  const TemporaryFolder folder;
  const RunResult run = run_text(with_key(config_text("two_bars"), "output", "fields_every", "1000"), folder);
  const auto read = [&](int window) {
    const auto file = fmt::format("{}/fields/scene_{:08}.vtm", run.folder, window);
    const auto outcome = run_command({"/usr/bin/python3", source_folder() + "/tests/cosimulation/print_vtm.py", file},
                                     folder.path().string(), 60.0);
    EXPECT_EQ(outcome.code, 0) << outcome.error;
    return outcome.out;
  };
  EXPECT_EQ(read(0),
            "left/explicit 16 15 0.0\nleft/implicit 6 5 0.0\nright/explicit 16 15 0.0\nright/implicit 6 5 0.0\n");
  const int last = run.summary.at("windows").get<int>();
  std::istringstream lines(read(last));
  std::string name;
  double nodes = 0, cells = 0, largest_m = 0, found_m = 0;
  while (lines >> name >> nodes >> cells >> largest_m) found_m = std::max(found_m, largest_m);
  double expected_m = 0.0;
  for (const char* participant : {"explicit", "implicit"})
    for (const double u : vtu_array(field_files(run.folder, participant, last), "displacement"))
      expected_m = std::max(expected_m, std::abs(u));
  EXPECT_NEAR(found_m / expected_m, 1.0, 1e-12);
}

}  // namespace
}  // namespace ricochet::test

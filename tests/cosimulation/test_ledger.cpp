// Balances that a run reports besides energy: angular momentum, axial momentum of a ring, drift of an interface; and
// the velocity of shared nodes in the fields.
#include <gmock/gmock.h>

#include <map>

#include "tests/support/run.hpp"
#include "tests/support/vtu.hpp"

namespace ricochet::test {
namespace {

/// Two blocks, one smaller along the axis, that meet obliquely with friction; the upper one spins afterwards.
std::string blocks(const std::string& protocol, bool plane) {
  std::string text = "model = \"plane_strain\"\n";
  for (const std::string name : {"lower", "upper"}) {
    if (plane && name == "upper") continue;
    text += "[[body]]\nname = \"" + name +
            "\"\nmaterial = { youngs_modulus_pa = 1e9, poisson_ratio = 0.25, density_kg_m3 = 1000.0 }\n";
    text += name == "lower"
                ? "mesh = { start_m = -0.06, height_m = 0.04, length_m = 0.06, elements = [4, 6] }\ngravity_m_s2 = "
                  "[30.0, 100.0]\n"
                  "initial_velocity_m_s = [1.0, 2.0]\n"
                : "mesh = { height_m = 0.04, length_m = 0.03, elements = [4, 3] }\ninitial_velocity_m_s = [0.0, -1.0]\n"
                  "traction = [{ surface = \"outer\", traction_pa = [0.0, 1e5] }]\n";
  }
  return text + "[contact]\nsurfaces = [\"lower.end\", \"" + (plane ? "rigid_plane" : "upper.start") +
         "\"]\nfriction_coefficient = 0.3\n[partition]\nimplicit_length_m = { lower = 0.021" +
         (plane ? "" : ", upper = 0.011") + " }\n[time]\nstep_s = 4e-6\nend_s = 6e-4\n[coupling]\nprotocol = \"" +
         protocol + "\"\n";
}

/// The same with a tenth of all speeds and loads.
std::string gentler(std::string text) {
  const std::pair<const char*, const char*> tenths[] = {
      {"[1.0, 2.0]", "[0.1, 0.2]"}, {"[0.0, -1.0]", "[0.0, -0.1]"}, {"[0.0, 1e5]", "[0.0, 1e4]"}};
  for (const auto& [whole, tenth] : tenths)
    if (text.find(whole) != std::string::npos) text = replaced(text, whole, tenth);
  return replaced(text, "[30.0, 100.0]", "[3.0, 10.0]");
}

class AngularMomentum : public testing::TestWithParam<std::string> {};

TEST_P(AngularMomentum, IsBalancedAgainstTheMomentsOfLoadsAndOfARigidPlane) {
  const TemporaryFolder folder;
  for (const bool plane : {false, true}) {
    const auto run = run_text(blocks(GetParam(), plane), folder, plane ? "plane" : "two");
    const auto& angular = run.column("angular_momentum_z_kg_m2_s");
    const double scale =
        *std::max_element(angular.begin(), angular.end()) - *std::min_element(angular.begin(), angular.end());
    EXPECT_GT(scale, 0.01) << "loads and friction change it";
    EXPECT_LT(run.summary.at("angular_momentum_error_max").get<double>(), 3e-3) << plane << ": strains are";
    EXPECT_LT(run.summary.at("momentum_error_max").get<double>(), 1e-9) << plane;
    // Small strain balances moments where bodies were: what is open goes with what they have moved since. Anything that
    // the ledger left out would not.
    const auto gentle = run_text(gentler(blocks(GetParam(), plane)), folder, plane ? "gentle_plane" : "gentle_two");
    const double open = run.summary.at("angular_momentum_error_max").get<double>();
    EXPECT_NEAR(gentle.summary.at("angular_momentum_error_max").get<double>(), 0.1 * open, 1e-6 * open) << plane;
  }
}

INSTANTIATE_TEST_SUITE_P(Protocols, AngularMomentum,
                         testing::Values("hughes_liu", "belytschko_mullen", "prakash_hjelmstad", "all_implicit",
                                         "all_explicit"),
                         [](const auto& test) { return test.param; });

TEST(AngularMomentum, IsNotBalancedWhereThePlatesRepeat) {
  const TemporaryFolder folder;
  const auto run = run_text(config_text("slipping_plates"), folder);
  EXPECT_TRUE(run.summary.at("angular_momentum_error_max").is_null()) << "not 0";
  EXPECT_EQ(run.history.count("angular_momentum_z_kg_m2_s"), 0U);
}

/// The normal is radial: what the plane gives along it is no momentum, what there is runs along the axis.
TEST(AxialMomentum, OfARingAgainstAPlaneAroundIt) {
  const std::string ring = R"(model = "axisymmetric"
[[body]]
name = "ring"
material = { youngs_modulus_pa = 1e9, poisson_ratio = 0.25, density_kg_m3 = 1000.0 }
mesh = { radius_m = 0.04, length_m = 0.06, elements = [4, 6] }
traction = [{ surface = "end", traction_pa = [0.0, -1e6] }]
[contact]
surfaces = ["ring.outer", "rigid_plane"]
initial_gap_m = 1e-6
friction_coefficient = 0.2
[partition]
implicit_length_m = { ring = 0.011 }
[time]
step_s = 4e-6
end_s = 6e-4
)";
  const TemporaryFolder folder;
  for (const char* protocol : {"hughes_liu", "all_implicit", "all_explicit"}) {
    const auto run = run_text(with_protocol(ring, protocol), folder, protocol);
    EXPECT_GT(run.largest("contact_force_n"), 0.0) << protocol;
    EXPECT_LT(run.summary.at("momentum_error_max").get<double>(), 1e-9) << protocol;
  }
}

TEST(InterfaceDrift, IsThatOfTheDisplacementsWhereOnlyVelocitiesAreTied) {
  const TemporaryFolder folder;
  std::string text = with_key(with_protocol(config_text("two_bars"), "prakash_hjelmstad"), "coupling", "substeps", "4");
  text = with_key(with_key(text, "output", "fields_every", "1"), "coupling", "after_separation", "\"implicit\"");
  const auto run = run_text(replaced(text, "step_s = 2.226e-6", "step_s = 8e-6"), folder);
  double largest = 0.0;
  for (int window = 0; window <= run.summary.at("windows").get<int>(); ++window) {
    std::map<double, double> of_explicit;
    for (const std::string participant : {"explicit", "implicit"}) {
      const auto files = field_files(run.folder, participant, window);
      const auto x = vtu_array(files, "Points"), u = vtu_array(files, "displacement");
      for (std::size_t i = 0; i < x.size(); i += 3) {
        if (participant == "explicit")
          of_explicit[x[i]] = u[i];
        else if (of_explicit.count(x[i]))
          largest = std::max(largest, std::abs(u[i] - of_explicit[x[i]]));
      }
    }
  }
  EXPECT_GT(largest, 0.0);
  EXPECT_NEAR(run.summary.at("interface_drift_m").get<double>(), largest, 1e-6 * largest);
  EXPECT_THAT(run.outcome.out, testing::HasSubstr("interface drift"));
  EXPECT_EQ(run_text(config_text("two_bars"), folder, "one_motion").summary.at("interface_drift_m"), 0.0);
}

TEST(Fields, TellTheVelocityOfSharedNodesFromEitherSide) {
  const TemporaryFolder folder;
  for (const char* protocol : {"hughes_liu", "kim", "belytschko_mullen", "fixed_point"}) {
    const auto run = run_text(
        with_protocol(with_key(config_text("two_bars"), "output", "fields_every", "1000"), protocol), folder, protocol);
    std::map<double, double> of_explicit;
    int shared = 0;
    for (const std::string participant : {"explicit", "implicit"}) {
      const auto files = field_files(run.folder, participant, run.summary.at("windows").get<int>());
      const auto x = vtu_array(files, "Points"), v = vtu_array(files, "velocity");
      for (std::size_t i = 0; i < x.size(); i += 3) {
        if (participant == "explicit") of_explicit[x[i]] = v[i];
        if (participant == "explicit" || !of_explicit.count(x[i])) continue;
        ++shared;
        EXPECT_NEAR(of_explicit[x[i]], v[i], 1.0)
            << protocol << " at " << x[i];  // of waves; it was 5 and -5 at the start
      }
    }
    EXPECT_EQ(shared, 2) << protocol;
  }
}

}  // namespace
}  // namespace ricochet::test

// Bodies thrown at a rigid sphere or a rigid cylinder, against Hertz' theory and against each other.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/support/run.hpp"

namespace ricochet::test {
namespace {

/// A disc of 20 mm radius and height with speed v on a rigid sphere of 10 mm radius. Hertz: with E* = E/(1 - nu^2),
///   approach d = (15 m v^2 / (16 sqrt(R) E*))^(2/5),  force 4/3 E* sqrt(R) d^(3/2),  time 2.9432 d/v.
struct DiscOnSphere {
  static constexpr double modulus = 48e9 / (1.0 - 0.2 * 0.2), sphere = 0.01, size = 0.02;
  double speed, mass = 2800.0 * std::numbers::pi * size * size * size;
  double approach = std::pow(15.0 * mass * speed * speed / (16.0 * std::sqrt(sphere) * modulus), 0.4);
  double duration_s = 2.9432 * approach / speed;

  [[nodiscard]] static double force(double depth) {
    return 4.0 / 3.0 * modulus * std::sqrt(sphere) * std::pow(std::max(depth, 0.0), 1.5);
  }
  [[nodiscard]] std::string scene(const char* model, int elements, double grading, const std::string& protocol,
                                  double steps) const {
    return fmt::format(
        "model = \"{}\"\n[[body]]\nname = \"disc\"\nmaterial = {{ youngs_modulus_pa = 48e9, poisson_ratio = 0.2, "
        "density_kg_m3 = 2800.0 }}\nmesh = {{ length_m = 0.02, radius_m = 0.02, elements = [{}, {}], grading = [{}, "
        "{}] "
        "}}\ninitial_velocity_m_s = [{}0.0, -{}]\n[contact]\nsurfaces = [\"disc.start\", \"rigid_sphere\"]\n"
        "rigid_radius_m = 0.01\n[time]\nstep_s = {}\nend_s = {}\n[coupling]\nprotocol = \"{}\"\n",
        model, elements, elements, grading, grading, model[0] == 's' ? "0.0, " : "", speed, duration_s / steps,
        1.2 * duration_s, protocol);
  }
};

/// At 0.1 m/s the contact is 0.27 mm wide, a hundredth of the disc, whose size tells by 1 % in the force. Measured,
/// with 24, 48 and 96 elements across: peak 3.1 % above, 1.0 % below and 1.1 % above Hertz'.
TEST(RigidSphere, PressesADiscAsHertzHasIt) {
  const DiscOnSphere hertz{0.1};
  for (const auto& [elements, tolerance, on_the_way] : {std::tuple{24, 0.04, 0.10}, {48, 0.015, 0.06}}) {
    const TemporaryFolder folder;
    const RunResult run = run_text(hertz.scene("axisymmetric", elements, 20.0, "all_implicit", 400.0), folder);
    EXPECT_NEAR(run.summary.at("peak_contact_force_n").get<double>() / DiscOnSphere::force(hertz.approach), 1.0,
                tolerance);
    // Force against approach, which is what the disc as a whole has flown, on the way in and out; the size tells more
    // there.
    const auto &force = run.column("contact_force_n"), &velocity = run.column("velocity_mean_disc_m_s");
    double depth_m = 0.0, touching_s = 0.0, worst = 0.0;
    for (std::size_t i = 0; i < force.size(); ++i) {
      if (i > 0) depth_m += 0.5 * (velocity[i - 1] + velocity[i]) * hertz.duration_s / 400.0;
      if (force[i] > 0.0) touching_s += hertz.duration_s / 400.0;
      if (depth_m > 0.5 * hertz.approach)
        worst = std::max(worst, std::abs(force[i] / DiscOnSphere::force(depth_m) - 1.0));
    }
    EXPECT_LT(worst, on_the_way);
    EXPECT_NEAR(touching_s / hertz.duration_s, 1.0, 0.02);
    EXPECT_LT(run.summary.at("momentum_error_max").get<double>(), 1e-10);
    EXPECT_NEAR(run.last("contact_impulse_n_s"), 2.0 * hertz.mass * hertz.speed, 1e-4 * hertz.mass * hertz.speed);
  }
}

class RigidSphereBy : public testing::TestWithParam<const char*> {};

TEST_P(RigidSphereBy, EveryProtocolHasTheSameForce) {
  const DiscOnSphere hertz{1.0};
  const TemporaryFolder folder;
  const bool is_explicit = std::string(GetParam()) == "all_explicit";
  const RunResult run =
      run_text(hertz.scene("axisymmetric", 24, 10.0, GetParam(), is_explicit ? 4000.0 : 1000.0), folder);
  EXPECT_NEAR(run.summary.at("peak_contact_force_n").get<double>() / DiscOnSphere::force(hertz.approach), 1.025, 0.005);
  EXPECT_LT(run.summary.at("momentum_error_max").get<double>(), 1e-10);
  EXPECT_LT(run.summary.at("energy_error_max").get<double>(), 1e-4);
}

INSTANTIATE_TEST_SUITE_P(Protocols, RigidSphereBy,
                         testing::Values("hughes_liu", "prakash_hjelmstad", "all_implicit", "all_explicit"),
                         [](const auto& test) { return std::string(test.param); });

/// Hertz' force is exceeded by 2.7 % at 1 m/s, which is the disc's size: 48 elements across in axisymmetry. A solid of
/// few elements nears that.
TEST(RigidSphere, PressesASolidDiscAsAnAxisymmetricOne) {
  const DiscOnSphere hertz{1.0};
  const auto peak = [&](const char* model, int elements, double grading, const char* protocol, double steps) {
    const TemporaryFolder folder;
    const RunResult run = run_text(hertz.scene(model, elements, grading, protocol, steps), folder);
    return run.summary.at("peak_contact_force_n").get<double>();
  };
  const double fine = peak("axisymmetric", 48, 20.0, "all_implicit", 400.0);
  EXPECT_NEAR(fine / DiscOnSphere::force(hertz.approach), 1.027, 0.003);
  EXPECT_NEAR(peak("solid", 6, 10.0, "all_explicit", 2000.0) / fine, 1.0, 0.05);
  EXPECT_NEAR(peak("solid", 8, 10.0, "all_explicit", 2000.0) / fine, 1.0, 0.01);
}

std::string block_on(const std::string& obstacle, const std::string& mesh, const std::string& more,
                     const std::string& protocol = "all_explicit", const std::string& supports = "") {
  return "model = \"solid\"\n[[body]]\nname = \"block\"\nmaterial = { youngs_modulus_pa = 48e9, poisson_ratio = 0.2, "
         "density_kg_m3 = 2800.0 }\nmesh = { " +
         mesh + " }\ninitial_velocity_m_s = [0.0, 0.0, -1.0]\n" + supports +
         "[contact]\nsurfaces = [\"block.start\", \"" + obstacle + "\"]\nrigid_radius_m = 0.01\n" + more +
         "[time]\nstep_s = 1e-7\nend_s = 60e-6\n[coupling]\nprotocol = \"" + protocol + "\"\n";
}

void expect_columns_near(const RunResult& a, const RunResult& b, double times, double tolerance) {
  const auto &x = a.column("contact_force_n"), &y = b.column("contact_force_n");
  ASSERT_EQ(x.size(), y.size());
  const double largest = b.largest("contact_force_n");
  ASSERT_GT(largest, 0.0);
  for (std::size_t i = 0; i < x.size(); ++i) ASSERT_NEAR(times * x[i], y[i], tolerance * largest) << i;
}

/// A quarter with its planes of symmetry through the sphere's middle, where the origin is, and all of the block on a
/// sphere in its middle.
TEST(RigidSphere, PressesAQuarterWithAQuarterOfTheForce) {
  const TemporaryFolder folder;
  const std::string planes =
      "[[body.support]]\nsurface = \"inner\"\nfixed = [\"x\"]\n[[body.support]]\nsurface = \"front\"\nfixed = "
      "[\"y\"]\n";
  const RunResult quarter =
      run_text(block_on("rigid_sphere", "length_m = 0.01, height_m = 0.01, width_m = 0.01, elements = [5, 5, 5]", "",
                        "all_explicit", planes),
               folder, "quarter");
  const RunResult whole =
      run_text(block_on("rigid_sphere", "length_m = 0.01, height_m = 0.02, width_m = 0.02, elements = [10, 10, 5]",
                        "rigid_place_m = [0.01, 0.01, 0.0]\n"),
               folder, "whole");
  expect_columns_near(quarter, whole, 4.0, 1e-12);
  EXPECT_LT(quarter.summary.at("momentum_error_max").get<double>(), 1e-11);
}

/// Off the middle of the block, which it turns and pushes aside, with and without friction. The push aside comes,
/// without friction, from normal forces alone: no column of friction has any of it, and both together are the change of
/// momentum.
TEST(RigidSphere, KeepsTheBalancesOfABlockThatItHitsOffItsMiddle) {
  for (const std::string friction : {"", "friction_coefficient = 0.3\n"}) {
    for (const std::string protocol : {"hughes_liu", "all_explicit"}) {
      const TemporaryFolder folder;
      const RunResult run =
          run_text(block_on("rigid_sphere", "length_m = 0.01, height_m = 0.02, width_m = 0.02, elements = [6, 6, 4]",
                            "rigid_place_m = [0.006, 0.009, 0.0]\n" + friction, protocol),
                   folder);
      EXPECT_LT(run.summary.at("momentum_error_max").get<double>(), 1e-11) << protocol << friction;
      EXPECT_LT(run.summary.at("energy_error_max").get<double>(), 0.02) << protocol << friction;
      EXPECT_GT(run.last("contact_impulse_n_s"), 0.0);
      const auto& aside = run.column("momentum_t_kg_m_s");
      EXPECT_GT(std::abs(aside.back() - aside.front()), 1e-6) << "its normal is not the surface's everywhere";
      const double scale = run.last("contact_impulse_n_s");
      EXPECT_NEAR(aside.front() - aside.back(), run.last("normal_impulse_t_n_s") + run.last("friction_impulse_n_s"),
                  1e-11 * scale);
      const auto& aside_b = run.column("momentum_b_kg_m_s");
      EXPECT_NEAR(aside_b.front() - aside_b.back(),
                  run.last("normal_impulse_b_n_s") + run.last("friction_impulse_b_n_s"), 1e-11 * scale);
      for (const char* along : {"normal_force_t_n", "normal_force_b_n"})
        EXPECT_GT(run.largest(along) - run.smallest(along), 1e-3 * run.largest("contact_force_n")) << along;
      for (const char* of_friction :
           {"friction_force_n", "friction_force_b_n", "friction_impulse_n_s", "friction_impulse_b_n_s"})
        EXPECT_EQ(run.largest(of_friction) == 0.0 && run.smallest(of_friction) == 0.0, friction.empty()) << of_friction;
    }
  }
}

/// A cylinder along x under a block is one along y under the block turned by a right angle.
TEST(RigidCylinder, LiesAlongXOrY) {
  const TemporaryFolder folder;
  const RunResult along_y =
      run_text(block_on("rigid_cylinder", "length_m = 0.01, height_m = 0.02, width_m = 0.012, elements = [8, 3, 4]",
                        "rigid_axis = \"y\"\nrigid_place_m = [0.01, 0.0, 0.0]\n"),
               folder, "y");
  const RunResult along_x =
      run_text(block_on("rigid_cylinder", "length_m = 0.01, height_m = 0.012, width_m = 0.02, elements = [3, 8, 4]",
                        "rigid_axis = \"x\"\nrigid_place_m = [0.0, 0.01, 0.0]\n"),
               folder, "x");
  expect_columns_near(along_x, along_y, 1.0, 1e-9);
}

/// E = rho = 1, nu = 0.3: half of a plate of unit size, graded towards where it meets a cylinder or a nose.
RunResult plate_on(bool cylinder, double radius_m, const TemporaryFolder& folder) {
  const std::string text = fmt::format(
      "model = \"plane_strain\"\n[[body]]\nname = \"plate\"\nmaterial = {{ youngs_modulus_pa = 1.0, poisson_ratio = "
      "0.3, density_kg_m3 = 1.0 }}\nmesh = {{ length_m = 1.0, height_m = 1.0, elements = [48, 24], grading = [20.0, "
      "20.0] }}\ninitial_velocity_m_s = [0.0, -1e-4]\nsupport = [{{ surface = \"inner\", fixed = [\"x\"] }}]\n"
      "[contact]\nsurfaces = [\"plate.start\", \"{}\"]\n{} = {}\n[time]\nstep_s = 0.02\nend_s = 10.0\n[coupling]\n"
      "protocol = \"all_implicit\"\n",
      cylinder ? "rigid_cylinder" : "rigid_plane", cylinder ? "rigid_radius_m" : "nose_radius_m", radius_m);
  return run_text(text, folder, cylinder ? "cylinder" : "nose");
}

/// As wide as Hertz has it for the force, b = sqrt(8 F R / (pi E*)) with F that of the half: between the last node that
/// touches and the first that does not. The parabola of a nose is the cylinder's, the closer the flatter they are.
TEST(RigidCylinder, TouchesAPlateAsWidelyAsHertzHasItAndAsANose) {
  double coarser = 1e-3;
  for (const double radius_m : {1.0, 4.0, 16.0}) {
    const TemporaryFolder folder;
    const RunResult run = plate_on(true, radius_m, folder), nose = plate_on(false, radius_m, folder);
    const auto& force = run.column("contact_force_n");
    const auto peak = static_cast<std::size_t>(std::max_element(force.begin(), force.end()) - force.begin());
    const double width = std::sqrt(8.0 * force[peak] * radius_m * (1.0 - 0.09) / std::numbers::pi);
    const double closed = run.column("pairs_stick")[peak] + run.column("pairs_slip")[peak];
    const double ratio = std::pow(20.0, 1.0 / 47.0);
    const auto node_at = [&](double i) { return std::expm1(i * std::log(ratio)) / std::expm1(48.0 * std::log(ratio)); };
    EXPECT_GT(width, node_at(closed - 1.0)) << radius_m;
    EXPECT_LT(width, node_at(closed)) << radius_m;
    double worst = 0.0;
    for (std::size_t i = 0; i < force.size(); ++i)
      worst = std::max(worst, std::abs(force[i] - nose.column("contact_force_n")[i]) / force[peak]);
    EXPECT_LT(worst, coarser) << radius_m;
    coarser = worst;
  }
}

}  // namespace
}  // namespace ricochet::test

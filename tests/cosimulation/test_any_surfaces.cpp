// Contact between surfaces whose meshes do not match, and the bars of Wolff and Bucher, against exact answers.
#include <fmt/format.h>

#include <cmath>
#include <complex>
#include <filesystem>

#include "tests/support/block_mesh.hpp"
#include "tests/support/run.hpp"
#include "tests/support/vtu.hpp"

namespace ricochet::test {
namespace {

const double plate_c_l = std::sqrt(1e9 * 0.75 / (1000 * 1.25 * 0.5)), plate_c_s = std::sqrt(1e9 / (2 * 1000 * 1.25));
const double stick_limit_m_s = 0.3 * plate_c_l / plate_c_s * 10.0;

/// A3 (words.md) with four elements across the lower plate and six across the upper one, sliding, if solid, at 30
/// degrees from the tangent.
struct UnequalPlates {
  const char *model, *protocol;
  double v_t = 0.0;
  int along = 100;

  [[nodiscard]] double width_m() const { return 0.25 * 4 / along; }
  [[nodiscard]] bool solid() const { return std::string(model) == "solid"; }
  [[nodiscard]] double area_m2() const { return solid() ? width_m() * width_m() : width_m(); }
  [[nodiscard]] double angle() const { return solid() ? M_PI / 6.0 : 0.0; }
  [[nodiscard]] double exact_pa() const { return std::min(1000 * plate_c_s * v_t, 0.3 * 1000 * plate_c_l * 10.0); }
  [[nodiscard]] RunResult run(const TemporaryFolder& folder) const {
    std::string text = fmt::format("model = \"{}\"\n", model);
    for (const auto& [name, start, sign, across] :
         {std::tuple{"lower", -0.25, 1.0, 4}, std::tuple{"upper", 0.0, -1.0, 6}}) {
      const std::string x = fmt::format("{:.17g}", sign * v_t * std::cos(angle())),
                        y = fmt::format("{:.17g}", sign * v_t * std::sin(angle()));
      text += fmt::format(
          "[[body]]\nname = \"{}\"\nmaterial = {{ youngs_modulus_pa = 1e9, poisson_ratio = 0.25, density_kg_m3 = "
          "1000.0 "
          "}}\nmesh = {{ start_m = {}, length_m = 0.25, height_m = {:.17g}, {} elements = [{}{}], periodic_across = "
          "true "
          "}}\ninitial_velocity_m_s = [{}, {:.1f}]\n",
          name, start, width_m(), solid() ? fmt::format("width_m = {:.17g},", width_m()) : "",
          solid() ? fmt::format("{0}, {0}, ", across) : fmt::format("{}, ", across), along, solid() ? x + ", " + y : x,
          sign * 10.0);
    }
    text +=
        "[contact]\nsurfaces = [\"upper.start\", \"lower.end\"]\nfriction_coefficient = 0.3\n[partition]\n"
        "implicit_length_m = { lower = 0.025, upper = 0.025 }\n[time]\nsafety_factor = 0.9\nend_s = 420e-6\n";
    return run_text(with_protocol_of_two_steps(text, protocol), folder);
  }
  /// Mean over the plateau of the traction that the lower plate, the second body, gets: along t, and as imaginary part
  /// along n x t. Out of the upper plate n is down, so that n x t = -y.
  [[nodiscard]] std::complex<double> traction_pa(const RunResult& run) const {
    const double along_b = solid() ? run.mean("friction_force_b_n", 50e-6, 400e-6) : 0.0;
    return std::complex<double>(run.mean("friction_force_n", 50e-6, 400e-6), along_b) / area_m2();
  }
  /// The upper plate drags the lower one along its own velocity.
  [[nodiscard]] std::complex<double> exact_traction_pa() const { return -std::polar(exact_pa(), -angle()); }
};

class Unequal : public testing::TestWithParam<std::tuple<const char*, const char*>> {};

/// 1 % below and above the limit of sticking, and far from it: 3 m/s sticks, 20 m/s slides some elements far. The edge
/// is as sharp as the pressure is smooth: short elements.
TEST_P(Unequal, PlatesHaveTheTractionOfTheoryOnEitherSideOfTheStickLimit) {
  const auto& [model, protocol] = GetParam();
  const std::string name = protocol;
  const int fine = name == "prakash_hjelmstad" ? 400 : name == "hughes_liu" ? 200 : 100;
  struct Case {
    double v_t;
    int along;
    bool sticks;
  };
  for (const Case& c : {Case{3.0, 50, true}, Case{20.0, 50, false}, Case{0.99 * stick_limit_m_s, fine, true},
                        Case{1.01 * stick_limit_m_s, fine, false}}) {
    const TemporaryFolder folder;
    const UnequalPlates plates{.model = model, .protocol = protocol, .v_t = c.v_t, .along = c.along};
    const RunResult r = plates.run(folder);
    EXPECT_LT(std::abs(plates.traction_pa(r) - plates.exact_traction_pa()), 1e-3 * plates.exact_pa()) << c.v_t;
    EXPECT_NEAR(r.mean("contact_pressure_mean_pa", 50e-6, 400e-6), 1.09545e7, 1e-3 * 1.09545e7) << c.v_t;
    const double pairs = plates.solid() ? 36.0 : 6.0;
    EXPECT_GT(r.mean(c.sticks ? "pairs_stick" : "pairs_slip", 50e-6, 400e-6), 0.8 * pairs) << c.v_t;
    EXPECT_LT(r.summary.at("momentum_error_max").get<double>(), 1e-10);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Models, Unequal,
    testing::Combine(testing::Values("plane_strain", "solid"),
                     testing::Values("hughes_liu", "prakash_hjelmstad", "all_implicit", "all_explicit")),
    [](const auto& test) { return std::string(std::get<0>(test.param)) + "_" + std::get<1>(test.param); });

/// Two blocks, 2 x 2 against 3 x 3 elements across, meet along an axis that lies anyhow in space. With nu = 0 each is a
/// bar: exact are the forces of bars with the same elements along, and one stress in every layer.
RunResult turned_impact(const Turn& turn, const std::string& protocol, const TemporaryFolder& folder) {
  std::string text = "model = \"solid\"\n";
  for (const auto& [name, start, sign, across] :
       {std::tuple{"lower", -0.1, 1.0, 2}, std::tuple{"upper", 0.0, -1.0, 3}}) {
    const BlockMesh block{.size_m = 0.03, .start_m = start, .length_m = 0.1, .across = across, .along = 10};
    (void)folder.write(turned(block_msh(name, block), turn), std::string(name) + ".msh");
    const Vector3 v = turn.of({0.0, 0.0, sign * 5.0});
    text += fmt::format(
        "[[body]]\nname = \"{0}\"\nmaterial = {{ youngs_modulus_pa = 1e9, poisson_ratio = 0.0, density_kg_m3 = 1000.0 "
        "}}\nmesh = {{ gmsh = \"{0}.msh\" }}\ninitial_velocity_m_s = [{1:.17g}, {2:.17g}, {3:.17g}]\n",
        name, v[0], v[1], v[2]);
  }
  text +=
      "[contact]\nsurfaces = [\"lower.end\", \"upper.start\"]\n[partition]\nimplicit_length_m = { lower = 0.03, upper "
      "= "
      "0.03 }\n[time]\nstep_s = 5e-6\nend_s = 4e-4\n[output]\nfields_every = 20\n";
  return run_text(with_protocol_of_two_steps(text, protocol), folder);
}

RunResult bar_impact(const std::string& protocol, const TemporaryFolder& folder) {
  std::string text = "model = \"bar\"\n";
  for (const auto& [name, start, sign] : {std::tuple{"lower", -0.1, 1.0}, std::tuple{"upper", 0.0, -1.0}})
    text += fmt::format(
        "[[body]]\nname = \"{}\"\nmaterial = {{ youngs_modulus_pa = 1e9, density_kg_m3 = 1000.0 }}\narea_m2 = 9e-4\n"
        "mesh = {{ start_m = {}, length_m = 0.1, elements = 10 }}\ninitial_velocity_m_s = [{:.1f}]\n",
        name, start, sign * 5.0);
  text +=
      "[contact]\nsurfaces = [\"lower.end\", \"upper.start\"]\n[partition]\nimplicit_length_m = { lower = 0.03, upper "
      "= "
      "0.03 }\n[time]\nstep_s = 5e-6\nend_s = 4e-4\n";
  return run_text(with_protocol_of_two_steps(text, protocol), folder);
}

/// Largest velocity across the axis of any node, in the middle of the contact: a stress that is not the same all over a
/// cross-section would make one.
double velocity_aside_m_s(const RunResult& run, const Turn& turn) {
  double largest = 0.0;
  for (const char* participant : {"explicit", "implicit"}) {
    const auto file = field_files(run.folder, participant, 20);
    if (file.empty()) continue;
    const auto v = vtu_array(file, "velocity");
    for (std::size_t i = 0; i < v.size(); i += 3) {
      const Vector3 axis = turn.of({0.0, 0.0, 1.0});
      const double along = v[i] * axis[0] + v[i + 1] * axis[1] + v[i + 2] * axis[2];
      largest =
          std::max(largest, std::hypot(v[i] - along * axis[0], v[i + 1] - along * axis[1], v[i + 2] - along * axis[2]));
    }
  }
  return largest;
}

TEST(TurnedAnyWay, BlocksOfUnequalMeshesPassThePatchTest) {
  for (const char* protocol : {"hughes_liu", "prakash_hjelmstad", "all_implicit", "all_explicit"}) {
    const TemporaryFolder bar_folder;
    const RunResult bars = bar_impact(protocol, bar_folder);
    const double peak_n = bars.largest("contact_force_n");
    for (const Turn& turn : {Turn{}, Turn{.about_z = 0.4, .about_x = 1.1}}) {
      const TemporaryFolder folder;
      const RunResult blocks = turned_impact(turn, protocol, folder);
      const auto &exact = bars.column("contact_force_n"), &force = blocks.column("contact_force_n");
      ASSERT_EQ(force.size(), exact.size());
      for (std::size_t i = 0; i < force.size(); ++i)
        ASSERT_NEAR(force[i], exact[i], 1e-10 * peak_n) << protocol << ", window " << i;
      EXPECT_LT(velocity_aside_m_s(blocks, turn), 1e-10 * 5.0) << protocol;
    }
  }
}

/// Two bars 10 x 1 x 1, E = rho = 1, nu = 0, meet at +-0.1 (Wolff and Bucher 2013): the force is 0.1 for as long as a
/// wave runs there and back, 20. Meshes of 5n x n x n bricks, four times finer at the contact than at the far end.
RunResult wolff_bucher(const std::string& protocol, const std::string& law, int n, const TemporaryFolder& folder) {
  std::string text = "model = \"solid\"\n";
  for (const auto& [name, start, sign] : {std::tuple{"left", -10.0, 1.0}, std::tuple{"right", 0.0, -1.0}})
    text += fmt::format(
        "[[body]]\nname = \"{0}\"\nmaterial = {{ youngs_modulus_pa = 1.0, poisson_ratio = 0.0, density_kg_m3 = 1.0 }}\n"
        "mesh = {{ start_m = {1}, length_m = 10.0, height_m = 1.0, width_m = 1.0, elements = [{2}, {2}, {3}], grading "
        "= "
        "[1.0, 1.0, {4}] }}\ninitial_velocity_m_s = [0.0, 0.0, {5}]\n",
        name, start, n, 5 * n, sign > 0.0 ? 0.25 : 4.0, sign * 0.1);
  text +=
      "[contact]\nsurfaces = [\"left.end\", \"right.start\"]\nmultiplier_update = \"" + law +
      "\"\n[partition]\nimplicit_length_m = { left = 2.0, right = 2.0 }\n[time]\nsafety_factor = 0.9\nend_s = 30.0\n";
  text =
      with_key(with_protocol_of_two_steps(text, protocol), "coupling", "outside_model", "\"go_on\"");  // strains of 0.1
  return run_text(text, folder);
}

/// The law that stops contact nodes loses at most 1/(2 * 5n) of the energy; without mass at the contact the baselines
/// lose none, and what a hybrid is then wrong by falls as the mesh is refined.
TEST(WolffAndBucher, BarsMeetWithTheForceOfTheImpedanceForTwentySeconds) {
  for (const char* law : {"trapezoidal_reset", "massless"}) {
    for (const std::string protocol : {"hughes_liu", "prakash_hjelmstad", "all_implicit", "all_explicit"}) {
      for (const int n : {2, 4}) {
        const TemporaryFolder folder;
        const RunResult r = wolff_bucher(protocol, law, n, folder);
        SCOPED_TRACE(fmt::format("{} {} n = {}", law, protocol, n));
        EXPECT_NEAR(r.mean("contact_force_n", 3.0, 17.0), 0.1, 0.1 * 0.025 / n);
        const auto &time = r.column("time_s"), &force = r.column("contact_force_n");
        double last_s = 0.0;
        for (std::size_t i = 0; i < time.size(); ++i)
          if (force[i] > 0.0) last_s = time[i];
        EXPECT_NEAR(last_s, 20.0, 3.5 / n);
        const auto energy = [&](std::size_t i) {
          return r.column("energy_kinetic_j")[i] + r.column("energy_strain_j")[i];
        };
        const double lost = 1.0 - energy(time.size() - 1) / energy(0);
        const bool baseline = protocol.starts_with("all_");
        if (std::string(law) == "trapezoidal_reset") {
          EXPECT_LE(lost, 1.0 / (10.0 * n));
          EXPECT_GT(lost, -1e-3);
        } else if (baseline) {
          EXPECT_NEAR(lost, 0.0, 1e-12);
        } else {
          EXPECT_NEAR(lost, 0.0, 0.05 / n);
        }
        EXPECT_LT(r.summary.at("momentum_error_max").get<double>(), 1e-12);
      }
    }
  }
}

}  // namespace
}  // namespace ricochet::test

#include <fmt/format.h>

#include <regex>

#include "tests/support/run.hpp"

// Acceptance A4 with less of the long bar: an absorbing end stands in for the rest. Each run is compared, window by
// window, with that of the whole bar, whose own far end is heard of only after the end.

namespace ricochet::test {
namespace {

/// A run against another: differences of the contact force over `force_n` and of the mean velocity of a body over
/// `velocity_m_s`.
struct Difference {
  double force_rms = 0.0, velocity_max = 0.0;
};

Difference compare(const RunResult& run, const RunResult& whole, double force_n, const std::string& body,
                   double velocity_m_s) {
  const std::string velocity = "velocity_mean_" + body + "_m_s";
  const std::size_t rows = std::min(run.column("time_s").size(), whole.column("time_s").size());
  Difference difference;
  for (std::size_t i = 0; i < rows; ++i) {
    const double force = (run.column("contact_force_n")[i] - whole.column("contact_force_n")[i]) / force_n;
    const double v = (run.column(velocity)[i] - whole.column(velocity)[i]) / velocity_m_s;
    difference.force_rms += force * force / static_cast<double>(rows);
    difference.velocity_max = std::max(difference.velocity_max, std::abs(v));
  }
  difference.force_rms = std::sqrt(difference.force_rms);
  return difference;
}

/// The ledger with every joule's owner, the dashpots among the external ones: largest change over the largest kinetic
/// energy.
double ledger_error(const RunResult& run) {
  const auto balance = [&run](std::size_t i) {
    const auto at = [&](const char* name) { return run.column(name)[i]; };
    return at("energy_kinetic_j") + at("energy_strain_j") + at("energy_friction_j") - at("energy_external_j") -
           at("energy_contact_j") - at("energy_interface_j");
  };
  double largest = 0.0;
  for (std::size_t i = 0; i < run.column("time_s").size(); ++i)
    largest = std::max(largest, std::abs(balance(i) - balance(0)));
  return largest / run.largest("energy_kinetic_j");
}

std::string with_absorbing(const std::string& text, const std::string& wave) {
  const std::string table =
      "[[body.absorbing]]\nsurface = \"end\"\n" + (wave.empty() ? "" : "wave = \"" + wave + "\"\n");
  return replaced(text, "[contact]", table + "\n[contact]");  // of the last body
}

// -- bars: configs/unequal_bars.toml, a quarter of the long bar. Its end would be heard of after 39 us.

const double z_steel = 1e-4 * std::sqrt(207e9 * 7860), z_aluminium = 1e-4 * std::sqrt(70e9 * 2700);
const double first_force_n = 10.0 * z_steel * z_aluminium / (z_steel + z_aluminium);

std::string bars(const std::string& protocol, int refinement) {
  std::string text =
      replaced(config_text("unequal_bars"), "safety_factor = 0.9", fmt::format("step_s = {}e-9", 174 / refinement));
  text =
      replaced(text, "length_m = 0.1, elements = 100", fmt::format("length_m = 0.1, elements = {}", 100 * refinement));
  text =
      replaced(text, "length_m = 0.4, elements = 400", fmt::format("length_m = 0.4, elements = {}", 400 * refinement));
  return with_protocol(text, protocol);
}

std::string cut(const std::string& text, int refinement) {
  return replaced(text, fmt::format("length_m = 0.4, elements = {}", 400 * refinement),
                  fmt::format("length_m = 0.1, elements = {}", 100 * refinement));
}

class AbsorbingBar : public testing::TestWithParam<const char*> {};

TEST_P(AbsorbingBar, StandsInForTheRestOfIt) {
  const TemporaryFolder folder;
  std::vector<Difference> differences;
  for (const int refinement : {1, 2}) {
    const std::string text = bars(GetParam(), refinement);
    const RunResult whole = run_text(text, folder, "whole"),
                    run = run_text(with_absorbing(cut(text, refinement), ""), folder, "cut");
    differences.push_back(compare(run, whole, first_force_n, "striker", 10.0));
    EXPECT_LT(ledger_error(run), 1e-10) << refinement;
  }
  EXPECT_LT(differences[0].force_rms, 5e-3);
  EXPECT_LT(differences[0].velocity_max, 5e-5);
  // With a front that jumps the force converges like the root of the element size, what it does to the striker like the
  // size.
  EXPECT_LT(differences[1].force_rms, 0.8 * differences[0].force_rms);
  EXPECT_LT(differences[1].velocity_max, 0.6 * differences[0].velocity_max);
}

TEST_P(AbsorbingBar, ItsFreeEndWouldReflect) {
  const TemporaryFolder folder;
  const std::string text = bars(GetParam(), 1);
  const RunResult whole = run_text(text, folder, "whole"), run = run_text(cut(text, 1), folder, "cut");
  EXPECT_GT(compare(run, whole, first_force_n, "striker", 10.0).force_rms, 0.3);
}

INSTANTIATE_TEST_SUITE_P(Protocols, AbsorbingBar,
                         testing::Values("hughes_liu", "kim", "belytschko_mullen", "prakash_hjelmstad",
                                         "gravouil_combescure", "fixed_point", "all_implicit", "all_explicit"),
                         [](const auto& test) { return std::string(test.param); });

TEST(AbsorbingBarSubsteps, StandsInForTheRestOfIt) {
  const TemporaryFolder folder;
  const std::string text = with_key(bars("prakash_hjelmstad", 1), "coupling", "substeps", "4");
  const std::string slow = replaced(text, "step_s = 174e-9", "step_s = 696e-9");
  const RunResult whole = run_text(slow, folder, "whole"),
                  run = run_text(with_absorbing(cut(slow, 1), ""), folder, "cut");
  const Difference difference = compare(run, whole, first_force_n, "striker", 10.0);
  EXPECT_LT(difference.force_rms, 5e-3);
  EXPECT_LT(difference.velocity_max, 5e-5);
}

// The dashpots next to what the link moves: on shared nodes, and within reach of the dual protocols' corrections.
TEST(AbsorbingBarAtTheInterface, StandsInForTheRestOfIt) {
  const TemporaryFolder folder;
  for (const auto& [protocol, substeps] :
       {std::pair{"hughes_liu", 1}, {"prakash_hjelmstad", 1}, {"prakash_hjelmstad", 4}}) {
    std::string text = bars(protocol, 1);
    if (substeps > 1) {
      text = replaced(with_key(text, "coupling", "substeps", std::to_string(substeps)), "step_s = 174e-9",
                      fmt::format("step_s = {}e-9", 174 * substeps));
    }
    const RunResult whole = run_text(text, folder, "whole");
    // 10 implicit elements and as many, two or no explicit ones behind them.
    for (const int elements : {20, 12}) {
      const std::string mesh = fmt::format("length_m = 0.0{0}, elements = {0}", elements);
      const RunResult run =
          run_text(with_absorbing(replaced(text, "length_m = 0.4, elements = 400", mesh), ""), folder, "cut");
      const Difference difference = compare(run, whole, first_force_n, "striker", 10.0);
      EXPECT_LT(difference.force_rms, substeps > 1 ? 1e-2 : 5e-3)
          << protocol << ' ' << elements << ": a long window smears the front";
      EXPECT_LT(difference.velocity_max, 2e-4) << protocol << ' ' << elements;
      EXPECT_LT(ledger_error(run), 1e-10) << protocol << ' ' << elements;
    }
  }
}

// A free bar in flight is not braked, a bar that is pushed moves off at the speed of one without end.
TEST(AbsorbingBarAlone, DoesNotBrakeAFlightAndTakesUpAPush) {
  const TemporaryFolder folder;
  for (const char* protocol : {"all_explicit", "all_implicit"}) {
    const std::string text = std::string(
                                 "model = \"bar\"\n[[body]]\nname = \"rod\"\n"
                                 "material = { youngs_modulus_pa = 1.0, density_kg_m3 = 1.0 }\n"
                                 "mesh = { length_m = 1.0, elements = 50 }\ninitial_velocity_m_s = [0.25]\n"
                                 "absorbing = [{ surface = \"end\" }]\n#push\n"
                                 "[time]\nsafety_factor = 0.9\nend_s = 8.0\n[coupling]\nprotocol = \"") +
                             protocol + "\"\n";
    const RunResult flight = run_text(text, folder, "flight");
    EXPECT_NEAR(flight.last("velocity_mean_rod_m_s"), 0.25, 1e-12) << protocol;
    EXPECT_NEAR(flight.last("energy_external_j"), 0.0, 1e-11) << protocol;
    // Traction 0.01 on E = rho = 1: the wave carries v = 0.01, and the end keeps it when it has passed.
    const RunResult push =
        run_text(replaced(text, "#push", "traction = [{ surface = \"start\", traction_pa = [0.01] }]"), folder, "push");
    EXPECT_NEAR(push.mean("velocity_mean_rod_m_s", 4.0, 8.0), 0.26, 2e-5) << protocol;
    EXPECT_LT(ledger_error(push), 1e-10) << protocol;
  }
}

// -- periodic plates, exactly uniaxial: the dilatational dashpot is as good as that of a bar, with shear besides.
// configs/sticking_plates.toml; the end of half a plate would be heard of after 228 us, before they part at 456 us.

std::string plates(const std::string& protocol, int refinement, int upper_halves) {
  const auto mesh = [&](double length_m, int along) {
    return fmt::format("length_m = {}, height_m = 0.0075, elements = [3, {}]", length_m, along * refinement);
  };
  std::string text =
      replaced(config_text("sticking_plates"), "mesh = { length_m = 0.25, height_m = 0.0075, elements = [3, 100]",
               "mesh = { " + mesh(0.125 * upper_halves, 50 * upper_halves));
  text = replaced(text, "length_m = 0.25, height_m = 0.0075, elements = [3, 100]", mesh(0.25, 100));
  return with_protocol(replaced(text, "safety_factor = 0.9", fmt::format("step_s = {}e-9", 2000 / refinement)),
                       protocol);
}

TEST(AbsorbingPlate, IsAsGoodAsABarsEndWithPressureAndShear) {
  const TemporaryFolder folder;
  const double force_n = 1.09545e7 * 0.0075;
  for (const char* protocol : {"all_explicit", "all_implicit", "hughes_liu"}) {
    std::vector<Difference> differences;
    for (const int refinement : {1, 2}) {
      const RunResult whole = run_text(plates(protocol, refinement, 8), folder, "whole");
      const RunResult run = run_text(with_absorbing(plates(protocol, refinement, 1), "dilatational"), folder, "cut");
      differences.push_back(compare(run, whole, force_n, "lower", 10.0));
      EXPECT_LT(ledger_error(run), 1e-10) << protocol;
      const double shear = run.mean("friction_force_n", 250e-6, 420e-6);
      EXPECT_NEAR(shear, whole.mean("friction_force_n", 250e-6, 420e-6), 2e-4 * std::abs(shear)) << protocol;
    }
    EXPECT_LT(differences[0].force_rms, 5e-3) << protocol;
    EXPECT_LT(differences[0].velocity_max, 5e-4) << protocol;
    EXPECT_LT(differences[1].force_rms, 0.8 * differences[0].force_rms) << protocol;
    EXPECT_LT(differences[1].velocity_max, 0.6 * differences[0].velocity_max) << protocol;
  }
}

// -- a slender cylinder and a thin strip with free sides: their long waves run at the bar speed, of the strip in plane
// strain at sqrt(E/(rho (1 - nu^2))). The rest of the front, lateral inertia, meets another impedance: that part
// does not vanish with the mesh.

std::string cylinders(const std::string& protocol, int along) {
  const std::string bar = replaced(bars(protocol, 1), "model = \"bar\"", "model = \"axisymmetric\"");
  std::string text = replaced(bar, "area_m2 = 1e-4\nmesh = { start_m = -0.1, length_m = 0.1, elements = 100 }",
                              "mesh = { start_m = -0.1, length_m = 0.1, radius_m = 0.002, elements = [2, 100] }");
  text = replaced(text, "initial_velocity_m_s = [10.0]", "initial_velocity_m_s = [0.0, 10.0]");
  text =
      replaced(text, "area_m2 = 1e-4\nmesh = { length_m = 0.4, elements = 400 }",
               fmt::format("mesh = {{ length_m = {}, radius_m = 0.002, elements = [2, {}] }}", 0.001 * along, along));
  text = replaced(text, "207e9, density", "207e9, poisson_ratio = 0.3, density");
  text = replaced(text, "70e9, density", "70e9, poisson_ratio = 0.33, density");
  return replaced(text, "step_s = 174e-9", "step_s = 120e-9");
}

std::string strips(const std::string& protocol, int along) {
  std::string text = replaced(cylinders(protocol, along), "\"axisymmetric\"", "\"plane_strain\"");
  for (int body = 0; body < 2; ++body) text = replaced(text, "radius_m = 0.002", "height_m = 0.004");
  return text;
}

void expect_bar_waves_absorbed(std::string (*scene)(const std::string&, int), double area_m2) {
  const TemporaryFolder folder;
  const double force_n = first_force_n * area_m2 / 1e-4;
  for (const char* protocol : {"all_explicit", "all_implicit", "hughes_liu", "prakash_hjelmstad"}) {
    const RunResult whole = run_text(scene(protocol, 400), folder, "whole");
    const RunResult run = run_text(with_absorbing(scene(protocol, 100), "bar"), folder, "cut");
    const Difference difference = compare(run, whole, force_n, "striker", 10.0);
    EXPECT_LT(difference.force_rms, 0.01) << protocol;
    EXPECT_LT(difference.velocity_max, 1e-4) << protocol;
    EXPECT_LT(ledger_error(run), 1e-10) << protocol;
    if (protocol != std::string("all_explicit")) continue;
    const RunResult wrong = run_text(with_absorbing(scene(protocol, 100), "dilatational"), folder, "cut");
    EXPECT_GT(compare(wrong, whole, force_n, "striker", 10.0).force_rms, 0.05) << "the other speed reflects";
  }
}

TEST(AbsorbingCylinder, TakesUpItsLongWavesAtTheBarSpeed) {
  expect_bar_waves_absorbed(cylinders, 3.14159265 * 0.002 * 0.002);
}

/// Two bars of 254 mm that meet after 49.5 µs, of which the first `kept` elements from the contact are there.
std::string ends_cut(const std::string& protocol, int elements, int kept) {
  const double length_m = 0.254 * kept / elements;
  const auto bar = [&](const char* name, double start_m, double velocity_m_s) {
    return fmt::format(
        "[[body]]\nname = \"{}\"\nmaterial = {{ youngs_modulus_pa = 206.8e9, density_kg_m3 = 7844.066 }}\n"
        "initial_velocity_m_s = [{}]\nmesh = {{ start_m = {}, length_m = {}, elements = {} }}\n",
        name, velocity_m_s, start_m, length_m, kept);
  };
  return "model = \"bar\"\n" + bar("left", -length_m, 5.13588) + bar("right", 0.508e-3, -5.13588) +
         fmt::format(
             "[contact]\nsurfaces = [\"left.end\", \"right.start\"]\n[partition]\nimplicit_length_m = {{ left = "
             "{0}, right = {0} }}\n[time]\nstep_s = {1}\nend_s = 70e-6\n[coupling]\nprotocol = \"{2}\"\n",
             0.508 / elements, 2.226e-6 * 20 / elements, protocol);
}

TEST(UnreachedEnds, CanBeLeftOut) {
  const TemporaryFolder folder;
  for (const int elements : {20, 80})
    for (const char* protocol : {"all_explicit", "all_implicit", "hughes_liu"}) {
      const std::string scene = folder.write(ends_cut(protocol, elements, elements));
      const std::string told = run_command({ricochet_binary(), "check", scene}, folder.path().string()).out;
      std::smatch found;
      ASSERT_TRUE(std::regex_search(told, found, std::regex(R"(no wave comes back from [^(]*\((\d+) of)"))) << told;
      const int kept = elements - std::stoi(found[1]);
      EXPECT_LT(kept, elements / 2);
      const RunResult whole = run_file(scene, folder, "whole");
      const auto apart = [&](int left_in) {
        const RunResult cut = run_text(ends_cut(protocol, elements, left_in), folder, "cut");
        const auto &force = cut.column("contact_force_n"), &expected = whole.column("contact_force_n");
        double largest = 0.0;
        for (std::size_t n = 0; n < expected.size(); ++n)
          largest = std::max(largest, std::abs(force.at(n) - expected[n]));
        return largest / whole.largest("contact_force_n");
      };
      EXPECT_LT(apart(kept), 2e-5) << protocol << ", " << elements;
      EXPECT_GT(apart(kept / 2), 1e-2) << protocol << ", " << elements << ": others matter";
    }
}

TEST(AbsorbingStrip, TakesUpItsLongWavesAtThePlateSpeed) { expect_bar_waves_absorbed(strips, 0.004); }

}  // namespace
}  // namespace ricochet::test

#include <cstdio>
#include <filesystem>

#include "tests/support/dome_mesh.hpp"
#include "tests/support/places.hpp"
#include "tests/support/run.hpp"

// Costs predicted by `ricochet check` of the scenes in configs/, beside those of runs: a table to read. How fast a
// machine is, and how busy, no test can promise.

namespace ricochet::test {
namespace {

std::vector<std::string> shipped_scenes() {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(source_folder() + "/configs"))
    if (entry.path().extension() == ".toml") names.push_back(entry.path().stem().string());
  std::sort(names.begin(), names.end());
  return names;
}

/// The number behind `text` in what `check` printed.
double number_after(const std::string& printed, const std::string& text) {
  const auto found = printed.find(text);
  EXPECT_NE(found, std::string::npos) << text << " is not in\n" << printed;
  return found == std::string::npos ? 0.0 : std::strtod(printed.c_str() + found + text.size(), nullptr);
}

struct Measured {
  double steps = 0.0, stepping_s = 0.0;
};
Measured measure(const std::string& text, const TemporaryFolder& folder, const std::string& name) {
  const RunResult run = run_text(text, folder, name);
  return {run.summary.at("windows").get<double>(), run.summary.at("phases").at("stepping_s").get<double>()};
}

TEST(PredictedCostOfShippedScenes, TableBesideWhatIsMeasured) {
  std::printf("%-16s %23s %31s %33s %33s\n%-16s %23s %31s %33s %33s\n", "predicted/", "steps", "time of a step [us]",
              "all_implicit, of a step [us]", "all_explicit, of a step [us]", "measured", "", "", "", "");
  for (const auto& name : shipped_scenes()) {
    const TemporaryFolder folder;
    const std::string text = with_absolute_meshes(config_text(name));
    const Outcome check =
        run_command({ricochet_binary(), "check", folder.write(text, "scene.toml")}, folder.path().string());
    ASSERT_EQ(check.code, 0) << check.error;
    const double steps = number_after(check.out, " s for "), window_us = number_after(check.out, " steps of "),
                 implicit_s = number_after(check.out, "all_implicit would take "),
                 explicit_s = number_after(check.out, "all_explicit would take "),
                 explicit_step_s = number_after(check.out, "in steps of "),
                 window_s = number_after(check.out, "\nstep "), end_s = steps * window_s;
    std::string text_of_explicit = with_protocol(text, "all_explicit");
    if (text.find("step_s") != std::string::npos)  // else it follows from the safety factor, as the prediction's
      text_of_explicit = with_key(text_of_explicit, "time", "step_s", fmt::format("{}", explicit_step_s));
    constexpr double long_s = 1.0;  // a baseline of which more is predicted is not computed: its row has none
    const Measured own = measure(text, folder, "own"), none{1.0, 0.0},
                   all_implicit = implicit_s > long_s
                                      ? none
                                      : measure(with_protocol(text, "all_implicit"), folder, "all_implicit"),
                   all_explicit = explicit_s > long_s ? none : measure(text_of_explicit, folder, "all_explicit");
    const auto beside = [](double predicted, double measured) {
      if (measured == 0.0) return fmt::format("{:.4g}/-", predicted);
      return fmt::format("{:.4g}/{:.4g} = {:.2f}", predicted, measured, predicted / measured);
    };
    const auto of_a_step_us = [](const Measured& run) { return 1e6 * run.stepping_s / run.steps; };
    std::printf("%-16s %23s %31s %33s %33s\n", name.c_str(), beside(steps, own.steps).c_str(),
                beside(window_us, of_a_step_us(own)).c_str(),
                beside(1e6 * implicit_s / steps, of_a_step_us(all_implicit)).c_str(),
                beside(1e6 * explicit_s / std::ceil(end_s / explicit_step_s), of_a_step_us(all_explicit)).c_str());
    std::fflush(stdout);
    EXPECT_GE(1.002 * steps, own.steps) << name << ": the prediction is of the end, or of the latest one";
    EXPECT_GT(window_us, 0.0);
  }
}

/// Two domes that meet at 4 m/s and, if `oblique`, slide by 2 m/s, with friction.
std::string domes(bool oblique, const std::string& protocol, const TemporaryFolder& folder) {
  std::string text = "model = \"solid\"\n";
  for (const bool lower : {true, false}) {
    const std::string name = lower ? "lower" : "upper";
    (void)folder.write(dome_msh(name, {.radius_m = 0.1,
                                       .start_m = lower ? -0.004 : 0.0,
                                       .up = lower,
                                       .half_x = false,
                                       .half_y = false,
                                       .across = lower ? 8 : 7,
                                       .along = 8}),
                       name + ".msh");
    text += fmt::format(
        "[[body]]\nname = \"{0}\"\nmaterial = {{ youngs_modulus_pa = 48e9, poisson_ratio = 0.2, density_kg_m3 = "
        "2800.0 }}\nmesh = {{ gmsh = \"{0}.msh\" }}\ninitial_velocity_m_s = [{1}, 0.0, {2}]\n",
        name, oblique ? (lower ? "1.0" : "-1.0") : "0.0", lower ? "2.0" : "-2.0");
  }
  return text + "[contact]\nsurfaces = [\"lower.cap\", \"upper.cap\"]\nnormal = [0.0, 0.0, 1.0]\n" +
         "friction_coefficient = 0.3\n[time]\nstep_s = 8e-8\nend_s = 40e-6\n[coupling]\nprotocol = \"" + protocol +
         "\"\n" +
         (protocol == "hughes_liu" ? "[partition]\nimplicit_length_m = { lower = 0.0011, upper = 0.0011 }\n" : "");
}

/// Both columns are times of this machine; PredictedCost.CountsRowsThatAreWrittenAnew compares numbers of its work.
TEST(PredictedCostOfImpacts, StraightAndObliqueBesideWhatIsMeasured) {
  for (const char* protocol : {"all_explicit", "all_implicit", "hughes_liu"}) {
    for (const bool oblique : {false, true}) {
      const TemporaryFolder folder;
      const std::string text = domes(oblique, protocol, folder);
      const Outcome check =
          run_command({ricochet_binary(), "check", folder.write(text, "scene.toml")}, folder.path().string());
      ASSERT_EQ(check.code, 0) << check.error;
      const double predicted_s = number_after(check.out, "predicted: "),
                   measured_s = measure(text, folder, "run").stepping_s;
      std::printf("%-14s %-9s %.3g/%.3g s = %.2f\n", protocol, oblique ? "oblique" : "straight", predicted_s,
                  measured_s, predicted_s / measured_s);
      EXPECT_GT(predicted_s, 0.0) << protocol;
    }
  }
}

}  // namespace
}  // namespace ricochet::test

#include <cstdio>
#include <filesystem>

#include "tests/support/run.hpp"

// What `ricochet check` predicts of the scenes in configs/, beside what runs of them take: a table to read. How fast a
// machine is, and how busy, no test can promise.

namespace ricochet::test {
namespace {

std::vector<std::string> shipped_scenes() {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(std::string(RICOCHET_SOURCE) + "/configs"))
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
    const Measured own = measure(text, folder, "own"),
                   all_implicit = measure(with_protocol(text, "all_implicit"), folder, "all_implicit"),
                   all_explicit = measure(text_of_explicit, folder, "all_explicit");
    const auto beside = [](double predicted, double measured) {
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

}  // namespace
}  // namespace ricochet::test

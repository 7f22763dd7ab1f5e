// `time.largest_step_s`: the step and the implicit part are chosen by measured cost.
#include <gmock/gmock.h>

#include <filesystem>

#include "tests/support/run.hpp"

namespace ricochet::test {
namespace {

using testing::HasSubstr;

/// Two bars, 40 elements each, at the contact 30 times smaller than at the far ends.
std::string graded_bars(const std::string& time) {
  std::string text = "model = \"bar\"\n";
  for (const bool left : {true, false}) {
    text += std::string("[[body]]\nname = \"") + (left ? "left" : "right") +
            "\"\nmaterial = { youngs_modulus_pa = 2e11, density_kg_m3 = 8000.0 }\narea_m2 = 1e-4\n"
            "mesh = { start_m = " +
            (left ? "-1.0" : "0.0") + ", length_m = 1.0, elements = 40, grading = " + (left ? "0.0333" : "30.0") +
            " }\ninitial_velocity_m_s = [" + (left ? "5.0" : "-5.0") + "]\n";
  }
  return text + "[contact]\nsurfaces = [\"left.end\", \"right.start\"]\n[partition]\nrule = \"auto\"\n[time]\n" + time +
         "\nend_s = 6e-4\n";
}

/// Rows of calibration.csv, and its column `step_s` of the one with the least prediction.
struct Calibration {
  explicit Calibration(const RunResult& run) : columns(read_history(run.folder + "/calibration.csv")) {
    const auto& predicted = columns.at("predicted_s");
    best_step_s = columns.at(
        "step_s")[static_cast<std::size_t>(std::min_element(predicted.begin(), predicted.end()) - predicted.begin())];
  }
  History columns;
  double best_step_s = 0.0;
};

TEST(LargestStep, TheRunTakesTheStepOfLeastPredictedTime) {
  const TemporaryFolder folder;
  const auto run = run_text(graded_bars("largest_step_s = 1e-5"), folder);
  const Calibration calibration(run);
  const auto& steps = calibration.columns.at("step_s");
  ASSERT_GE(steps.size(), 3U);
  EXPECT_EQ(steps.front(), 1e-5);
  for (std::size_t i = 0; i < steps.size(); ++i) {
    EXPECT_EQ(calibration.columns.at("elements")[i], 80);
    EXPECT_GT(calibration.columns.at("window_s")[i], 0.0);
    EXPECT_GT(calibration.columns.at("predicted_s")[i], calibration.columns.at("setup_s")[i]);
    if (i == 0) continue;
    EXPECT_LT(steps[i], steps[i - 1]);
    EXPECT_LT(calibration.columns.at("implicit_elements")[i], calibration.columns.at("implicit_elements")[i - 1]);
  }
  EXPECT_NEAR(run.summary.at("window_size_s").get<double>(), calibration.best_step_s, 1e-5 * calibration.best_step_s);
  EXPECT_THAT(run.outcome.out, HasSubstr("  chosen\n"));
  EXPECT_THAT(run.summary.at("scene").get<std::string>(), HasSubstr("/scene/scene.toml"));
  // The bars exchange their velocities whatever the step is (impedance theory), but for waves that the coarse far ends
  // disperse.
  EXPECT_NEAR(run.last("velocity_mean_left_m_s"), -5.0, 0.3);
  EXPECT_LT(run.summary.at("momentum_error_max").get<double>(), 1e-9);
}

TEST(LargestStep, WhatWasMeasuredIsNotMeasuredAgain) {
  const TemporaryFolder folder;
  const std::string text = graded_bars("largest_step_s = 1e-5");
  const auto run_ids = [&] {
    std::map<std::string, std::string> ids;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder.path() / "scene" / "calibration")) {
      if (entry.path().filename() != "summary.json") continue;
      ids[entry.path().string()] =
          nlohmann::json::parse(file_text(entry.path().string())).at("run_id").get<std::string>();
    }
    return ids;
  };
  const auto first = run_text(text, folder);
  const auto measured = run_ids();
  const auto second = run_text(text, folder);
  EXPECT_GE(measured.size(), 3U);
  EXPECT_EQ(run_ids(), measured);
  EXPECT_NE(first.summary.at("run_id"), second.summary.at("run_id"));
  EXPECT_EQ(first.summary.at("window_size_s"), second.summary.at("window_size_s"));
}

TEST(LargestStep, OneThatIsTooLongForEveryElementLeavesTheOthersToChooseFrom) {
  const TemporaryFolder folder;
  const auto run = run_text(graded_bars("largest_step_s = 1e-4"), folder);
  const Calibration calibration(run);
  EXPECT_LT(calibration.columns.at("step_s").front(), 5e-5);
  EXPECT_LT(calibration.columns.at("implicit_elements").front(), 80);
}

TEST(LargestStep, ABaselineTakesItAsItIs) {
  const TemporaryFolder folder;
  const auto run = run_text(with_protocol(graded_bars("largest_step_s = 1e-5"), "all_implicit"), folder);
  EXPECT_EQ(run.summary.at("window_size_s"), 1e-5);
  EXPECT_FALSE(std::filesystem::exists(run.folder + "/calibration.csv"));
}

TEST(LargestStep, ASolverThatFailsIsTheRunsFailure) {
  const TemporaryFolder folder;
  const std::string participants =
      "[[participant]]\nname = \"mine\"\nrole = \"explicit\"\nbodies = [\"left\", \"right\"]\n"
      "executable = \"/bin/false\"\n[[participant]]\nname = \"implicit\"\nrole = \"implicit\"\n";
  const auto run = run_file(folder.write(graded_bars("largest_step_s = 1e-5") + participants), folder);
  EXPECT_EQ(run.outcome.code, 4);
  EXPECT_THAT(run.outcome.out, HasSubstr("cannot be run: participant 'mine' ended with exit code 1"));
  EXPECT_EQ(run.summary.at("status"), "participant_failed");
}

TEST(LargestStep, CheckSaysThatTheRunChooses) {
  const TemporaryFolder folder;
  const auto check = run_command({ricochet_binary(), "check", folder.write(graded_bars("largest_step_s = 1e-5"))},
                                 folder.path().string(), 30.0);
  EXPECT_EQ(check.code, 0);
  EXPECT_THAT(check.out, HasSubstr("this is the largest step: `ricochet run` measures"));
}

}  // namespace
}  // namespace ricochet::test

// `--set KEY=VALUE` of run, check and study.
#include <gmock/gmock.h>

#include <filesystem>

#include "tests/support/run.hpp"

namespace ricochet::test {
namespace {

using testing::HasSubstr;

class Set : public testing::Test {
 protected:
  Outcome command(const std::vector<std::string>& words) const {
    std::vector<std::string> all{ricochet_binary()};
    all.insert(all.end(), words.begin(), words.end());
    return run_command(all, folder_.path().string());
  }
  const TemporaryFolder folder_;
  const std::string scene_ = folder_.write(config_text("two_bars"), "bars.toml");
  const std::string out_ = folder_.path().string() + "/out";
};

TEST_F(Set, ComputesTheSceneWithTheKeysChanged) {
  const auto outcome = command({"run", scene_, "--set", "time.step_s=1e-6", "--set", "coupling.protocol=kim", "--set",
                                "output.fields_every=100", "--out", out_});
  ASSERT_EQ(outcome.code, 0) << outcome.error;
  const auto summary = nlohmann::json::parse(file_text(out_ + "/summary.json"));
  EXPECT_THAT(summary.at("scene").get<std::string>(), testing::EndsWith("/out/scene/bars.toml"));
  EXPECT_TRUE(std::filesystem::exists(out_ + "/fields/bars.pvd"));
  const std::string text =
      with_protocol(replaced(config_text("two_bars"), "step_s = 2.226e-6", "step_s = 1e-6"), "kim");
  const auto by_hand = run_text(text, folder_, "by_hand");
  EXPECT_EQ(file_text(out_ + "/history.csv"), file_text(by_hand.folder + "/history.csv"));
  EXPECT_EQ(file_text(scene_), config_text("two_bars")) << "the file stays as it is";
}

TEST_F(Set, LeavesASceneThatResumes) {
  ASSERT_EQ(command({"run", scene_, "--set", "checkpoint.every_windows=20", "--out", out_}).code, 0);
  const auto resumed = command({"resume", out_, "--until", "3e-4"});
  EXPECT_EQ(resumed.code, 0) << resumed.error;
}

TEST_F(Set, RefusesByKeyAndArgumentBeforeAnythingIsWritten) {
  ASSERT_EQ(command({"run", scene_, "--out", out_}).code, 0);
  const auto history = file_text(out_ + "/history.csv");
  for (const auto& [argument, says] :
       {std::pair<std::string, std::string>{"time.step_s=-1", "time.step_s: found -1; allowed: a number > 0"},
        {"time.stepp_s=1e-6", "did you mean \"step_s\"?"},
        {"body.lift.area_m2=1", "did you mean \"left\"?"},
        {"coupling.protocol=kin", "did you mean \"kim\"?"}}) {
    const auto outcome = command({"run", scene_, "--set", argument, "--out", out_});
    EXPECT_EQ(outcome.code, 2) << argument;
    EXPECT_THAT(outcome.error, HasSubstr(says)) << argument;
    EXPECT_EQ(command({"check", scene_, "--set", argument}).code, 2) << argument;
  }
  EXPECT_THAT(command({"check", scene_, "--set", "time.step_s=-1"}).error,
              HasSubstr("bars.toml with --set time.step_s=-1: "));
  EXPECT_THAT(command({"check", scene_, "--set", "time.step_s=1e-4"}).error,  // found after it was read
              HasSubstr("bars.toml: time.step_s: found a step of 0.0001 s"));
  EXPECT_EQ(file_text(out_ + "/history.csv"), history);
}

TEST_F(Set, IsCheckedLikeTheChangedFile) {
  const auto checked = command({"check", scene_, "--set", "time.step_s=1e-6"});
  EXPECT_EQ(checked.code, 0) << checked.error;
  EXPECT_THAT(checked.out, HasSubstr("step 1e-06 s"));
}

TEST_F(Set, ChangesTheSceneOfAStudy) {
  const std::string study = folder_.write(
      "scene = \"bars.toml\"\nmethods = [\"hughes_liu\"]\nquantities = [\"separation_time\"]\n"
      "[reference]\nexact = \"impedance_theory\"\n",
      "study.toml");
  ASSERT_EQ(command({"study", study, "--set", "time.step_s=1e-6", "--out", out_}).code, 0);
  int scenes = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(out_ + "/runs")) {
    if (entry.path().filename() != "scene.toml") continue;
    EXPECT_THAT(file_text(entry.path().string()), HasSubstr("step_s = 9.9999999999999995e-07"));
    ++scenes;
  }
  EXPECT_EQ(scenes, 1);
  EXPECT_EQ(command({"study", study, "--set", "time.stepp_s=1e-6", "--out", out_}).code, 2);
}

}  // namespace
}  // namespace ricochet::test

// Checkpoints are written by a thread beside the run.
#include <gtest/gtest.h>

#include <fstream>
#include <string>
#include <vector>

#include "coupler/run/checkpoints.hpp"
#include "tests/support/scene_file.hpp"

namespace ricochet::coupler {
namespace {

class CheckpointsTest : public testing::Test {
 protected:
  CheckpointsTest() {
    settings_.every_windows = 1;
    settings_.every_s = 0;
  }

  static Checkpoint cut(std::int64_t window) {
    Checkpoint checkpoint;
    checkpoint.window = window;
    checkpoint.coupler = std::string(100'000, static_cast<char>(window));
    checkpoint.parts.push_back({"implicit", std::string(100'000, static_cast<char>(window + 1))});
    return checkpoint;
  }

  test::TemporaryFolder results_;
  std::string folder_ = results_.path() / "checkpoint";
  scene::Checkpointing settings_;
  Launcher launcher_;
};

/// The run goes on while one is written, and what it changes meanwhile is not in it.
TEST_F(CheckpointsTest, AreWrittenBesideTheRun) {
  Checkpoints checkpoints(settings_, folder_, FieldDigests(results_.path(), {"implicit"}), launcher_);
  std::int64_t begun = 0;
  int put_off = 0;
  for (std::int64_t window = 1; begun < 5; ++window) {
    if (checkpoints.due(window) == Checkpoints::Due::no) {
      ++put_off;
      continue;
    }
    auto checkpoint = cut(window);
    checkpoints.begin(checkpoint);
    checkpoint.coupler.assign("of the next window");
    ++begun;
  }
  const auto last = checkpoints.settle();
  EXPECT_GT(put_off, 0);
  std::vector<std::string> damaged;
  const auto found = CheckpointFolder(folder_).last(damaged);
  ASSERT_TRUE(found);
  EXPECT_TRUE(damaged.empty());
  EXPECT_EQ(found->window, last);
  EXPECT_EQ(found->coupler, cut(last).coupler);
  EXPECT_EQ(found->parts.at(0).bytes, cut(last).parts[0].bytes);
}

TEST_F(CheckpointsTest, OneThatIsAskedForWaitsForTheOneBefore) {
  Checkpoints checkpoints(settings_, folder_, FieldDigests(results_.path(), {"implicit"}), launcher_);
  for (std::int64_t window = 1; window <= 4; ++window) checkpoints.begin(cut(window));
  EXPECT_EQ(checkpoints.settle(), 4);
  EXPECT_EQ(CheckpointFolder(folder_).windows(), (std::vector<std::int64_t>{3, 4}));
}

TEST_F(CheckpointsTest, WhatCannotBeWrittenDoesNotEndTheRun) {
  std::ofstream(folder_) << "a file where the folder should be";
  Checkpoints checkpoints(settings_, folder_, FieldDigests(results_.path(), {"implicit"}), launcher_);
  testing::internal::CaptureStderr();
  checkpoints.begin(cut(1));
  EXPECT_EQ(checkpoints.settle(), -1);
  EXPECT_NE(testing::internal::GetCapturedStderr().find("warning: no checkpoint at window 1"), std::string::npos);
}

}  // namespace
}  // namespace ricochet::coupler

// A program of somebody else's that several processes compute: `launch` has mpirun start it, and the first one speaks.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <filesystem>

#include "tests/support/places.hpp"
#include "tests/support/run.hpp"
#include "tests/support/same_history.hpp"

namespace ricochet::test {
namespace {

using testing::HasSubstr;

/// Both bars by a program that mpirun starts twice.
std::string bars_by_several(const std::string& program) {
  return config_text("two_bars") +
         fmt::format(
             "[[participant]]\nname = \"right\"\nrole = \"explicit\"\nbodies = [\"left\", \"right\"]\nexecutable = "
             "\"{}\"\nlaunch = [\"mpirun\", \"--allow-run-as-root\", \"--oversubscribe\", \"-n\", \"2\"]\n"
             "[[participant]]\nname = \"implicit\"\nrole = \"implicit\"\n",
             program);
}

TEST(MpiParticipant, TakesPartByItsFirstProcess) {
  TemporaryFolder folder;
  const auto program = folder.write(
      "#!/bin/sh\n[ \"$OMPI_COMM_WORLD_RANK\" = 0 ] && exec " + build_folder() + "/wrong_participant \"$@\"\nexit 0\n",
      "first_alone.sh");
  std::filesystem::permissions(program, std::filesystem::perms::owner_all);
  const auto run = run_text(bars_by_several(program), folder, "mpi");
  const auto ours = run_text(config_text("two_bars"), folder, "ours");
  expect_same_history(run, ours, 0.0);
}

TEST(MpiParticipant, IsRefusedAtOnceIfEveryProcessWantsToTakePart) {
  TemporaryFolder folder;
  const std::string python = source_folder() + "/common/participant/python/explicit_bar.py";
  for (const auto& program : {build_folder() + "/wrong_participant", python}) {
    const auto run = run_file(folder.write(bars_by_several(program)), folder, "out", 30.0);
    EXPECT_NE(run.outcome.code, 0);
    EXPECT_THAT(run.outcome.error + file_text(run.folder + "/logs/right.log"),
                HasSubstr("found process 1 (OMPI_COMM_WORLD_RANK) of those that `launch` starts taking part, allowed: "
                          "process 0 alone"));
  }
}

}  // namespace
}  // namespace ricochet::test

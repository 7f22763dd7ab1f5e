// The script ./ricochet with stand-ins for cmake, ninja and ctest, which write down how they are called.
#include <filesystem>

#include "tests/support/run.hpp"

namespace ricochet::test {
namespace {

/// `./ricochet test ARGUMENTS` with a ctest that ends with `code`; what was called stands in `calls` of the folder.
Outcome script(const TemporaryFolder& folder, const std::string& arguments, int code) {
  for (const std::string program : {"cmake", "ninja", "ctest"}) {
    const std::string end = program == "ctest" ? std::to_string(code) : "0";
    const std::string path = folder.write(
        "#!/bin/sh\necho " + program + " \"$@\" >> " + (folder.path() / "calls").string() + "\nexit " + end + "\n",
        program);
    std::filesystem::permissions(path, std::filesystem::perms::owner_all);
  }
  return run_command({"/bin/sh", "-c",
                      "PATH=" + folder.path().string() + ":$PATH RICOCHET_BUILD_DIR=" + folder.path().string() +
                          "/build " RICOCHET_SOURCE "/ricochet test " + arguments},
                     folder.path().string());
}

TEST(Script, SaysWhatToDoWhenTestsFail) {
  const TemporaryFolder folder;
  const Outcome outcome = script(folder, "-R Bars", 8);
  EXPECT_EQ(outcome.code, 8);
  EXPECT_NE(
      outcome.error.find("ctest --test-dir " + folder.path().string() + "/build --rerun-failed --output-on-failure"),
      std::string::npos)
      << outcome.error;
}

TEST(Script, RunsSteadyTestsOnceAndRacingOnesUpToThreeTimes) {
  const TemporaryFolder folder;
  const Outcome outcome = script(folder, "-R Bars", 0);
  EXPECT_EQ(outcome.code, 0) << outcome.error;
  EXPECT_EQ(outcome.error.find("rerun-failed"), std::string::npos) << outcome.error;
  const std::string calls = file_text((folder.path() / "calls").string());
  EXPECT_NE(calls.find("-L steady --output-on-failure -R Bars\n"), std::string::npos) << calls;
  EXPECT_NE(calls.find("-L racing --output-on-failure -R Bars --repeat until-pass:3\n"), std::string::npos) << calls;
}

TEST(Script, BuildsAndRunsUnitTestsAloneWhenThatIsToBeQuick) {
  const TemporaryFolder folder;
  EXPECT_EQ(script(folder, "--quick", 0).code, 0);
  const std::string calls = file_text((folder.path() / "calls").string());
  EXPECT_NE(calls.find("--quiet unit_tests\n"), std::string::npos) << calls;
  EXPECT_NE(calls.find("-L unit-steady"), std::string::npos) << calls;
  EXPECT_EQ(calls.find("racing"), std::string::npos) << calls;
}

TEST(Script, NeitherInstallsNorBuildsIfThatIsNotWanted) {
  const TemporaryFolder folder;
  const std::string build = folder.path().string() + "/build";
  std::filesystem::create_directory(build);
  const auto run = [&](const std::string& arguments) {
    return run_command({"/bin/sh", "-c", "RICOCHET_BUILD_DIR=" + build + " " RICOCHET_SOURCE "/ricochet " + arguments},
                       folder.path().string());
  };
  const Outcome missing = run("run --no-build scene.toml");
  EXPECT_EQ(missing.code, 4);
  EXPECT_NE(missing.error.find("found no program " + build + "/ricochet"), std::string::npos) << missing.error;
  (void)folder.write("#!/bin/sh\necho \"$@\"\n", "build/ricochet");
  std::filesystem::permissions(build + "/ricochet", std::filesystem::perms::owner_all);
  EXPECT_EQ(run("run --no-build scene.toml --out x").out, "run scene.toml --out x\n");
}

}  // namespace
}  // namespace ricochet::test

// The script ./ricochet with stand-ins for cmake, ninja and ctest, which write down how they are called.
#include <gmock/gmock.h>

#include <filesystem>

#include "tests/support/places.hpp"
#include "tests/support/run.hpp"

namespace ricochet::test {
namespace {

using testing::ContainsRegex;
using testing::HasSubstr;

/// Output of ctest with a failure, a test that passed and one that it skipped.
constexpr const char* a_failure = R"(    Start 3: Bars.Part
1/3 Test #3: Bars.Part # GetParam() = (1, 2) ..................***Failed    0.04 sec
bars.cpp:9: Failure

    Start 5: Bars.Stay
2/3 Test #4: Bars.Meet ......   Passed    0.02 sec
3/3 Test #5: Bars.Stay ......***Skipped   0.02 sec
no reason

The following tests did not run:
	  5 - Bars.Stay (Skipped)

The following tests FAILED:
	  3 - Bars.Part # GetParam() = (1, 2) (Failed)
)";

/// `./ricochet test ARGUMENTS` with a ctest that ends with `code`; what was called stands in `calls` of the folder.
Outcome script(const TemporaryFolder& folder, const std::string& arguments, int code) {
  for (const std::string program : {"cmake", "ninja", "ctest"}) {
    std::string text = "#!/bin/sh\necho " + program + " \"$@\" >> " + (folder.path() / "calls").string() + "\n";
    if (program == "ctest") {
      text += "while [ \"$1\" != --output-log ]; do shift; done\nmkdir -p \"${2%/*}\"\n";
      text +=
          std::string("cat > \"$2\" <<'END'\n") + (code == 0 ? "" : a_failure) + "END\nexit " + std::to_string(code);
    }
    const std::string path = folder.write(text + "\n", program);
    std::filesystem::permissions(path, std::filesystem::perms::owner_all);
  }
  return run_command({"/bin/sh", "-c",
                      "PATH=" + folder.path().string() + ":$PATH RICOCHET_BUILD_DIR=" + folder.path().string() +
                          "/build " + source_folder() + "/ricochet test " + arguments},
                     folder.path().string());
}

TEST(Script, SaysWhatToDoWhenTestsFail) {
  const TemporaryFolder folder;
  const Outcome outcome = script(folder, "-R Bars", 8);
  EXPECT_EQ(outcome.code, 8);
  EXPECT_THAT(outcome.error,
              HasSubstr("ctest --test-dir " + folder.path().string() + "/build --output-on-failure -I 0,0,0,3'"));
  EXPECT_THAT(outcome.error, HasSubstr("***Failed    0.04 sec\nbars.cpp:9: Failure\n"));
  EXPECT_THAT(outcome.error, testing::Not(testing::AnyOf(HasSubstr("Bars.Meet"), HasSubstr("no reason"))));
}

TEST(Script, RunsSteadyTestsOnceAndRacingOnesUpToThreeTimes) {
  const TemporaryFolder folder;
  const Outcome outcome = script(folder, "-R Bars", 0);
  EXPECT_EQ(outcome.code, 0) << outcome.error;
  EXPECT_EQ(outcome.error.find("tests failed"), std::string::npos) << outcome.error;
  const std::string calls = file_text((folder.path() / "calls").string());
  EXPECT_THAT(calls, ContainsRegex("-L steady -LE whole --output-on-failure --output-log .*/steady.log -R Bars\n"));
  EXPECT_THAT(
      calls, ContainsRegex(
                 "-L racing -LE whole --output-on-failure --output-log .*/racing.log -R Bars --repeat until-pass:3\n"));
}

TEST(Script, BuildsAndRunsUnitTestsAloneWhenThatIsToBeQuick) {
  const TemporaryFolder folder;
  EXPECT_EQ(script(folder, "--quick", 0).code, 0);
  const std::string calls = file_text((folder.path() / "calls").string());
  EXPECT_NE(calls.find("--quiet unit_tests\n"), std::string::npos) << calls;
  EXPECT_NE(calls.find("-L unit-steady -LE each "), std::string::npos) << calls;
  EXPECT_EQ(calls.find("racing"), std::string::npos) << calls;
}

TEST(Script, NeitherInstallsNorBuildsIfThatIsNotWanted) {
  const TemporaryFolder folder;
  const std::string build = folder.path().string() + "/build";
  std::filesystem::create_directory(build);
  const auto run = [&](const std::string& arguments) {
    return run_command(
        {"/bin/sh", "-c", "RICOCHET_BUILD_DIR=" + build + " " + source_folder() + "/ricochet " + arguments},
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

#include <filesystem>
#include <regex>

#include "tests/support/run.hpp"

// What the README promises of the commands, run for real.

namespace ricochet::test {
namespace {

std::string readme() { return file_text(std::string(RICOCHET_SOURCE) + "/README.md"); }

TEST(Readme, TheFirstCommandEndsWithTheLinesShown) {
  const TemporaryFolder folder;
  const Outcome outcome = run_command({ricochet_binary(), "run", std::string(RICOCHET_SOURCE) + "/configs/kim_impact.toml", "--out",
                                       (folder.path() / "kim_impact").string()}, folder.path().string());
  ASSERT_EQ(outcome.code, 0) << outcome.error;
  // Numbers of the mechanics to the letter; wall time and folder are the machine's.
  std::smatch block;
  const std::string text = readme();
  ASSERT_TRUE(std::regex_search(text, block, std::regex("```\n(done: [^`]*)```")));
  std::istringstream lines(block[1]);
  int checked = 0;
  for (std::string line; std::getline(lines, line);) {
    if (line == "  ...") continue;
    std::string expected = std::regex_replace(line, std::regex(", [0-9.]+ s wall"), "");
    expected = std::regex_replace(expected, std::regex("results in out/kim_impact: .*"), "results in ");
    EXPECT_NE(outcome.out.find(expected), std::string::npos) << "not printed: " << expected << "\n" << outcome.out;
    ++checked;
  }
  EXPECT_EQ(checked, 4);
  for (const char* file : {"history.csv", "summary.json", "report.html", "trace.json", "fields/kim_impact.pvd", "logs"}) {
    EXPECT_TRUE(std::filesystem::exists(folder.path() / "kim_impact" / file)) << file;
  }
}

TEST(Readme, EveryCommandOfTheTableExists) {
  const TemporaryFolder folder;
  const std::string text = readme();
  const std::regex row("\\| `ricochet ([a-z-]+) ");
  int commands = 0;
  for (std::sregex_iterator it(text.begin(), text.end(), row), end; it != end; ++it, ++commands) {
    const Outcome outcome = run_command({ricochet_binary(), (*it)[1].str(), "--help"}, folder.path().string());
    EXPECT_EQ(outcome.code, 0) << (*it)[1];
  }
  EXPECT_GE(commands, 4);
}

TEST(Readme, InitWritesASceneThatRuns) {
  const TemporaryFolder folder;
  const auto in_folder = [&](const std::string& command) {
    return run_command({"/bin/sh", "-c", "cd " + folder.path().string() + " && " + ricochet_binary() + " " + command}, folder.path().string());
  };
  EXPECT_EQ(in_folder("init first").code, 0);
  EXPECT_EQ(in_folder("check first.toml").code, 0);
  const Outcome run = in_folder("run first.toml");
  EXPECT_EQ(run.code, 0) << run.error;
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "out" / "first" / "report.html"));
  EXPECT_EQ(in_folder("init first").code, 2) << "it must not overwrite";
  EXPECT_EQ(in_folder("report out/first").code, 0);
}

TEST(Readme, EveryProtocolOfTheTableRunsAndSaysWhatItIs) {
  const std::string text = readme();
  const TemporaryFolder folder;
  for (const std::string protocol : {"hughes_liu", "kim", "kim_predicted", "all_implicit", "all_explicit"}) {
    EXPECT_NE(text.find("\n| `" + protocol + "`"), std::string::npos) << protocol;
    const RunResult run = run_file(folder.write(with_protocol(config_text("two_bars"), protocol)), folder);
    EXPECT_EQ(run.summary.at("protocol"), protocol);
  }
}

TEST(Readme, EveryPathItNamesExists) {
  const std::string text = readme();
  const std::regex path("(?:`|\\()((?:docs|tests|coupler|common|configs)/[A-Za-z0-9_./]*[A-Za-z0-9_/])(?:`|\\))");
  int paths = 0;
  for (std::sregex_iterator it(text.begin(), text.end(), path), end; it != end; ++it, ++paths) {
    EXPECT_TRUE(std::filesystem::exists(std::string(RICOCHET_SOURCE) + "/" + (*it)[1].str())) << (*it)[1];
  }
  EXPECT_GE(paths, 10);
}

}  // namespace
}  // namespace ricochet::test

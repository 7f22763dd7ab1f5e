#include <fmt/format.h>

#include <filesystem>
#include <map>
#include <regex>
#include <set>

#include "tests/support/page.hpp"
#include "tests/support/places.hpp"
#include "tests/support/run.hpp"

// The promises that the README, docs/commands.md and docs/protocols.md promise of the commands, run for real.

namespace ricochet::test {
namespace {

std::string readme() { return page_text("README.md"); }

TEST(Readme, HasFewerThanElevenHundredWords) {
  std::istringstream text(readme());
  int words = 0;
  for (std::string word; text >> word;) ++words;
  EXPECT_LT(words, 1100);
  EXPECT_GT(words, 300);
}

TEST(Readme, TheFirstCommandEndsWithTheLinesShown) {
  const TemporaryFolder folder;
  const Outcome outcome = run_command({ricochet_binary(), "run", source_folder() + "/configs/kim_impact.toml", "--out",
                                       (folder.path() / "kim_impact").string()},
                                      folder.path().string());
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
  for (const char* file :
       {"history.csv", "summary.json", "report.html", "trace.json", "fields/kim_impact.pvd", "logs"}) {
    EXPECT_TRUE(std::filesystem::exists(folder.path() / "kim_impact" / file)) << file;
  }
}

/// Every match of a pattern's first group.
std::set<std::string> all(const std::string& text, const std::string& pattern) {
  std::set<std::string> found;
  const std::regex expression(pattern);
  for (std::sregex_iterator it(text.begin(), text.end(), expression), end; it != end; ++it) found.insert((*it)[1]);
  return found;
}

/// The text of --help, of the command itself or of a subcommand.
std::string help_of(const std::vector<std::string>& subcommand) {
  const TemporaryFolder folder;
  std::vector<std::string> words{ricochet_binary()};
  words.insert(words.end(), subcommand.begin(), subcommand.end());
  words.emplace_back("--help");
  const Outcome outcome = run_command(words, folder.path().string());
  EXPECT_EQ(outcome.code, 0) << fmt::format("{}", fmt::join(words, " "));
  return outcome.out;
}

/// The rows of the table of commands, by the subcommand; `prefix`: how the command is called.
std::map<std::string, std::string> rows_of_commands(const std::string& prefix) {
  std::map<std::string, std::string> rows;
  const std::string text = page_text("docs/commands.md");
  const std::regex row("\n\\| `" + prefix + "ricochet ([a-z-]+)([^`]*)` \\|");
  for (std::sregex_iterator it(text.begin(), text.end(), row), end; it != end; ++it) rows[(*it)[1]] = (*it)[2];
  return rows;
}

TEST(Commands, AreTheSameInTheTableInTheHelpAndInTheScript) {
  const std::string help = help_of({});
  std::set<std::string> of_table, of_script_in_table;
  for (const auto& [name, arguments] : rows_of_commands("")) of_table.insert(name);
  for (const auto& [name, arguments] : rows_of_commands("\\./")) of_script_in_table.insert(name);
  of_table.insert(of_script_in_table.begin(), of_script_in_table.end());
  const auto begin = help.find("Subcommands:");
  ASSERT_NE(begin, std::string::npos) << help;
  EXPECT_EQ(all(help.substr(begin, help.find("\n\n", begin) - begin), "\n  ([a-z-]+) "), of_table);
  EXPECT_EQ(all(file_text(source_folder() + "/ricochet"), "\"\\$\\{1:-\\}\" = ([a-z-]+) \\]"), of_script_in_table);
  EXPECT_EQ(all(help, "(--[a-z-]+)"), all(page_text("docs/commands.md"), "`ricochet (--[a-z-]+)`"));
}

TEST(Commands, HaveTheSameOptionsInTheTableAndInTheHelp) {
  int commands = 0;
  for (const auto& [name, arguments] : rows_of_commands("")) {
    auto options = all(help_of({name}), "\n  (?:-[a-z],)?(--[a-z-]+)");
    options.erase("--help");
    EXPECT_EQ(options, all(arguments, "(--[a-z-]+)")) << name;
    ++commands;
  }
  EXPECT_EQ(commands, 11);
}

TEST(Commands, OfTheScriptAreNotThoseOfTheProgram) {
  const TemporaryFolder folder;
  for (const auto& [name, arguments] : rows_of_commands("\\./")) {
    const Outcome outcome = run_command({ricochet_binary(), name, "-R", "KimImpact"}, folder.path().string());
    EXPECT_EQ(outcome.code, 2);
    EXPECT_NE(outcome.error.find("a command of the script ./ricochet"), std::string::npos) << outcome.error;
  }
}

TEST(Commands, ExitCodesOfTheTableAreThoseOfTheHelp) {
  const TemporaryFolder folder;
  const std::string help = run_command({ricochet_binary(), "--help"}, folder.path().string()).out;
  const std::string text = page_text("docs/commands.md");
  const std::regex row("\n\\| ([0-9]+) \\| ([^|:(;]*[^|:(; ])");
  int codes = 0;
  for (std::sregex_iterator it(text.begin(), text.end(), row), end; it != end; ++it, ++codes) {
    const std::string entry = fmt::format(" {} {}", (*it)[1].str(), (*it)[2].str());
    EXPECT_NE(help.find(entry), std::string::npos) << entry << "\n" << help;
  }
  EXPECT_EQ(codes, 8);
}

TEST(Commands, ARunLeavesTheFilesOfTheTable) {
  const TemporaryFolder folder;
  const auto scene = with_key(config_text("kim_impact"), "checkpoint", "every_windows", "500") +
                     "[[output.probe]]\nname = \"p\"\nbody = \"steel\"\nat_m = [0.001, -0.005]\n";
  const RunResult run = run_file(folder.write(scene, "kim_impact.toml"), folder);
  const std::string text = page_text("docs/commands.md");
  const std::regex row("\n\\| `([a-z_./*]+)` \\|");
  int files = 0;
  for (std::sregex_iterator it(text.begin(), text.end(), row), end; it != end; ++it, ++files) {
    bool exists = false;  // a star stands for the scene or for a participant
    for (const char* named : {"kim_impact", "explicit"}) {
      const std::string name = std::regex_replace((*it)[1].str(), std::regex("\\*"), named);
      exists = exists || std::filesystem::exists(run.folder + "/" + name);
    }
    EXPECT_TRUE(exists) << (*it)[1];
  }
  EXPECT_EQ(files, 10);
}

TEST(Readme, InitWritesASceneThatRuns) {
  const TemporaryFolder folder;
  const auto in_folder = [&](const std::string& command) {
    return run_command({"/bin/sh", "-c", "cd " + folder.path().string() + " && " + ricochet_binary() + " " + command},
                       folder.path().string());
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
  const TemporaryFolder folder;
  for (const std::string protocol :
       {"hughes_liu", "kim", "kim_predicted", "belytschko_mullen", "prakash_hjelmstad", "gravouil_combescure",
        "fixed_point", "all_implicit", "all_explicit", "local_explicit"}) {
    for (const char* page : {"README.md", "docs/protocols.md"}) {
      EXPECT_NE(page_text(page).find("\n| `" + protocol + "`"), std::string::npos) << page << ": " << protocol;
    }
    const RunResult run = run_file(folder.write(with_protocol(config_text("two_bars"), protocol)), folder);
    EXPECT_EQ(run.summary.at("protocol"), protocol);
  }
}

// The table of protocols: "-0.21 % to 0" of the energy on the way through the reference scene, and the momentum.
TEST(Readme, EnergyAndMomentumOfTheTableAreThoseOfTheRuns) {
  struct Row {
    const char *protocol, *energy, *momentum;
    int substeps;
    double lowest, highest, momentum_error;
  };
  const std::string text = page_text("docs/protocols.md");
  for (const Row& row : {Row{"hughes_liu", "-0.21 % to 0 ", "exact", 0, -0.0021, 0.0, 0.0},
                         Row{"kim", "-0.27 % to 0 ", "1e-4", 0, -0.0027, 0.0, 1e-4},
                         Row{"kim_predicted", "-0.22 % to 0 ", "exact", 0, -0.0022, 0.0, 0.0},
                         Row{"belytschko_mullen", "-0.20 % to 0 ", "exact", 0, -0.0020, 0.0, 0.0},
                         Row{"prakash_hjelmstad", "-0.21 % to 0 at m = 1 ", "exact", 1, -0.0021, 0.0, 0.0},
                         Row{"prakash_hjelmstad", "to +0.05 % at m = 4,", "exact", 4, -0.0021, 5e-4, 0.0},
                         Row{"prakash_hjelmstad", "+0.5 % at m = 16 ", "exact", 16, -0.0021, 5e-3, 0.0},
                         Row{"gravouil_combescure", "", "1e-4 at m = 2", 2, 0.0, 0.0, 1e-4},
                         Row{"fixed_point", "-0.21 % to 0 ", "to the tolerance", 0, -0.0021, 0.0, 0.0},
                         Row{"all_implicit", "-0.21 % to 0 ", "exact", 0, -0.0021, 0.0, 0.0},
                         Row{"all_explicit", "-0.21 % to 0 ", "exact", 0, -0.0021, 0.0, 0.0},
                         Row{"local_explicit", "-0.21 % to 0, ", "exact", 0, -0.0021, 0.0, 0.0}}) {
    std::smatch line;
    ASSERT_TRUE(std::regex_search(text, line, std::regex("\n\\| `" + std::string(row.protocol) + "`[^\n]*")))
        << row.protocol;
    EXPECT_NE(line.str().find(row.energy), std::string::npos) << row.protocol << ": " << row.energy;
    EXPECT_NE(line.str().find(row.momentum), std::string::npos) << row.protocol << ": " << row.momentum;
    const TemporaryFolder folder;
    std::string scene = with_key(with_protocol(config_text("kim_impact"), row.protocol), "output", "fields_every", "0");
    if (row.substeps > 0) scene = with_key(scene, "coupling", "substeps", std::to_string(row.substeps));
    if (row.substeps > 0) scene = with_key(scene, "time", "step_s", fmt::format("{:.17g}", 5.4e-8 * row.substeps));
    const RunResult run = run_text(scene, folder);
    if (row.substeps <= 1) {
      EXPECT_NEAR(run.smallest("energy_error"), row.lowest, -0.1 * row.lowest) << row.protocol;
    }
    EXPECT_NEAR(run.largest("energy_error"), row.highest, std::max(0.1 * row.highest, 5e-5))
        << row.protocol << " " << row.substeps;
    const double momentum = run.summary.at("momentum_error_max").get<double>();
    EXPECT_NEAR(momentum, row.momentum_error, row.momentum_error > 0.0 ? 0.5 * row.momentum_error : 1e-9)
        << row.protocol;
  }
}

}  // namespace
}  // namespace ricochet::test

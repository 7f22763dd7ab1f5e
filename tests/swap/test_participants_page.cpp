// docs/participants.md tells what is so: its code stands in the examples, its clauses are those of check-participant,
// its files exist, its numbers are right.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <regex>
#include <sstream>

#include "common/scene/protocols.hpp"
#include "tests/support/places.hpp"
#include "tests/support/run.hpp"

namespace ricochet::test {
namespace {

namespace fs = std::filesystem;
const std::string root = source_folder() + "/";
const std::string python = root + "common/participant/python/";

std::string page() { return file_text(root + "docs/participants.md"); }

/// The fenced blocks of a language.
std::vector<std::string> blocks(const std::string& language) {
  const std::string text = page(), begin = "\n```" + language + "\n";
  std::vector<std::string> found;
  for (auto at = text.find(begin); at != std::string::npos; at = text.find(begin, at + 1)) {
    const auto first = at + begin.size();
    found.push_back(text.substr(first, text.find("```\n", first) - first));
  }
  return found;
}

void expect_code(const std::string& language, std::size_t count, const std::vector<std::string>& files) {
  const auto found = blocks(language);
  EXPECT_EQ(found.size(), count) << language;
  std::string code;
  for (const auto& file : files) code += file_text(file);
  for (const auto& block : found) EXPECT_THAT(code, testing::HasSubstr(block));
}

TEST(ParticipantsPage, ShowsCodeOfTheExamples) {
  const std::string project = root + "tests/support/spring_mass_project/";
  expect_code("cpp", 3, {project + "spring_mass.cpp", root + "tests/support/own_loop_spring.cpp"});
  expect_code("cmake", 1, {project + "CMakeLists.txt"});
  expect_code("python", 6,
              {python + "explicit_bar.py", python + "getfem_impact.py", python + "ricochet_participant.py",
               python + "sfepy_body.py"});
  expect_code("fortran", 1, {root + "common/participant/c/explicit_bar.f90"});
}

TEST(ParticipantsPage, ShowsASceneEntryThatRuns) {
  ASSERT_EQ(blocks("toml").size(), 2U);
  TemporaryFolder folder;
  fs::copy_file(build_folder() + "/spring_mass", folder.path() / "spring_mass");
  run_text(config_text("two_bars") + "\n" + blocks("toml")[0] +
               "[[participant]]\nname = \"explicit\"\nrole = \"explicit\"\nbodies = [\"right\"]\n"
               "[[participant]]\nname = \"implicit\"\nrole = \"implicit\"\n",
           folder);
}

/// The far 12 elements of the left of two bars.
TEST(ParticipantsPage, ShowsAForeignBodyThatRuns) {
  TemporaryFolder folder;
  fs::create_symlink(root + "tests/swap/foreign_body.py", folder.path() / "foreign_body.py");
  (void)folder.write(
      "body = \"tail\"\nmodel = \"bar\"\nmaterial = { youngs_modulus_pa = 206.8e9, density_kg_m3 = 7844.066 }\n"
      "section = 6.4516e-4\nstart = [-0.254]\nsize = [0.1524]\nelements = [12]\nvelocity = [5.13588]\n"
      "shared = \"high\"\n",
      "far.toml");
  const auto two_bars = config_text("two_bars");
  const auto near = replaced(two_bars, "start_m = -0.254, length_m = 0.254, elements = 20",
                             "start_m = -0.1016, length_m = 0.1016, elements = 8");
  const auto run = run_text(near + "\n" + blocks("toml").at(1) +
                                "[[participant]]\nname = \"explicit\"\nrole = \"explicit\"\nbodies = [\"left\", "
                                "\"right\"]\n[[participant]]\nname = \"implicit\"\nrole = \"implicit\"\n",
                            folder);
  EXPECT_NEAR(run.last("velocity_mean_tail_m_s"), -5.13588, 0.5) << "the bars rebound";
  EXPECT_LT(run.summary.at("momentum_error_max").get<double>(), 1e-12);
  EXPECT_FALSE(run.summary.contains("theory"));
}

TEST(ParticipantsPage, ListsTheClausesOfTheContract) {
  TemporaryFolder folder;
  const auto outcome =
      run_command({ricochet_binary(), "check-participant", "--", build_folder() + "/spring_mass", "--name", "spring"},
                  folder.path().string());
  std::string text = page(), clauses = "| clause | what is done |\n|---|---|\n";
  std::istringstream lines(outcome.out);
  std::vector<std::string> tested, listed;
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind("  ", 0) == 0) tested.push_back(line.substr(11, line.find(':') - 11));
  }
  std::istringstream table(text.substr(text.find(clauses) + clauses.size()));
  for (std::string line; std::getline(table, line) && line.rfind("| ", 0) == 0;) {
    listed.push_back(line.substr(2, line.find(" | ") - 2));
  }
  EXPECT_EQ(tested.size(), 17U) << outcome.out;
  EXPECT_EQ(listed, tested);
}

TEST(ParticipantsPage, TellsWhatEachProtocolAsksFor) {
  const auto words = [](const std::vector<Capability>& capabilities) {
    std::string text;
    for (const auto c : capabilities) text += fmt::format("{}`{}`", text.empty() ? "" : ", ", name_of(c));
    return text.empty() ? "nothing" : text;
  };
  const std::string text = page();
  std::size_t rows = 0;
  for (const auto& protocol : scene::protocols()) {
    if (!protocol.coupled()) continue;
    ++rows;
    EXPECT_THAT(text, testing::HasSubstr(fmt::format(
                          "\n| `{}` | {} | {} | {} |\n", protocol.name, protocol.dual ? "force" : "displacement",
                          words(protocol.explicit_capabilities), words(protocol.implicit_capabilities))));
  }
  EXPECT_EQ(rows, 7U);
}

TEST(ParticipantsPage, NamesFilesThatExist) {
  const std::string text = page();
  const std::regex path("`((?:tests|common|configs)/[^` ]+)`");
  int count = 0;
  for (std::sregex_iterator found(text.begin(), text.end(), path), end; found != end; ++found, ++count) {
    EXPECT_TRUE(fs::exists(root + (*found)[1].str())) << (*found)[1];
  }
  EXPECT_GE(count, 6);
}

TEST(ParticipantsPage, CountsLinesRightly) {
  const auto lines = [](const std::string& name) {
    const std::string text = file_text(python + name);
    return std::count(text.begin(), text.end(), '\n');
  };
  EXPECT_THAT(page(), testing::HasSubstr(fmt::format("`getfem_impact.py` ({} lines)", lines("getfem_impact.py"))));
  EXPECT_THAT(page(), testing::HasSubstr(fmt::format("explicit_bar.py` ({} lines)", lines("explicit_bar.py"))));
  EXPECT_THAT(page(), testing::HasSubstr(fmt::format("`sfepy_body.py` ({} lines)", lines("sfepy_body.py"))));
  EXPECT_THAT(page(), testing::HasSubstr(fmt::format("`sfepy_integrator.py` ({} lines", lines("sfepy_integrator.py"))));
  EXPECT_LT(lines("ricochet_wire.py") + lines("ricochet_session.py"), 600);
  EXPECT_LT(lines("ricochet_memory.py"), 200);
  EXPECT_LT(lines("../c/explicit_bar.f90"), 120);
}

TEST(ParticipantsPage, StatesTheDefaultsOfTheCommand) {
  TemporaryFolder folder;
  const auto help = run_command({ricochet_binary(), "check-participant", "--help"}, folder.path().string());
  EXPECT_THAT(help.out, testing::HasSubstr("--timeout FLOAT=10"));
  EXPECT_THAT(help.out, testing::HasSubstr("default: half of its critical time step"));
}

}  // namespace
}  // namespace ricochet::test

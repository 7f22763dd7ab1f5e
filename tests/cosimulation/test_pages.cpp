#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <regex>
#include <set>

#include "tests/support/page.hpp"
#include "tests/support/places.hpp"
#include "tests/support/run.hpp"

// All pages have in common: links lead somewhere, files and functions they name exist.

namespace ricochet::test {
namespace {

namespace fs = std::filesystem;
const fs::path root = source_folder();

/// A heading as the end of a link: lower case, without punctuation, spaces as hyphens.
std::string anchor(const std::string& heading) {
  std::string result;
  for (const char letter : heading) {
    const auto byte = static_cast<unsigned char>(letter);
    if (byte >= 128 || std::isalnum(byte) != 0 || letter == '-' || letter == '_')
      result += static_cast<char>(std::tolower(byte));
    if (letter == ' ') result += '-';
  }
  return result;
}

std::set<std::string> anchors_of(const std::string& page) {
  std::set<std::string> anchors;
  std::istringstream lines(page);
  for (std::string line; std::getline(lines, line);) {
    std::smatch heading;
    if (std::regex_match(line, heading, std::regex("#+ (.*)"))) anchors.insert(anchor(heading[1]));
  }
  return anchors;
}

/// Every match of a pattern's first group.
std::vector<std::string> all(const std::string& text, const std::string& pattern) {
  std::vector<std::string> found;
  const std::regex expression(pattern);
  for (std::sregex_iterator it(text.begin(), text.end(), expression), end; it != end; ++it) found.push_back((*it)[1]);
  return found;
}

/// Paths of the sources by their names without a folder.
const std::multimap<std::string, fs::path>& sources() {
  static const auto table = [] {
    std::multimap<std::string, fs::path> paths;
    for (const char* top : {"common", "explicit_solver", "implicit_solver", "coupler", "tests"}) {
      for (const auto& entry : fs::recursive_directory_iterator(root / top))
        paths.insert({entry.path().filename().string(), entry.path()});
    }
    return paths;
  }();
  return table;
}

TEST(Pages, EveryLinkLeadsSomewhere) {
  int links = 0;
  for (const auto& page : pages()) {
    const std::string text = page_text(page);
    for (const auto& link : all(text, "\\]\\(([^)\\s]+)\\)")) {
      if (link.rfind("http", 0) == 0) continue;
      ++links;
      const auto hash = link.find('#');
      const std::string file = link.substr(0, hash);
      const fs::path target = file.empty() ? root / page : (root / page).parent_path() / file;
      ASSERT_TRUE(fs::exists(target)) << page << " links to " << link;
      if (hash == std::string::npos) continue;
      EXPECT_TRUE(anchors_of(file_text(target.string())).count(link.substr(hash + 1))) << page << " links to " << link;
    }
  }
  EXPECT_GT(links, 80);
}

TEST(Pages, MakeASiteInWhichEveryLinkLeadsSomewhere) {
  const TemporaryFolder folder;
  const Outcome built = run_command({"/bin/sh", "-c",
                                     "mkdocs build --strict --quiet --config-file " + source_folder() +
                                         "/.mkdocs.yml --site-dir " + folder.path().string() + "/site"},
                                    folder.path().string());
  ASSERT_EQ(built.code, 0) << built.out << built.error;
  int links = 0;
  for (const auto& page : pages()) {
    if (page.rfind("docs/", 0) != 0 || page == "docs/index.md") continue;
    const fs::path file = folder.path() / "site" / fs::path(page).stem() / "index.html";
    ASSERT_TRUE(fs::exists(file)) << page;
    for (const auto& link : all(file_text(file.string()), "href=\"([^\":]*#[^\"]+)\"")) {
      const auto hash = link.find('#');
      const fs::path target = hash == 0 ? file : file.parent_path() / link.substr(0, hash) / "index.html";
      EXPECT_NE(file_text(target.string()).find("id=\"" + link.substr(hash + 1) + "\""), std::string::npos)
          << page << " links to " << link;
      ++links;
    }
  }
  EXPECT_GT(links, 200);
}

TEST(Pages, EveryPathTheyNameExists) {
  int paths = 0;
  for (const auto& page : pages()) {
    if (page == "CHANGELOG.md") continue;  // it tells of what was
    for (const auto& path :
         all(page_text(page), "[`( ]((?:docs|tests|coupler|common|configs)/[A-Za-z0-9_./]*[A-Za-z0-9_])[`) ,:;]")) {
      EXPECT_TRUE(fs::exists(root / path)) << page << " names " << path;
      ++paths;
    }
  }
  EXPECT_GT(paths, 60);
}

TEST(Pages, EveryProgramOfTheTestsThatTheyCallCanBeCalled) {
  std::size_t called = 0;
  for (const auto& page : pages()) {
    for (const auto& program : all(page_text(page), R"(\n(tests/[\w/]+\.(?:py|sh))(?= |\n))")) {
      ++called;
      EXPECT_NE(fs::status(root / program).permissions() & fs::perms::owner_exec, fs::perms::none)
          << page << ": " << program;
    }
  }
  EXPECT_GT(called, 5U);
}

TEST(Pages, EverySourceFileTheyNameExists) {
  int files = 0;
  for (const auto& page : pages()) {
    if (page == "CHANGELOG.md") continue;
    for (const auto& name : all(page_text(page), "`([a-z_]+\\.[ch]pp)`")) {
      EXPECT_GT(sources().count(name), 0U) << page << " names " << name;
      ++files;
    }
  }
  EXPECT_GT(files, 40);
}

/// `Suite.Name`, and every alternative of `./ricochet test -R "..."`.
TEST(Pages, EveryTestTheyNameExists) {
  const std::set<std::string> tests = all_tests();
  const auto is_one = [&tests](const std::string& pattern) {
    return std::any_of(tests.begin(), tests.end(),
                       [&](const std::string& test) { return test.find(pattern) != std::string::npos; });
  };
  int named = 0;
  for (const auto& page : pages()) {
    if (page == "CHANGELOG.md") continue;
    const std::string text = page_text(page);
    for (const auto& test : all(text, "`([A-Z]\\w+\\.[A-Z]\\w+)`")) {
      EXPECT_EQ(tests.count(test), 1U) << page << " names " << test;
      ++named;
    }
    for (const auto& patterns : all(text, "test -R \"?([A-Z][A-Za-z.|]+)")) {
      if (patterns == "NAME") continue;
      std::istringstream alternatives(patterns);
      for (std::string pattern; std::getline(alternatives, pattern, '|'); ++named)
        EXPECT_TRUE(is_one(pattern)) << page << " runs " << pattern;
    }
  }
  EXPECT_GT(named, 80);
}

/// The text of a page: without headings, fenced blocks and code.
std::string prose_of(const std::string& page) {
  std::string prose;
  bool fenced = false;
  std::istringstream lines(page);
  for (std::string line; std::getline(lines, line);) {
    const bool fence = line.find("```") != std::string::npos;
    fenced = fence ? !fenced : fenced;
    if (!fence && !fenced && line.rfind('#', 0) != 0)
      prose += std::regex_replace(line, std::regex("`[^`]*`"), "") + "\n";
  }
  return prose;
}

/// Files of the SDK that users read: C++, C and Fortran by the list that installs them, and Python.
std::vector<std::string> public_sources() {
  auto files = all(file_text((root / "common/participant/package/install.cmake").string()),
                   "(common/[a-z/_]+\\.(?:hpp|h|f90))\\b");
  for (const auto& entry : fs::directory_iterator(root / "common/participant/python")) {
    if (entry.path().extension() == ".py") files.push_back(fs::relative(entry.path(), root).string());
  }
  return files;
}

/// With a capital these four words stand at the beginning of a sentence alone. Headings may ask questions.
TEST(Pages, NoSentenceBeginsWithOfWhoWhatOrSo) {
  const std::string word = "\\b((?:Of|Who|What|So)\\b[^\n]{0,60})";
  for (const auto& page : pages()) EXPECT_THAT(all(prose_of(page_text(page)), word), testing::IsEmpty()) << page;
  const auto sources = public_sources();
  EXPECT_GE(sources.size(), 12U);
  for (const auto& file : sources)
    EXPECT_THAT(all(file_text((root / file).string()), word), testing::IsEmpty()) << file;
  for (const auto& [name, path] : ricochet::test::sources()) {
    if (!name.ends_with(".cpp") && !name.ends_with(".hpp")) continue;
    EXPECT_THAT(all(file_text(path.string()), "//[^\n]*?" + word), testing::IsEmpty()) << path;
  }
}

/// A row without a head above it, as behind an empty line, is shown as text with bars.
TEST(Pages, EveryTableHasAHead) {
  for (const auto& page : pages()) {
    std::istringstream lines(prose_of(page_text(page)));
    std::string above;
    bool begins = false;  // the line above is the first of a table
    for (std::string line; std::getline(lines, line); above = line) {
      EXPECT_TRUE(!begins || line.rfind("|--", 0) == 0) << page << ": " << above;
      begins = line.rfind('|', 0) == 0 && above.rfind('|', 0) != 0;
    }
  }
}

/// docs/how_it_works.md: `file.cpp` | `Class::function`, in a row of a table or as `file.cpp`: `function`.
TEST(HowItWorks, EveryFunctionStandsInTheFileNamed) {
  const std::string text = page_text("docs/how_it_works.md");
  std::istringstream lines(text);
  int functions = 0;
  const auto expect_in = [&](const std::vector<std::string>& files, const std::string& function) {
    bool found = false;
    for (const auto& file : files) {
      ASSERT_EQ(sources().count(file), 1U) << file << " is not the name of one file";
      found = found || file_text(sources().find(file)->second.string()).find(function + "(") != std::string::npos;
    }
    EXPECT_TRUE(found) << function << " is not in " << fmt::format("{}", fmt::join(files, ", "));
    ++functions;
  };
  for (std::string line; std::getline(lines, line);) {
    std::smatch row;
    if (!std::regex_match(line, row, std::regex("\\| [^|]* \\| ([^|]*) \\| ([^|]*) \\|"))) continue;
    for (const auto& function : all(row[2], "`([A-Za-z_:]+)`")) expect_in(all(row[1], "`([a-z_]+\\.cpp)`"), function);
  }
  const std::regex in_prose("`([a-z_]+\\.cpp)`: `([A-Za-z_:]+)`");
  for (std::sregex_iterator it(text.begin(), text.end(), in_prose), end; it != end; ++it)
    expect_in({(*it)[1]}, (*it)[2]);
  EXPECT_GT(functions, 35);
}

}  // namespace
}  // namespace ricochet::test

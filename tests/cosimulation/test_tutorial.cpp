#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <regex>

#include "tests/support/page.hpp"
#include "tests/support/places.hpp"
#include "tests/support/run.hpp"

// docs/tutorial.md, every step of it, in a folder that looks like the root of the repository. Its fenced blocks are
//   sh      commands of one shell session, in the order of the page
//   (none)  what the commands before print: each line in this order, `...` for lines that are not shown
//   others  files: the path stands in a comment in one of the first two lines

namespace ricochet::test {
namespace {

namespace fs = std::filesystem;

/// Without what differs from run to run: times, which are printed with three decimals, and the width of columns.
std::string comparable(const std::string& line) {
  const std::string untimed = std::regex_replace(line, std::regex("\\b[0-9]+\\.[0-9]{3}\\b(?!e)"), "#");
  return std::regex_replace(std::regex_replace(untimed, std::regex("\\s+"), " "), std::regex(" $"), "");
}

/// But for the last digit of "3.12e-03", which rounding decides.
bool same(const std::string& a, const std::string& b) {
  constexpr double last_digit = 0.01;
  std::istringstream words_a(a), words_b(b);
  for (std::string x, y;;) {
    const bool more_a = static_cast<bool>(words_a >> x), more_b = static_cast<bool>(words_b >> y);
    if (!more_a || !more_b) return more_a == more_b;
    if (x == y) continue;
    const std::regex number("[+-]?[0-9]\\.[0-9]+e[+-][0-9]+");
    if (!std::regex_match(x, number) || !std::regex_match(y, number)) return false;
    if (std::abs(std::stod(x) - std::stod(y)) > last_digit * std::abs(std::stod(x))) return false;
  }
}

std::string path_of_file(const Block& block) {
  std::smatch path;
  const std::regex comment("^(?:[^\\n]*\\n)?(?:#|//) (mine/[a-z_.]+)");
  if (!std::regex_search(block.text, path, comment)) throw std::runtime_error("no path in the block\n" + block.text);
  return path[1];
}

std::string marker(std::size_t step) { return fmt::format("@@@ step {} @@@", step); }

/// The page as one shell script that says where each step begins.
std::string script(const std::vector<Block>& blocks) {
  std::string text = "exec 2>&1\nset -e\n";
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (blocks[i].language.empty()) continue;
    text += fmt::format("echo '{}'\n", marker(i));
    if (blocks[i].language == "sh") {
      text += blocks[i].text;
    } else {
      text += fmt::format("cat > {} <<'@@@ end of file @@@'\n{}@@@ end of file @@@\n", path_of_file(blocks[i]),
                          blocks[i].text);
    }
  }
  return text;
}

void expect_lines(const std::string& shown, const std::string& printed, std::size_t step) {
  std::vector<std::string> lines;
  std::istringstream all(printed);
  for (std::string line; std::getline(all, line);) lines.push_back(comparable(line));
  auto at = lines.begin();
  std::istringstream expected(shown);
  for (std::string line; std::getline(expected, line);) {
    if (line.find_first_not_of(' ') == line.find("...")) continue;
    const auto found =
        std::find_if(at, lines.end(), [&](const std::string& other) { return same(comparable(line), other); });
    EXPECT_NE(found, lines.end()) << "step " << step << " does not print, or not there: " << line << "\n" << printed;
    if (found == lines.end()) return;
    at = found + 1;
  }
}

TEST(Tutorial, EveryStepPrintsWhatThePageShows) {
  const TemporaryFolder folder;
  fs::create_symlink(ricochet_binary(), folder.path() / "ricochet");
  for (const char* name : {"configs", "common"}) {
    fs::create_symlink(source_folder() + "/" + name, folder.path() / name);
  }
  const auto blocks = blocks_of(page_text("docs/tutorial.md"));
  ASSERT_GT(blocks.size(), 10U);
  const std::string session = folder.write(script(blocks), "session.sh");
  const Outcome outcome = run_command({"/bin/sh", "-c", fmt::format("cd {} && sh {}", folder.path().string(), session)},
                                      folder.path().string(), 400.0);
  EXPECT_EQ(outcome.code, 0) << outcome.out;
  int compared = 0;
  for (std::size_t i = 0; i + 1 < blocks.size(); ++i) {
    if (blocks[i].language != "sh" || !blocks[i + 1].language.empty()) continue;
    const auto begin = outcome.out.find(marker(i));
    ASSERT_NE(begin, std::string::npos) << "the session ended before step " << i << "\n" << outcome.out;
    const auto end = outcome.out.find("@@@ step", begin + 4);
    expect_lines(blocks[i + 1].text, outcome.out.substr(begin, end - begin), i);
    ++compared;
  }
  EXPECT_GE(compared, 8);
}

}  // namespace
}  // namespace ricochet::test

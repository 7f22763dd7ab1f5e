#include <regex>
#include <set>

#include "tests/support/page.hpp"
#include "tests/support/run.hpp"

// docs/limits.md: every row stands on tests that exist.

namespace ricochet::test {
namespace {

TEST(LimitsPage, NamesTestsThatExistInEveryRow) {
  const std::set<std::string> tests = all_tests();
  EXPECT_GT(tests.size(), 200U);
  std::istringstream page(file_text(std::string(RICOCHET_SOURCE) + "/docs/limits.md"));
  const std::regex name("`([A-Z]\\w+\\.\\w+)`");
  std::set<int> rows;
  for (std::string line; std::getline(page, line);) {
    std::smatch number;
    if (!std::regex_search(line, number, std::regex("^\\| (\\d+) \\|"))) continue;
    EXPECT_TRUE(rows.insert(std::stoi(number[1])).second) << "twice: row " << number[1];
    int named = 0;
    for (std::sregex_iterator it(line.begin(), line.end(), name), end; it != end; ++it, ++named) {
      EXPECT_EQ(tests.count((*it)[1]), 1U) << "row " << number[1] << " names " << (*it)[1];
    }
    EXPECT_GE(named, 1) << "row " << number[1];
  }
  for (const int row : {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16}) EXPECT_EQ(rows.count(row), 1U) << row;
}

}  // namespace
}  // namespace ricochet::test

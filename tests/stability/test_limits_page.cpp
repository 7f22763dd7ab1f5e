#include <map>
#include <regex>
#include <set>

#include "tests/support/page.hpp"
#include "tests/support/places.hpp"
#include "tests/support/run.hpp"

// docs/limits.md: every setting with an edge stands on tests that exist.

namespace ricochet::test {
namespace {

TEST(LimitsPage, NamesTestsThatExistUnderEveryNumber) {
  const std::set<std::string> tests = all_tests();
  EXPECT_GT(tests.size(), 200U);
  std::istringstream page(file_text(source_folder() + "/docs/limits.md"));
  const std::regex name("`([A-Z]\\w+\\.\\w+)`");
  std::map<int, int> named;  // tests under each number
  int last = 0;
  for (std::string line; std::getline(page, line);) {
    std::smatch number;
    if (std::regex_search(line, number, std::regex("^### (\\d+)\\. "))) {
      EXPECT_EQ(std::stoi(number[1]), last + 1) << "in order, each once";
      last = std::stoi(number[1]);
    }
    if (line.rfind("- Tests: ", 0) != 0) continue;
    for (std::sregex_iterator it(line.begin(), line.end(), name), end; it != end; ++it, ++named[last])
      EXPECT_EQ(tests.count((*it)[1]), 1U) << last << " names " << (*it)[1];
  }
  EXPECT_GE(last, 18);
  for (int setting = 1; setting <= last; ++setting) EXPECT_GE(named[setting], 1) << setting;
}

}  // namespace
}  // namespace ricochet::test

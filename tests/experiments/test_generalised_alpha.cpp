// Programs that decided a question of docs/ by measuring: they still print what the page says.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <sstream>
#include <string>

#include "tests/support/places.hpp"
#include "tests/support/process.hpp"
#include "tests/support/scene_file.hpp"

namespace ricochet::test {
namespace {

struct Row {
  double overshoot = 0, rms = 0, plateau = 0, mean = 0, lost = 0;
};

/// Rows of the tables in `text`, by window and name of the law: "0.5 h/c, reset, trapezoidal rule".
std::map<std::string, Row> rows_of(const std::string& text) {
  constexpr std::size_t name_width = 34;
  std::map<std::string, Row> rows;
  std::istringstream lines(text);
  std::string window;
  for (std::string line; std::getline(lines, line);) {
    if (const auto at = line.find("elements, window "); at != std::string::npos) window = line.substr(at + 17);
    if (line.size() < name_width || (line.rfind("massless", 0) != 0 && line.rfind("reset", 0) != 0)) continue;
    std::string name = line.substr(0, name_width);
    name.erase(name.find_last_not_of(' ') + 1);
    Row row;
    std::istringstream(line.substr(name_width)) >> row.overshoot >> row.rms >> row.plateau >> row.mean >> row.lost;
    rows[window + ", " + name] = row;
  }
  return rows;
}

class GeneralisedAlpha : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    const TemporaryFolder folder;
    const auto outcome = run_command({"/usr/bin/python3", source_folder() + "/tests/experiments/generalised_alpha.py"},
                                     folder.path().string());
    ASSERT_EQ(outcome.code, 0) << outcome.error;
    printed() = rows_of(outcome.out);
  }
  static std::map<std::string, Row>& printed() {
    static std::map<std::string, Row> rows;
    return rows;
  }
};

TEST_F(GeneralisedAlpha, PrintsTheRowsOfThePage) {
  const auto page = rows_of(file_text(source_folder() + "/docs/contact_laws.md"));
  EXPECT_GE(page.size(), 8U);
  for (const auto& [name, row] : page) {
    ASSERT_EQ(printed().count(name), 1U) << name;
    const auto& now = printed().at(name);
    EXPECT_NEAR(row.overshoot, now.overshoot, 2e-3) << name;
    EXPECT_NEAR(row.rms, now.rms, 2e-4) << name;
    EXPECT_NEAR(row.plateau, now.plateau, 2e-4) << name;
    EXPECT_NEAR(row.mean, now.mean, 2e-4) << name;
    EXPECT_NEAR(row.lost, now.lost, 2e-5) << name;
  }
}

TEST_F(GeneralisedAlpha, DampingCostsMoreEnergyThanTheResetLawBeforeItLowersThePeak) {
  ASSERT_EQ(printed().size(), 24U);
  const double undamped = printed()["0.5 h/c, massless, generalised alpha 1"].overshoot;
  EXPECT_NEAR(undamped, 1.0 / 3.0, 5e-3);
  const auto reset = printed()["0.5 h/c, reset, trapezoidal rule"];
  EXPECT_NEAR(reset.lost, 1.0 / 200.0, 1e-4) << "1/(2n)";
  for (const auto& [name, row] : printed()) {
    if (name.rfind("0.5 h/c, massless", 0) != 0 || row.overshoot > 0.9 * undamped) continue;
    EXPECT_GT(row.lost, 3 * reset.lost) << name;
    EXPECT_GT(row.overshoot, reset.overshoot) << name;
  }
  EXPECT_LT(printed()["0.5 h/c, massless, generalised alpha 0"].overshoot, 0.9 * undamped)
      << "some damping does lower it";
}

TEST_F(GeneralisedAlpha, ThePeakOfTheResetLawIsHalfAnElementOverTheWindow) {
  const auto reset = printed()["0.1 h/c, reset, trapezoidal rule"];
  EXPECT_NEAR(reset.overshoot, 0.5 / 0.1 - 1, 0.1) << "h/2 stopped in one window, over its size";
  EXPECT_LT(printed()["0.1 h/c, massless, generalised alpha 1"].overshoot, 0.34);
}

}  // namespace
}  // namespace ricochet::test

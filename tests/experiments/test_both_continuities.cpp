// both_continuities.py: a dual interface bears equal velocities; equal displacements besides make windows grow.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>
#include <string>

#include "tests/support/places.hpp"
#include "tests/support/process.hpp"
#include "tests/support/scene_file.hpp"

namespace ricochet::test {
namespace {

TEST(BothContinuities, GrowWithFourSubstepsAndMore) {
  const TemporaryFolder folder;
  const auto outcome = run_command({"/usr/bin/python3", source_folder() + "/tests/experiments/both_continuities.py"},
                                   folder.path().string());
  ASSERT_EQ(outcome.code, 0) << outcome.error;
  std::istringstream lines(outcome.out);
  int bars = 0, drifts = 0;
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind("drift", 0) == 0) {
      double early = 0, late = 0;
      char comma = ' ';
      std::istringstream(line.substr(line.find(':') + 1)) >> early >> comma >> late;
      EXPECT_GT(early, 1e-2) << line;
      EXPECT_LT(late, 2.0 * early) << "100 times as many windows: " << line;
      ++drifts;
    }
    const auto substeps = line.find(", m=");
    if (substeps == std::string::npos || line.rfind("drift", 0) == 0) continue;
    double velocities_alone = 1;
    std::istringstream cells(line.substr(substeps + 5));
    cells >> velocities_alone;
    EXPECT_LT(velocities_alone, 1e-6) << line;
    const char m = line[substeps + 4];
    if (m != '4' && m != '8') continue;
    for (double growth = 0; cells >> growth;) EXPECT_GT(growth, 1e-3) << line;
    ++bars;
  }
  EXPECT_EQ(bars, 6);
  EXPECT_EQ(drifts, 4);
}

}  // namespace
}  // namespace ricochet::test

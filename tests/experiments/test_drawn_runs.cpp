// Programs that draw scenes by lot: whatever is drawn, a run is refused, leaves the model, or keeps what it must keep.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <regex>

#include "tests/support/places.hpp"
#include "tests/support/process.hpp"
#include "tests/support/scene_file.hpp"

namespace ricochet::test {
namespace {

void expect_none_wrong(const std::string& program, int seed, int count, int runs) {
  const TemporaryFolder folder;
  const auto outcome = run_command({"/usr/bin/python3", source_folder() + "/tests/experiments/" + program, "--build",
                                    build_folder(), "--seed", std::to_string(seed), "--count", std::to_string(count)},
                                   folder.path().string(), 300.0);
  EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.error;
  std::smatch found;
  const std::regex last(fmt::format(R"({} runs, (\d+) refused, 0 wrong)", runs));
  ASSERT_TRUE(std::regex_search(outcome.out, found, last)) << outcome.out;
  EXPECT_LT(std::stoi(found[1]), runs / 2) << "most are to be computed";
}

/// By five protocols each.
TEST(RandomImpacts, MakeNoEnergyAndLoseNoMomentum) { expect_none_wrong("random_impacts.py", 3, 8, 40); }

/// By five, and turned in space, and with the names in the other order: impulses agree; a run that is resumed, or
/// computed with ranks or threads, writes the same bytes.
TEST(RandomCurves, KeepWhatEveryRunMustKeep) { expect_none_wrong("random_curves.py", 8, 8, 47); }

/// By nine: check and run agree, balances hold, protocols agree, and a run that is resumed writes the same bytes.
TEST(RandomProcessSets, KeepWhatEveryRunMustKeep) { expect_none_wrong("random_process_sets.py", 5, 5, 45); }

}  // namespace
}  // namespace ricochet::test

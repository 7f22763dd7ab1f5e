#include <gmock/gmock.h>

#include <filesystem>

#include "tests/support/run.hpp"

// The mean axial stress of layers along the axis, axial_stress.csv: against the exact wave, and however bodies are
// spread.

namespace ricochet::test {
namespace {

History axial_stress(const RunResult& run) { return read_history(run.folder + "/axial_stress.csv"); }

/// The middle of the layer of a column BODY/LOW/HIGH [m].
double middle_m(const std::string& column) {
  const auto first = column.find('/'), last = column.rfind('/');
  return 0.5 * (std::stod(column.substr(first + 1)) + std::stod(column.substr(last + 1)));
}

std::string every_window(const std::string& text) { return with_key(text, "output", "axial_stress_every", "1"); }

TEST(AxialStress, OfTwoBarsIsTheExactWaveOnBothSidesOfItsFront) {
  const TemporaryFolder folder;
  const RunResult run = run_text(every_window(config_text("two_bars")), folder);
  const History stress = axial_stress(run);
  EXPECT_EQ(stress.size(), 41U) << "time, and 20 elements in each bar";
  const auto& time = stress.at("time_s");
  EXPECT_EQ(time, run.column("time_s"));
  const double speed = std::sqrt(206.8e9 / 7844.066), first = 49.456e-6, exact = -1.33453e5 / 6.4516e-4, h = 0.0127;
  int loaded = 0, free = 0;
  double sum = 0.0;
  for (const auto& [column, values] : stress) {
    if (column == "time_s") continue;
    const bool left = column.rfind("left/", 0) == 0;
    const double x = middle_m(column), from_contact = left ? -x : x - 0.508e-3;
    for (std::size_t row = 0; row < time.size() && time[row] < first + 0.9 * 0.254 / speed; ++row) {
      const double front = speed * (time[row] - first);  // its distance from the contact
      if (front > from_contact + 6 * h) {
        EXPECT_NEAR(values[row], exact, 0.15 * std::abs(exact)) << column << " at " << time[row];
        sum += values[row];
        ++loaded;
      } else if (front < from_contact - 3 * h) {
        EXPECT_NEAR(values[row], 0.0, 0.01 * std::abs(exact)) << column << " at " << time[row];
        ++free;
      }
    }
  }
  EXPECT_GT(loaded, 150);
  EXPECT_NEAR(sum / loaded, exact, 0.01 * std::abs(exact));
  EXPECT_GT(free, 500);
}

TEST(AxialStress, OfALayerInTwoProcessesIsThatOfImpedanceTheoryOnThePlateau) {
  const TemporaryFolder folder;
  std::string text = with_key(config_text("kim_impact"), "output", "fields_every", "0");
  // The layer of steel from 10 mm to 11 mm off the contact is implicit in one half and explicit in the other.
  text = with_key(text, "partition", "implicit_length_m", "{ steel = 0.0105, carbide = 0.015 }");
  const History stress = axial_stress(run_text(text, folder));
  ASSERT_EQ(stress.size(), 161U) << "time, and 80 layers in each cylinder";
  const auto& time = stress.at("time_s");
  int layers = 0;
  for (const auto& [column, values] : stress) {
    if (column == "time_s" || std::abs(middle_m(column)) > 0.02) continue;
    double sum = 0.0;
    int rows = 0;
    for (std::size_t row = 0; row < time.size(); ++row) {
      ASSERT_TRUE(std::isfinite(values[row])) << column;
      if (time[row] < 8e-6 || time[row] > 18e-6) continue;
      sum += values[row];
      ++rows;
    }
    EXPECT_NEAR(sum / rows, -853.75e6, 0.015 * 853.75e6) << column;
    ++layers;
  }
  EXPECT_EQ(layers, 40);
}

TEST(AxialStress, IsWrittenOnlyIfItIsAskedFor) {
  const TemporaryFolder folder;
  const RunResult run = run_text(config_text("two_bars"), folder);
  EXPECT_FALSE(std::filesystem::exists(run.folder + "/axial_stress.csv"));
  EXPECT_FALSE(std::filesystem::exists(run.folder + "/fields/scene.pvd"));
}

TEST(AxialStress, OfAProtocolWithSubstepsHasOneRowAWindow) {
  const TemporaryFolder folder;
  std::string text = with_key(every_window(config_text("two_bars")), "coupling", "protocol", "\"prakash_hjelmstad\"");
  text = with_key(text, "coupling", "substeps", "2");
  const RunResult run = run_text(text, folder);
  const History stress = axial_stress(run);
  EXPECT_EQ(stress.at("time_s"), run.column("time_s"));
  double largest = 0.0;
  for (const double value : stress.begin()->second) largest = std::max(largest, std::abs(value));
  EXPECT_NEAR(largest, 206.9e6, 0.25 * 206.9e6);
}

}  // namespace
}  // namespace ricochet::test

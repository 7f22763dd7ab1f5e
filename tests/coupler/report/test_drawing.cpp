// Drawing: thinning, units, and the choice of charts and series.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "coupler/report/parts/quantity.hpp"
#include "coupler/report/parts/thinning.hpp"
#include "coupler/report/run_page/history_charts.hpp"
#include "tests/coupler/report/sample_run.hpp"

namespace ricochet::report {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

std::vector<double> times(std::size_t rows) {
  std::vector<double> time(rows);
  for (std::size_t i = 0; i < rows; ++i) time[i] = 1e-9 * static_cast<double>(i);
  return time;
}

TEST(Thinning, ShortHistoriesStayWhole) {
  const std::vector<double> time = times(4);
  EXPECT_THAT(thin(time, {&time}, 2), ElementsAre(0, 1, 2, 3));
  EXPECT_THAT(thin({}, {}, 2), IsEmpty());
}

TEST(Thinning, KeepsTheExtremaOfEverySeriesInEveryPixelColumn) {
  const std::size_t rows = 20000, pixels = 50;
  const auto time = times(rows);
  std::mt19937 random(1);
  std::normal_distribution<double> noise;
  std::vector<double> a(rows), b(rows);
  for (auto& value : a) value = noise(random);
  for (auto& value : b) value = noise(random);
  a[12345] = 1e3;  // one single peak
  b[777] = -1e3;
  const auto kept = thin(time, {&a, &b}, pixels);
  EXPECT_LE(kept.size(), (pixels + 1) * 6);
  EXPECT_TRUE(std::is_sorted(kept.begin(), kept.end()));
  EXPECT_EQ(std::adjacent_find(kept.begin(), kept.end()), kept.end());
  EXPECT_EQ(kept.front(), 0U);
  EXPECT_EQ(kept.back(), rows - 1);
  for (const auto* series : {&a, &b}) {
    for (std::size_t pixel = 0; pixel < pixels; ++pixel) {
      // The last row lies exactly on the right edge; the columns in between are 400 rows wide but for rounding.
      const std::size_t begin = pixel * rows / pixels + 1, end = (pixel + 1) * rows / pixels - 1;
      const auto first = series->begin() + static_cast<long>(begin), last = series->begin() + static_cast<long>(end);
      const double lowest = *std::min_element(first, last), highest = *std::max_element(first, last);
      double low = lowest + 1, high = highest - 1;
      for (const auto row : kept) {
        if (row + 2 < begin || row > end + 2) continue;
        low = std::min(low, (*series)[row]);
        high = std::max(high, (*series)[row]);
      }
      EXPECT_LE(low, lowest);
      EXPECT_GE(high, highest);
    }
  }
}

TEST(Thinning, AValueThatIsNoNumberStaysAsABreak) {
  const auto time = times(1000);
  std::vector<double> values(1000, 1.0);
  values[500] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(thin(time, {&values}, 10), testing::Contains(500U));
}

TEST(Quantity, PrefixBringsTheNumberBetweenOneAndThousand) {
  EXPECT_EQ(quantity(31.158e-6, "s"), "31.158 µs");
  EXPECT_EQ(quantity(855.4e6, "Pa"), "855.4 MPa");
  EXPECT_EQ(quantity(-2.5e-3, "m"), "-2.5 mm");
  EXPECT_EQ(quantity(1e-3, "s"), "1 ms");
  EXPECT_EQ(quantity(5132.0, "m/s"), "5132 m/s") << "not km/s";
  EXPECT_EQ(quantity(3.45e9, "Pa"), "3450 MPa") << "stresses are read in MPa";
  EXPECT_EQ(quantity(0.0, "N"), "0 N");
  EXPECT_EQ(quantity(1e-5, ""), "1e-05");
  EXPECT_EQ(display_unit(std::nan(""), "J").name, "J");
}

const Chart* chart(const std::vector<Chart>& charts, const std::string& id) {
  const auto found = std::find_if(charts.begin(), charts.end(), [&](const Chart& c) { return c.id == id; });
  return found == charts.end() ? nullptr : &*found;
}

class HistoryCharts : public SampleRun {};

TEST_F(HistoryCharts, OnlyWhatExistsAndIsNotZeroIsShown) {
  const auto charts = history_charts(read_history(path("history.csv")), {1e-6});
  std::vector<std::string> ids;
  for (const auto& c : charts) ids.push_back(c.id);
  EXPECT_THAT(ids, ElementsAre("contact_stress", "gap", "velocities")) << "friction is zero, energies are not there";
}

TEST_F(HistoryCharts, RowsAreInDisplayUnitsAndWhatIsNoNumberIsNull) {
  const auto charts = history_charts(read_history(path("history.csv")), {});
  const auto* stress = chart(charts, "contact_stress");
  ASSERT_TRUE(stress);
  EXPECT_EQ(stress->columns, (std::vector<std::string>{"time", "c0", "c1"}));
  EXPECT_EQ(stress->rows[1], Json({1.0, 3400.0, 500.0}));
  const auto spec = Json::parse(stress->spec);
  EXPECT_EQ(spec["encoding"]["x"]["title"], "time [µs]");
  EXPECT_THAT(stress->spec, testing::AllOf(HasSubstr("stress [MPa]"), HasSubstr("contact pressure, mean [MPa]")));
  EXPECT_EQ(stress->spec.find("{{"), std::string::npos);
  EXPECT_TRUE(chart(charts, "gap")->rows[2][1].is_null());
}

TEST_F(HistoryCharts, AStarStandsForEveryBody) {
  const auto charts = history_charts(read_history(path("history.csv")), {});
  EXPECT_THAT(chart(charts, "velocities")->spec, testing::AllOf(HasSubstr("steel [m/s]"), HasSubstr("a<b [m/s]")));
}

TEST_F(HistoryCharts, RoundingNoiseBesideAValueIsNoSeries) {
  write("history.csv", "time_s,momentum_n_kg_m_s,momentum_t_kg_m_s\n0,1.5,0\n1,1.5,1e-16\n");
  const auto charts = history_charts(read_history(path("history.csv")), {});
  ASSERT_EQ(charts.size(), 1U);
  EXPECT_EQ(charts[0].columns.size(), 2U);
}

TEST_F(HistoryCharts, LongHistoriesSayThatTheyAreThinned) {
  std::string text = "time_s,contact_force_n\n";
  for (int i = 0; i < 20000; ++i) text += std::to_string(i) + "," + std::to_string(i % 7) + "\n";
  write("history.csv", text);
  const auto charts = history_charts(read_history(path("history.csv")), {});
  ASSERT_EQ(charts.size(), 1U);
  EXPECT_LT(charts[0].rows.size(), 6000U);
  EXPECT_THAT(charts[0].note, HasSubstr("of 20000 rows"));
}

TEST_F(HistoryCharts, NothingToDrawOfASingleRow) {
  write("history.csv", "time_s,contact_force_n\n0,1\n");
  EXPECT_THAT(history_charts(read_history(path("history.csv")), {}), IsEmpty());
}

}  // namespace
}  // namespace ricochet::report

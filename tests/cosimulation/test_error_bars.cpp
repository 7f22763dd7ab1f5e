// `ricochet run --estimate-error`: bars beside true errors of scenes with exact answers, and what is unknown.
#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <set>
#include <sstream>

#include "tests/support/page.hpp"
#include "tests/support/places.hpp"
#include "tests/support/two_bars.hpp"

namespace ricochet::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;

struct EstimatedRun {
  Outcome outcome;
  std::string folder;
  nlohmann::json summary;
  [[nodiscard]] const nlohmann::json& bar(const std::string& quantity) const {
    return summary.at("error_bar").at("quantities").at(quantity);
  }
  /// Bar over true error.
  [[nodiscard]] double ratio(const std::string& quantity, double exact) const {
    const auto& of = bar(quantity);
    return of.at("total").get<double>() / std::abs(of.at("value").get<double>() - exact);
  }
};

EstimatedRun estimated(const std::string& text, const TemporaryFolder& folder) {
  EstimatedRun run;
  run.folder = folder.path().string() + "/out";
  run.outcome = run_command({ricochet_binary(), "run", folder.write(text), "--out", run.folder, "--estimate-error"},
                            folder.path().string(), 120.0);
  if (std::ifstream file(run.folder + "/summary.json"); file) run.summary = nlohmann::json::parse(file);
  return run;
}

/// Exact: force Z v = 1.33453e5 N for 98.937 us, full rebound. The table of docs/accuracy.md has these ratios.
TEST(ErrorBars, HoldTheTrueErrorsOfTwoBars) {
  for (const int finer : {1, 2, 4, 8}) {
    const TemporaryFolder folder;
    const auto run = estimated(bars_of(finer), folder);
    ASSERT_EQ(run.outcome.code, 0) << run.outcome.error;
    const double duration_s = bars_contact_s, force_n = bars_force_n;
    for (const auto& [quantity, exact, largest] : {std::tuple{"contact_impulse_n_s", force_n * duration_s, 3.0},
                                                   {"rebound_velocity_left_m_s", -5.13588, 3.0},
                                                   {"separation_time_s", 148.393e-6, 10.0},
                                                   {"contact_duration_s", duration_s, 10.0}}) {
      const double ratio = run.ratio(quantity, exact);
      RecordProperty(std::string(quantity) + std::to_string(20 * finer), std::to_string(ratio));
      EXPECT_GE(ratio, 1.0) << quantity << ", " << 20 * finer << " elements";
      EXPECT_LE(ratio, largest) << quantity << ", " << 20 * finer << " elements";
    }
    EXPECT_GE(run.ratio("plateau_stress_pa", force_n / 6.4516e-4), 1.0);
  }
}

/// A2: contact for one period 1 <= t <= 2 with an impulse of 1/2; the rod needs no window for its step.
TEST(ErrorBars, HoldTheTrueErrorsOfARodOnAStop) {
  const TemporaryFolder folder;
  const auto run = estimated(replaced(config_text("rod_on_stop"), "end_s = 12.0", "end_s = 2.5"), folder);
  ASSERT_EQ(run.outcome.code, 0) << run.outcome.error;
  EXPECT_GE(run.ratio("contact_impulse_n_s", 0.5), 1.0);
  EXPECT_LE(run.ratio("contact_impulse_n_s", 0.5), 3.0);
  EXPECT_GE(run.ratio("contact_duration_s", 1.0), 1.0);
  EXPECT_GE(run.ratio("separation_time_s", 2.0), 1.0);
}

TEST(ErrorBars, TellPartsApartOnTheConsoleInTheSummaryAndOnThePage) {
  const TemporaryFolder folder;
  const auto run = estimated(bars_of(2), folder);
  ASSERT_EQ(run.outcome.code, 0) << run.outcome.error;
  EXPECT_EQ(run.summary.at("error_bar").at("companions").size(), 5U);
  const auto& impulse = run.bar("contact_impulse_n_s");
  for (const char* part : {"total", "time", "space", "coupling", "contact_law"})
    EXPECT_TRUE(impulse.at(part).is_number()) << part << ": " << impulse.dump();
  // Both changes of the difference of two levels, one after the other.
  EXPECT_GE(impulse.at("time").get<double>() + impulse.at("space").get<double>(),
            (1 - 1e-9) * impulse.at("total").get<double>());
  EXPECT_THAT(run.outcome.out, AllOf(HasSubstr("error bars from 5 companion runs"), HasSubstr("contact_impulse_n_s")));
  EXPECT_THAT(file_text(run.folder + "/report.html"), HasSubstr("error bars, each in the unit of its name"));
}

TEST(ErrorBars, HaveTheKeysOfTheirPageAndNoOther) {
  const TemporaryFolder folder;
  const auto run = estimated(
      with_protocol(bars_of(1), "kim") + "[accuracy]\nrelative_error = { contact_impulse_n_s = 0.1 }\n", folder);
  ASSERT_EQ(run.outcome.code, 0) << run.outcome.error;
  const std::string page = file_text(source_folder() + "/docs/accuracy.md");
  const std::string table = page.substr(page.find("\n## error_bar\n"));
  const auto& block = run.summary.at("error_bar");
  std::set<std::string> keys;
  for (const auto* object : {&block, &block.at("companions").at(0), &run.bar("contact_impulse_n_s")}) {
    for (const auto& [key, value] : object->items()) {
      keys.insert(key);
      EXPECT_THAT(table, HasSubstr("`" + key + "`"));
    }
  }
  std::istringstream lines(table);
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind("| `", 0) != 0) continue;
    const auto key = line.substr(3, line.find('`', 3) - 3);
    EXPECT_EQ(keys.count(key), 1U) << key;
  }
}

TEST(ErrorBars, OfNothingAreNotRelative) {
  const TemporaryFolder folder;  // the bars meet later, and one is at rest until then
  const std::string flight =
      replaced(with_key(with_protocol(bars_of(1), "kim"), "time", "end_s", "2e-5"), "[-5.13588]", "[0.0]");
  const auto run = estimated(flight + "[accuracy]\nrelative_error = { rebound_velocity_right_m_s = 0.1 }\n", folder);
  ASSERT_EQ(run.outcome.code, 0) << run.outcome.error;
  EXPECT_THAT(run.outcome.out,
              HasSubstr("rebound_velocity_right_m_s within 10 %: not reached, its value of 0 has no relative error"));
  EXPECT_FALSE(run.bar("rebound_velocity_right_m_s").at("reached").get<bool>());
}

TEST(ErrorBars, OfABaselineHaveNoCoupling) {
  const TemporaryFolder folder;
  const auto run = estimated(with_protocol(bars_of(2), "all_explicit"), folder);
  ASSERT_EQ(run.outcome.code, 0) << run.outcome.error;
  EXPECT_EQ(run.bar("contact_impulse_n_s").at("coupling"), 0.0);
}

TEST(ErrorBars, OfAGmshMeshAreOfTimeAlone) {
  const TemporaryFolder folder;
  const auto run = estimated(with_absolute_meshes(config_text("striker_gmsh")), folder);
  ASSERT_EQ(run.outcome.code, 0) << run.outcome.error;
  const auto& separation = run.bar("separation_time_s");
  EXPECT_TRUE(separation.at("total").is_null());
  EXPECT_TRUE(separation.at("space").is_null());
  EXPECT_TRUE(separation.at("time").is_number()) << separation.dump();
  EXPECT_EQ(separation.at("unknown").at("space"), "a Gmsh mesh has no coarser one");
  EXPECT_THAT(run.outcome.out, HasSubstr("space unknown: a Gmsh mesh has no coarser one"));
}

TEST(ErrorBars, ACompanionThatIsRefusedLeavesTimeAlone) {
  const TemporaryFolder folder;  // three elements across cannot become fewer
  const auto run = estimated(config_text("slipping_plates"), folder);
  ASSERT_EQ(run.outcome.code, 0) << run.outcome.error;
  const auto& rebound = run.bar("rebound_velocity_lower_m_s");
  EXPECT_TRUE(rebound.at("total").is_null());
  EXPECT_THAT(rebound.at("unknown").at("space").get<std::string>(), HasSubstr("elements and step doubled: "));
  EXPECT_TRUE(rebound.at("time").is_number()) << rebound.dump();
}

TEST(ErrorBars, RefuseByNameWhoseCompanionsCannotBeRun) {
  const std::string participants =
      "\n[[participant]]\nname = \"mine\"\nrole = \"explicit\"\nbodies = [\"left\", \"right\"]\n{}\n"
      "[[participant]]\nname = \"implicit\"\nrole = \"implicit\"\n";
  const TemporaryFolder folder;
  const auto refusal = [&folder](const std::string& text) {
    const auto run = estimated(text, folder);
    EXPECT_EQ(run.outcome.code, 2);
    EXPECT_TRUE(run.summary.is_null());  // nothing was run
    return run.outcome.error;
  };
  EXPECT_THAT(refusal(bars_of(1) + replaced(participants, "{}", "executable = \"/bin/false\"")),
              HasSubstr("--estimate-error: found participant 'mine', a program of somebody else's; allowed: "));
  EXPECT_THAT(refusal(bars_of(1) + replaced(participants, "{}", "start = \"by_hand\"")),
              HasSubstr("--estimate-error: found participant 'mine', started by hand; allowed: "));
  EXPECT_THAT(
      refusal(replaced(bars_of(1), "end_s = 250e-6", "end_s = 250e-6\nchanges = [{ from_s = 1e-4, step_s = 1e-6 }]")),
      HasSubstr("--estimate-error: found time.changes; allowed: one step"));
}

}  // namespace
}  // namespace ricochet::test

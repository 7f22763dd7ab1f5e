// `ricochet study` with real processes: the exact solution of two bars, resuming, rows that fail.
#include <gmock/gmock.h>

#include <filesystem>
#include <thread>

#include "tests/support/run.hpp"

namespace ricochet::test {
namespace {

using testing::HasSubstr;
namespace fs = std::filesystem;
using Row = std::map<std::string, std::string>;

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells{""};
  bool quoted = false;
  for (const char c : line) {
    if (c == '"')
      quoted = !quoted;
    else if (c == ',' && !quoted)
      cells.emplace_back();
    else
      cells.back() += c;
  }
  return cells;
}

std::vector<Row> rows_of(const std::string& folder) {
  std::istringstream text(file_text(folder + "/results.csv"));
  std::vector<std::string> names;
  std::vector<Row> rows;
  for (std::string line; std::getline(text, line);) {
    const auto cells = cells_of(line);
    if (names.empty()) {
      names = cells;
      continue;
    }
    EXPECT_EQ(cells.size(), names.size()) << line;
    auto& row = rows.emplace_back();
    for (std::size_t i = 0; i < std::min(cells.size(), names.size()); ++i) row[names[i]] = cells[i];
  }
  return rows;
}

std::string study_text(const std::string& rest) {
  return "scene = \"" + std::string(RICOCHET_SOURCE) + "/configs/two_bars.toml\"\n" + rest;
}

std::string run_id(const std::string& folder, const Row& row, int repeat) {
  return nlohmann::json::parse(
             file_text(folder + "/runs/" + row.at("run") + "/" + std::to_string(repeat) + "/summary.json"))
      .at("run_id");
}

Outcome study(const std::string& path, const std::string& out, const TemporaryFolder& folder) {
  return run_command({ricochet_binary(), "study", path, "--out", out}, folder.path().string(), 300.0);
}

double number(const Row& row, const std::string& column) { return std::stod(row.at(column)); }

TEST(Study, ErrorsAgainstTheExactImpactFallWithTheMeshAndFailuresAreRows) {
  const TemporaryFolder folder;
  const std::string out = (folder.path() / "study").string();
  const auto path = folder.write(study_text(R"(methods = ["hughes_liu", "all_implicit", "all_explicit"]
repeats = 2
[[vary]]
body.left.mesh.elements = [20, 80, 20]
body.right.mesh.elements = [20, 80, 20]
time.step_s = [2.226e-6, 5.565e-7, 2.6e-6]
[reference]
exact = "impedance_theory"
)"),
                                 "study.toml");
  const auto outcome = study(path, out, folder);
  ASSERT_EQ(outcome.code, 0) << outcome.error;
  const auto rows = rows_of(out);
  ASSERT_EQ(rows.size(), 9U);
  for (std::size_t m = 0; m < 3; ++m) {
    const auto &coarse = rows[m], &fine = rows[3 + m], &too_long = rows[6 + m];
    EXPECT_EQ(coarse.at("status"), "done");
    EXPECT_EQ(coarse.at("repeats"), "2");
    for (const char* quantity : {"error_contact_pressure", "error_principal_stress", "error_energy_drift"}) {
      EXPECT_LT(number(fine, quantity), 0.75 * number(coarse, quantity)) << fine.at("method") << " " << quantity;
    }
    // A jump that is met within one step is an RMS error of sqrt(step / period) at most.
    EXPECT_LT(number(coarse, "error_contact_pressure"), 0.5);
    EXPECT_LT(number(fine, "error_rebound_velocity"), 0.03);
    EXPECT_LT(number(fine, "error_separation_time"), 0.02);
    EXPECT_LE(number(coarse, "wall_min_s"), number(coarse, "wall_s"));
    EXPECT_LE(number(coarse, "wall_s"), number(coarse, "wall_max_s"));
    EXPECT_GT(number(coarse, "cpu_s"), 0.0);
    EXPECT_GE(number(coarse, "wall_s"), number(coarse, "stepping_s") + number(coarse, "setup_s"));
    // 1.05 of the critical step: only all-implicit can take it.
    const bool implicit = too_long.at("method") == "all_implicit";
    EXPECT_EQ(too_long.at("status"), implicit ? "done" : "scene_wrong");
    if (!implicit) {
      EXPECT_THAT(too_long.at("error"), HasSubstr("critical time step"));
    }
  }
  EXPECT_THAT(file_text(out + "/report.html"), HasSubstr("contact_pressure_wall_s"));
  fs::remove(out + "/report.html");
  fs::remove_all(out + "/runs");
  const auto again = run_command({ricochet_binary(), "report", out}, folder.path().string());
  EXPECT_EQ(again.code, 0) << again.error;
  EXPECT_THAT(file_text(out + "/report.html"), HasSubstr("critical time step")) << "redrawn from the results alone";
}

TEST(Study, ThatWasInterruptedGoesOnWhereItStopped) {
  const TemporaryFolder folder;
  const std::string out = (folder.path() / "study").string();
  const auto path = folder.write(study_text(R"(methods = ["hughes_liu", "kim", "all_implicit", "all_explicit"]
repeats = 2
quantities = ["peak_force"]
[[vary]]
time.step_s = [2.226e-6, 1e-6]
[reference]
protocol = "all_explicit"
changes = { time.step_s = 5e-7 }
refine = { time.step_s = 2.5e-7 }
)"),
                                 "study.toml");
  {
    Process process({ricochet_binary(), "study", path, "--out", out}, (folder.path() / "o").string(),
                    (folder.path() / "e").string());
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    const auto any_done = [&] {
      const auto rows = rows_of(out);
      return !rows.empty() && rows.front().at("status") == "done";
    };
    while (!any_done() && std::chrono::steady_clock::now() < deadline) {
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    kill(process.pid(), SIGINT);
    EXPECT_EQ(process.wait(30.0), 130);
  }
  const auto half = rows_of(out);
  ASSERT_EQ(half.size(), 8U);
  EXPECT_EQ(half.front().at("status"), "done");
  EXPECT_EQ(half.back().at("status"), "waiting");
  const auto first = run_id(out, half.front(), 1);
  const auto outcome = study(path, out, folder);
  ASSERT_EQ(outcome.code, 0) << outcome.error;
  EXPECT_THAT(outcome.out, HasSubstr("reference: from ")) << "not computed again";
  const auto rows = rows_of(out);
  for (const auto& row : rows) {
    EXPECT_EQ(row.at("status"), "done") << row.at("error");
    EXPECT_EQ(row.at("repeats"), "2");
  }
  EXPECT_EQ(run_id(out, rows.front(), 1), first) << "not computed again";
  const auto later = study(path, out, folder);
  EXPECT_EQ(later.code, 0);
  EXPECT_EQ(later.out.find("s left"), std::string::npos) << "nothing is left to compute: " << later.out;
  EXPECT_EQ(rows_of(out), rows);
}

TEST(Study, AnUnstableRunIsARowAndIsNotComputedAgain) {
  const TemporaryFolder folder;
  const std::string out = (folder.path() / "study").string();
  const auto path = folder.write(study_text(R"(methods = ["prakash_hjelmstad", "gravouil_combescure"]
repeats = 2
[[vary]]
coupling.substeps = [20]
time.step_s = [4.452e-5]
[reference]
exact = "impedance_theory"
)"),
                                 "study.toml");
  ASSERT_EQ(study(path, out, folder).code, 0);
  const auto rows = rows_of(out);
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0].at("status"), "done");
  EXPECT_EQ(rows[1].at("status"), "unstable");
  EXPECT_THAT(rows[1].at("error"), HasSubstr("the energy balance has grown"));
  EXPECT_EQ(rows[1].at("error_peak_force"), "");
  const auto first = run_id(out, rows[1], 1);
  ASSERT_EQ(study(path, out, folder).code, 0);
  EXPECT_EQ(run_id(out, rows[1], 1), first);
  EXPECT_EQ(rows_of(out), rows);
}

TEST(Study, RefusesAWrongFileAndOneOfWhichNothingCanRun) {
  const TemporaryFolder folder;
  const std::string out = (folder.path() / "study").string();
  const std::string reference = "[reference]\nexact = \"impedance_theory\"\n";
  const auto wrong = study(folder.write(study_text("methods = [\"kin\"]\n" + reference), "a.toml"), out, folder);
  EXPECT_EQ(wrong.code, 2);
  EXPECT_THAT(wrong.error, HasSubstr("did you mean \"kim\"?"));
  const auto none =
      study(folder.write(study_text("methods = [\"kim\"]\n[[vary]]\ntime.step_s = [1e-5]\n" + reference), "b.toml"),
            out, folder);
  EXPECT_EQ(none.code, 2);
  EXPECT_THAT(none.error, HasSubstr("every run of the study is refused"));
  const auto bad_reference =
      study(folder.write(study_text("methods = [\"kim\"]\n[reference]\nprotocol = \"all_explicit\"\n"
                                    "changes = { time.step_s = 1e-5 }\nrefine = { time.step_s = 1e-6 }\n"),
                         "c.toml"),
            out, folder);
  EXPECT_EQ(bad_reference.code, 2);
  EXPECT_THAT(bad_reference.error, HasSubstr("the reference failed: "));
}

TEST(Study, TheShippedOnesAreReportedInTheDocs) {
  int studies = 0;
  for (const auto& entry : fs::directory_iterator(std::string(RICOCHET_SOURCE) + "/configs/studies")) {
    ++studies;
    const std::string page = file_text(std::string(RICOCHET_SOURCE) + "/docs/studies.md");
    EXPECT_THAT(page, HasSubstr("ricochet study configs/studies/" + entry.path().filename().string()));
  }
  EXPECT_GE(studies, 2);
}

}  // namespace
}  // namespace ricochet::test

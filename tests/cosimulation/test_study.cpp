// `ricochet study` with real processes: the exact solution of two bars, resuming, rows that fail.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>
#include <thread>

#include "tests/support/places.hpp"
#include "tests/support/process_table.hpp"
#include "tests/support/run.hpp"
#include "tests/support/same_results.hpp"

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
  return "scene = \"" + source_folder() + "/configs/two_bars.toml\"\n" + rest;
}

std::string run_id(const std::string& folder, const Row& row, int repeat) {
  return nlohmann::json::parse(
             file_text(folder + "/runs/" + row.at("run") + "/" + std::to_string(repeat) + "/summary.json"))
      .at("run_id");
}

Outcome study(const std::string& path, const std::string& out, const TemporaryFolder& folder) {
  return run_command({ricochet_binary(), "study", path, "--out", out}, folder.path().string(), 300.0);
}

struct Computed {
  Outcome outcome;
  std::string out;
  std::vector<Row> rows;  ///< none of a study that failed, which is a failure
};

Computed computed(const std::string& text, const TemporaryFolder& folder) {
  const std::string out = (folder.path() / "study").string();
  const Outcome outcome = study(folder.write(text, "study.toml"), out, folder);
  EXPECT_EQ(outcome.code, 0) << outcome.error;
  return {outcome, out, outcome.code == 0 ? rows_of(out) : std::vector<Row>()};
}

double number(const Row& row, const std::string& column) { return std::stod(row.at(column)); }

/// Substeps are a key of dual protocols alone: no run of another method is refused for it.
TEST(Study, VariesAKeyForTheMethodsThatHaveIt) {
  const TemporaryFolder folder;
  const auto [outcome, out, rows] = computed(study_text(R"(methods = ["kim", "prakash_hjelmstad"]
quantities = ["separation_time"]
[[vary]]
methods = ["prakash_hjelmstad"]
coupling.substeps = [1, 2, 4]
[[vary]]
contact.multiplier_update = ["trapezoidal_reset", "massless"]
[reference]
exact = "impedance_theory"
[histories]
quantity = "contact_pressure"
over_pa = 2e8
over_name = "p"
compare_to = "kim"
)"),
                                             folder);
  ASSERT_EQ(rows.size(), 8U);
  std::map<std::string, int> substeps;
  for (const auto& row : rows) {
    EXPECT_EQ(row.at("status"), "done") << row.at("error");
    ++substeps[row.at("method") + row.at("coupling.substeps")];
    EXPECT_EQ(number(row, "rms_compared") == 0.0, row.at("method") == "kim") << "beside kim with the same contact law";
  }
  EXPECT_EQ(substeps["kim"], 2);
  for (const char* m : {"1", "2", "4"}) EXPECT_EQ(substeps[std::string("prakash_hjelmstad") + m], 2) << m;
  EXPECT_THAT(outcome.out, HasSubstr("\nkim contact.multiplier_update=massless "));
}

TEST(Study, ErrorsAgainstTheExactImpactFallWithTheMeshAndFailuresAreRows) {
  const TemporaryFolder folder;
  const auto [outcome, out, rows] = computed(study_text(R"(methods = ["hughes_liu", "all_implicit", "all_explicit"]
repeats = 2
[[vary]]
body.left.mesh.elements = [20, 80, 20]
body.right.mesh.elements = [20, 80, 20]
time.step_s = [2.226e-6, 5.565e-7, 2.6e-6]
[reference]
exact = "impedance_theory"
)"),
                                             folder);
  ASSERT_EQ(rows.size(), 9U);
  for (std::size_t m = 0; m < 3; ++m) {
    const auto &coarse = rows[m], &fine = rows[3 + m], &too_long = rows[6 + m];
    EXPECT_EQ(coarse.at("status"), "done");
    EXPECT_EQ(coarse.at("repeats"), "2");
    for (const char* quantity : {"error_contact_force", "error_principal_stress", "error_energy_drift"}) {
      EXPECT_LT(number(fine, quantity), 0.75 * number(coarse, quantity)) << fine.at("method") << " " << quantity;
    }
    // A jump that is met within one step is an RMS error of sqrt(step / period) at most.
    EXPECT_LT(number(coarse, "error_contact_force"), 0.5);
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
  EXPECT_THAT(file_text(out + "/report.html"), HasSubstr("contact_force_wall_s"));
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

/// The error of a probe's history falls with the step; a column that no probe has is refused by its nearest name.
TEST(Study, ComparesWhatAProbeSees) {
  const TemporaryFolder folder;
  (void)folder.write(config_text("two_bars") + "[[output.probe]]\nname = \"middle\"\nbody = \"left\"\nat_m = [0.0]\n",
                     "probed.toml");
  const std::string text = R"(scene = "probed.toml"
methods = ["all_implicit"]
quantities = ["probe/middle.displacement_x_m"]
[[vary]]
time.step_s = [1e-6, 5e-7]
[reference]
protocol = "all_explicit"
changes = { time.step_s = 1e-7 }
refine = { time.step_s = 5e-8 }
)";
  const auto [outcome, out, rows] = computed(text, folder);
  ASSERT_EQ(rows.size(), 2U);
  const double coarse = std::stod(rows[0].at("error_probe/middle.displacement_x_m")),
               fine = std::stod(rows[1].at("error_probe/middle.displacement_x_m"));
  EXPECT_LT(coarse, 2e-2);
  EXPECT_LT(fine, coarse);
  EXPECT_GT(fine, 0.0);
  EXPECT_THAT(file_text(out + "/report.html"), HasSubstr("middle.displacement_x_m"));
  const auto wrong =
      study(folder.write(replaced(text, "displacement_x_m", "displacement_y_m"), "wrong.toml"), out + "_wrong", folder);
  EXPECT_EQ(wrong.code, 2);
  EXPECT_THAT(wrong.error, HasSubstr("did you mean \"probe/middle.displacement_x_m\"?"));
}

/// The run that was going on is not begun anew: it goes on, to the bytes of one that was never interrupted.
TEST(Study, ResumesInsideTheRunThatWasInterrupted) {
  const TemporaryFolder folder;
  const std::string out = (folder.path() / "study").string();
  const auto path = folder.write(study_text(R"(methods = ["hughes_liu"]
[[vary]]
time.end_s = [0.05]
[reference]
exact = "impedance_theory"
)"),
                                 "study.toml");
  std::string run;
  {
    Process process({ricochet_binary(), "study", path, "--out", out}, (folder.path() / "o").string(),
                    (folder.path() / "e").string());
    const auto begun = [&] {
      const auto names = names_in(out + "/runs");
      if (!names.empty()) run = out + "/runs/" + *names.rbegin();  // the other one is the list of own files
      std::error_code none;
      return !run.empty() && std::filesystem::file_size(run + "/1/history.csv", none) > 100000 && !none;
    };
    ASSERT_TRUE(wait_until([&] { return begun() || !process.running(); }, 60.0));
    kill(process.pid(), SIGTERM);
    EXPECT_EQ(process.wait(30.0), 143) << file_text(folder.path() / "e");
  }
  const auto saved = checkpoints_in(run + "/1");
  ASSERT_EQ(saved.size(), 1U);
  const auto outcome = study(path, out, folder);
  ASSERT_EQ(outcome.code, 0) << outcome.error;
  const auto summary = nlohmann::json::parse(file_text(run + "/1/summary.json"));
  EXPECT_EQ(summary.at("status"), "done");
  const auto whole = run_file(run + "/scene.toml", folder, "whole");
  expect_same_results(run + "/1", whole.folder);
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

/// Twice the speed, bodies that touch from the start: a linear problem, all of whose stresses double.
const std::string twice_as_fast = R"(body.left.initial_velocity_m_s = [[5.13588], [10.27176]]
body.right.initial_velocity_m_s = [[-5.13588], [-10.27176]]
body.right.mesh.start_m = [0.0, 0.0]
)";

TEST(Study, AReferenceThatFollowsAVariedKeyScalesWithIt) {
  const TemporaryFolder folder;
  const std::string out = (folder.path() / "study").string();
  const auto path = folder.write(study_text(R"(methods = ["hughes_liu", "all_implicit", "all_explicit"]
quantities = ["contact_force", "rebound_velocity"]
along = "body.left.initial_velocity_m_s"
[[vary]]
)" + twice_as_fast + R"([histories]
quantity = "contact_pressure"
over_pa = 206.852e6
over_name = "rho c v"
compare_to = "all_implicit"
[reference]
protocol = "all_explicit"
follow = ["body.left.initial_velocity_m_s", "body.right.initial_velocity_m_s", "body.right.mesh.start_m"]
changes = { time.step_s = 5.565e-7 }
refine = { time.step_s = 2.7825e-7 }
)"),
                                 "study.toml");
  const auto outcome = study(path, out, folder);
  ASSERT_EQ(outcome.code, 0) << outcome.error;
  const auto rows = rows_of(out);
  ASSERT_EQ(rows.size(), 6U);
  for (std::size_t m = 0; m < 3; ++m) {
    const auto &slow = rows[m], &fast = rows[3 + m];
    EXPECT_LT(number(slow, "error_contact_force"), 0.4) << "of a reference at another speed it would be 0.5 or more";
    for (const char* relative : {"error_contact_force", "error_rebound_velocity"})
      EXPECT_NEAR(number(fast, relative), number(slow, relative), 1e-5 * number(slow, relative)) << slow.at("method");
    for (const char* absolute : {"rms_compared", "rms_reference"}) {
      EXPECT_NEAR(number(fast, absolute), 2.0 * number(slow, absolute), 2e-5 * number(slow, absolute));
      EXPECT_EQ(number(slow, absolute) > 0.0, std::string(absolute) == "rms_reference" || m != 1) << slow.at("method");
    }
  }
  const auto references = nlohmann::json::parse(file_text(out + "/study.json")).at("references");
  ASSERT_EQ(references.size(), 2U);
  EXPECT_EQ(references[1].at("follows").at("body.left.initial_velocity_m_s"), "10.27176");
  fs::remove_all(out + "/runs");
  fs::remove_all(out + "/reference");
  const auto again = run_command({ricochet_binary(), "report", out}, folder.path().string());
  EXPECT_EQ(again.code, 0) << again.error;
  const auto page = file_text(out + "/report.html");
  for (const char* chart : {"history_1", "history_2", "along_rms_compared_1", "along_wall_s_1"})
    EXPECT_THAT(page, HasSubstr(fmt::format("id=\"{}\"", chart))) << "redrawn from the results alone";
}

/// A rigid striker on a plate of soft steel, over two decades of velocity: Johnson's e = 3.8 (Y/E*)^(1/2)
/// (m V^2/(2 Y R^3))^(-1/8) (Contact Mechanics, 1985, 11.4), by a mean pressure of 3 Y; it falls with V^(-1/4).
TEST(Study, RestitutionFallsWithTheFourthRootOfTheVelocity) {
  const TemporaryFolder folder;
  const auto [outcome, out, rows] = computed("scene = \"" + source_folder() + R"(/configs/rebound.toml"
methods = ["all_explicit"]
quantities = ["energy_drift"]
values = ["restitution", "peak_contact_force_n"]
along = "body.striker.initial_velocity_m_s"
axis = { title = "speed [m/s]", at = [0.1, 1, 10] }
measured = [{ value = "restitution", at = [0.37], measured = [0.4375], error = 0.0625, source = "somebody" },
            { value = "restitution", at = [0.73], measured = [0.371], source = "somebody else" }]
[[vary]]
body.striker.initial_velocity_m_s = [[0.0, -0.1], [0.0, -1.0], [0.0, -10.0]]
[[vary]]
time.step_s = [4.4e-9]
coupling.outside_model = ["go_on"]
[reference]
protocol = "all_explicit"
changes = { time.end_s = 1e-7, time.step_s = 4.4e-9 }
refine = { time.end_s = 1e-7, time.step_s = 2.2e-9 }
)",
                                             folder);
  ASSERT_EQ(rows.size(), 3U);
  const double m = 7850.0 * std::acos(-1.0) * 0.005 * 0.005 * 0.01, y = 100e6, modulus = 200e9 / 0.91, r = 0.01;
  for (std::size_t i = 0; i < 3; ++i) {
    const double v = 0.1 * std::pow(10.0, i), e = number(rows[i], "value_restitution");
    EXPECT_NEAR(e / (3.8 * std::sqrt(y / modulus) * std::pow(0.5 * m * v * v / (y * r * r * r), -0.125)), 1.0, 0.13);
    EXPECT_GT(number(rows[i], "value_peak_contact_force_n"), 0.0);
  }
  const double fallen = number(rows[2], "value_restitution") / number(rows[0], "value_restitution");
  EXPECT_NEAR(std::log(fallen) / std::log(100.0), -0.25, 0.01);
  const auto page = file_text(out + "/report.html");
  EXPECT_THAT(page, HasSubstr("Magnitude of restitution"));
  EXPECT_THAT(page, HasSubstr("speed [m/s]"));
  EXPECT_THAT(page, HasSubstr("◇ measured: somebody. △ measured: somebody else."));
  EXPECT_THAT(page, HasSubstr(R"({"at":0.37,"value":0.4375,"sign":"◇","source":"somebody","low":0.375,"high":0.5})"));
  EXPECT_THAT(page, HasSubstr(R"({"at":0.73,"value":0.371,"sign":"△","source":"somebody else"})"));
  EXPECT_THAT(page, HasSubstr(R"([0.1,)")) << "the runs stand at the axis' numbers";
  EXPECT_THAT(page, HasSubstr(R"("title":"speed [m/s]","scale":{"type":"log","nice":false,"padding":12})"));
}

// With solids, too, a key with one entry for each direction is varied, and errors fall with the mesh.
TEST(Study, ErrorsOfSolidsFallWithTheMesh) {
  const TemporaryFolder folder;
  std::string scene = "model = \"solid\"\n";
  for (const auto& [name, start, speed] : {std::tuple{"left", 0.0, 10.0}, std::tuple{"right", 0.04, 0.0}}) {
    scene += fmt::format(
        "[[body]]\nname = \"{}\"\nmaterial = {{ youngs_modulus_pa = 2e11, poisson_ratio = 0.3, density_kg_m3 = 8000 "
        "}}\nmesh = {{ start_m = {}, length_m = 0.04, height_m = 0.01, width_m = 0.01, elements = [1, 1, 6] }}\n"
        "initial_velocity_m_s = [0.0, 0.0, {}]\n",
        name, start, speed);
  }
  (void)folder.write(scene +
                         "[contact]\nsurfaces = [\"left.end\", \"right.start\"]\n[partition]\nimplicit_length_m = { "
                         "left = 0.014, right = 0.014 }\n[time]\nend_s = 45e-6\n",
                     "solids.toml");
  const auto [outcome, out, rows] = computed(R"(scene = "solids.toml"
methods = ["hughes_liu", "all_explicit"]
quantities = ["contact_force", "rebound_velocity"]
[[vary]]
body.left.mesh.elements = [[1, 1, 6], [2, 2, 12]]
body.right.mesh.elements = [[1, 1, 6], [2, 2, 12]]
time.step_s = [4e-7, 2e-7]
[reference]
protocol = "all_explicit"
changes = { body.left.mesh.elements = [4, 4, 24], body.right.mesh.elements = [4, 4, 24], time.step_s = 1e-7 }
refine = { body.left.mesh.elements = [6, 6, 36], body.right.mesh.elements = [6, 6, 36], time.step_s = 6e-8 }
)",
                                             folder);
  ASSERT_EQ(rows.size(), 4U);
  for (std::size_t m = 0; m < 2; ++m) {
    for (const char* error : {"error_contact_force", "error_rebound_velocity"})
      EXPECT_LT(number(rows[2 + m], error), 0.6 * number(rows[m], error)) << error;
  }
}

TEST(Study, AHistoryOverTheExactStressIsOneWhileTheBarsTouch) {
  const TemporaryFolder folder;
  const std::string out = (folder.path() / "study").string();
  const auto path = folder.write(study_text(R"(methods = ["all_explicit"]
[histories]
quantity = "contact_pressure"
over_pa = 206.852e6
over_name = "rho c v"
compare_to = "all_explicit"
[reference]
exact = "impedance_theory"
)"),
                                 "study.toml");
  ASSERT_EQ(study(path, out, folder).code, 0);
  std::istringstream lines(file_text(out + "/histories.csv"));
  const auto run = rows_of(out)[0].at("run");
  double sum = 0.0;
  int count = 0, exact = 0;
  for (std::string line; std::getline(lines, line);) {
    const auto cells = cells_of(line);
    if (cells[0] == "exact" && std::stod(cells[2]) != 0.0) {
      EXPECT_NEAR(std::stod(cells[2]), 1.0, 1e-4);
      ++exact;
    }
    if (cells[0] != run || std::stod(cells[1]) < 60e-6 || std::stod(cells[1]) > 130e-6) continue;
    sum += std::stod(cells[2]);
    ++count;
  }
  EXPECT_EQ(exact, 2) << "the corners of the rectangle";
  ASSERT_GT(count, 20);
  EXPECT_NEAR(sum / count, 1.0, 0.02);
}

TEST(Study, MethodsThatComeToTheSameSceneShareItsRuns) {
  const TemporaryFolder folder;
  const std::string out = (folder.path() / "study").string();
  const auto path = folder.write(study_text(R"(methods = ["all_implicit"]
repeats = 2
quantities = ["peak_force"]
[[method]]
name = "all_implicit, short steps"
protocol = "all_implicit"
changes = { time.step_s = 1.113e-6, contact.multiplier_update = "" }
[[vary]]
time.step_s = [2.226e-6, 1.113e-6]
contact.multiplier_update = ["massless", ""]
[reference]
exact = "impedance_theory"
)"),
                                 "study.toml");
  const auto outcome = study(path, out, folder);
  ASSERT_EQ(outcome.code, 0) << outcome.error;
  const auto rows = rows_of(out);
  ASSERT_EQ(rows.size(), 4U);
  EXPECT_EQ(rows[1].at("method"), "all_implicit, short steps");
  EXPECT_NE(rows[0].at("run"), rows[1].at("run"));
  for (const std::size_t same : {1U, 3U}) {
    EXPECT_EQ(rows[same].at("run"), rows[2].at("run"));
    EXPECT_EQ(rows[same].at("repeats"), "2");
    EXPECT_EQ(rows[same].at("wall_s"), rows[2].at("wall_s"));
  }
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
  for (const auto& entry : fs::directory_iterator(source_folder() + "/configs/studies")) {
    ++studies;
    const std::string page = file_text(source_folder() + "/docs/studies.md");
    EXPECT_THAT(page, HasSubstr("ricochet study configs/studies/" + entry.path().filename().string()));
  }
  EXPECT_GE(studies, 2);
}

}  // namespace
}  // namespace ricochet::test

// Files of a run: results folder, field index, summary, trace, starter scene; and the command line.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <sstream>

#include "common/base/error.hpp"
#include "coupler/command/command_line.hpp"
#include "coupler/command/starter_scene.hpp"
#include "coupler/processes/interrupted.hpp"
#include "coupler/processes/run_id.hpp"
#include "coupler/report/parts/csv_table.hpp"
#include "coupler/results/csv_cell.hpp"
#include "coupler/results/results_directory.hpp"
#include "coupler/results/summary.hpp"
#include "coupler/results/trace.hpp"
#include "coupler/run/compute_scene.hpp"
#include "tests/support/places.hpp"

namespace ricochet::coupler {
namespace {

using testing::AllOf;
using testing::HasSubstr;
namespace fs = std::filesystem;

std::string read(const std::string& path) {
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

class ResultsTest : public testing::Test {
 protected:
  std::string folder_ = testing::TempDir() + "results_" + std::to_string(getpid());
  void SetUp() override { fs::remove_all(folder_); }
  void TearDown() override { fs::remove_all(folder_); }
  void touch(const std::string& name) const {
    fs::create_directories(fs::path(folder_ + "/" + name).parent_path());
    std::ofstream(folder_ + "/" + name) << "old";
  }
};

const std::vector<std::string> run_names = {"history.csv", "summary.json", "fields/implicit_#.vtu", "logs/a.log"};

TEST_F(ResultsTest, FormerResultsGoOtherFilesStay) {
  const std::vector<std::string> others = {"notes.txt", "results.csv", "fields/mine.png", "fields/other_1.vtu",
                                           "charts/mine.svg"};
  for (const auto& name : others) touch(name);
  {
    const ResultsDirectory results(folder_, run_names);
    for (const auto* name : {"history.csv", "fields/implicit_00000001.vtu", "fields/implicit_2.vtu.part", "logs/a.log"})
      touch(name);
  }
  const ResultsDirectory results(folder_ + "/", run_names);
  EXPECT_EQ(results.path(), folder_);
  EXPECT_FALSE(fs::exists(results.file("history.csv")));
  EXPECT_FALSE(fs::exists(results.file("fields/implicit_00000001.vtu")));
  EXPECT_FALSE(fs::exists(results.file("fields/implicit_2.vtu.part")));
  EXPECT_FALSE(fs::exists(results.log("a")));
  for (const auto& name : others) EXPECT_EQ(read(results.file(name)), "old") << name;
}

TEST_F(ResultsTest, AFileThatIsNotOursIsRefusedAndNothingIsTouched) {
  {
    const ResultsDirectory results(folder_, run_names);
    touch("history.csv");
  }
  for (const std::string foreign :
       {"summary.json", "fields/implicit_00000001.vtu", "logs/a.log", "summary.json.part"}) {
    touch(foreign);
    try {
      const ResultsDirectory results(folder_, run_names);
      FAIL() << foreign;
    } catch (const ConfigError& error) {
      EXPECT_THAT(error.what(), AllOf(HasSubstr(folder_ + "/" + foreign), HasSubstr("move it away")));
    }
    EXPECT_EQ(read(folder_ + "/" + foreign), "old");
    EXPECT_TRUE(fs::exists(folder_ + "/history.csv"));
    fs::remove(folder_ + "/" + foreign);
  }
}

TEST_F(ResultsTest, WhatTheUserChangedAfterwardsIsTheUsers) {
  {
    const ResultsDirectory results(folder_, run_names);
    touch("history.csv");
  }
  std::ofstream(folder_ + "/history.csv") << "my own notes";
  EXPECT_THROW(ResultsDirectory(folder_, run_names), ConfigError);
  const ResultsDirectory other(folder_, {"summary.json"});
  EXPECT_EQ(read(folder_ + "/history.csv"), "my own notes");
}

TEST_F(ResultsTest, WhatAKilledRunLeftIsOurs) {
  {
    const ResultsDirectory results(folder_, run_names);
    touch("summary.json");
  }
  std::ofstream(folder_ + "/" + OwnFiles::list_name, std::ios::app)
      << "history.csv\t-1\t-1\nfields/implicit_#.vtu\t-1\t-1\n";
  touch("history.csv");
  touch("fields/implicit_00000001.vtu");
  const ResultsDirectory results(folder_, run_names);
  EXPECT_FALSE(fs::exists(results.file("history.csv")));
  EXPECT_FALSE(fs::exists(results.file("fields/implicit_00000001.vtu")));
}

TEST_F(ResultsTest, AListThatLeadsOutOfTheFolderRemovesNothing) {
  const std::string outside = folder_ + "_outside";
  fs::create_directories(outside);
  std::ofstream(outside + "/thesis.tex") << "old";
  {
    const ResultsDirectory results(folder_, run_names);
    touch("summary.json");
  }
  const std::string list = read(folder_ + "/" + OwnFiles::list_name);
  for (const std::string& name :
       {"../" + fs::path(outside).filename().string() + "/thesis.tex", outside + "/thesis.tex"}) {
    std::ofstream(folder_ + "/" + OwnFiles::list_name) << list << name << "\t-1\t-1\n";
    EXPECT_THROW(ResultsDirectory(folder_, run_names), ConfigError);
  }
  fs::create_symlink(outside, folder_ + "/link");
  std::ofstream(folder_ + "/" + OwnFiles::list_name) << list << "link/thesis.tex\t-1\t-1\n";
  const ResultsDirectory results(folder_, run_names);
  EXPECT_EQ(read(outside + "/thesis.tex"), "old");
  fs::remove_all(outside);
}

TEST_F(ResultsTest, TwoRunsInOneFolderAreRefusedButOneAfterTheOtherIsFine) {
  {
    const ResultsDirectory first(folder_, {});
    EXPECT_THROW(ResultsDirectory second(folder_, {}), ConfigError);
  }
  EXPECT_NO_THROW(ResultsDirectory again(folder_, {}));
}

TEST_F(ResultsTest, UnwritableFolderIsAConfigError) {
  EXPECT_THROW(ResultsDirectory results("/proc/nonexistent", {}), ConfigError);
}

TEST_F(ResultsTest, FieldsAreOneDataSetATimeWithBodiesByName) {
  const ResultsDirectory results(folder_, {});
  for (const auto* name : {"implicit.b_00000010.vtu", "implicit.a_b_00000010.vtu", "explicit.b_00000010.vtu",
                           "explicit.b_00000002.vtu", "explicit.b_x.vtu", "explicit.b.c_00000002.vtu", "explicit2.vtu",
                           "own_00000002.vtu", "scene_00000003.vtm", "scene_mine.vtm"}) {
    touch(std::string("fields/") + name);
  }
  write_collection(results, "scene", {"b", "a_b"}, {"explicit", "implicit", "own"}, 0.5);
  const auto index = read(results.file("fields/scene.pvd"));
  EXPECT_THAT(index, HasSubstr("<DataSet timestep=\"1\" file=\"scene_00000002.vtm\"/>\n"
                               "    <DataSet timestep=\"5\" file=\"scene_00000010.vtm\"/>\n  </Collection>"));
  EXPECT_THAT(read(results.file("fields/scene_00000010.vtm")), HasSubstr(R"(    <Block index="0" name="b">
      <DataSet index="0" name="explicit" file="explicit.b_00000010.vtu"/>
      <DataSet index="1" name="implicit" file="implicit.b_00000010.vtu"/>
    </Block>
    <Block index="1" name="a_b">
      <DataSet index="0" name="implicit" file="implicit.a_b_00000010.vtu"/>
    </Block>
)"));
  EXPECT_THAT(read(results.file("fields/scene_00000002.vtm")), HasSubstr(R"(    <Block index="0" name="b">
      <DataSet index="0" name="explicit" file="explicit.b_00000002.vtu"/>
    </Block>
    <Block index="1" name="all bodies">
      <DataSet index="0" name="own" file="own_00000002.vtu"/>
    </Block>
)"));
  EXPECT_FALSE(fs::exists(results.file("fields/scene_00000003.vtm"))) << "of a run with another step";
  EXPECT_TRUE(fs::exists(results.file("fields/scene_mine.vtm")));
}

TEST_F(ResultsTest, NoSnapshotsNoPvdAndNoEmptyFolder) {
  {
    const ResultsDirectory results(folder_, {});
    write_collection(results, "scene", {}, {"explicit"}, 0.5);
  }
  EXPECT_FALSE(fs::exists(folder_ + "/fields"));
}

Summary finished() {
  Summary summary;
  summary.status = RunStatus::done;
  summary.protocol = "hughes_liu";
  summary.windows = 42;
  summary.clock = 1e-6;
  summary.scene_sha256 = "abc";
  summary.switches = {{32e-6, Role::explicit_solver}};
  summary.processes = {{"coupler", {}, 1, {}, 1.0, 0.2, 0.8, {{"implicit", 0.8}}},
                       {"implicit", Role::implicit_solver, 2, Transport::shm, 1.0, std::nullopt, std::nullopt, {}}};
  return summary;
}

const WindowClock micro_second(1e-6), three_eighths(0.375), half_second(0.5), one_second(1.0);

/// In contact from 1 to 30 windows; `clock`: of windows as long as a second of the rows' own time is.
Tally tally_on_plateau(const WindowClock& clock = micro_second) {
  Tally tally(ImpactTheory{31.2e-6, "striker", 850e6, 30.0, true, 31.2e-6}, false,
              ForceTally(clock, 4.5 * clock.size_s(), 10));
  HistoryRow row;
  for (int i = 0; i <= 60; ++i) {
    const double force_n = i == 1 ? 300.0 : i > 30 || i == 0 ? 0.0 : 100.0 + i;
    tally.add_forces(i, &force_n);
  }
  for (int i = 0; i <= 30; ++i) {
    row.time_s = i * 1e-6;
    row.energy_error = i == 10 ? -2e-3 : 1e-4;
    row.contact.contact_pressure_mean_pa = i < 5 || i > 22 ? 0.0 : 840e6;
    tally.add(row);
  }
  return tally;
}

TEST(Summary, HasTheKeysOfTheIssue) {
  const auto json = nlohmann::json::parse(to_json(finished(), tally_on_plateau()));
  for (const auto* key : {"status", "protocol", "windows", "wall_s", "separation_time_s", "energy_error_max",
                          "momentum_error_max", "peak_contact_force_n", "processes", "scene_sha256", "version",
                          "phases", "largest_drift", "switches", "window_size_s", "error"}) {
    EXPECT_TRUE(json.contains(key)) << key;
  }
  EXPECT_EQ(json["windows"], 42);
  EXPECT_EQ(json["processes"][1]["transport"], "shm");
  EXPECT_DOUBLE_EQ(json["energy_error_max"], 2e-3);
  EXPECT_DOUBLE_EQ(json["peak_contact_force_n"], 130.0);
  EXPECT_DOUBLE_EQ(json["peak_contact_force_s"], 30e-6);
  EXPECT_DOUBLE_EQ(json["first_window_force_n"], 300.0);
  EXPECT_NEAR(json["gauge_peak_force_n"].get<double>(), (300.0 + 102.0 + 103.0 + 104.0) / 4.5, 1e-9)
      << "4.5 windows, the oldest of which were before the contact";
  EXPECT_DOUBLE_EQ(json["separation_time_s"], 30e-6);
  EXPECT_DOUBLE_EQ(json["contact_level_n"], 0.3);
  EXPECT_DOUBLE_EQ(json["processes"][0]["wait_s"], 0.8);
  EXPECT_TRUE(json["processes"][1]["compute_s"].is_null());
  EXPECT_EQ(json["switches"][0]["to"], "explicit");
  EXPECT_NEAR(json["plateau_stress_pa"].get<double>(), 840e6, 1.0);
}

/// Names of all that a JSON value holds: `a.b`; `a[].b` of the entries of a list.
void add_keys(const nlohmann::json& json, const std::string& name, std::set<std::string>& keys) {
  if (json.is_object() && !json.empty()) {
    for (const auto& [key, value] : json.items()) add_keys(value, name.empty() ? key : name + "." + key, keys);
  } else if (json.is_array() && !json.empty() && json.front().is_object()) {
    for (const auto& entry : json) add_keys(entry, name + "[]", keys);
  } else {
    keys.insert(name);
  }
}

std::set<std::string> keys_of_results_page() {
  const std::string page = read(test::source_folder() + "/docs/results.md");
  std::istringstream lines(page.substr(page.find("\n## summary.json\n")));
  std::set<std::string> keys;
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind("| `", 0) != 0) continue;
    const auto cell = line.substr(0, line.find(" | "));
    const std::regex name("`([^`]+)`");
    for (std::sregex_iterator it(cell.begin(), cell.end(), name), end; it != end; ++it) keys.insert((*it)[1]);
  }
  return keys;
}

TEST(Summary, HasTheKeysOfTheResultsPageAndNoOther) {
  Summary summary = finished();
  summary.outside_model.emplace_back();
  summary.limits.emplace_back();
  summary.processes = {{"coupler", {}, 1, {}, 1.0, 0.2, 0.8, {{"NAME", 0.8}}}};
  const ForceTally forces(half_second, 0.4, 2);
  const Tally several(std::nullopt, true, forces, {{"NAME", forces, {}}});
  Tally one_solid(std::nullopt, true, forces);
  one_solid.plastic.emplace().hottest_k = 300.0;
  one_solid.highest_modes_energy_max = 0.0;
  std::set<std::string> keys;
  for (const auto& tally : {several, one_solid, tally_on_plateau()})
    add_keys(nlohmann::json::parse(to_json(summary, tally)), "", keys);
  EXPECT_EQ(keys, keys_of_results_page());
}

TEST(Summary, TableSetsResultsBesideTheory) {
  const std::string table = to_table(finished(), tally_on_plateau());
  EXPECT_THAT(table, AllOf(HasSubstr("30.0000 us"), HasSubstr("2L/c of 'striker': 32.2000 us"), HasSubstr("840.00 MPa"),
                           HasSubstr("impedance theory: 850.00 MPa"), HasSubstr("implicit 0.800")));
}

TEST(Summary, TimesInTheirUnitAndManySwitchesInShort) {
  auto summary = finished();
  summary.switches.assign(7, {2.5e-3, Role::implicit_solver});
  const std::string table = to_table(summary, tally_on_plateau(three_eighths));
  EXPECT_THAT(table, AllOf(HasSubstr("11.2500 s"), HasSubstr("2.5000 ms"), HasSubstr("and 3 times more")));
}

TEST(Summary, WithoutContactNoContactRows) {
  const std::string table = to_table(finished(), Tally(std::nullopt));
  EXPECT_EQ(table.find("separation"), std::string::npos);
  EXPECT_TRUE(nlohmann::json::parse(to_json(Summary{}, Tally(std::nullopt)))["separation_time_s"].is_null());
}

/// Rows of every second window of 0.5 s; two windows without force are a separation.
TEST(Summary, TellsOfEachOfSeveralContacts) {
  const ForceTally forces(half_second, 0.4, 2);
  Tally tally(std::nullopt, true, forces, {{"hit", forces, {}}, {"missed", forces, {}}});
  const double force[] = {0.0, 3.0, 5.0, 0.0, 0.0};
  for (int i = 0; i < 5; ++i) {
    HistoryRow row;
    row.window = 2 * i;
    row.contact.contacts.resize(2);
    auto &hit = row.contact.contacts[0], &missed = row.contact.contacts[1];
    hit.contact_force_n = force[i];
    hit.pairs_slip = force[i] > 0.0 ? 1.0 : 0.0;
    hit.gap_min_m = i > 2 ? i : 0.0;
    hit.contact_impulse_n_s = i;
    hit.friction_impulse_n_s = -0.5 * i;
    hit.friction_impulse_b_n_s = 0.25 * i;
    missed.gap_min_m = 1.0 + i;
    row.contact.friction_impulse_b_n_s = 0.25 * i;
    row.contact.contact_force_n = force[i];
    const double of_each[] = {force[i], 0.0};
    tally.add_forces(row.window, of_each);
    tally.add(row);
  }
  const auto json = nlohmann::json::parse(to_json(finished(), tally));
  for (const char* of_one : {"peak_contact_force_n", "contact_impulse_n_s", "friction_impulse_n_s"})
    EXPECT_TRUE(json[of_one].is_null()) << of_one << ": forces in series are not added";
  EXPECT_FALSE(json.contains("friction_impulse_b_n_s"));
  EXPECT_THAT(to_table(finished(), tally), testing::Not(HasSubstr("peak contact force")));
  const auto &hit = json["contacts"]["hit"], &missed = json["contacts"]["missed"];
  EXPECT_EQ(hit["first_contact_s"], 1.0);
  EXPECT_EQ(hit["separation_time_s"], 2.0);
  EXPECT_EQ(hit["peak_contact_force_n"], 5.0);
  EXPECT_EQ(hit["contact_impulse_n_s"], 4.0);
  EXPECT_EQ(hit["friction_impulse_n_s"], -2.0);
  EXPECT_EQ(hit["friction_impulse_b_n_s"], 1.0);
  EXPECT_TRUE(missed["first_contact_s"].is_null());
  EXPECT_TRUE(missed["separation_time_s"].is_null());
  EXPECT_THAT(to_table(finished(), tally),
              AllOf(HasSubstr("contact 'hit'            first 1.0000 s, separation 2.0000 s, impulse 4 N s, peak 5 N"),
                    HasSubstr("contact 'missed'         first never, separation not within this run")));
}

TEST(Summary, OfOneContactInTwoDimensionsHasNeitherContactsNorABinormal) {
  const auto json = nlohmann::json::parse(to_json(finished(), tally_on_plateau()));
  EXPECT_FALSE(json.contains("contacts"));
  EXPECT_FALSE(json.contains("friction_impulse_b_n_s"));
}

TEST(Summary, TellsOfContactImpulsesAndOfForcesThatWereNotFound) {
  Tally tally(std::nullopt);
  HistoryRow row;
  const auto add = [&](std::int64_t window, double iterations, double residual, double unconverged) {
    row.window = window;
    row.contact.contact_iterations = iterations;
    row.contact.contact_residual = residual;
    row.contact.contact_unconverged = unconverged;
    row.contact.contact_impulse_n_s += 0.5;
    row.contact.friction_impulse_n_s -= 0.125;
    tally.add(row);
  };
  add(0, 0, 0, 0);
  add(1, 3, 1e-9, 0);
  EXPECT_EQ(contact_warning(tally), "");
  add(3, 10, 2e-5, 2);  // a row of two windows
  add(4, 3, 0, 2);
  const auto json = nlohmann::json::parse(to_json(finished(), tally));
  EXPECT_DOUBLE_EQ(json["contact_impulse_n_s"], 2.0) << "of the last row, which counts from the start";
  EXPECT_DOUBLE_EQ(json["friction_impulse_n_s"], -0.5);
  EXPECT_DOUBLE_EQ(json["contact"]["iterations_mean"], 4.0) << "16 in 4 windows";
  EXPECT_DOUBLE_EQ(json["contact"]["iterations_max"], 5.0);
  EXPECT_DOUBLE_EQ(json["contact"]["residual_max"], 2e-5);
  EXPECT_EQ(json["contact"]["windows_unconverged"], 2);
  EXPECT_THAT(
      to_table(finished(), tally),
      HasSubstr("2 windows whose contact forces were not found to 1e-6 of the largest one; worst residual 2e-05"));
}

TEST(Trace, CountersStandAtTheEndOfTheirWindow) {
  const TraceTrack track{
      "coupler", "waits for a", {{0, 1.0, 2.0}, {3, 3.0, 4.0}, {4, 5.0, 6.0}}, {{2, 7, 1e-9}, {4, 0, 0}, {5, 1, 0}}};
  std::vector<nlohmann::json> counters;
  const auto json = nlohmann::json::parse(to_trace({track}, 0.0));
  for (const auto& event : json["traceEvents"]) {
    if (event["ph"] == "C") counters.push_back(event);
  }
  ASSERT_EQ(counters.size(), 4U) << "iterations and residual of two rows; nobody waited for a window 5";
  EXPECT_DOUBLE_EQ(counters[0]["ts"], 4e6) << "the windows up to 3 were asked for at once";
  EXPECT_DOUBLE_EQ(counters[0]["args"]["iterations"], 7);
  EXPECT_DOUBLE_EQ(counters[1]["args"]["residual"], 1e-9);
  EXPECT_DOUBLE_EQ(counters[2]["ts"], 6e6);
}

TEST(Trace, IsChromeTraceJson) {
  const auto json = nlohmann::json::parse(to_trace(
      {{"coupler", "waits for a", {{1, 10.0, 10.5}}, {}}, {"a", "computes", {{1, 10.1, 10.4}, {2, 11.0, 11.1}}, {}}},
      10.0));
  const auto& events = json["traceEvents"];
  ASSERT_EQ(events.size(), 7U);
  EXPECT_EQ(events[2]["ph"], "X");
  EXPECT_DOUBLE_EQ(events[2]["dur"], 5e5);
  EXPECT_EQ(events[5]["args"]["window"], 1);
  EXPECT_TRUE(nlohmann::json::parse(to_trace({}, 0.0))["traceEvents"].empty());
}

TEST(RunId, EndpointsPerTransport) {
  EXPECT_NE(make_run_id(), make_run_id());
  scene::CouplingSettings coupling;
  EXPECT_EQ(listen_endpoint(coupling), "ipc://*");
  coupling.transport = Transport::zmq;
  EXPECT_EQ(listen_endpoint(coupling), "ipc://*");
  coupling.transport = Transport::tcp;
  EXPECT_EQ(listen_endpoint(coupling), "tcp://127.0.0.1:*");
  coupling.port = 5555;
  coupling.address = "::1";
  EXPECT_EQ(listen_endpoint(coupling), "tcp://[::1]:5555");
  EXPECT_EQ(local_endpoint("tcp://0.0.0.0:5555"), "tcp://127.0.0.1:5555");
  EXPECT_EQ(local_endpoint("tcp://10.0.0.7:5555"), "tcp://10.0.0.7:5555");
  EXPECT_EQ(local_endpoint("ipc://@x"), "ipc://@x");
  EXPECT_THAT(remote_endpoint("tcp://0.0.0.0:5555"), testing::Not(HasSubstr("0.0.0.0")));
}

std::string command_line_error(std::vector<const char*> arguments) {
  arguments.insert(arguments.begin(), "ricochet");
  try {
    run_command_line(static_cast<int>(arguments.size()), arguments.data());
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "";
}

TEST(CommandLine, UnknownCommandsAndOptionsSuggestTheNearest) {
  EXPECT_THAT(command_line_error({"rum", "x.toml"}), AllOf(HasSubstr("\"rum\""), HasSubstr("did you mean \"run\"")));
  EXPECT_THAT(command_line_error({"run", "x.toml", "--oout", "d"}),
              AllOf(HasSubstr("--oout"), HasSubstr("did you mean \"--out\"")));
  EXPECT_THAT(command_line_error({"--versoin"}), HasSubstr("did you mean \"--version\""));
  EXPECT_THAT(command_line_error({"check", "x.toml", "y.toml"}), HasSubstr("y.toml"));
  EXPECT_THAT(command_line_error({"run", "--ot"}), HasSubstr("did you mean \"--out\""));
  EXPECT_THAT(command_line_error({"run"}), HasSubstr("SCENE"));
  EXPECT_THAT(command_line_error({"run", "x.toml", "--out"}), HasSubstr("--out"));
}

TEST(CommandLine, MissingSceneIsAConfigError) {
  EXPECT_THAT(command_line_error({"run", "/nonexistent/scene.toml"}), HasSubstr("/nonexistent/scene.toml"));
  EXPECT_THAT(command_line_error({"check", "/nonexistent/scene.toml"}), HasSubstr("/nonexistent/scene.toml"));
}

TEST(CommandLine, VersionAndHelp) {
  const char* version[] = {"ricochet", "--version"};
  testing::internal::CaptureStdout();
  EXPECT_EQ(run_command_line(2, version), 0);
  EXPECT_THAT(testing::internal::GetCapturedStdout(), HasSubstr("ricochet " RICOCHET_VERSION));
  const char* nothing[] = {"ricochet"};
  testing::internal::CaptureStdout();
  EXPECT_EQ(run_command_line(1, nothing), 2);
  EXPECT_THAT(testing::internal::GetCapturedStdout(), AllOf(HasSubstr("Exit codes"), HasSubstr("init")));
}

TEST(CommandLine, ExitCodes) {
  EXPECT_EQ(exit_code_of(ConfigError("")), 2);
  EXPECT_EQ(exit_code_of(SolverError("")), 3);
  EXPECT_EQ(exit_code_of(ParticipantError("")), 4);
  EXPECT_EQ(exit_code_of(ProtocolError("")), 5);
  EXPECT_EQ(exit_code_of(Interrupted(SIGINT)), 130);
  EXPECT_EQ(exit_code_of(Interrupted(SIGTERM)), 143);
  EXPECT_EQ(exit_code_of(std::runtime_error("")), 1);
}

TEST_F(ResultsTest, StarterSceneIsAcceptedByCheckAndNeverOverwrites) {
  fs::create_directories(folder_);
  const std::string path = write_starter_scene(folder_ + "/impact");
  EXPECT_EQ(path, folder_ + "/impact.toml");
  EXPECT_EQ(command_line_error({"check", path.c_str()}), "");
  EXPECT_THROW(write_starter_scene(path), ConfigError);
  EXPECT_THROW(write_starter_scene(folder_ + "/" + std::string(300, 'n')), Error) << "no file can be named so";
}

TEST(CsvCell, IsReadAsItWasWritten) {
  const std::string text = "found \"x\", allowed: 1, 2";
  EXPECT_EQ(csv_cell(text), "\"found \"\"x\"\", allowed: 1, 2\"");
  EXPECT_EQ(csv_cell("plain"), "plain");
  EXPECT_EQ(csv_cell("two\nlines"), "\"two lines\"");
  const std::string path = testing::TempDir() + "cells_" + std::to_string(getpid()) + ".csv";
  std::ofstream(path) << "error,step\n" << csv_cell(text) << ",1\n";
  EXPECT_EQ(report::read_csv(path).at(0).at("error"), text);
  std::filesystem::remove(path);
}

TEST(Summary, SaysWhatLeftTheModel) {
  Summary summary = finished();
  summary.valid_until_s = 2e-6;
  summary.outside_model.push_back({.kind = "off_partner",
                                   .body = "striker",
                                   .size = 1.5,
                                   .first_s = 3e-6,
                                   .time_s = 4e-6,
                                   .within_s = 2e-6,
                                   .place_m = {0.1, 0.2, 0.3},
                                   .first_size = 1.25,
                                   .first_place_m = {0.4, 0.5, 0.6},
                                   .looks = 3,
                                   .wrong = true,
                                   .text = "it slid off"});
  const auto json = nlohmann::json::parse(to_json(summary, tally_on_plateau()));
  EXPECT_EQ(json["valid_until_s"], 2e-6);
  const auto& entry = json["outside_model"].at(0);
  EXPECT_EQ(entry["kind"], "off_partner");
  EXPECT_EQ(entry["body"], "striker");
  EXPECT_EQ(entry["size"], 1.5);
  EXPECT_EQ(entry["place_m"], nlohmann::json({0.1, 0.2}));
  EXPECT_EQ(entry["first_s"], 3e-6);
  EXPECT_EQ(entry["last_without_s"], 2e-6);
  EXPECT_EQ(entry["first_size"], 1.25);
  EXPECT_EQ(entry["first_place_m"], nlohmann::json({0.4, 0.5}));
  const Tally of_solids(std::nullopt, true);
  EXPECT_EQ(nlohmann::json::parse(to_json(summary, of_solids))["outside_model"].at(0)["place_m"],
            nlohmann::json({0.1, 0.2, 0.3}));
  EXPECT_EQ(entry["looks"], 3);
  EXPECT_TRUE(entry["results_wrong"]);
  EXPECT_THAT(to_table(summary, tally_on_plateau()), HasSubstr("it slid off"));
}

TEST(Summary, HasTheLimitsOfTheMaterials) {
  Summary summary = finished();
  EXPECT_TRUE(nlohmann::json::parse(to_json(summary, tally_on_plateau()))["limits"].empty());
  summary.limits.push_back({"striker", 4e8, std::numeric_limits<double>::infinity()});
  const auto limit = nlohmann::json::parse(to_json(summary, tally_on_plateau()))["limits"].at(0);
  EXPECT_EQ(limit["body"], "striker");
  EXPECT_EQ(limit["yield_stress_pa"], 4e8);
  EXPECT_TRUE(limit["strength_pa"].is_null());
}

ForceTally told(const std::vector<double>& forces, double rise_time_s = 2.0) {
  ForceTally tally(one_second, rise_time_s, 3);
  for (std::size_t i = 0; i < forces.size(); ++i) tally.add(static_cast<std::int64_t>(i), forces[i]);
  return tally;
}

/// The level is that of the end: what rounding does before the contact, and after it, is none.
TEST(ForceTally, LooksAtForcesAboveAThousandthOfTheLargest) {
  const auto tally = told({0, 1e-9, 0, 2e-9, 0, 0.0005, 5, 9, 4, 0.02, 1e-9, 0, 1e-9, 0, 0, 0});
  EXPECT_EQ(tally.first_contact_s(), 6.0);
  EXPECT_EQ(tally.separation_time_s(), 9.0);
  EXPECT_EQ(tally.first_window_n(), 5.0);
  EXPECT_DOUBLE_EQ(tally.level_n(), 9e-3);
}

TEST(ForceTally, OfAContactThatLastsToTheEndHasNoSeparation) {
  EXPECT_EQ(told({0, 5, 9, 4, 6}).separation_time_s(), std::nullopt);
  EXPECT_EQ(told({0, 5, 0}).separation_time_s(), std::nullopt) << "three windows are one";
  EXPECT_EQ(told({0, 5, 0, 0}).separation_time_s(), 1.0) << "at the end of the first of them the pairs were open";
  EXPECT_EQ(told({0, 5, 0, 0, 0, 4}).separation_time_s(), 1.0) << "the last one that there was";
  EXPECT_EQ(told({0, 1e-9, 0, 0, 0, 4}).separation_time_s(), std::nullopt) << "of rounding there is none";
}

/// Each impact has its first windows.
TEST(ForceTally, TakesThePeakBeyondTheRiseTimeOfEachContact) {
  const auto tally = told({0, 50, 20, 7, 8, 0, 0, 60, 9, 6, 0});
  EXPECT_EQ(tally.settled()->force_n, 8.0);
  EXPECT_EQ(tally.settled()->window, 4);
  EXPECT_EQ(tally.largest().force_n, 60.0);
  EXPECT_EQ(tally.gauge_n(), 35.0) << "mean of 50 and 20";
  EXPECT_FALSE(told({0, 50, 20, 0}).settled()) << "shorter than it";
}

/// As many windows as one likes: the lists stay short.
TEST(ForceTally, IsFoundOfALongSlowRise) {
  ForceTally tally(one_second, 1.0, 3);
  for (int i = 1; i <= 200000; ++i) tally.add(i, i);
  for (int i = 199999; i >= 0; --i) tally.add(400000 - i, i);
  EXPECT_NEAR(*tally.first_contact_s(), 201.0, 1.0);
  for (int i = 1; i < 5; ++i) tally.add(400000 + i, 0.0);
  EXPECT_NEAR(*tally.separation_time_s(), 400000.0 - 200.0, 1.0);
}

}  // namespace
}  // namespace ricochet::coupler

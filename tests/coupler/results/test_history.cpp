#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <regex>
#include <set>
#include <sstream>

#include "common/base/error.hpp"
#include "common/base/ledger.hpp"
#include "common/base/write_file.hpp"
#include "coupler/results/history.hpp"
#include "coupler/results/history_file.hpp"
#include "coupler/watch/energy_watch.hpp"
#include "tests/support/places.hpp"
#include "tests/support/scene_file.hpp"

namespace ricochet::coupler {
namespace {

using testing::AllOf;
using testing::HasSubstr;

std::string text_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

std::string read(const std::string& path) {
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

const std::vector<std::string> bodies = {"striker", "target"};

History two_participants() {
  return History({{"explicit", {"window", "energy_kinetic_j/target", "energy_kinetic_j/striker", "energy_interface_j"}},
                  {"implicit",
                   {"window", "energy_kinetic_j/striker", "momentum_n_kg_m_s/striker", "gap_min_m", "energy_friction_j",
                    "energy_interface_j"}}},
                 bodies);
}

TEST(History, MergesByWindowAndSumsOverBodiesAndParticipants) {
  History history = two_participants();
  history.add(0, {0, 10, 1, 0.0, 2, 11, 2, 0.5});
  EXPECT_FALSE(history.next(0.5));
  history.add(1, {0, 4, 7, 1e-3, 0, 0.0});
  const auto row = history.next(0.5);
  ASSERT_TRUE(row);
  EXPECT_EQ(row->window, 0);
  EXPECT_DOUBLE_EQ(row->bodies[0].energy_kinetic_j, 5.0);
  EXPECT_DOUBLE_EQ(row->bodies[1].energy_kinetic_j, 10.0);
  EXPECT_DOUBLE_EQ(row->sum.energy_kinetic_j, 15.0);
  EXPECT_DOUBLE_EQ(row->sum.momentum_n_kg_m_s, 7.0);
  EXPECT_DOUBLE_EQ(row->contact.gap_min_m, 1e-3);
  EXPECT_FALSE(history.next(0.5));
  history.add(1, {2, 4, 7, 0.0, 0, -0.25});
  const auto second = history.next(0.5);
  ASSERT_TRUE(second);
  EXPECT_DOUBLE_EQ(second->time_s, 1.0);
  EXPECT_DOUBLE_EQ(second->sum.energy_interface_j, 0.25);
}

TEST(History, CreatedEnergyIsPerParticipant) {
  History history = two_participants();
  history.add(0, {0, 10, 1, 0.0, 1, 10, 4, 2.0});
  history.add(1, {0, 4, 7, 0, 0, 0.0, 1, 2, 7, 0, 1.5, -2.0});
  (void)history.next(0.5);
  const auto row = history.next(0.5);
  ASSERT_TRUE(row);
  EXPECT_DOUBLE_EQ(row->created_j[0], 1.0);  // gained 3, was given 2
  EXPECT_DOUBLE_EQ(row->created_j[1], 1.5);  // lost 2, gave 2 away, yet dissipated 1.5
}

TEST(History, SumsDoNotDependOnHowBodiesAreSpread) {
  const std::vector<double> e = {0.1, 0.7, 1.0 / 3.0, 1e-9};  // striker explicit, target explicit, implicit parts
  History one({{"explicit",
                {"window", "energy_strain_j/striker", "energy_strain_j/target", "energy_interface_j/striker",
                 "energy_interface_j/target"}},
               {"implicit", {"window", "energy_strain_j/striker", "energy_strain_j/target"}}},
              bodies);
  History two({{"b", {"window", "energy_strain_j/target", "energy_interface_j/target"}},
               {"implicit", {"window", "energy_strain_j/striker", "energy_strain_j/target"}},
               {"a", {"window", "energy_strain_j/striker", "energy_interface_j/striker"}}},
              bodies);
  one.add(0, {0, e[0], e[1], 0.3, 1e-17});
  one.add(1, {0, e[2], e[3]});
  two.add(0, {0, e[1], 1e-17});
  two.add(1, {0, e[2], e[3]});
  two.add(2, {0, e[0], 0.3});
  const auto row_1 = one.next(0.5), row_2 = two.next(0.5);
  EXPECT_EQ(row_1->sum.energy_strain_j, row_2->sum.energy_strain_j);
  EXPECT_EQ(row_1->sum.energy_interface_j, row_2->sum.energy_interface_j);
}

TEST(History, WrongColumnsAndWindowsAreRefusedByName) {
  const auto make = [](const std::vector<std::string>& columns) { History({{"implicit", columns}}, bodies); };
  EXPECT_THAT(text_of([&] {
                make({"window", "energy_kinetic_j/other"});
              }),
              AllOf(HasSubstr("'implicit'"), HasSubstr("energy_kinetic_j/other"), HasSubstr("striker, target")));
  EXPECT_THAT(text_of([&] { make({"window", "temperature_k"}); }), HasSubstr("temperature_k"));
  EXPECT_THAT(text_of([&] { make({"window", "gap_min_m", "gap_min_m"}); }), HasSubstr("twice"));
  EXPECT_THAT(text_of([&] { make({"gap_min_m"}); }), HasSubstr("\"window\""));
  History history = two_participants();
  history.add(0, {3, 0, 0, 0});
  EXPECT_THAT(text_of([&] { history.add(0, {3, 0, 0, 0}); }), HasSubstr("after that of window 3"));
  history.add(1, {4, 0, 0, 0, 0, 0});
  EXPECT_THAT(text_of([&] { (void)history.next(0.5); }), AllOf(HasSubstr("window 3"), HasSubstr("window 4")));
}

TEST(History, TakesWhatIsToldOfEachOfSeveralContacts) {
  const std::vector<std::string> contacts = {"first", "striker"};
  const auto make = [&](const std::vector<std::string>& columns) {
    return History({{"implicit", columns}}, bodies, {}, contacts);
  };
  History history =
      make({"window", "contact_force_n", "contact_force_n/striker", "gap_min_m/first", "mass_kg/striker"});
  history.add(0, {0, 3, 2, 1e-3, 5});
  const auto row = history.next(0.5);
  ASSERT_TRUE(row);
  ASSERT_EQ(row->contact.contacts.size(), 2U);
  EXPECT_EQ(row->contact.contact_force_n, 3.0);
  EXPECT_EQ(row->contact.contacts[1].contact_force_n, 2.0) << "a contact may have the name of a body";
  EXPECT_EQ(row->bodies[0].mass_kg, 5.0);
  EXPECT_EQ(row->contact.contacts[0].gap_min_m, 1e-3);
  EXPECT_EQ(row->contact.contacts[0].contact_force_n, 0.0) << "what nobody tells is 0";
  EXPECT_THAT(text_of([&] {
                (void)make({"window", "contact_force_n/third"});
              }),
              AllOf(HasSubstr("\"contact_force_n/third\""), HasSubstr("contacts: first, striker")));
  EXPECT_THAT(text_of([&] {
                (void)make({"window", "energy_contact_j/first"});
              }),
              HasSubstr("unknown history column \"energy_contact_j/first\""))
      << "told of all together";
  EXPECT_THAT(text_of([] {
                History({{"x", {"window", "mass_kg/rod"}}}, {});
              }),
              HasSubstr("unknown history column \"mass_kg/rod\" (no bodies)"));
  EXPECT_THAT(
      contacts_named_in({"window", "mass_kg/rod", "gap_min_m/b", "gap_min_m/a", "contact_force_n/b", "gap_min_m"}),
      testing::ElementsAre("b", "a"));
}

HistoryRow row_of(double kinetic, double external, double friction, double momentum, double impulse) {
  HistoryRow row;
  row.bodies.resize(1);
  row.bodies[0].energy_kinetic_j = kinetic;
  row.bodies[0].momentum_n_kg_m_s = momentum;
  row.sum = row.bodies[0];
  row.sum.energy_external_j = external;
  row.sum.impulse_n_kg_m_s = impulse;
  row.contact.energy_friction_j = friction;
  return row;
}

TEST(Errors, EnergyAndMomentumAgainstTheirReferences) {
  Errors errors;
  auto row = row_of(10, 0, 0, 2, 0);
  errors.add(row);
  EXPECT_EQ(row.energy_error, 0.0);
  row = row_of(8, 1, 2.5, 4, 1);  // 8 + 2.5 - 1 - 10 = -0.5 of 10; 4 - 1 - 2 = 1 of 4
  errors.add(row);
  EXPECT_DOUBLE_EQ(row.energy_error, -0.05);
  EXPECT_DOUBLE_EQ(row.momentum_error, 0.25);
  row = row_of(31, -20, 0, 2, 0);  // the work is now the larger reference: 31 + 20 - 10 = 41 of 20
  errors.add(row);
  EXPECT_DOUBLE_EQ(row.energy_error, 41.0 / 20.0);
  EXPECT_DOUBLE_EQ(row.momentum_error, 0.0);
}

TEST(Errors, TangentialMomentumCountsOnlyWhereItIsOne) {
  Errors plane, axisymmetric(Conserved{{{1, 0}}, 0});
  for (auto* errors : {&plane, &axisymmetric}) {
    auto row = row_of(1, 0, 0, 3, 0);
    errors->add(row);
    row.sum.momentum_t_kg_m_s = row.bodies[0].momentum_t_kg_m_s = 4;
    errors->add(row);
    EXPECT_DOUBLE_EQ(row.momentum_error, errors == &plane ? 0.8 : 0.0);
  }
}

TEST(Errors, AnInclinedDirectionIsConservedAlone) {
  Errors axial(Conserved{{{0.6, 0.8}}, 0});  // a cone's normal and tangent; the radial sum changes by 5
  auto row = row_of(1, 0, 0, 10, 0);
  axial.add(row);
  row.sum.momentum_n_kg_m_s = row.bodies[0].momentum_n_kg_m_s = 10 - 0.8 * 5;
  row.sum.momentum_t_kg_m_s = row.bodies[0].momentum_t_kg_m_s = 0.6 * 5;
  axial.add(row);
  EXPECT_NEAR(row.momentum_error, 0.0, 1e-15);
}

TEST(Errors, MomentumOfSolidsIsThatAlongTheBinormalToo) {
  Errors errors(Conserved{{{1, 0}, {0, 1}, {0, 0, 1}}, 0});
  auto row = row_of(1, 0, 0, 3, 0);
  errors.add(row);
  row.sum.momentum_b_kg_m_s = row.bodies[0].momentum_b_kg_m_s = 4;
  row.sum.impulse_b_kg_m_s = 1.5;
  errors.add(row);
  EXPECT_DOUBLE_EQ(row.momentum_error, 0.5);
}

TEST(Errors, AngularMomentumAgainstMomentumTimesTheArm) {
  Errors errors(Conserved{{{1, 0}, {0, 1}}, 0.5}), unbalanced;
  for (auto* e : {&errors, &unbalanced}) {
    auto row = row_of(1, 0, 0, 4, 0);
    row.sum.angular_momentum_z_kg_m2_s = 7;
    e->add(row);
    row.sum.angular_momentum_z_kg_m2_s = 9;
    row.sum.angular_impulse_z_kg_m2_s = 1.5;
    e->add(row);
    EXPECT_EQ(row.angular_momentum_error, e == &errors ? std::optional(0.25) : std::nullopt) << "not 0";
    row.sum.angular_impulse_x_kg_m2_s = 0.3;
    row.sum.angular_momentum_y_kg_m2_s = 0.4;
    e->add(row);
    if (e == &errors) {
      EXPECT_DOUBLE_EQ(*row.angular_momentum_error, std::sqrt(0.5) / 2.0) << "of a vector";
    }
  }
}

/// For solids all three components have to be told by everyone, else the balance is empty.
TEST(History, BalancesAngularMomentumWhereAllOfItIsTold) {
  const Conserved solid{{{1, 0}, {0, 1}, {0, 0, 1}}, 0.5}, plane{{{1, 0}, {0, 1}}, 0.5};
  std::vector<std::string> columns = {"window", "momentum_n_kg_m_s/rod", "angular_momentum_z_kg_m2_s/rod"};
  const auto balanced = [&](const Conserved& conserved) {
    History history({{"p", columns}}, {"rod"}, conserved);
    history.add(0, std::vector<double>(columns.size(), 0.0));
    return history.next(1.0)->angular_momentum_error.has_value();
  };
  EXPECT_TRUE(balanced(plane));
  EXPECT_FALSE(balanced(solid));
  columns.insert(columns.end(), {"angular_momentum_x_kg_m2_s/rod", "angular_momentum_y_kg_m2_s/rod"});
  EXPECT_TRUE(balanced(solid));
  columns[2] = "angular_momentum_kg_m2_s/rod";
  EXPECT_THAT(text_of([&] {
                History({{"p", columns}}, {"rod"}, plane);
              }),
              HasSubstr("announces the unknown history column \"angular_momentum_kg_m2_s/rod\""))
      << "with the arms of the start: not read as something else";
}

TEST(Errors, StartAtRestHasNoReferenceAtFirst) {
  Errors errors;
  auto row = row_of(0, 0, 0, 0, 0);
  errors.add(row);
  EXPECT_EQ(row.energy_error, 0.0);
  EXPECT_EQ(row.momentum_error, 0.0);
  row = row_of(1, 1, 0, 0, 0);
  errors.add(row);
  EXPECT_EQ(row.energy_error, 0.0);
}

TEST(HistoryFile, ColumnsOfTheIssueInOrderAndSeventeenDigits) {
  const std::string path = testing::TempDir() + "history.csv";
  HistoryRow row = row_of(1.0 / 3.0, 0, 0, 3, 0);
  row.bodies[0].mass_kg = 2;
  {
    HistoryFile file(path, {.bodies = {"rod"}});
    file.add(row);
  }
  std::istringstream lines(read(path));
  std::string header, line;
  std::getline(lines, header);
  std::getline(lines, line);
  EXPECT_EQ(header,
            "time_s,gap_min_m,contact_force_n,contact_pressure_mean_pa,contact_pressure_max_pa,principal_stress_mean_"
            "pa,friction_force_n,"
            "normal_force_t_n,"
            "pairs_stick,pairs_slip,pairs_open,energy_kinetic_j,energy_strain_j,energy_external_j,energy_contact_j,"
            "energy_friction_j,energy_interface_j,energy_error,momentum_n_kg_m_s,momentum_t_kg_m_s,"
            "contact_impulse_n_s,"
            "friction_impulse_n_s,normal_impulse_t_n_s,contact_iterations,contact_residual,contact_unconverged,"
            "velocity_mean_rod_m_s");
  EXPECT_THAT(line,
              AllOf(HasSubstr("0.33333333333333331"), HasSubstr("0,nan,"), testing::EndsWith(",3,0,0,0,0,0,0,0,1.5")));
}

std::string docs_page(const std::string& name) { return read(test::source_folder() + "/docs/" + name); }

/// Names in the first cells of the tables between two headings of docs/results.md.
std::set<std::string> columns_of_page(const std::string& begin, const std::string& end) {
  const auto page = docs_page("results.md");
  const auto first = page.find("\n" + begin + "\n"), last = page.find("\n" + end + "\n");
  std::istringstream lines(page.substr(first, last - first));
  std::set<std::string> names;
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind("| `", 0) != 0) continue;
    const auto cell = line.substr(0, line.find(" | "));
    const std::regex name("`([^`]+)`");
    for (std::sregex_iterator it(cell.begin(), cell.end(), name), none; it != none; ++it) names.insert((*it)[1]);
  }
  return names;
}

std::set<std::string> set_of(const std::vector<std::string>& names) { return {names.begin(), names.end()}; }

TEST(HistoryFile, ColumnsAreThoseOfTheResultsPage) {
  const auto written = history_columns(
      {.bodies = {"BODY"}, .solid = true, .angular = 3, .round = true, .yields = true, .heats = true, .reduced = true});
  EXPECT_EQ(columns_of_page("## history.csv", "## probes.csv"), set_of(written));
}

/// A column without a body is one of the contact's owner, or the work of a link.
TEST(HistoryFile, ColumnsOfTheContactAreThoseOfTheResultsPage) {
  std::set<std::string> known;
  for (const auto& [name, member] : contact_quantities) known.insert(std::string(name));
  EXPECT_EQ(columns_of_page("### Columns of the contact", "## probes.csv"), known);
}

TEST(HistoryFile, QuantitiesOfBodiesStandOnTheParticipantsPage) {
  const auto page = docs_page("participants.md");
  for (const auto& [name, member] : body_quantities) EXPECT_THAT(page, HasSubstr("`" + std::string(name) + "`"));
}

TEST(HistoryFile, OfSolidsEndsWithWhatLiesAlongTheBinormal) {
  const auto path = ::testing::TempDir() + "/history_of_solids.csv";
  HistoryRow row;
  row.contact.friction_force_b_n = 1.5;
  row.contact.friction_impulse_b_n_s = 2.5;
  row.contact.normal_force_b_n = 4.5;
  row.contact.normal_impulse_b_n_s = 5.5;
  row.sum.momentum_b_kg_m_s = 3.5;
  {
    HistoryFile file(path, {.has_contact = true, .solid = true});
    file.add(row);
  }
  const std::string text = read(path);
  EXPECT_THAT(text, HasSubstr("contact_unconverged,friction_force_b_n,normal_force_b_n,friction_impulse_b_n_s,"
                              "normal_impulse_b_n_s,momentum_b_kg_m_s\n"));
  EXPECT_THAT(text, testing::EndsWith(",1.5,4.5,2.5,5.5,3.5\n"));
}

TEST(HistoryFile, HasNoTemperatureThatNobodyTells) {
  for (const auto& [told_k, written] : {std::pair{0.0, ",nan\n"}, {312.5, ",312.5\n"}}) {
    const auto path = ::testing::TempDir() + "/history_of_heat.csv";
    HistoryRow row;
    row.sum.temperature_max_k = told_k;
    {
      HistoryFile file(path, {.yields = true, .heats = true});
      file.add(row);
    }
    EXPECT_THAT(read(path), AllOf(HasSubstr(",temperature_max_k\n"), testing::EndsWith(written)));
  }
}

TEST(HistoryFile, OfSeveralContactsEndsWithWhatIsToldOfEach) {
  const auto path = ::testing::TempDir() + "/history_of_contacts.csv";
  HistoryRow row;
  row.contact.contacts.resize(2);
  row.contact.contacts[0].friction_force_b_n = 7.5;
  row.contact.contacts[0].gap_min_m = std::numeric_limits<double>::max();
  row.contact.contacts[1].contact_force_n = 1.5;
  row.contact.contacts[1].friction_impulse_n_s = 2.5;
  {
    HistoryFile file(path, {.has_contact = true, .contacts = {"a", "b"}});
    file.add(row);
  }
  EXPECT_THAT(
      read(path),
      AllOf(
          HasSubstr(
              "contact_unconverged,gap_min_m/a,contact_force_n/a,contact_pressure_mean_pa/a,contact_pressure_max_pa/a,"
              "friction_force_n/a,normal_force_t_n/a,pairs_stick/a,pairs_slip/a,pairs_open/a,"
              "contact_impulse_n_s/a,friction_impulse_n_s/a,normal_impulse_t_n_s/a,gap_min_m/b,"),
          testing::EndsWith(",nan,0,0,0,0,0,0,0,0,0,0,0,0,1.5,0,0,0,0,0,0,0,0,2.5,0\n")));
  const auto of_solids = history_columns({.solid = true, .contacts = {"a"}});
  EXPECT_THAT(of_solids,
              testing::IsSupersetOf({"friction_force_b_n/a", "friction_impulse_b_n_s/a", "normal_force_b_n/a"}));
}

TEST(HistoryFile, UnwritableFolderIsNamed) {
  const test::TemporaryFolder folder;
  const auto missing = (folder.path() / "missing").string();
  EXPECT_THAT(text_of([&] { HistoryFile(missing + "/history.csv", {}); }), HasSubstr(missing + "/history.csv"));
  EXPECT_THAT(text_of([&] { write_atomically(missing + "/x", ""); }), HasSubstr(missing + "/x"));
}

TEST(HistoryFile, FollowsNoLinkAndWaitsForNobody) {
  const test::TemporaryFolder folder;
  const auto path = (folder.path() / "history.csv").string(), mine = folder.write("by the user", "mine.txt");
  std::filesystem::create_symlink(mine, path);
  EXPECT_THAT(text_of([&] { HistoryFile(path, {}); }), HasSubstr("cannot write " + path));
  std::ifstream read(mine);
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(read), {}), "by the user");
  std::filesystem::remove(path);
  ASSERT_EQ(mkfifo(path.c_str(), 0600), 0);
  EXPECT_THAT(text_of([&] { HistoryFile(path, {}); }), HasSubstr("cannot write " + path));
}

TEST(HistoryFile, GoesOnAfterABeginningThatIsAsItWasWritten) {
  const test::TemporaryFolder folder;
  const auto path = (folder.path() / "history.csv").string();
  Beginning header, row;
  {
    HistoryFile file(path, {});
    header = file.so_far();
    file.add({});
    row = file.so_far();
    file.add({});
  }
  {
    HistoryFile file(path, {}, header);
    file.add({});
    EXPECT_EQ(file.so_far().sha256, row.sha256);
    EXPECT_EQ(file.so_far().bytes, row.bytes);
  }
  header.sha256[0] ^= 1;
  EXPECT_THAT(text_of([&] { HistoryFile(path, {}, header); }), HasSubstr(path + " is not what was written"));
}

/// An energy watch that is shown a row each `every` windows.
struct Watched {
  EnergyWatch watch;
  std::int64_t window = 0;
  explicit Watched(Suspicion suspicion = {}, double floor_j = 0)
      : watch(0.05, floor_j, std::move(suspicion), {"explicit", "implicit"}, {"rod"}) {}
  void row(double kinetic, double external, std::vector<double> created = {0, 0}, double interface = 0) {
    auto r = row_of(kinetic, external, 0, 0, 0);
    r.window = window;
    r.time_s = static_cast<double>(window) * 1e-6;
    r.created_j = std::move(created);
    r.sum.energy_interface_j = interface;
    window += EnergyWatch::every;
    watch.check(r);
  }
};

/// With the most that may be lost; `momentum_error` of each row.
struct LossWatched {
  double moving_kg_m_s = 1.0;
  EnergyWatch watch;
  std::int64_t window = 0;
  explicit LossWatched(LossLimits limits, Suspicion suspicion = {})
      : watch(0.05, 0.0, std::move(suspicion), {"explicit"}, {"rod"}, EnergyWatch::every, limits) {}
  void row(double kinetic, double external, double momentum_error) {
    auto r = row_of(kinetic, external, 0, 0, 0);
    r.window = window;
    r.momentum_error = momentum_error;
    r.momentum_reference_kg_m_s = moving_kg_m_s;
    r.sum.mass_kg = 2.0;
    window += EnergyWatch::every;
    watch.check(r);
  }
};

TEST(EnergyWatch, WhatIsLostBeyondItsLimitStopsAndNamesWhoIsForeign) {
  Suspicion suspicion;
  suspicion.protocol = "hughes_liu";
  suspicion.protocol_trouble = "has a trouble of its own";
  suspicion.foreign = {"explicit"};
  suspicion.scene_path = "/a/scene.toml";
  LossWatched energy({.energy = 0.3}, suspicion), momentum({.momentum = 0.2}, suspicion);
  energy.row(1, 0, 0);
  EXPECT_NO_THROW(energy.row(0.71, 0, 0.9));
  EXPECT_THAT(
      text_of([&] { energy.row(0.69, 0, 0.9); }),
      AllOf(HasSubstr("window 16"), HasSubstr("31 % of the energy got lost (coupling.energy_loss_limit = 30 %)"),
            HasSubstr("likely cause: participant 'explicit', a program of your own"),
            HasSubstr("check-participant --scene /a/scene.toml --name explicit`"),
            HasSubstr("; or protocol hughes_liu has a trouble")));
  momentum.row(1, 0, 0);
  EXPECT_NO_THROW(momentum.row(0.1, 0, 0.19));
  EXPECT_THAT(text_of([&] { momentum.row(1, 0, 0.21); }),
              HasSubstr("21 % of the momentum came from nowhere or got lost, allowed are 20 %"));
}

TEST(EnergyWatch, MomentumThatIsRoundingAloneIsNone) {
  LossWatched swinging({.momentum = 0.2});
  swinging.moving_kg_m_s = 1e-12;
  swinging.row(1, 0, 0);
  EXPECT_NO_THROW(swinging.row(1, 0, 1.0));
}

TEST(EnergyWatch, ALossOfWhatComesFromOutsideMustLast) {
  LossWatched watched({.energy = 0.3, .momentum = 0.2});
  watched.row(0, 0, 0);
  for (int n = 0; n < 4; ++n) EXPECT_NO_THROW(watched.row(1, 10, 0.5)) << n;
  EXPECT_NO_THROW(watched.row(10, 10, 0));
  for (int n = 0; n < 4; ++n) EXPECT_NO_THROW(watched.row(1, 10, 0)) << n;
  EXPECT_THROW(watched.row(1, 10, 0), SolverError);
}

TEST(EnergyWatch, LossesAndSmallGrowthPass) {
  Watched watched;
  watched.row(1, 0);
  EXPECT_NO_THROW(watched.row(0.2, 0));
  EXPECT_NO_THROW(watched.row(1.049, 0));
}

TEST(EnergyWatch, GrowthStopsAndNamesWindowTimeParticipantAndStepRatio) {
  Suspicion suspicion;
  suspicion.step_s = 1.2e-6;
  suspicion.step_key = "time.flight_step_s";
  suspicion.steps = {{"explicit", 1e-6}};
  Watched watched(suspicion);
  watched.row(1, 0);
  const std::string text = text_of([&] { watched.row(1.2, 0, {0.19, 0.01}); });
  EXPECT_THAT(text, AllOf(HasSubstr("window 8"), HasSubstr("8e-06 s"), HasSubstr("20 %"), HasSubstr("body 'rod'"),
                          HasSubstr("participant 'explicit'"), HasSubstr("1.2 times the critical step"),
                          HasSubstr("lower time.flight_step_s")));
}

TEST(EnergyWatch, InterfacePenaltyAndProtocolAreNamed) {
  Suspicion suspicion;
  suspicion.protocol = "kim_predicted";
  suspicion.protocol_trouble = "is unstable at almost any time step";
  suspicion.penalty_step_ratio = 3.0;
  Watched watched(suspicion);
  watched.row(1, 0);
  EXPECT_THAT(text_of([&] {
                watched.row(1.2, 0, {0, 0}, 0.2);
              }),
              AllOf(HasSubstr("made at the interface"), HasSubstr("kim_predicted is unstable"), HasSubstr("penalty")));
}

TEST(EnergyWatch, NothingObviousSaysSo) { EXPECT_THAT(likely_cause({}, 0, 1), HasSubstr("not obvious")); }

TEST(EnergyWatch, NonFiniteStops) {
  Watched watched;
  watched.row(1, 0);
  EXPECT_THAT(text_of([&] {
                watched.row(NAN, 0, {NAN, 0});
              }),
              AllOf(HasSubstr("not finite"), HasSubstr("participant 'explicit'")));
}

TEST(EnergyWatch, GrowthOfWhatComesFromOutsideMustLast) {
  Watched watched;  // at rest, then prescribed motion: half the first window's work is an error of the step
  watched.row(0, 0);
  watched.row(0, 0);
  watched.row(1, 0);
  for (int n = 1; n < 4; ++n) EXPECT_NO_THROW(watched.row(1 + 15 * n, 15 * n)) << n;
  EXPECT_NO_THROW(watched.row(61, 60));
  for (int n = 0; n < 4; ++n) EXPECT_NO_THROW(watched.row(80, 60)) << n;
  EXPECT_THROW(watched.row(80, 60), SolverError) << "after 32 windows";
}

TEST(EnergyWatch, OneLookWithinTheLimitForgivesWhatWasBefore) {
  Watched watched;
  watched.row(0, 0);
  for (int n = 0; n < 20; ++n) EXPECT_NO_THROW(watched.row(n % 4 == 3 ? 60 : 80, 60)) << n;
}

TEST(EnergyWatch, HasAFloorBelowWhichRoundOffDecides) {
  Watched floored({}, 1e-20), bare;
  for (auto* watched : {&floored, &bare}) watched->row(1e-25, 0);
  EXPECT_NO_THROW(floored.row(4e-22, 0));
  EXPECT_THROW(bare.row(4e-22, 0), SolverError);
  EXPECT_THROW(floored.row(1e-20, 0), SolverError);
}

TEST(EnergyWatch, LooksAtTheSameWindowsWhateverRowsThereAre) {
  EnergyWatch watch(0.05, 0.0, {}, {"implicit"}, {"rod"});
  auto row = row_of(1, 0, 0, 0, 0);
  watch.check(row);
  row = row_of(5, 0, 0, 0, 0);
  for (row.window = 1; row.window < EnergyWatch::every; ++row.window) EXPECT_NO_THROW(watch.check(row));
  EXPECT_THROW(watch.check(row), SolverError);
}

}  // namespace
}  // namespace ricochet::coupler

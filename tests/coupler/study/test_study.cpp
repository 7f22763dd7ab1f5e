// Studies: the file, the measures of error, the key of a run, the Pareto front.
#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>

#include "common/base/error.hpp"
#include "coupler/report/parts/csv_table.hpp"
#include "coupler/report/study_page/study_page.hpp"
#include "coupler/study/study_case.hpp"
#include "coupler/study/study_file.hpp"
#include "coupler/study/study_measures.hpp"
#include "tests/support/places.hpp"
#include "tests/support/scene_file.hpp"

namespace ricochet::coupler {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;

const std::string bars = test::source_folder() + "/configs/two_bars.toml";

std::string good_study() {
  return "scene = \"" + bars + R"("
methods = ["kim", "all_implicit"]
quantities = ["peak_force"]
along = "time.step_s"
[[vary]]
time.step_s = [2e-6, 1e-6]
body.left.mesh.elements = [10, 20]
[[vary]]
"contact.enforcement" = ["penalty"]
[reference]
protocol = "all_explicit"
changes = { time.step_s = 1e-7 }
refine = { time.step_s = 5e-8 }
follow = ["contact.enforcement"]
[[method]]
name = "soft"
protocol = "kim"
changes = { contact.penalty_pa_m = 1e12, contact.enforcement = "" }
[histories]
quantity = "contact_pressure"
over_pa = 2e8
over_name = "p0"
compare_to = "all_implicit"
[[published]]
methods = ["kim", "soft"]
over = "all_implicit"
at = { time.step_s = 1e-6 }
time_ratio = 0.5
source = "there"
)";
}

TEST(StudyFile, ReadsMethodsVariationsAndReference) {
  const test::TemporaryFolder folder;
  const auto study = load_study(folder.write(good_study(), "study.toml"));
  EXPECT_EQ(study.scene, bars);
  EXPECT_THAT(method_names(study), ElementsAre("kim", "all_implicit", "soft"));
  EXPECT_EQ(study.repeats, 1);
  ASSERT_EQ(study.variations.size(), 2U);
  EXPECT_THAT(study.variations[0].keys, ElementsAre("time.step_s", "body.left.mesh.elements"));
  EXPECT_EQ(study.reference.changes.size(), 2U) << "and the protocol";
  const auto all = all_combinations(study);
  ASSERT_EQ(all.size(), 2U) << "keys of one table go together, tables multiply";
  EXPECT_EQ(text_of(all[1][0]), "1e-06");
  EXPECT_EQ(text_of(all[1][1]), "20");
  EXPECT_EQ(text_of(all[1][2]), "penalty");
}

TEST(StudyFile, VariesSomeKeysForSomeMethodsOnly) {
  const test::TemporaryFolder folder;
  const auto text = test::replaced(good_study(), "[[vary]]\ntime", "[[vary]]\nmethods = [\"kim\", \"soft\"]\ntime");
  const auto study = load_study(folder.write(text, "study.toml"));
  EXPECT_THAT(study.variations[0].methods, ElementsAre("kim", "soft"));
  EXPECT_EQ(combinations(study.variations, "kim").size(), 2U);
  const auto of_other = combinations(study.variations, "all_implicit");
  ASSERT_EQ(of_other.size(), 1U);
  EXPECT_EQ(text_of(of_other[0][0]), "") << "as the scene says";
  EXPECT_EQ(text_of(of_other[0][2]), "penalty");
  EXPECT_EQ(all_combinations(study).size(), 3U);
  const auto common = of_all_methods(study, of_other[0]);
  ASSERT_EQ(common.size(), 1U);
  EXPECT_EQ(common[0].key, "contact.enforcement");
}

TEST(StudyFile, MethodsMayHaveTheirOwnValuesOfAKey) {
  const test::TemporaryFolder folder;
  const auto text = test::replaced(good_study(), "[[vary]]\ntime",
                                   "[[vary]]\nmethods = [\"all_implicit\"]\ntime.step_s = [3e-6, 4e-6, 5e-6]\n"
                                   "[[vary]]\nmethods = [\"kim\", \"soft\"]\ntime");
  const auto study = load_study(folder.write(text, "study.toml"));
  EXPECT_THAT(varied_keys(study), ElementsAre("time.step_s", "body.left.mesh.elements", "contact.enforcement"));
  const auto implicit = combinations(study.variations, "all_implicit"), kim = combinations(study.variations, "kim");
  ASSERT_EQ(implicit.size(), 3U);
  ASSERT_EQ(kim.size(), 2U);
  EXPECT_EQ(text_of(implicit[1][0]), "4e-06");
  EXPECT_EQ(text_of(implicit[1][1]), "") << "as the scene says";
  EXPECT_EQ(text_of(kim[0][0]), "2e-06");
  EXPECT_EQ(text_of(kim[0][1]), "10");
  EXPECT_EQ(kim[0][2].key, "contact.enforcement");
  EXPECT_EQ(all_combinations(study).size(), 5U);
}

TEST(StudyFile, ReadsWhatIsDrawnAndComparedBesides) {
  const test::TemporaryFolder folder;
  const auto study = load_study(folder.write(good_study(), "study.toml"));
  EXPECT_EQ(study.along, "time.step_s");
  EXPECT_TRUE(study.values.empty());
  EXPECT_THAT(study.reference.follow, ElementsAre("contact.enforcement"));
  EXPECT_EQ(study.methods[2].protocol, "kim");
  EXPECT_EQ(study.histories.quantity, "contact_pressure");
  EXPECT_EQ(study.histories.over_pa, 2e8);
  EXPECT_EQ(study.histories.compare_to, "all_implicit");
  EXPECT_FALSE(study.axis.has_value());
  ASSERT_EQ(study.published.size(), 1U);
  EXPECT_THAT(study.published[0].methods, ElementsAre("kim", "soft"));
  EXPECT_EQ(text_of(study.published[0].at[0]), "1e-06");
}

const std::string axis_and_measured = R"(along = "time.step_s"
values = ["restitution"]
axis = { title = "step [us]", at = [2, 1] }
measured = [{ value = "restitution", at = [1.5, 1.1], measured = [0.5, 0.6], error = 0.1, source = "somebody" }]
)";

TEST(StudyFile, ReadsAnAxisAndWhatWasMeasuredOverIt) {
  const test::TemporaryFolder folder;
  const std::string along = "along = \"time.step_s\"\n";
  const auto study = load_study(folder.write(test::replaced(good_study(), along, axis_and_measured), "study.toml"));
  ASSERT_TRUE(study.axis.has_value());
  EXPECT_EQ(study.axis->title, "step [us]");
  EXPECT_THAT(study.axis->at, ElementsAre(testing::Pair("2e-06", 2.0), testing::Pair("1e-06", 1.0)));
  ASSERT_EQ(study.measurements.size(), 1U);
  EXPECT_EQ(study.measurements[0].value, "restitution");
  EXPECT_THAT(study.measurements[0].at, ElementsAre(1.5, 1.1));
  EXPECT_THAT(study.measurements[0].measured, ElementsAre(0.5, 0.6));
  EXPECT_EQ(study.measurements[0].error, 0.1);
  EXPECT_EQ(study.measurements[0].source, "somebody");
}

TEST(StudyFile, OfAKeyThatIsSetTwiceTheLastValueCountsAndAnEmptyTextTakesItBack) {
  const auto changes = merged({{"time.step_s", 1.0}, {"contact.enforcement", std::string("penalty")}},
                              {{"time.step_s", 2.0}, {"contact.enforcement", std::string()}});
  ASSERT_EQ(changes.size(), 1U);
  EXPECT_EQ(changes[0].key, "time.step_s");
  EXPECT_EQ(text_of(changes[0]), "2");
}

TEST(StudyFile, ListsOfNumbersAreValues) {
  const test::TemporaryFolder folder;
  const auto text =
      test::replaced(good_study(), "body.left.mesh.elements = [10, 20]", "body.left.mesh.elements = [[1, 2], [3, 4]]");
  const auto study = load_study(folder.write(text, "study.toml"));
  EXPECT_EQ(text_of(study.variations[0].settings[1][1]), "3 4");
}

TEST(StudyFile, TheShippedOnesLoad) {
  int studies = 0;
  for (const auto& entry : std::filesystem::directory_iterator(test::source_folder() + "/configs/studies")) {
    const auto study = load_study(entry.path().string());
    EXPECT_FALSE(all_combinations(study).empty());
    ++studies;
  }
  EXPECT_GE(studies, 2);
}

TEST(StudyFile, TheFirstKeyWhoseValuesDifferTellsSettingsApart) {
  const test::TemporaryFolder folder;
  const auto keys = [&](const std::string& steps) {
    const auto text = test::replaced(good_study(), "time.step_s = [2e-6, 1e-6]", "time.step_s = " + steps);
    auto variation =
        load_study(
            folder.write(test::replaced(text, "at = {", "at = { contact.enforcement = \"penalty\" } # "), "study.toml"))
            .variations[0];
    return telling_keys(variation);
  };
  EXPECT_THAT(keys("[2e-6, 1e-6]"), ElementsAre("time.step_s"));
  EXPECT_THAT(keys("[1e-6, 1e-6]"), ElementsAre("body.left.mesh.elements"));
  EXPECT_EQ(telling_keys({{}, {"a.b", "c.d"}, {{{"a.b", 1.0}, {"c.d", 1.0}}, {{"a.b", 1.0}, {"c.d", 1.0}}}}).size(),
            2U);
}

/// A scene of two contacts, as solids or not.
std::string two_contacts(const std::string& model) {
  return "model = \"" + model + "\"\n[[contact]]\nname = \"first\"\n[[contact]]\nname = \"second\"\n";
}

TEST(StudyFile, MayAskForQuantitiesOfAContactAndOfSolids) {
  const test::TemporaryFolder folder;
  const auto load = [&](const std::string& model, const std::string& quantities) {
    (void)folder.write(two_contacts(model), "two.toml");
    auto text = test::replaced(good_study(), bars, "two.toml");
    text = test::replaced(text, "quantities = [\"peak_force\"]", quantities);
    text = test::replaced(text, "quantity = \"contact_pressure\"", "quantity = \"contact_pressure/second\"");
    return load_study(folder.write(text, "study.toml"));
  };
  const auto study = load("plane_strain", "quantities = [\"peak_force/second\", \"friction_force/first\"]");
  EXPECT_THAT(study.quantities, ElementsAre("peak_force/second", "friction_force/first"));
  EXPECT_EQ(study.histories.quantity, "contact_pressure/second");
  EXPECT_THAT(load("plane_strain", "").quantities, testing::Not(testing::Contains("friction_force_b")));
  EXPECT_THAT(load("solid", "").quantities, testing::Contains("friction_force_b"));
  EXPECT_THAT(load("solid", "").quantities, testing::Not(testing::Contains("peak_force/second"))) << "if asked for";
  EXPECT_THAT(load("solid", "quantities = [\"friction_force_b/first\"]").quantities,
              ElementsAre("friction_force_b/first"));
  for (const auto& [wrong, right] :
       {std::pair{"peak_force/secnd", "peak_force/second"}, {"friction_force_b", "friction_force"}}) {
    try {
      (void)load("plane_strain", "quantities = [\"" + std::string(wrong) + "\"]");
      ADD_FAILURE() << wrong;
    } catch (const ConfigError& error) {
      EXPECT_THAT(error.what(), testing::AllOf(HasSubstr("study.toml:3: quantities: found \"" + std::string(wrong)),
                                               HasSubstr("did you mean \"" + std::string(right) + "\"?")));
    }
  }
}

TEST(StudyFile, ReachesTheKeysOfOneOfSeveralContactsByItsName) {
  const test::TemporaryFolder folder;
  const auto text = test::replaced(good_study(), "contact.penalty_pa_m = 1e12, contact.enforcement = \"\"",
                                   "contact.second.friction_coefficient = 0.5");
  EXPECT_EQ(load_study(folder.write(text, "study.toml")).methods[2].changes[0].key,
            "contact.second.friction_coefficient");
}

TEST(StudyFile, WithoutVariationsThereIsOneCombination) { EXPECT_EQ(combinations({}, "kim").size(), 1U); }

/// One edit that spoils the study, the line that the error names and what it says.
struct Wrong {
  std::string name, from, to;
  int line;
  std::vector<std::string> says;
};

void PrintTo(const Wrong& wrong, std::ostream* out) { *out << wrong.name; }

class WrongStudy : public testing::TestWithParam<Wrong> {};

TEST_P(WrongStudy, IsRefusedWithPlaceFoundAndAllowed) {
  const auto& wrong = GetParam();
  const test::TemporaryFolder folder;
  const std::string path = folder.write(test::replaced(good_study(), wrong.from, wrong.to), "study.toml");
  try {
    (void)load_study(path);
    FAIL() << "accepted";
  } catch (const ConfigError& error) {
    const std::string text = error.what();
    if (wrong.line > 0) {
      EXPECT_THAT(text, StartsWith(path + ":" + std::to_string(wrong.line) + ": "));
    }
    for (const auto& part : wrong.says) EXPECT_THAT(text, HasSubstr(part));
    EXPECT_THAT(text, HasSubstr("allowed:"));
  }
}

INSTANTIATE_TEST_SUITE_P(
    Edits, WrongStudy,
    testing::Values(
        Wrong{"syntax", "methods = [", "methods = ", 0, {"not a TOML file"}},
        Wrong{"unknown_key", "quantities", "quantitys", 3, {"quantitys", "did you mean \"quantities\"?"}},
        Wrong{"name_too_long", "/two_bars.toml", "/" + std::string(300, 'n'), 1, {"scene: found no file", "nnn"}},
        Wrong{"no_scene", "/two_bars.toml", "/three_bars.toml", 1, {"scene: found no file", "three_bars.toml"}},
        Wrong{"unknown_method", "\"kim\"", "\"kin\"", 2, {"methods: found \"kin\"", "did you mean \"kim\"?"}},
        Wrong{"method_twice", "\"all_implicit\"", "\"kim\"", 2, {"\"kim\" twice"}},
        Wrong{"unknown_quantity", "peak_force", "peak_farce", 3, {"did you mean \"peak_force\"?"}},
        Wrong{"unknown_scene_key",
              "time.step_s = [2",
              "time.stepp_s = [2",
              6,
              {"vary[0]", "\"stepp_s\" in the key time.stepp_s", "did you mean \"step_s\"?"}},
        Wrong{"unknown_key_of_a_contact",
              "contact.penalty_pa_m = 1e12",
              "contact.second.penalty_pa = 1e12",
              18,
              {"\"penalty_pa\" in the key contact.second.penalty_pa", "did you mean \"penalty_pa_m\"?"}},
        Wrong{"unknown_scene_table", "\"contact.enf", "\"contacts.enf", 9, {"vary[1]", "did you mean \"contact\"?"}},
        Wrong{"table_of_scene", "\"contact.enforcement\"", "contact", 9, {"the table \"contact\"", "\"enforcement\""}},
        Wrong{"methods_of_a_variation",
              "[[vary]]\ntime",
              "[[vary]]\nmethods = [\"kin\"]\ntime",
              6,
              {"vary[0].methods", "found \"kin\"", "did you mean \"kim\"?", "a list of methods of the study"}},
        Wrong{"no_methods_of_a_variation",
              "[[vary]]\ntime",
              "[[vary]]\nmethods = []\ntime",
              6,
              {"vary[0].methods", "found an array of 0", "a list of methods of the study"}},
        Wrong{"no_list", "[2e-6, 1e-6]", "2e-6", 6, {"vary[0].time.step_s", "found 2e-06", "a list"}},
        Wrong{"unequal_lists", "[10, 20]", "[10, 20, 30]", 7, {"3 values", "2, as many as time.step_s"}},
        Wrong{"key_twice",
              "\"contact.enforcement\" = [\"penalty\"]",
              "time.step_s = [1e-7]",
              8,
              {"time.step_s a second time for \"", "each key in one table of a method"}},
        Wrong{"protocol_varied",
              "\"contact.enforcement\" = [\"penalty\"]",
              "coupling.protocol = [\"kim\"]",
              9,
              {"the protocol", "methods = "}},
        Wrong{"value_no_number", "[\"penalty\"]", "[true]", 9, {"found true", "a number, a text or a list"}},
        Wrong{"vary_no_tables", "[[vary]]\ntime", "[other]\ntime", 5, {"unknown key \"other\""}},
        Wrong{"no_refinement", "refine = { time.step_s = 5e-8 }", "", 10, {"reference.refine", "refinement"}},
        Wrong{"no_reference", "[reference]", "[refrence]", 10, {"did you mean \"reference\"?"}},
        Wrong{"exact_and_computed",
              "protocol = \"all_explicit\"",
              "exact = \"impedance_theory\"",
              12,
              {"reference.changes", "only with a computed reference"}},
        Wrong{"unknown_exact", "protocol = \"all_explicit\"", "exact = \"theory\"", 11, {"\"impedance_theory\""}},
        Wrong{"along_nothing",
              "along = \"time.step_s\"",
              "along = \"time.stepp_s\"",
              4,
              {"did you mean \"time.step_s\"?"}},
        Wrong{"axis_of_other_values",
              "along = \"time.step_s\"",
              "along = \"time.step_s\"\naxis = { title = \"x\", at = [1, 2, 3] }",
              5,
              {"axis.at", "2 numbers"}},
        Wrong{"axis_without_along",
              "along = \"time.step_s\"",
              "axis = { title = \"x\", at = [1, 2] }",
              4,
              {"axis", "only with along"}},
        Wrong{"measured_without_axis",
              "along = \"time.step_s\"",
              "along = \"time.step_s\"\nmeasured = [{ value = \"restitution\" }]",
              5,
              {"measured", "only with axis"}},
        Wrong{"measured_what_is_not_told",
              "along = \"time.step_s\"",
              "along = \"time.step_s\"\naxis = { title = \"x\", at = [1, 2] }\nvalues = [\"restitution\"]\n"
              "measured = [{ value = \"restitutio\", at = [1], measured = [1], source = \"s\" }]",
              7,
              {"measured[0].value", "did you mean \"restitution\"?"}},
        Wrong{"measured_too_little",
              "along = \"time.step_s\"",
              "along = \"time.step_s\"\naxis = { title = \"x\", at = [1, 2] }\nvalues = [\"restitution\"]\n"
              "measured = [{ value = \"restitution\", at = [1, 2], measured = [1], source = \"s\" }]",
              7,
              {"measured[0].measured", "2 numbers"}},
        Wrong{"tells_nothing",
              "along = \"time.step_s\"",
              "values = [\"restituton\"]",
              4,
              {"did you mean \"restitution\"?"}},
        Wrong{"follows_nothing",
              "follow = [\"contact",
              "follow = [\"contacts",
              14,
              {"did you mean \"contact.enforcement\"?"}},
        Wrong{"follows_what_it_changes",
              "follow = [\"contact.enforcement\"",
              "follow = [\"time.step_s\"",
              14,
              {"\"time.step_s\", which the reference changes"}},
        Wrong{"method_twice_by_table", "name = \"soft\"", "name = \"kim\"", 16, {"\"kim\" a second time"}},
        Wrong{"method_of_no_protocol",
              "protocol = \"kim\"",
              "protocol = \"soft\"",
              17,
              {"method[0].protocol", "\"kim\""}},
        Wrong{"method_changes_protocol",
              "contact.penalty_pa_m = 1e12",
              "coupling.protocol = \"kim\"",
              18,
              {"found the protocol", "protocol = "}},
        Wrong{"method_changes_no_key",
              "contact.penalty_pa_m",
              "contact.penalty_pa",
              18,
              {"did you mean \"penalty_pa_m\"?"}},
        Wrong{"no_history", "\"contact_pressure\"", "\"peak_force\"", 20, {"\"principal_stress\""}},
        Wrong{"over_nothing", "over_pa = 2e8", "over_pa = 0.0", 21, {"histories.over_pa: found 0", "a number > 0"}},
        Wrong{"compared_to_nothing", "compare_to = \"all_implicit\"", "compare_to = \"fixed_point\"", 23, {"\"soft\""}},
        Wrong{"published_of_nothing", "[\"kim\", \"soft\"]", "[\"kim\", \"sofd\"]", 25, {"did you mean \"soft\"?"}},
        Wrong{"published_at_no_axis",
              "at = { time.step_s = 1e-6 }",
              "at = { time.end_s = 1e-6 }",
              27,
              {"published[0].at", "\"time.end_s\"", "\"time.step_s\""}},
        Wrong{"published_at_no_value",
              "at = { time.step_s = 1e-6 }",
              "at = { time.step_s = 3e-6 }",
              27,
              {"found time.step_s = 3e-06", "a value that the study varies: 2e-06, 1e-06"}},
        Wrong{"published_negative", "time_ratio = 0.5", "time_ratio = -0.5", 28, {"a number > 0"}}),
    [](const auto& test) { return test.param.name; });

TEST(StudyFile, RefusesAMissingAndAnEmptyFile) {
  const test::TemporaryFolder folder;
  EXPECT_THROW((void)load_study((folder.path() / "none.toml").string()), ConfigError);
  EXPECT_THROW((void)load_study(folder.write("", "empty.toml")), ConfigError);
  EXPECT_THROW((void)load_study(folder.write(test::replaced(good_study(), "methods", "repeats = 0\nmethods"))),
               ConfigError);
}

/// A force and pressure of 1 from 0 to 10 s, sampled so that the jumps are where they should be.
Observation plateau(double pressure) {
  report::HistoryTable history;
  history.names = {"time_s",           "contact_force_n",     "contact_pressure_mean_pa", "principal_stress_mean_pa",
                   "friction_force_n", "velocity_mean_a_m_s", "velocity_mean_b_m_s"};
  history.columns.resize(history.names.size());
  for (int i = 0; i <= 12; ++i) {
    const double p = i >= 1 && i <= 11 ? pressure : 0.0, v = i < 6 ? 4.0 : -pressure;
    const double row[] = {double(i), 2.0 * p, p, -p, i % 2 == 0 ? 0.2 * p : -0.2 * p, v, 0.0};
    for (std::size_t c = 0; c < history.columns.size(); ++c) history.columns[c].push_back(row[c]);
  }
  return observe(history, {{"peak_contact_force_n", 2.0 * pressure},
                           {"separation_time_s", 11.5 + 0.1 * pressure},
                           {"energy_error_max", 0.01 * pressure}});
}

TEST(StudyMeasures, ErrorsOfHandMadeHistories) {
  const auto reference = plateau(1.0), run = plateau(1.25);
  EXPECT_EQ(reference.contact_begin_s, 1.0);
  EXPECT_EQ(reference.contact_end_s, 11.0);
  EXPECT_NEAR(*error_of("contact_force", run, reference), 0.25, 1e-12) << "the same difference at all times";
  EXPECT_NEAR(*error_of("principal_stress", run, reference), 0.25, 1e-12) << "relative to |plateau|";
  EXPECT_NEAR(*error_of("peak_force", run, reference), 0.25, 1e-12);
  // a zigzag between -0.05 and 0.05, whose mean square is a third of 0.05^2, over a contact force of 2
  EXPECT_NEAR(*error_of("friction_force", run, reference), 0.05 / std::sqrt(3.0) / 2.0, 1e-6);
  EXPECT_NEAR(*error_of("separation_time", run, reference), 0.025 / 10.0, 1e-12) << "over the contact period";
  EXPECT_NEAR(*error_of("rebound_velocity", run, reference), 0.25 / 4.0, 1e-12) << "over the greatest speed";
  EXPECT_NEAR(*error_of("energy_drift", run, reference), 0.0125, 1e-12) << "of the run alone";
  for (const auto& quantity : quantity_names({})) {
    if (quantity != "energy_drift") {
      EXPECT_EQ(*error_of(quantity, reference, reference), 0.0) << quantity;
    }
  }
}

TEST(StudyMeasures, OfAContactAreThoseOfItsColumnsAndItsSummary) {
  const auto seen = [](double force, double along_b) {
    report::HistoryTable history;
    for (const std::string of : {"", "/one", "/two"}) {
      for (const char* name :
           {"contact_force_n", "contact_pressure_mean_pa", "friction_force_n", "friction_force_b_n"}) {
        history.names.push_back(name + of);
        const bool binormal = std::string(name) == "friction_force_b_n";
        const double value = of == "/two" ? (binormal ? along_b : force) : binormal ? 1.0 : 8.0;
        history.columns.push_back({0.0, value, value, value, 0.0});
      }
    }
    history.names.insert(history.names.end(), {"time_s", "principal_stress_mean_pa"});
    history.columns.insert(history.columns.end(), {{0.0, 1.0, 2.0, 3.0, 4.0}, {0.0, 1.0, 1.0, 1.0, 0.0}});
    const nlohmann::ordered_json two = {{"peak_contact_force_n", force}, {"separation_time_s", 3.0 + 0.1 * force}};
    return observe(history,
                   {{"window_size_s", 1.0}, {"contacts", {{"one", nlohmann::ordered_json::object()}, {"two", two}}}});
  };
  const auto reference = seen(2.0, 0.5), run = seen(3.0, 0.25);
  ASSERT_EQ(run.contacts.size(), 2U);
  EXPECT_EQ(*error_of("contact_force", run, reference), 0.0);
  EXPECT_EQ(*error_of("contact_force/one", run, reference), 0.0);
  EXPECT_NEAR(*error_of("contact_force/two", run, reference), 0.5, 0.1) << "of the plateau 2";
  EXPECT_NEAR(*error_of("peak_force/two", run, reference), 0.5, 1e-12);
  EXPECT_FALSE(error_of("peak_force/one", run, reference)) << "its summary says nothing";
  EXPECT_NEAR(*error_of("separation_time/two", run, reference), 0.1 / 3.0, 1e-12);
  EXPECT_NEAR(*error_of("friction_force_b/two", run, reference), 0.125, 0.02) << "0.25 of the contact force 2";
  EXPECT_EQ(*error_of("friction_force_b", run, reference), 0.0);
  EXPECT_FALSE(error_of("contact_force/three", run, reference)) << "no such contact";
  EXPECT_EQ(history_of("contact_pressure/two", run).at(1.0), 3.0);
  EXPECT_GT(*rms_difference("contact_pressure/two", run, reference), 0.5);
  EXPECT_EQ(*rms_difference("principal_stress", run, reference), 0.0);
}

TEST(StudyMeasures, AForceStandsAtTheMiddleOfItsWindow) {
  report::HistoryTable history;
  history.names = {"time_s", "contact_force_n", "contact_pressure_mean_pa", "principal_stress_mean_pa",
                   "friction_force_n"};
  history.columns = {
      {0.0, 1.0, 2.0, 3.0}, {0.0, 5.0, 7.0, 0.0}, {0.0, 1.0, 3.0, 0.0}, {0.0, 1.0, 1.0, 1.0}, {0.0, 0.0, 2.0, 0.0}};
  const auto seen = observe(history, {{"window_size_s", 0.5}});
  EXPECT_EQ(seen.contact_begin_s, 0.5) << "where the first window with a force begins";
  EXPECT_EQ(seen.contact_end_s, 2.0);
  EXPECT_EQ(seen.contact_pressure_pa.at(0.5), 1.0) << "no window ends at the first row";
  EXPECT_EQ(seen.contact_pressure_pa.at(1.75), 3.0);
  EXPECT_EQ(seen.friction_force_n.at(1.25), 1.0);
  EXPECT_EQ(seen.principal_stress_pa.at(1.0), 1.0) << "a stress is that of its time";
}

/// They differ by 2 (t - 2) from t = 2 to 3 in a run of 3 s; the largest magnitude is 4.
TEST(StudyMeasures, AProbeIsComparedOverItsWholeRun) {
  const auto seen = [](const report::HistoryTable& probes) {
    report::HistoryTable history;
    history.names = {"time_s", "contact_force_n", "contact_pressure_mean_pa", "principal_stress_mean_pa",
                     "friction_force_n"};
    history.columns.assign(5, {0.0});
    return observe(history, nlohmann::ordered_json::object(), probes);
  };
  const std::vector<std::string> names{"time_s", "far.stress_pa", "far.strain"};
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  const auto run = seen({names, {{0.0, 2.0, 3.0}, {-4.0, -4.0, -2.0}, {none, none, none}}}),
             reference = seen({names, {{0.0, 3.0}, {-4.0, -4.0}, {1.0, 1.0}}});
  EXPECT_NEAR(*error_of("probe/far.stress_pa", run, reference), std::sqrt(4.0 / 9.0) / 4.0, 1e-6);
  EXPECT_EQ(*error_of("probe/far.stress_pa", reference, reference), 0.0);
  EXPECT_FALSE(error_of("probe/far.strain", run, reference)) << "nobody told it";
  EXPECT_FALSE(error_of("probe/near.stress_pa", run, reference));
}

TEST(StudyMeasures, RmsOfARampIsExact) {
  Observation reference, run;
  reference.contact_end_s = run.contact_end_s = 3.0;
  reference.contact_force_n = {{0.0, 3.0}, {2.0, 2.0}};
  run.contact_force_n = {{-1.0, 1.0, 2.0, 7.0}, {2.0, 2.0, 2.0, 12.0}};  // 2 (t - 2) above from t = 2 on
  // integral of 4 s^2 over 0..1, over 3, is 4/9
  EXPECT_NEAR(*error_of("contact_force", run, reference), std::sqrt(4.0 / 9.0) / 2.0, 1e-6);
}

TEST(StudyMeasures, AStressThatIsNowhereWhileAForceActsIsNotThere) {
  // Contact nodes without implicit elements: the implicit side knows no stress.
  report::HistoryTable history;
  history.names = {"time_s", "contact_force_n", "contact_pressure_mean_pa", "principal_stress_mean_pa",
                   "friction_force_n"};
  history.columns = {{0.0, 1.0, 2.0}, {0.0, 5.0, 5.0}, {0.0, 1.0, 1.0}, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
  const auto seen = observe(history, nlohmann::ordered_json::object());
  EXPECT_TRUE(seen.principal_stress_pa.time_s.empty());
  EXPECT_FALSE(error_of("principal_stress", seen, plateau(1.0)));
  EXPECT_TRUE(error_of("contact_force", seen, plateau(1.0)));
}

TEST(StudyMeasures, WhatIsNotThereHasNoError) {
  const auto reference = plateau(1.0);
  Observation none = plateau(0.0);
  none.separation_time_s.reset();
  EXPECT_EQ(none.contact_begin_s, none.contact_end_s);
  EXPECT_FALSE(error_of("separation_time", none, reference));
  EXPECT_FALSE(error_of("contact_force", reference, none)) << "a reference without contact";
  auto smooth = reference;
  for (double& force : smooth.friction_force_n.value) force = 0.0;
  EXPECT_FALSE(error_of("friction_force", reference, smooth)) << "a reference without friction";
  EXPECT_TRUE(error_of("friction_force", smooth, reference));
  EXPECT_NEAR(*error_of("contact_force", none, reference), 1.0, 1e-12);
}

TEST(ExactImpact, OfTwoBarsIsThatOfTheScenesHead) {
  const auto exact = exact_impact(scene::build_problem(scene::load_scene(bars)));
  EXPECT_NEAR(exact.contact_begin_s, 49.456e-6, 1e-9);
  EXPECT_NEAR(*exact.separation_time_s, 148.393e-6, 1e-9);
  EXPECT_NEAR(*exact.peak_force_n, 1.33453e5, 1.0);
  EXPECT_NEAR(exact.contact_pressure_pa.at(1e-4) * 6.4516e-4, 1.33453e5, 1.0);
  EXPECT_NEAR(exact.contact_force_n.at(1e-4), 1.33453e5, 1.0);
  EXPECT_EQ(exact.contact_pressure_pa.at(4e-5), 0.0);
  EXPECT_EQ(exact.contact_pressure_pa.at(1.6e-4), 0.0);
  EXPECT_EQ(exact.principal_stress_pa.at(1e-4), exact.contact_pressure_pa.at(1e-4))
      << "positive in compression, as in histories";
  ASSERT_EQ(exact.rebound_velocity_m_s.size(), 2U);
  EXPECT_NEAR(exact.rebound_velocity_m_s[0], -5.13588, 1e-9);
  EXPECT_NEAR(exact.rebound_velocity_m_s[1], 5.13588, 1e-9);
}

TEST(ExactImpact, OfASoftStrikerKeepsMomentumAndReboundsByImpedances) {
  // Z1 < Z2, and the striker's wave is back before the long bar's.
  const test::TemporaryFolder folder;
  const std::string path = (folder.path() / "a.toml").string();
  scene::write_variant(test::source_folder() + "/configs/unequal_bars.toml",
                       {{"body.striker.material.youngs_modulus_pa", 7e9},
                        {"body.striker.material.density_kg_m3", 2700.0},
                        {"time.step_s", 1e-7}},
                       path);
  const auto problem = scene::build_problem(scene::load_scene(path));
  const auto exact = exact_impact(problem);
  double before = 0.0, after = 0.0;
  for (std::size_t b = 0; b < 2; ++b) {
    const auto& body = problem.scene.bodies[b];
    const double mass = body.material.density_kg_m3 * body.area_m2 * body.structured()->length_m;
    before += body.initial_velocity_m_s.empty() ? 0.0 : mass * body.initial_velocity_m_s[0];
    after += mass * exact.rebound_velocity_m_s[b];
  }
  EXPECT_NEAR(after, before, 1e-12 * std::abs(before)) << "momentum";
  // v1 (Z1 - Z2) / (Z1 + Z2), as a point mass of the impedances would rebound
  const double z1 = std::sqrt(7e9 * 2700.0), z2 = std::sqrt(70e9 * 2700.0);
  EXPECT_NEAR(exact.rebound_velocity_m_s[0], 10.0 * (z1 - z2) / (z1 + z2), 1e-9);
}

TEST(ExactImpact, IsRefusedWhereTheoryIsNotExact) {
  const auto refused = [](const std::string& path) {
    try {
      (void)exact_impact(scene::build_problem(scene::load_scene(path)));
    } catch (const ConfigError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const std::string configs = test::source_folder() + "/configs/";
  for (const char* name : {"kim_impact", "bouncing_bar", "slipping_plates", "unequal_bars"}) {
    EXPECT_THAT(refused(configs + name + ".toml"), HasSubstr("allowed with reference.exact")) << name;
  }
  const test::TemporaryFolder folder;
  scene::write_variant(bars, {{"body.right.gravity_m_s2", std::vector<double>{-9.81}}},
                       (folder.path() / "a.toml").string());
  EXPECT_THAT(refused((folder.path() / "a.toml").string()), HasSubstr("supports or loads of 'right'"));
}

TEST(RunKey, ChangesWithTheSceneAndWithThePrograms) {
  const auto key = run_key("scene", {"coupler", "solver"});
  EXPECT_EQ(key.size(), 16U);
  EXPECT_EQ(run_key("scene", {"coupler", "solver"}), key);
  EXPECT_NE(run_key("other", {"coupler", "solver"}), key);
  EXPECT_NE(run_key("scene", {"coupler", "rebuilt"}), key);
}

TEST(StudyCaseOfARefusedVariant, HasAStatusAndAReason) {
  const test::TemporaryFolder folder;
  const StudyCase run(bars, {{"time.step_s", 1e-4}}, folder.path().string());
  EXPECT_TRUE(run.failed());
  EXPECT_EQ(run.status(), RunStatus::scene_wrong);
  EXPECT_THAT(run.error(), HasSubstr("critical time step"));
  EXPECT_TRUE(std::filesystem::exists(run.folder() + "/scene.toml"));
}

TEST(ParetoFront, HoldsWhatNoOtherPointBeats) {
  using report::pareto_front;
  //                            front         beaten       front         front (equal)  beaten: same cost, worse
  EXPECT_THAT(pareto_front({{1.0, 9.0}, {3.0, 9.5}, {2.0, 4.0}, {2.0, 4.0}, {2.0, 5.0}, {8.0, 4.0}}),
              ElementsAre(true, false, true, true, false, false));
  EXPECT_TRUE(pareto_front({}).empty());
}

TEST(CsvTable, ReadsQuotedCellsAndRefusesShortLines) {
  const test::TemporaryFolder folder;
  const auto rows = report::read_csv(folder.write("a,b,c\n1.5,\"x, \"\"y\"\"\",\n", "t.csv"));
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_EQ(*report::number(rows[0], "a"), 1.5);
  EXPECT_EQ(rows[0].at("b"), "x, \"y\"");
  EXPECT_FALSE(report::number(rows[0], "c"));
  EXPECT_THROW((void)report::read_csv(folder.write("a,b\n1\n", "short.csv")), ConfigError);
}

TEST(StudyMeasures, AHistorysRmsIsThatOfEquation29) {
  // Eq. 29 over sigma_0 = 2 of two constant histories, 0.25 apart
  const auto reference = plateau(1.0), run = plateau(1.25);
  const auto rms =
      rms_difference(history_of("principal_stress", run), history_of("principal_stress", reference), reference);
  EXPECT_NEAR(*rms / 2.0, 0.125, 1e-12);
  EXPECT_FALSE(rms_difference(history_of("contact_pressure", run), history_of("contact_pressure", run), plateau(0.0)));
}

const std::string drawn_study = R"({"study": "/there/s.toml", "scene": "a.toml", "methods": ["kim", "all_implicit"],
  "parameters": ["x.y"], "axes": ["x.y"], "along": "", "along_together": [], "quantities": [], "repeats": 3, "version": "1",
  "references": [], "histories": null,
  "published": [{"methods": ["kim"], "over": "all_implicit", "at": {"x.y": "2"}, "time_ratio": 0.614, "source": "T<2>"}]})";

TEST(StudyPage, SetsTimesBesidePublishedOnes) {
  const test::TemporaryFolder folder;
  (void)folder.write(drawn_study, "study.json");
  (void)folder.write(
      "method,x.y,status,wall_s,wall_min_s,wall_max_s,start_s,setup_s,stepping_s,cpu_s,repeats,steps,step_s,run,error\n"
      "kim,1,done,9,9,9,0,0,9,9,3,1,1,a,\nall_implicit,1,done,9,9,9,0,0,9,9,3,1,1,b,\n"
      "kim,2,done,2,1,3,0,0,1,2,3,1,1,c,\nall_implicit,2,done,4,3.2,5,0,0,4,4,3,1,1,d,\n",
      "results.csv");
  const auto page = report::study_page(folder.path().string());
  EXPECT_THAT(
      page,
      HasSubstr(
          "<td>kim</td><td>all_implicit</td><td>x.y = 2</td><td>0.614</td><td>0.250</td><td>0.500 (0.200 to 0.938)</td>"
          "<td>T&lt;2&gt;</td>"));
  EXPECT_EQ(page.find("<td>x.y = 1</td><td>0.614"), std::string::npos) << "other settings";
}

TEST(StudyPage, RefusesWhatIsNoStudy) {
  const test::TemporaryFolder folder;
  (void)folder.write("{}", "study.json");
  (void)folder.write("method\n", "results.csv");
  EXPECT_THROW((void)report::study_page(folder.path().string()), ConfigError);
}

}  // namespace
}  // namespace ricochet::coupler

// The page as a whole: files in, one HTML file out.
#include <gmock/gmock.h>

#include <cmath>
#include <regex>
#include <stdexcept>

#include "common/base/error.hpp"
#include "coupler/report/parts/history_table.hpp"
#include "coupler/report/parts/text.hpp"
#include "coupler/report/report.hpp"
#include "coupler/report/run_page/timeline.hpp"
#include "coupler/results/trace.hpp"
#include "tests/coupler/report/sample_run.hpp"

namespace ricochet::report {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

TEST(Text, HtmlIsEscaped) {
  EXPECT_EQ(escape_html(R"(<b a="1">'x' & y</b>)"), "&lt;b a=&quot;1&quot;&gt;&#39;x&#39; &amp; y&lt;/b&gt;");
  EXPECT_EQ(escape_html("gnp.\u202etoml\u2028<"), "gnp.?toml?&lt;") << "no text turns or breaks what stands beside it";
}

TEST(Text, NothingInAScriptEndsIt) {
  EXPECT_EQ(inside_script(R"(["</SCRIPT>", "<!--", "a<b"])"), "[\"\\u003c/SCRIPT>\", \"\\u003c!--\", \"a<b\"]");
}

/// U+2028 and U+2029 end lines of JavaScript, wherever they stand.
TEST(Text, NothingInAScriptEndsALineOfIt) {
  EXPECT_EQ(inside_script("[\"a\u2028b\u2029\", \"\u202a\u00e2\"]"), "[\"a\\u2028b\\u2029\", \"\u202a\u00e2\"]");
  EXPECT_EQ(inside_script("<\xe2\x80"), "<\xe2\x80");
}

TEST(Text, TemplatesAreFilledOnceAndWhollyOrNotAtAll) {
  EXPECT_EQ(fill_page("<{{a}}|{{b}}>", {{"a", "{{b}}"}, {"b", "2"}}), "<{{b}}|2>");
  EXPECT_EQ(fill_json(R"({"x": "{{list}}"})", {{"list", "[1, 2]"}}), R"({"x": [1, 2]})");
  EXPECT_THROW((void)fill_page("{{unknown}}", {}), std::logic_error);
}

class Page : public SampleRun {};

TEST_F(Page, IsOneFileWithoutReferencesToTheNetwork) {
  EXPECT_EQ(write_report(folder_).path, path("report.html"));
  const auto page = read("report.html");
  EXPECT_LT(page.size(), 3'000'000U);
  const std::regex reference("<(script|link|img)[^>]*(src|href)=\"?(https?:|//)");
  EXPECT_FALSE(std::regex_search(page.substr(0, 10000), reference));
  EXPECT_EQ(page.find("<script src"), std::string::npos);
  EXPECT_EQ(page.find("{{charts"), std::string::npos);
}

TEST_F(Page, SetsResultsBesideTheory) {
  write_report(folder_);
  EXPECT_THAT(read("report.html"),
              AllOf(HasSubstr("<h1>impact</h1>"), HasSubstr("3 µs (first contact + 2L/c of steel)"),
                    HasSubstr("+0.00 %"), HasSubstr("850 MPa (impedance theory)"), HasSubstr("-1.18 %"),
                    HasSubstr("implicit 0.750"), HasSubstr("switch of integration 3.5 µs"),
                    HasSubstr("impedance theory, until a wave returns"), HasSubstr("1.5 N s")));
}

TEST_F(Page, DrawsTheYieldStressAndMarksWhenItIsPassed) {
  write("summary.json", R"({"status": "left_model", "scene": "a.toml", "limits": [
    {"body": "rod", "yield_stress_pa": 9e8, "strength_pa": null}, {"body": "far", "yield_stress_pa": 2e11, "strength_pa": 1}],
    "outside_model": [{"kind": "yield", "body": "rod", "first_s": 1.5e-6, "text": "rod flows"},
    {"kind": "tension", "body": "far", "first_s": 2.5e-6, "text": "far breaks"}, {"kind": "strain", "text": "s"}]})");
  write_report(folder_);
  EXPECT_THAT(read("report.html"),
              AllOf(HasSubstr("yield stress of rod"), HasSubstr("yield stress passed in rod 1.5 µs"),
                    HasSubstr("strength passed in far 2.5 µs"), HasSubstr("rod flows"), HasSubstr("far breaks"),
                    Not(HasSubstr("yield stress of far"))));
}

TEST_F(Page, TellsOfContactForcesThatWereNotFound) {
  write_report(folder_);
  EXPECT_THAT(read("report.html"), AllOf(HasSubstr("windows whose contact forces were not found"),
                                         HasSubstr("3; worst residual 0.0002 of the largest force")));
  write("summary.json", R"({"status": "done", "scene": "a.toml", "contact": {"windows_unconverged": 0}})");
  write_report(folder_);
  EXPECT_THAT(read("report.html"), Not(HasSubstr("contact forces were not found")));
}

/// A page is sent to others: it names the scene, not where it lies.
TEST_F(Page, ShowsNoPathOfTheMachine) {
  write("summary.json", R"({"status": "done", "scene": "/home/me/a.toml"})");
  write_report(folder_);
  EXPECT_THAT(read("report.html"), AllOf(HasSubstr("<dt>scene</dt><dd>a.toml "), Not(HasSubstr("/home/me"))));
}

TEST_F(Page, SaysWhatAContactForceIs) {
  write_report(folder_);
  EXPECT_THAT(read("report.html"), HasSubstr("Contact pressure: impulse over the window / window size"));
}

TEST_F(Page, AFailedRunShowsItsErrorEscaped) {
  write("summary.json", R"({"status": "unstable", "error": "energy <grew> & \"grew\"", "scene": "<i>.toml"})");
  write_report(folder_);
  const auto page = read("report.html");
  EXPECT_THAT(page, AllOf(HasSubstr("energy &lt;grew&gt; &amp; &quot;grew&quot;"), HasSubstr("status failed"),
                          HasSubstr("<h1>&lt;i&gt;</h1>")));
  EXPECT_THAT(page, Not(HasSubstr("<grew>")));
}

TEST_F(Page, ARunThatWasKilledBeforeItsFirstWindowHasAPageToo) {
  write("summary.json", R"({"status": "running", "error": ""})");
  write("history.csv", "time_s,contact_force_n\n");
  write_report(folder_);
  EXPECT_THAT(read("report.html"),
              AllOf(HasSubstr("its coupler was killed"), HasSubstr("ended before there was a history")));
}

TEST_F(Page, MissingFilesAreNamed) {
  const auto report = [this] { write_report(folder_); };
  std::filesystem::remove(path("history.csv"));
  EXPECT_THAT(config_error(report), AllOf(HasSubstr(path("history.csv")), HasSubstr("results folder")));
  std::filesystem::remove(path("summary.json"));
  EXPECT_THAT(config_error(report), HasSubstr(path("summary.json")));
  EXPECT_THAT(config_error([] { write_report("/nonexistent"); }), HasSubstr("/nonexistent/summary.json"));
  EXPECT_FALSE(std::filesystem::exists(path("report.html")));
}

TEST_F(Page, WrongFilesAreNamed) {
  const auto report = [this] { write_report(folder_); };
  write("summary.json", R"({"status": 7})");
  EXPECT_THAT(config_error(report), HasSubstr("summary.json"));
  write("summary.json", "[");
  EXPECT_THAT(config_error(report), HasSubstr("summary.json"));
  write("summary.json", R"({"status": "done"})");
  write("trace.json", "{}");
  EXPECT_THAT(config_error(report), HasSubstr("trace.json"));
}

TEST_F(Page, WrongHistoriesAreNamedByLineAndColumn) {
  const auto history = [this] { (void)read_history(path("history.csv")); };
  write("history.csv", "time_s,a\n0,1\n1,x\n");
  EXPECT_THAT(config_error(history), AllOf(HasSubstr("history.csv:3"), HasSubstr("\"x\""), HasSubstr("\"a\"")));
  write("history.csv", "time_s,a\n0\n");
  EXPECT_THAT(config_error(history), AllOf(HasSubstr("history.csv:2"), HasSubstr("1 values")));
  write("history.csv", "a,b\n");
  EXPECT_THAT(config_error(history), HasSubstr("time_s"));
}

TEST_F(Page, HalfALastLineIsIgnored) {
  write("history.csv", "time_s,a\n0,inf\n1,2");
  const auto table = read_history(path("history.csv"));
  EXPECT_EQ(table.rows(), 1U);
  EXPECT_TRUE(std::isinf((*table.find("a"))[0]));
  EXPECT_EQ(table.find("b"), nullptr);
}

TEST(Timeline, WhatLiesBetweenTheSpansIsFilledIn) {
  const auto chart = timeline(R"({"traceEvents": [
    {"name": "process_name", "ph": "M", "pid": 1, "args": {"name": "coupler"}},
    {"name": "process_name", "ph": "M", "pid": 2, "args": {"name": "implicit"}},
    {"name": "waits for implicit", "ph": "X", "ts": 10, "dur": 5, "pid": 1, "tid": 1, "args": {"window": 0}},
    {"name": "waits for implicit", "ph": "X", "ts": 100, "dur": 20, "pid": 1, "tid": 1, "args": {"window": 1}},
    {"name": "waits for implicit", "ph": "X", "ts": 130, "dur": 10, "pid": 1, "tid": 1, "args": {"window": 2}},
    {"name": "computes", "ph": "X", "ts": 105, "dur": 10, "pid": 2, "tid": 2, "args": {"window": 1}},
    {"name": "computes", "ph": "X", "ts": 900000, "dur": 10, "pid": 2, "tid": 2, "args": {"window": 41}}]})");
  ASSERT_TRUE(chart);
  ASSERT_EQ(chart->rows.size(), 4U) << chart->rows.dump() << ": start-up and late windows are left out";
  EXPECT_EQ(chart->rows[0], Json({"coupler", "waits", "waits for implicit", 1, 0.0, 20.0, 20.0}));
  EXPECT_EQ(chart->rows[1], Json({"coupler", "computes", "computes", 2, 20.0, 30.0, 10.0}));
  EXPECT_EQ(chart->rows[3], Json({"implicit", "computes", "computes", 1, 5.0, 15.0, 10.0}));
  EXPECT_THAT(chart->spec, HasSubstr("[µs]"));
}

TEST(Timeline, OfThePartOfATraceThatIsReadIsThatOfAll) {
  coupler::TraceTrack coupler{"coupler", "waits for \"one\"", {}, {}}, one{"one", "computes", {}, {}};
  for (int window = 0; window < 300; ++window) {
    coupler.spans.push_back({window, 1e-3 * window, 1e-3 * window + 4e-4});
    one.spans.push_back({window, 1e-3 * window + 1e-4, 1e-3 * window + 3e-4});
    one.counters.push_back({window, 2.0, 1e-12});
  }
  for (const auto& tracks : {std::vector{coupler, one}, std::vector{one, coupler}, std::vector{one}}) {
    const std::string text = coupler::to_trace(tracks, 0.0);
    const auto part = timeline(text), all = timeline(Json::parse(text).dump());
    ASSERT_TRUE(part && all);
    EXPECT_EQ(part->rows, all->rows);
    EXPECT_EQ(part->spec, all->spec);
    EXPECT_GT(part->rows.size(), 10U);
  }
}

TEST(Timeline, NoWindowNoTimeline) {
  EXPECT_FALSE(timeline(R"({"traceEvents": []})"));
  EXPECT_NE(config_error([] { (void)timeline("nonsense"); }), "");
}

}  // namespace
}  // namespace ricochet::report

// The charts as files, drawn by node; and the stability maps that join a run's page.
#include <gmock/gmock.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <regex>

#include "common/base/error.hpp"
#include "coupler/report/pictures.hpp"
#include "coupler/report/report.hpp"
#include "coupler/report/stability_page/stability_maps.hpp"
#include "coupler/report/stability_page/stability_page.hpp"
#include "tests/coupler/report/sample_run.hpp"

namespace ricochet::report {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;

/// The texts of an SVG file, one a line, then "marks: " and the number of its paths, images and circles, by an
/// independent reader of XML.
std::string texts_of(const std::string& path) {
  const std::string command =
      "/usr/bin/python3 -c \"import sys,xml.etree.ElementTree as e\n"
      "s='{http://www.w3.org/2000/svg}'; r=e.parse(sys.argv[1]).getroot(); assert r.tag==s+'svg'\n"
      "print(*[t.text for t in r.iter(s+'text')],sep='\\n')\n"
      "g=[m for m in r.iter(s+'g') if m.get('class','').startswith('mark-')]\n"
      "print('lines:',sum(len(list(m)) for m in g if 'mark-line' in m.get('class') and 'marks' in m.get('class')))\n"
      "print('images:',len(list(r.iter(s+'image'))))\" '" +
      path + "' 2>&1";
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), pclose);
  std::string text;
  std::array<char, 4096> buffer{};
  while (const std::size_t count = std::fread(buffer.data(), 1, buffer.size(), pipe.get()))
    text.append(buffer.data(), count);
  return text;
}

class PicturesOfARun : public SampleRun {
 protected:
  /// A page with the programs of ours and one chart.
  [[nodiscard]] std::string one_chart(const std::string& id) const {
    std::string page = stability_page(map());
    const std::string known = "\"id\": \"stability_open\"";
    return page.replace(page.find(known), known.size(), "\"id\": \"" + id + "\"");
  }
  StabilityMap map() const {
    StabilityMap map{"two_bars", "Courant number", "coupling.protocol", {"kim"}, {}, false, {}, {}, {}};
    map.cells = {{"open", 0, 0.9, 0.0, true}, {"open", 0, 1.1, 0.5, false}};
    map.edges = {{"open", 0, 1.0, "predicted"}};
    return map;
  }
};

TEST_F(PicturesOfARun, EveryChartIsAFileWithTitleAndLabels) {
  write("axial_stress.csv", "time_s,left/-0.02/0,right/0/0.04\n0,0,0\n1e-6,-2e6,-1e6\n2e-6,1e6,0\n");
  std::filesystem::create_directories(path("charts"));
  write("charts/mine.svg", "mine");
  static_cast<void>(draw_pictures({path("report.html"), one_chart("former")}));
  EXPECT_TRUE(std::filesystem::exists(path("charts/former.svg")));
  const auto pictures = draw_pictures(write_report(folder_));
  EXPECT_EQ(pictures.obstacle, "");
  EXPECT_EQ(pictures.count, 4);
  EXPECT_FALSE(std::filesystem::exists(path("charts/former.svg")));
  EXPECT_EQ(read("charts/mine.svg"), "mine");
  EXPECT_THAT(texts_of(path("charts/contact_stress.svg")),
              AllOf(HasSubstr("Stress on the contact surfaces\n"), HasSubstr("stress [MPa]\n"),
                    HasSubstr("time [µs]\n"), HasSubstr("impedance theory"), HasSubstr("lines: 3\n")));
  EXPECT_THAT(texts_of(path("charts/axial_stress.svg")),
              AllOf(HasSubstr("Stress waves"), HasSubstr("axial position [mm]\n"), HasSubstr("axial stress [MPa]\n"),
                    HasSubstr("left\n"), HasSubstr("images: 2\n")));
  EXPECT_THAT(texts_of(path("charts/gap.svg")), AllOf(HasSubstr("Smallest gap\n"), HasSubstr("lines: 1\n")));
  EXPECT_THAT(texts_of(path("charts/velocities.svg")), AllOf(HasSubstr("a<b"), HasSubstr("lines: 2\n")));
}

TEST_F(PicturesOfARun, WithoutNodeThePageIsThereAndWhatIsMissingIsSaid) {
  const std::string before = std::getenv("PATH");
  const auto page = write_report(folder_);
  setenv("PATH", "/nonexistent", 1);
  const auto pictures = draw_pictures(page);
  setenv("PATH", before.c_str(), 1);
  EXPECT_EQ(pictures.count, 0);
  EXPECT_THAT(pictures.obstacle, AllOf(HasSubstr("`node` is not on PATH"), HasSubstr("install")));
  EXPECT_TRUE(std::filesystem::exists(page.path));
  EXPECT_FALSE(std::filesystem::exists(path("charts")));
}

TEST_F(PicturesOfARun, APageThatIsNoneIsAnError) {
  EXPECT_THROW((void)draw_pictures({path("other.html"), "<html></html>"}), ParticipantError);
  EXPECT_THROW((void)draw_pictures({"/proc/report.html", one_chart("a")}), ConfigError);
  EXPECT_THROW((void)draw_pictures({path("report.html"), one_chart("../../evil")}), ParticipantError);
}

TEST_F(PicturesOfARun, APictureThatIsNotOursIsNotReplaced) {
  std::filesystem::create_directories(path("charts"));
  write("charts/gap.svg", "mine");
  const auto page = write_report(folder_);
  EXPECT_THAT(config_error([&] { static_cast<void>(draw_pictures(page)); }),
              HasSubstr("charts/gap.svg is there already"));
  EXPECT_EQ(read("charts/gap.svg"), "mine");
  write("report.html", "mine");
  EXPECT_THAT(config_error([&] { write_report(folder_); }), HasSubstr("report.html is there already"));
  EXPECT_EQ(read("report.html"), "mine");
}

TEST_F(PicturesOfARun, StabilityMapsBesideTheRunJoinItsPage) {
  EXPECT_THAT(stability_maps(folder_), IsEmpty());
  std::filesystem::create_directories(folder_ + "_stability");
  std::ofstream(folder_ + "_stability/stability.json") << to_json(map());
  for (const std::string& folder : {folder_, folder_ + "/"}) {
    const auto maps = stability_maps(folder);
    ASSERT_EQ(maps.size(), 1U);
    EXPECT_EQ(maps[0].id, "stability_open");
    EXPECT_THAT(maps[0].title, HasSubstr("Contact open"));
    EXPECT_THAT(maps[0].note, HasSubstr("_stability/stability.json"));
    EXPECT_EQ(maps[0].rows.size(), 3U);
  }
  write_report(folder_);
  EXPECT_THAT(read("report.html"), HasSubstr(R"(id="stability_open")"));
  std::ofstream(folder_ + "_stability/stability.json") << "something else";
  EXPECT_THROW((void)stability_maps(folder_), ConfigError);
  std::filesystem::remove_all(folder_ + "_stability");
}

/// A page that lies in the folder may hold programs of anybody: neither is it run nor does anything of it reach ours.
TEST_F(PicturesOfARun, ThoseOfAStabilityMapAreDrawnFromItsNumbers) {
  const std::string folder = path("map");
  std::filesystem::create_directories(folder);
  std::ofstream(folder + "/stability.json") << to_json(map());
  const auto page = write_report(folder);
  EXPECT_EQ(page.path, folder + "/stability.html");
  EXPECT_EQ(draw_pictures(page).count, 1);
  EXPECT_THAT(texts_of(folder + "/charts/stability_open.svg"),
              AllOf(HasSubstr("Contact open\n"), HasSubstr("Courant number\n"), HasSubstr("coupling.protocol\n")));
}

TEST_F(PicturesOfARun, AMapWithOtherThingsThanNumbersIsRefused) {
  const std::string folder = path("map"), file = folder + "/stability.json", good = to_json(map());
  std::filesystem::create_directories(folder);
  const auto with = [&](const std::string& old, const std::string& replacement) {
    std::string text = good;
    text.replace(text.find(old), old.size(), replacement);
    std::ofstream(file) << text;
    return config_error([&] { write_report(folder); });
  };
  EXPECT_THAT(with("\"open\"", "\"open'></div><script>\""), HasSubstr("'contact' is neither"));
  EXPECT_THAT(with("\"predicted\"", "\"guessed\""), HasSubstr("'kind' is neither"));
  EXPECT_THAT(with("\"step\": 0.9", "\"step\": -1"), HasSubstr("'step' is not above 0"));
  EXPECT_THAT(with("\"column\": 0", "\"column\": 7"), HasSubstr("'column' is none"));
  EXPECT_THAT(with("\"cells\"", "\"cell\""), HasSubstr("not a map of ricochet stability"));
  with("\"kim\"", "\"' + alert(1) + '\\\"\"");
  EXPECT_THAT(read("map/stability.html"), HasSubstr(R"(\"' + alert(1) + '\\\")"));
}

}  // namespace
}  // namespace ricochet::report

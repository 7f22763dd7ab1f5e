// The x-t diagram: picture, colours, layers and times; and the axes that do not give way to one large value.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <array>
#include <cstdio>
#include <memory>

#include "common/base/error.hpp"
#include "coupler/report/parts/outliers.hpp"
#include "coupler/report/parts/png.hpp"
#include "coupler/report/run_page/history_charts.hpp"
#include "coupler/report/run_page/stress_waves.hpp"
#include "tests/coupler/report/sample_run.hpp"

namespace ricochet::report {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

/// The text that a script prints of a file.
std::string said_by_python(const std::string& script, const std::string& path) {
  const std::string command = "/usr/bin/python3 -c \"" + script + "\" '" + path + "' 2>&1";
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), pclose);
  std::string text;
  std::array<char, 4096> buffer{};
  while (const std::size_t count = std::fread(buffer.data(), 1, buffer.size(), pipe.get()))
    text.append(buffer.data(), count);
  return text;
}

/// Content that a separate reader finds in a PNG file of ours: width, height, then the colours as hexadecimal numbers.
std::string decoded(const std::string& path) {
  const std::string script =
      "import sys,zlib,struct\n"
      "d=open(sys.argv[1],'rb').read(); assert d[:8]==b'\\x89PNG\\r\\n\\x1a\\n'; at=8; c={}\n"
      "while at<len(d):\n"
      "  n,=struct.unpack('>I',d[at:at+4]); k=d[at+4:at+8]; b=d[at+8:at+8+n]; at+=12+n; c[k]=b\n"
      "  assert struct.unpack('>I',d[at-4:at])[0]==zlib.crc32(k+b)\n"
      "w,h=struct.unpack('>II',c[b'IHDR'][:8]); l=zlib.decompress(c[b'IDAT']); assert len(l)==h*(w+1) and b'IEND' in "
      "c\n"
      "print(w,h,*[c[b'PLTE'][3*l[r*(w+1)+1+x]:][:3].hex() for r in range(min(h,3)) for x in range(min(w,3))])\n";
  return said_by_python(script, path);
}

class StressWaves : public SampleRun {
 protected:
  /// The diagrams of a table with time_s and the given columns.
  std::vector<Chart> charts(const std::string& text) {
    write("axial_stress.csv", text);
    table_ = read_history(path("axial_stress.csv"));
    return stress_wave_charts(table_, {table_.columns.front().front(), table_.columns.front().back(), {1e-6}});
  }
  HistoryTable table_;
};

TEST_F(StressWaves, PngIsReadByAnIndependentReader) {
  write("a.png", png(2, 2, {0, 1, 1, 2}, {{255, 0, 0}, {0, 255, 0}, {1, 2, 3}}));
  EXPECT_EQ(decoded(path("a.png")), "2 2 ff0000 00ff00 00ff00 010203\n");
  write("b.png", png(300, 250, std::vector<std::uint8_t>(75000, 0), {{9, 8, 7}}));
  EXPECT_THAT(decoded(path("b.png")), HasSubstr("300 250 090807"));
  EXPECT_LT(std::filesystem::file_size(path("b.png")), 1500U) << "what repeats is compressed";
  EXPECT_THROW((void)png(2, 2, {0}, {{0, 0, 0}}), std::invalid_argument);
}

// Repeats of every length and of two distances, and colours of every number between them.
TEST_F(StressWaves, EveryPixelOfAPngIsReadBack) {
  constexpr std::size_t width = 777, height = 40;
  std::vector<std::uint8_t> pixels;
  for (std::uint32_t random = 1, length = 1; pixels.size() < width * height; ++length) {
    random = 1664525U * random + 1013904223U;
    pixels.insert(pixels.end(), length % 300, static_cast<std::uint8_t>(random >> 24U));
    for (std::uint32_t i = 0; i < length % 7 && pixels.size() > width; ++i)
      pixels.push_back(pixels[pixels.size() - width]);
  }
  pixels.resize(width * height);
  write("a.png", png(width, height, pixels, std::vector<Rgb>(256)));
  const std::string script =
      "import sys,zlib; d=open(sys.argv[1],'rb').read(); at=d.index(b'IDAT'); n=int.from_bytes(d[at-4:at],'big')\n"
      "print(zlib.decompress(d[at+4:at+4+n]).hex(),end='')";
  std::string expected;
  for (std::size_t i = 0; i < pixels.size(); ++i)
    expected += fmt::format("{}{:02x}", i % width == 0 ? "00" : "", pixels[i]);
  EXPECT_TRUE(said_by_python(script, path("a.png")) == expected);
}

TEST_F(StressWaves, RowsAreInDisplayUnitsWithOneColumnForEachLayer) {
  const auto all =
      charts("time_s,left/-0.02/-0.01,left/-0.01/0,right/0/0.04\n0,0,0,0\n1e-6,-2e6,-1e6,nan\n2e-6,1e6,0,0\n");
  ASSERT_EQ(all.size(), 1U);
  const auto& chart = all.front();
  EXPECT_EQ(chart.id, "axial_stress");
  EXPECT_THAT(chart.columns, ElementsAre("time", "s0", "s1", "s2"));
  EXPECT_EQ(chart.rows[1], Json({1.0, -2.0, -1.0, nullptr}));
  EXPECT_THAT(chart.spec, AllOf(HasSubstr("axial position [mm]"), HasSubstr("axial stress [MPa]"),
                                HasSubstr("time [µs]"), Not(HasSubstr("{{"))));
  const auto layers = Json::parse(chart.spec)["layer"];
  const auto images = layers[0]["data"]["values"];
  ASSERT_EQ(images.size(), 2U);
  EXPECT_EQ(images[0]["low"], -20.0);
  EXPECT_EQ(images[1]["high"], 40.0);
  EXPECT_EQ(images[0]["begin"], -0.5) << "a cell reaches half a step to both sides";
  EXPECT_EQ(images[0]["end"], 2.5);
  EXPECT_EQ(layers[4]["data"]["values"], Json::array({{{"position", 0.0}}})) << "where the bodies meet";
  EXPECT_THAT(chart.note, HasSubstr("where the bodies meet"));
}

TEST_F(StressWaves, TensionIsDottedCompressionIsNot) {
  std::string text = "time_s,a/0/1,a/1/2\n";
  for (int i = 0; i < 100; ++i) text += fmt::format("{},1e6,-1e6\n", i);
  const auto spec = Json::parse(charts(text).at(0).spec);
  const auto dots = spec["layer"][2]["data"]["values"];
  ASSERT_GT(dots.size(), 10U);
  for (const auto& dot : dots) EXPECT_EQ(dot["position"], 0.5);
}

TEST_F(StressWaves, AFewLargeStressesDoNotSetTheColours) {
  std::string text = "time_s,a/0/1\n";
  for (int i = 0; i < 400; ++i) text += fmt::format("{},{}\n", i, i == 30 ? -9e8 : -1e8);
  const auto chart = charts(text).at(0);
  EXPECT_EQ(Json::parse(chart.spec)["layer"][1]["encoding"]["color"]["scale"]["domain"][0], -100.0);
  EXPECT_THAT(chart.note, AllOf(HasSubstr("-900 MPa at 30 s, lies beyond the colours"), HasSubstr("200 of 400 times")));
}

TEST_F(StressWaves, BodiesSideBySideHaveADiagramEach) {
  const auto all = charts("time_s,a/0/1,b/0.5/1.5\n0,0,1\n1,2,3\n");
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(all[0].id, "axial_stress_a");
  EXPECT_EQ(all[1].columns.size(), 2U);
  EXPECT_THAT(all[1].title, HasSubstr("in b"));
}

TEST_F(StressWaves, ManyLayersAreTakenTogether) {
  std::string header = "time_s", row;
  for (int i = 0; i < 401; ++i) {
    header += fmt::format(",a/{}/{}", i, i + 1);
    row += fmt::format(",{}", i % 3);
  }
  const auto chart = charts(header + "\n0" + row + "\n1" + row + "\n").at(0);
  EXPECT_EQ(chart.columns.size(), 1U + 134U);
  EXPECT_EQ(chart.rows[0][1], 1.0) << "the mean of 0, 1 and 2";
  EXPECT_EQ(Json::parse(chart.spec)["params"][3]["value"].back(), 401.0);
}

TEST_F(StressWaves, NothingToDrawOfOneTimeOrOfNoStress) {
  EXPECT_THAT(charts("time_s,a/0/1\n0,1\n"), IsEmpty());
  EXPECT_THAT(charts("time_s,a/0/1\n0,0\n1,nan\n"), IsEmpty());
}

TEST_F(StressWaves, AColumnThatIsNoLayerIsNamed) {
  for (const std::string column : {"a", "a/0", "a/x/1", "a/0/1/2"}) {
    try {
      (void)charts("time_s," + column + "\n0,1\n1,1\n");
      ADD_FAILURE() << column;
    } catch (const ConfigError& error) {
      EXPECT_THAT(error.what(), HasSubstr("\"" + column + "\""));
    }
  }
}

TEST(ShownRange, EndsShortOfAFewLargeValuesOnly) {
  std::vector<double> values(1000, 0.0);
  for (std::size_t i = 0; i < 1000; ++i) values[i] = static_cast<double>(i % 11);
  EXPECT_TRUE(shown_range({&values}).holds(1e300)) << "nothing stands out";
  values[3] = 100.0;
  EXPECT_DOUBLE_EQ(shown_range({&values}).high, 11.25);
  EXPECT_TRUE(shown_range({&values}).holds(-1e300));
  values[5] = -7.0;
  EXPECT_DOUBLE_EQ(shown_range({&values}).low, -1.25);
  const std::vector<double> high(1000, 90.0);
  EXPECT_TRUE(shown_range({&values, &high}).holds(100.0)) << "the other series needs the room anyway";
  for (std::size_t i = 0; i < 20; ++i) values[i] = 100.0;
  EXPECT_TRUE(shown_range({&values}).holds(100.0)) << "2 % of the rows are no few";
}

TEST_F(StressWaves, WhatLiesBeyondTheAxisOfAChartIsMarkedAndTold) {
  std::string text = "time_s,contact_force_n\n";
  for (int i = 0; i < 100; ++i) text += fmt::format("{},{}\n", i, i == 1 ? 5000 : i);
  write("history.csv", text);
  const auto chart = history_charts(read_history(path("history.csv")), {}).at(0);
  EXPECT_THAT(chart.note, HasSubstr("contact force reaches 5 kN at 1 s"));
  const auto layers = Json::parse(chart.spec)["layer"];
  EXPECT_EQ(layers[2]["data"]["values"][0]["label"], "▲ 5 kN");
  EXPECT_THAT(layers[1]["transform"][1]["calculate"].get<std::string>(), HasSubstr("min(datum.value, "));
  EXPECT_EQ(chart.rows[1][1], 5.0) << "the value itself is there, for the pointer and for an enlarged chart";
}

}  // namespace
}  // namespace ricochet::report

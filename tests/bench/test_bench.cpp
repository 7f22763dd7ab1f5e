#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>

#include "tests/bench/table.hpp"
#include "tests/support/places.hpp"
#include "tests/support/process.hpp"
#include "tests/support/scene_file.hpp"

// The benchmarks measure what they say; how fast anything is, no test asks.

namespace ricochet::bench {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

TEST(Table, MedianAndPairedQuotients) {
  EXPECT_EQ(median({5.0, 1.0, 2.0}), 2.0);
  EXPECT_EQ(median({4.0, 1.0, 2.0, 9.0}), 3.0);
  EXPECT_THAT(quotients({1.0, 9.0}, {2.0, 3.0}), ElementsAre(0.5, 3.0));
  EXPECT_THROW(quotients({1.0, 9.0}, {2.0}), std::out_of_range) << "a repeat is missing";
}

TEST(Table, SaysWhetherALevelIsReached) {
  const std::vector<Row> rows = {{"a / b", "1 mm", {1.0, 3.0, 2.0}, Level{true, 2.0}},
                                 {"c / d", "1 mm", {1.0}, Level{false, 2.0}},
                                 {"e / f", "1 mm", {1.0}, {}},
                                 {"g / h", "1 mm", {}, {}, "g not installed"}};
  EXPECT_EQ(to_csv(rows),
            "ratio,at,median,min,max,repeats,wanted,verdict\n"
            "\"a / b\",1 mm,2,1,3,3,<= 2,reached\n\"c / d\",1 mm,1,1,1,1,>= 2,missed\n\"e / f\",1 mm,1,1,1,1,,\n"
            "\"g / h\",1 mm,,,,0,,g not installed\n");
  EXPECT_THAT(to_text(rows), HasSubstr("g not installed"));
  EXPECT_THAT(to_text(rows), HasSubstr(">= 2 missed"));
}

test::Outcome bench(std::vector<std::string> arguments, const test::TemporaryFolder& folder) {
  arguments.insert(arguments.begin(), {test::build_folder() + "/bench_scenes", "--out", folder.path().string()});
  return test::run_command(arguments, folder.path().string(), 300.0);
}

/// All but `memory`, `set-up` and `contact-windows`, which have one size and take a minute.
TEST(BenchScenes, EveryFigureOfAShortRunIsThereAndFinite) {
  const test::TemporaryFolder folder;
  const auto outcome =
      bench({"--repeats", "1", "--steps", "8", "--refinements", "2,1", "--only",
             "scenes,striker,contact,exchange,flood,checkpoint,threads,ranks,turning,tied,kernels,calculix"},
            folder);
  ASSERT_EQ(outcome.code, 0) << outcome.error;
  std::istringstream csv(test::file_text((folder.path() / "bench.csv").string()));
  std::set<std::string> names;
  std::string line;
  std::getline(csv, line);
  while (std::getline(csv, line)) {
    const auto end = line.find("\",");
    const auto value = line.find(',', end + 2) + 1;
    EXPECT_TRUE(names.insert(line.substr(0, value - 1)).second) << "twice: " << line;
    if (line.find("calculix-ccx not installed") != std::string::npos) continue;
    if (line.find("one processor") != std::string::npos) continue;
    const double ratio = std::stod(line.substr(value));
    EXPECT_TRUE(std::isfinite(ratio)) << line;
    EXPECT_TRUE(ratio > 0.0 || line.find(": error of") != std::string::npos) << line;
  }
  for (const char* name : {"\"hughes_liu / all_implicit\",0.5 mm",
                           "\"hughes_liu / all_explicit\",0.25 mm",
                           "\"hughes_liu, three processes / one\",0.25 mm",
                           "\"prakash_hjelmstad, m = 4: error of the impulse against all_implicit\",0.5 mm",
                           "\"hughes_liu: set-up / stepping through the whole scene\",0.25 mm",
                           "\"hughes_liu: growth of time per step from 0.5 mm / of unknowns\",0.25 mm",
                           "\"CalculiX / hughes_liu, first 8 steps, wall time of the whole command\",0.5 mm",
                           "\"rounded striker: prakash_hjelmstad, m = 16 / all_explicit, whole run\",18 um",
                           "\"rounded striker, all_implicit: error of the peak force\",18 um",
                           "\"exchange, shared memory / ping-pong of the same bytes\",10001 nodes",
                           "\"hughes_liu over tcp: its port flooded / another port flooded, stepping\",0.25 mm",
                           "\"hughes_liu: time with a checkpoint every 300 s / without\",0.25 mm",
                           "\"all_explicit: rows that waves have reached / all rows, carbide of 640 mm\",0.5 mm",
                           "\"all_implicit, stepping: one thread / two\",0.25 mm",
                           "\"all_explicit, stepping: one thread / two\",0.25 mm",
                           "\"discs, hughes_liu: large_rotation / without, stepping\",1000 rad/s",
                           "\"bar, one mesh and step / tied 4:1 by hughes_liu, stepping\",20 um",
                           "\"K u: element by element / explicit kernel\",0.25 mm",
                           "\"K u of solids: one thread / two\",0.5 mm",
                           "\"solve: one thread / two\",0.25 mm",
                           "\"condensed factor: solves per second / bound\",0.5 mm"}) {
    EXPECT_EQ(names.count(name), 1U) << name;
  }
}

TEST(BenchScenes, MeasuresWhatIsAskedForOnly) {
  const test::TemporaryFolder folder;
  const auto outcome = bench({"--repeats", "1", "--steps", "8", "--only", "calculix"}, folder);
  ASSERT_EQ(outcome.code, 0) << outcome.error;
  const auto table = test::file_text((folder.path() / "bench.csv").string());
  EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 1 + 2 * 3) << table;
  const bool installed = table.find("not installed") == std::string::npos;
  const auto histories = test::file_text((folder.path() / "calculix.csv").string());
  EXPECT_EQ(std::count(histories.begin(), histories.end(), '\n'), installed ? 1 + 8 : 0);
}

TEST(BenchScenes, RefusesWhatItCannotMeasure) {
  const test::TemporaryFolder folder;
  for (const auto& [option, value, complaint] : {std::tuple{"--steps", "10", "not a multiple of 4"},
                                                 {"--repeats", "0", "--repeats"},
                                                 {"--refinements", "3", "--refinements"},
                                                 {"--only", "nothing", "--only"}}) {
    const auto outcome = bench({option, value}, folder);
    EXPECT_EQ(outcome.code, 2);
    EXPECT_THAT(outcome.error, HasSubstr(complaint));
  }
}

}  // namespace
}  // namespace ricochet::bench

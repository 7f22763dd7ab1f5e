#include <gtest/gtest.h>

#include "coupler/results/history_file.hpp"
#include "coupler/watch/conserved.hpp"
#include "tests/support/merged_history.hpp"
#include "tests/support/run.hpp"

// The run of both solvers in one process, against which the benchmarks measure three, computes what three compute: the
// same text of history.csv, whose 17 digits tell every double from every other.

namespace ricochet {
namespace {

/// history.csv as the coupler would write it.
std::string history_in_one_process(const std::string& scene, const std::string& path) {
  test::OneProcess run(scene);
  coupler::History history = test::history_of(run);
  auto& links = run.coupling().links();
  {
    coupler::HistoryFile file(path, coupler::history_shape(run.problem()));
    run.run([&](std::int64_t) {
      for (std::size_t p = 0; p < links.size(); ++p) history.add(p, links[p].take_records());
      while (const auto row = history.next(run.problem().clock.size_s())) file.add(*row);
    });
  }
  return test::file_text(path);
}

/// The paper's impact on a coarser mesh: friction, contact from the first window on, coupling values made absolute
/// twice.
std::string impact(const std::string& protocol) {
  auto text = test::config_text("kim_impact");
  for (int body = 0; body < 2; ++body) text = test::replaced(text, "elements = [10, 160]", "elements = [3, 80]");
  text = test::with_key(text, "time", "step_s", "1e-7");
  text = test::with_key(text, "time", "end_s", "25e-6");
  text = test::with_key(text, "output", "fields_every", "0");
  return test::with_protocol(text, protocol);
}

void expect_same_numbers(const std::string& text) {
  const test::TemporaryFolder folder;
  const std::string scene = folder.write(text);
  const auto three = test::run_file(scene, folder);
  ASSERT_EQ(three.outcome.code, 0) << three.outcome.error;
  EXPECT_GT(three.mean("contact_pressure_mean_pa", 1e-6, 20e-6), 1e8) << "the bodies are to be in contact";
  EXPECT_LT(three.smallest("friction_force_n"), -100.0);
  const auto one = history_in_one_process(scene, (folder.path() / "one.csv").string());
  EXPECT_TRUE(one == test::file_text(three.folder + "/history.csv")) << "the histories differ";
}

TEST(OneProcess, HughesLiuGivesTheSameBitsAsThreeProcesses) { expect_same_numbers(impact("hughes_liu")); }

TEST(OneProcess, PrakashHjelmstadGivesTheSameBitsAsThreeProcesses) {
  expect_same_numbers(test::with_key(impact("prakash_hjelmstad"), "coupling", "substeps", "2"));
}

/// The plane that the striker flies off is a second contact; its columns travel, too.
TEST(OneProcess, OfTwoContactsGivesTheSameBitsAsThreeProcesses) {
  auto text = test::replaced(impact("hughes_liu"), "[contact]", "[[contact]]\nname = \"impact\"");
  text = test::replaced(text, "[partition]",
                        "[[contact]]\nname = \"wall\"\nsurfaces = [\"steel.start\", \"rigid_plane\"]\n"
                        "friction_coefficient = 0.5\n[partition]");
  expect_same_numbers(text);
}

}  // namespace
}  // namespace ricochet

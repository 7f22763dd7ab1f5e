// The explicit participant as several processes that OpenMPI starts: the bytes of one process without MPI.
#include <fmt/format.h>

#include <csignal>

#include "tests/support/process_table.hpp"
#include "tests/support/same_results.hpp"

namespace ricochet::test {
namespace {

using testing::HasSubstr;

/// The scene with its explicit participant in so many ranks; 0: without MPI.
std::string with_ranks(const std::string& text, int ranks, const std::string& more = "") {
  std::string bodies;
  const std::string key = "[[body]]\nname = ";
  for (auto at = text.find(key); at != std::string::npos; at = text.find(key, at + 1)) {
    const auto begin = at + key.size();
    bodies += (bodies.empty() ? "" : ", ") + text.substr(begin, text.find('\n', begin) - begin);
  }
  const std::string given = ranks > 0 ? fmt::format("ranks = {}\n", ranks) : "";
  return text + fmt::format(
                    "\n[[participant]]\nname = \"explicit\"\nrole = \"explicit\"\nbodies = [{}]\n{}{}"
                    "[[participant]]\nname = \"implicit\"\nrole = \"implicit\"\n",
                    bodies, given, more);
}

struct RankedRun {
  std::string name, text;
  std::vector<int> ranks{2, 7};
};

void PrintTo(const RankedRun& run, std::ostream* out) { *out << run.name; }

std::vector<RankedRun> ranked_runs() {
  std::vector<RankedRun> runs;
  for (const std::string protocol : {"hughes_liu", "prakash_hjelmstad", "all_explicit"}) {
    runs.push_back(
        {"cylinders_" + protocol, with_protocol_of_two_steps(config_text("kim_impact"), protocol), {1, 2, 3, 4, 7}});
    runs.push_back(
        {"slipping_" + protocol, with_key(with_protocol_of_two_steps(config_text("slipping_plates"), protocol),
                                          "output", "fields_every", "50")});
  }
  runs.push_back({"balls_of_tetrahedra", with_absolute_meshes(config_text("two_balls_solid"))});
  runs.push_back({"ball_of_hexahedra_on_plate",
                  with_key(with_absolute_meshes(config_text("ball_on_plate")), "time", "end_s", "2e-6"),
                  {3}});
  return runs;
}

class Ranks : public testing::TestWithParam<RankedRun> {};

TEST_P(Ranks, OfAnyNumberGiveTheSameBytes) {
  const TemporaryFolder folder;
  const RunResult one = run_text(with_ranks(GetParam().text, 0), folder);
  for (const int ranks : GetParam().ranks) {
    const TemporaryFolder other_folder;
    const RunResult many = run_text(with_ranks(GetParam().text, ranks), other_folder);
    expect_same_results(many.folder, one.folder, {"scene", "scene_sha256"});  // in which the numbers stand
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, Ranks, testing::ValuesIn(ranked_runs()),
                         [](const testing::TestParamInfo<RankedRun>& test) { return test.param.name; });

TEST(Rank, ThatWasSavedGoesOnToTheSameBytes) {
  const TemporaryFolder folder;
  const RunResult whole =
      run_text(with_key(with_ranks(config_text("kim_impact"), 3), "checkpoint", "every_windows", "400"), folder);
  (void)expect_the_same_from_the_earlier_checkpoint(whole, folder);
}

Outcome refused(const std::string& text, const TemporaryFolder& folder) {
  return run_file(folder.write(text), folder).outcome;
}

/// Started by hand it would have the number that somebody typed.
TEST(Rank, OfAnotherNumberThanTheScenesIsRefused) {
  const TemporaryFolder folder;
  const auto outcome =
      refused(with_ranks(config_text("two_bars"), 3,
                         "launch = [\"mpirun\", \"--allow-run-as-root\", \"--oversubscribe\", \"-n\", \"2\"]\n"),
              folder);
  EXPECT_EQ(outcome.code, 4) << outcome.error;
  EXPECT_THAT(outcome.error, HasSubstr("participant 'explicit' has ranks = 3, and 2 were started"));
}

TEST(Rank, IsForTheShippedExplicitSolver) {
  const TemporaryFolder folder;
  const std::string wrong[] = {
      replaced(with_ranks(config_text("two_bars"), 2), "ranks = 2", "ranks = 2\nexecutable = \"mine\""),
      replaced(with_ranks(config_text("two_bars"), 2), "ranks = 2", "ranks = 2\nstart = \"by_hand\""),
      with_ranks(config_text("two_bars"), 0) + "ranks = 2\n"};
  for (const auto& text : wrong) {
    const auto outcome = refused(text, folder);
    EXPECT_EQ(outcome.code, 2) << outcome.error;
    EXPECT_THAT(outcome.error, HasSubstr("ranks: found 2; allowed: only with role = \"explicit\", the shipped solver"));
  }
  const auto none = refused(replaced(with_ranks(config_text("two_bars"), 2), "ranks = 2", "ranks = 0"), folder);
  EXPECT_THAT(none.error, HasSubstr("ranks: found 0; allowed: an integer from 1 to 100000"));
}

}  // namespace
}  // namespace ricochet::test

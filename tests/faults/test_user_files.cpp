// Files of the user in the results folder: never removed, never written over, whatever the command.
#include "tests/faults/fault_run.hpp"

namespace ricochet::test {
namespace {

namespace fs = std::filesystem;

struct Command {
  const char* name;
  std::vector<std::string> words;   ///< behind `ricochet`; SCENE and STUDY stand for the files
  std::vector<std::string> writes;  ///< names that it needs in the folder
};

void PrintTo(const Command& command, std::ostream* out) { *out << command.name; }

const std::vector<Command> commands = {
    {"run",
     {"run", "SCENE", "--out", "."},
     {"history.csv", "summary.json", "trace.json", "logs/explicit.log", "report.html"}},
    {"stability",
     {"stability", "SCENE", "--sweep", "courant=0.5", "--out", "."},
     {"stability.csv", "stability.json", "stability.html", "variants/0001.toml", "logs/implicit.log"}},
    {"study", {"study", "STUDY", "--out", "."}, {"results.csv", "study.json", "report.html", "runs/draft.toml"}},
};

/// Of every kind that some command writes, under names that none of these takes.
const std::vector<std::string> foreign = {
    "mine/scene.toml",    "results_of_mine.csv", "charts/mine.svg", "logs/mine.log",
    "variants/mine.toml", "fields/mine.vtu",     "fields/mine.pvd", "notes.txt"};

class UserFiles : public testing::TestWithParam<Command> {
 protected:
  UserFiles() {
    for (const auto& name : foreign) write(name);
  }
  void write(const std::string& name) const {
    fs::create_directories((folder_.path() / name).parent_path());
    std::ofstream(folder_.path() / name) << "by the user";
  }
  [[nodiscard]] std::string text(const std::string& name) const { return file_text((folder_.path() / name).string()); }
  [[nodiscard]] Outcome run(const std::vector<std::string>& words) const {
    std::string line = "cd '" + folder_.path().string() + "' && '" + ricochet_binary() + "'";
    for (auto word : words) {
      if (word == "SCENE") word = scene_;
      if (word == "STUDY") word = study_;
      line += " '" + word + "'";
    }
    return run_command({"/bin/sh", "-c", line}, scratch_.path().string(), 120.0);
  }
  void expect_foreign_files() const {
    for (const auto& name : foreign) EXPECT_EQ(text(name), "by the user") << name;
    EXPECT_EQ(text("scene.toml"), file_text(scene_));
  }

  TemporaryFolder folder_, scratch_;
  std::string scene_ = folder_.write(bars(few_windows), "scene.toml");
  std::string study_ = folder_.write(
      "scene = \"scene.toml\"\nmethods = [\"hughes_liu\", \"kim\"]\nrepeats = 1\n"
      "[reference]\nexact = \"impedance_theory\"\n",
      "study.toml");
};

TEST_P(UserFiles, stay_as_they_are_in_the_results_folder) {
  for (int repeat = 0; repeat < 2; ++repeat) {
    const auto outcome = run(GetParam().words);
    EXPECT_EQ(outcome.code, 0) << outcome.error;
    expect_foreign_files();
  }
  const auto report = run({"report", "."});
  EXPECT_EQ(report.code, 0) << report.error;
  expect_foreign_files();
  EXPECT_EQ(run(GetParam().words).code, 0);
  expect_foreign_files();
}

TEST_P(UserFiles, under_a_name_that_is_needed_are_named_and_stay) {
  for (const auto& name : GetParam().writes) {
    write(name);
    const auto outcome = run(GetParam().words);
    EXPECT_EQ(outcome.code, 2) << name;
    EXPECT_THAT(outcome.error, HasSubstr(name + " is there already, and ricochet did not write it"));
    EXPECT_EQ(text(name), "by the user");
    expect_foreign_files();
    fs::remove(folder_.path() / name);
  }
}

INSTANTIATE_TEST_SUITE_P(Faults, UserFiles, testing::ValuesIn(commands),
                         [](const auto& test) { return test.param.name; });

/// A page of others in a results folder is neither run nor taken for ours.
TEST(CodeFromData, report_runs_no_program_that_lies_in_the_folder) {
  const TemporaryFolder folder;
  const std::string mark = folder.path().string() + "/mark";
  const std::string page =
      "<script type=\"application/json\" id=\"charts\">[]</script><script>/*! vega\n*/"
      "process.getBuiltinModule?.('fs').writeFileSync('" +
      mark +
      "', ''); "
      "require('fs').writeFileSync('" +
      mark + "', '')</script>";
  static_cast<void>(folder.write(page, "stability.html"));
  auto outcome = run_command({ricochet_binary(), "report", folder.path().string()}, folder.path().string(), 60.0);
  EXPECT_EQ(outcome.code, 2);
  EXPECT_EQ(file_text(folder.path().string() + "/stability.html"), page);
  const RunResult run = run_text(bars(few_windows), folder, "out");
  std::ofstream(run.folder + "/stability.html") << page;
  outcome = run_command({ricochet_binary(), "report", run.folder}, folder.path().string(), 60.0);
  EXPECT_EQ(outcome.code, 0) << outcome.error;
  EXPECT_FALSE(fs::exists(mark));
}

}  // namespace
}  // namespace ricochet::test

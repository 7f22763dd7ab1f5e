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

/// Files of every kind that some command writes, under names that none of these takes.
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

/// Scenes that lie in the folder into which their results go, as ricochet itself writes them, too.
class ScenesInResults : public testing::Test {
 protected:
  [[nodiscard]] Outcome ricochet(const std::vector<std::string>& words) const {
    std::vector<std::string> command = {ricochet_binary()};
    command.insert(command.end(), words.begin(), words.end());
    return run_command(command, scratch_.path().string(), 120.0);
  }
  /// Two bars whose step `ricochet run` chooses; it writes the scene that it comes to.
  [[nodiscard]] static std::string with_chosen_step() {
    const std::string text = bars(few_windows);
    const auto partition = text.find("[partition]"), time = text.find("[time]");
    return replaced(text.substr(0, partition) + "[partition]\nrule = \"auto\"\n" + text.substr(time), "step_s",
                    "largest_step_s");
  }
  const TemporaryFolder scratch_, folder_;
  const std::string out_ = folder_.path().string();
};

TEST_F(ScenesInResults, written_by_ricochet_are_run_and_stay) {
  const auto scene = scratch_.write(with_chosen_step());
  ASSERT_EQ(ricochet({"run", scene, "--out", out_}).code, 0);
  const auto written = out_ + "/scene/scene.toml", text = file_text(written);
  ASSERT_THAT(text, HasSubstr("step_s"));
  fs::create_symlink(written, scratch_.path() / "link.toml");
  for (const auto& path : {written, out_ + "/logs/../scene/scene.toml", (scratch_.path() / "link.toml").string()}) {
    const auto outcome = ricochet({"run", path, "--out", out_});
    EXPECT_EQ(outcome.code, 0) << outcome.error;
    EXPECT_EQ(file_text(written), text) << path;
  }
  const auto study = scratch_.write("scene = \"" + written +
                                        "\"\nmethods = [\"hughes_liu\"]\nrepeats = 1\n[reference]\nexact = "
                                        "\"impedance_theory\"\n",
                                    "study.toml");
  const auto outcome = ricochet({"study", study, "--out", out_});
  EXPECT_EQ(outcome.code, 0) << outcome.error;
  EXPECT_EQ(file_text(written), text);
  EXPECT_EQ(ricochet({"run", scene, "--out", out_}).code, 0) << "it still is one of ours for other scenes";
}

TEST_F(ScenesInResults, of_the_user_are_not_written_over) {
  fs::create_directories(folder_.path() / "scene");
  const auto scene = folder_.write(with_chosen_step(), "scene/mine.toml");  // where one of its name is to be written
  const auto outcome = ricochet({"run", scene, "--out", out_});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.error, HasSubstr(scene + " is read by this command, which would write a file of that name"));
  EXPECT_EQ(file_text(scene), with_chosen_step());
}

TEST_F(ScenesInResults, that_a_new_file_would_replace_are_named_and_stay) {
  const auto scene = scratch_.write(bars(few_windows));
  const std::vector<std::string> sweep = {"--sweep", "courant=0.5", "--out", out_};
  const auto stability = [&](const std::string& path) {
    std::vector<std::string> words = {"stability", path};
    words.insert(words.end(), sweep.begin(), sweep.end());
    return ricochet(words);
  };
  ASSERT_EQ(stability(scene).code, 0);
  const auto variant = out_ + "/variants/0001.toml", text = file_text(variant);
  ASSERT_FALSE(text.empty());
  const auto outcome = stability(variant);
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.error, HasSubstr(variant + " is read by this command"));
  EXPECT_EQ(file_text(variant), text);
  EXPECT_EQ(ricochet({"run", variant, "--out", out_}).code, 0);
  EXPECT_EQ(file_text(variant), text);
}

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

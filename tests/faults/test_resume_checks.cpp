// `ricochet resume` goes on from what was written, by the programs that began, and named by who may name it.
#include <fmt/format.h>
#include <sys/stat.h>

#include <functional>

#include "tests/faults/fault_run.hpp"
#include "tests/support/same_results.hpp"

namespace ricochet::test {
namespace {

namespace fs = std::filesystem;

void write_file(const std::string& path, const std::string& text) { std::ofstream(path, std::ios::binary) << text; }

/// A byte that every checkpoint needs is another one, the size is the same.
void flip_a_byte(const std::string& path) {
  auto bytes = file_text(path);
  bytes[bytes.size() / 4] ^= 1;
  write_file(path, bytes);
}

void change_manifests(const std::string& results, const std::function<std::string(const std::string&)>& change) {
  for (const int window : checkpoints_in(results)) {
    const auto path = fmt::format("{}/checkpoint/{}.json", results, window);
    write_file(path, change(file_text(path)));
  }
}

/// The value of a key becomes another one.
std::function<void(const std::string&)> with_manifest(const std::string& key, const std::string& value) {
  return [=](const std::string& results) {
    change_manifests(results, [&](const std::string& text) {
      const auto begin = text.find("\"" + key + "\": ") + key.size() + 4, end = text.find_first_of(",\n", begin);
      return text.substr(0, begin) + value + text.substr(end);
    });
  };
}

/// Something that happens to a folder between the kill and the resume.
struct Damage {
  const char* name;
  std::function<void(const std::string& results)> does;
  std::vector<std::string> words;
};

void PrintTo(const Damage& damage, std::ostream* out) { *out << damage.name; }

const std::vector<Damage> damages = {
    {"a_byte_of_the_history",
     [](const std::string& results) { flip_a_byte(results + "/history.csv"); },
     {"history.csv is not what was written"}},
    {"a_history_that_was_cut",
     [](const std::string& results) { fs::resize_file(results + "/history.csv", 1000); },
     {"history.csv has 1000 bytes, expected at least"}},
    {"another_history_of_the_same_size",
     [](const std::string& results) {
       const auto path = results + "/history.csv";
       write_file(path, std::string(fs::file_size(path), '0'));
     },
     {"history.csv is not what was written"}},
    {"a_byte_of_a_field",
     [](const std::string& results) { flip_a_byte(results + "/fields/explicit.left_00000020.vtu"); },
     {"fields/explicit.left_00000020.vtu is not what was written"}},
    {"a_field_that_is_missing",
     [](const std::string& results) { fs::remove(results + "/fields/implicit.left_00000040.vtu"); },
     {"fields/implicit.left_00000040.vtu is missing"}},
    {"the_list_of_fields",
     [](const std::string& results) { flip_a_byte(results + "/checkpoint/fields.sha256"); },
     {"checkpoint/fields.sha256 is not what was written"}},
    {"the_step_in_the_manifest", with_manifest("time_s", "2.5e-06"), {".json is not what was written"}},
    {"the_time_in_the_manifest", with_manifest("wall_s", "1e6"), {".json is not what was written"}},
    {"the_protocol_in_the_manifest", with_manifest("protocol", "\"kim\""), {".json is not what was written"}},
    {"the_scene_in_the_manifest", with_manifest("scene", "\"/tmp/other.toml\""), {".json is not what was written"}},
    {"a_manifest_under_another_window",
     [](const std::string& results) {
       for (const int window : checkpoints_in(results)) {
         for (const std::string part : {".json", ".state", ".explicit.state", ".implicit.state"}) {
           const auto path = fmt::format("{}/checkpoint/", results);
           fs::rename(path + std::to_string(window) + part, path + std::to_string(window + 1000) + part);
         }
       }
     },
     {".json is not what was written"}},
};

std::string with_all_kept(int every_windows = 50) {
  const std::string text =
      with_key(config_text("two_bars"), "checkpoint", "every_windows", std::to_string(every_windows));
  return with_key(text, "output", "fields_every", "20");
}

class DamagedResults : public testing::TestWithParam<Damage> {};

TEST_P(DamagedResults, are_named_and_nothing_goes_on_from_them) {
  const TemporaryFolder folder;
  const auto run = run_text(with_all_kept(), folder);
  GetParam().does(run.folder);
  const auto history = file_text(run.folder + "/history.csv");
  const auto outcome = resume(run.folder, folder);
  EXPECT_EQ(outcome.code, 2) << outcome.error;
  EXPECT_THAT(outcome.error, HasSubstr("has no checkpoint that is whole"));
  for (const auto& word : GetParam().words) EXPECT_THAT(outcome.error, HasSubstr(word));
  EXPECT_TRUE(file_text(run.folder + "/history.csv") == history) << "what was there is lost";
}

INSTANTIATE_TEST_SUITE_P(Faults, DamagedResults, testing::ValuesIn(damages),
                         [](const auto& test) { return test.param.name; });

/// Results damaged behind the checkpoint before are computed once more from there.
TEST(DamagedResults, BehindTheCheckpointBeforeAreComputedOnceMore) {
  const TemporaryFolder folder;
  const auto whole = run_text(with_all_kept(), folder, "whole");
  const auto out = (folder.path() / "out").string();
  fs::copy(whole.folder, out, fs::copy_options::recursive);
  auto history = file_text(out + "/history.csv");
  history[history.size() - 20] ^= 1;
  write_file(out + "/history.csv", history);
  const auto outcome = resume(out, folder);
  EXPECT_EQ(outcome.code, 0) << outcome.error;
  EXPECT_THAT(outcome.error, HasSubstr("warning: " + out + "/history.csv is not what was written"));
  expect_same_results(out, whole.folder);
}

/// Which fields were written, as whoever has only coreutils can check it.
TEST(DamagedResults, AreFoundBySha256sumToo) {
  const TemporaryFolder folder;
  const auto run = run_text(with_all_kept(), folder);
  const auto check = [&] {
    const std::string line = "cd '" + run.folder + "' && sha256sum --check --quiet checkpoint/fields.sha256";
    return run_command({"/bin/sh", "-c", line}, folder.path().string()).code;
  };
  EXPECT_EQ(check(), 0);
  const auto names = names_in(run.folder + "/fields");
  EXPECT_EQ(static_cast<std::ptrdiff_t>(lines_of(run.folder + "/checkpoint/fields.sha256").size()),
            std::count_if(names.begin(), names.end(), [](const auto& name) { return name.ends_with(".vtu"); }));
  flip_a_byte(run.folder + "/fields/explicit.left_00000020.vtu");
  EXPECT_NE(check(), 0);
}

/// An explicit solver of somebody else's, a script: stiffness times what stands in a file beside it.
class AnotherProgram : public testing::Test {
 protected:
  AnotherProgram() {
    write_script("");
    set_stiffness("1");
    scene_ = folder_.write(with_participants(with_key(apart(bars(windows)), "checkpoint", "every_windows", "500"),
                                             "explicit", "executable = \"./solver.sh\""));
  }
  void write_script(const std::string& line) const {
    const auto path = folder_.write("#!/bin/sh\n" + line + "\nexport WRONG_STIFFNESS=$(cat '" + path_of("stiffness") +
                                        "')\nexec '" + program("wrong_participant") + "' \"$@\"\n",
                                    "solver.sh");
    fs::permissions(path, fs::perms::owner_all);
  }
  void set_stiffness(const std::string& factor) const { write_file(path_of("stiffness"), factor); }
  [[nodiscard]] std::string path_of(const std::string& name) const { return (folder_.path() / name).string(); }
  /// By kill -9 of the coupler, once there is a checkpoint.
  void run_until_killed() const {
    Process run({ricochet_binary(), "run", scene_, "--out", out()}, path_of("o"), path_of("e"));
    ASSERT_TRUE(wait_until([&] { return !checkpoints_in(out()).empty() || !run.running(); }, 60.0));
    ASSERT_TRUE(run.running()) << file_text(path_of("e"));
    kill(run.pid(), SIGKILL);
    run.wait(10.0);
    ASSERT_TRUE(wait_until([&] { return processes_with("--scene " + scene_).empty(); }, 10.0));
  }
  [[nodiscard]] std::string out() const { return path_of("out"); }
  void expect_refused(const std::vector<std::string>& words) const {
    const auto outcome = resume(out(), folder_);
    EXPECT_EQ(outcome.code, 2) << outcome.error;
    EXPECT_THAT(outcome.error,
                HasSubstr("participant 'explicit': its program is another one than this run began with"));
    for (const auto& word : words) EXPECT_THAT(outcome.error, HasSubstr(word));
  }
  static constexpr int windows = all_windows;
  const TemporaryFolder folder_;
  std::string scene_;
};

TEST_F(AnotherProgram, OfAStiffnessThatIsHalfAPerMilleHigherDoesNotGoOn) {
  const auto whole = run_file(scene_, folder_, "whole");
  ASSERT_EQ(whole.outcome.code, 0) << whole.outcome.error;
  ASSERT_NO_FATAL_FAILURE(run_until_killed());
  set_stiffness("1.0005");
  expect_refused({"its answer to a change of its link input that was tried at the start, number 0 was ", ", it is "});
  set_stiffness("1");
  const auto outcome = resume(out(), folder_);
  EXPECT_EQ(outcome.code, 0) << outcome.error;
  expect_same_results(out(), whole.folder);
}

TEST_F(AnotherProgram, UnderTheSameNameDoesNotGoOn) {
  ASSERT_NO_FATAL_FAILURE(run_until_killed());
  write_script("# corrected");
  expect_refused({"the SHA-256 of " + path_of("solver.sh") + " was "});
}

/// A folder by somebody else, whose scene starts a program of theirs.
class NamedByTheFolder : public testing::Test {
 protected:
  NamedByTheFolder() {
    const auto path = folder_.write(
        "#!/bin/sh\necho started >> '" + mark() + "'\nexec '" + program("explicit_solver") + "' \"$@\"\n", "solver.sh");
    fs::permissions(path, fs::perms::owner_all);
    scene_ = folder_.write(with_participants(with_all_kept(), "explicit", "executable = \"./solver.sh\""));
  }
  [[nodiscard]] std::string mark() const { return (folder_.path() / "mark").string(); }
  [[nodiscard]] std::string out() const { return (folder_.path() / "out").string(); }
  [[nodiscard]] Outcome ricochet_as(const std::string& user, const std::vector<std::string>& words) const {
    std::vector<std::string> command = {"/usr/bin/env", "XDG_STATE_HOME=" + (folder_.path() / user).string(),
                                        ricochet_binary()};
    command.insert(command.end(), words.begin(), words.end());
    return run_command(command, folder_.path().string());
  }
  const TemporaryFolder folder_;
  std::string scene_;
};

TEST_F(NamedByTheFolder, ASceneIsStartedByWhoBeganItOrNamesIt) {
  ASSERT_EQ(ricochet_as("author", {"run", scene_, "--out", out()}).code, 0);
  fs::remove(mark());
  const auto unknown = ricochet_as("reader", {"resume", out()});
  EXPECT_EQ(unknown.code, 2);
  EXPECT_THAT(unknown.error, HasSubstr("names the scene " + scene_ + ", which starts explicit: "));
  EXPECT_THAT(unknown.error, HasSubstr((folder_.path() / "solver.sh").string()));
  EXPECT_THAT(unknown.error, HasSubstr("resume " + out() + " --scene " + scene_));
  EXPECT_FALSE(fs::exists(mark())) << "the program was started";
  const auto begun = ricochet_as("author", {"resume", out()});
  EXPECT_EQ(begun.code, 0) << begun.error;
  EXPECT_THAT(begun.error, HasSubstr("with the scene " + scene_ + "; explicit: "));
  EXPECT_TRUE(fs::exists(mark()));
}

TEST_F(NamedByTheFolder, WhoNamesTheSceneGoesOn) {
  ASSERT_EQ(ricochet_as("author", {"run", scene_, "--out", out()}).code, 0);
  const auto other = folder_.write(bars(few_windows), "other.toml");
  const auto wrong = ricochet_as("reader", {"resume", out(), "--scene", other});
  EXPECT_EQ(wrong.code, 2);
  EXPECT_THAT(wrong.error, HasSubstr(other + ": the scene or a mesh of it has changed since the checkpoint"));
  const auto named = ricochet_as("reader", {"resume", out(), "--scene", scene_});
  EXPECT_EQ(named.code, 0) << named.error;
}

/// The signature is of all that the manifest says: somebody else's does not lend it to another scene.
TEST_F(NamedByTheFolder, ASignatureHoldsForItsManifestAlone) {
  ASSERT_EQ(ricochet_as("author", {"run", scene_, "--out", out()}).code, 0);
  const auto signature = nlohmann::json::parse(
      file_text(fmt::format("{}/checkpoint/{}.json", out(), checkpoints_in(out()).back())))["signature"];
  ASSERT_EQ(ricochet_as("other", {"run", scene_, "--out", out()}).code, 0);
  change_manifests(out(), [&](const std::string& text) {
    auto json = nlohmann::ordered_json::parse(text);
    json["signature"] = signature;
    return json.dump(1);
  });
  EXPECT_EQ(ricochet_as("author", {"resume", out()}).code, 2);
}

TEST_F(NamedByTheFolder, AFifoInPlaceOfTheSceneIsNotWaitedFor) {
  ASSERT_EQ(ricochet_as("author", {"run", scene_, "--out", out()}).code, 0);
  fs::remove(scene_);
  ASSERT_EQ(mkfifo(scene_.c_str(), 0600), 0);
  const auto outcome = ricochet_as("author", {"resume", out()});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.error, HasSubstr(scene_ + ", the scene that the checkpoint names, is no file"));
}

}  // namespace
}  // namespace ricochet::test

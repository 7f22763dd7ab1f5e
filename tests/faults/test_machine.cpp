// Things that the machine lacks: files, disk, memory, standard files. Exit code 7 with the cause and the place.
#include "tests/faults/fault_run.hpp"

namespace ricochet::test {
namespace {

class Machine : public testing::Test {
 protected:
  /// The scene by `ricochet run`, in a shell that has done `before` to itself; `after` stands behind the command.
  Outcome run(const std::string& before, const std::string& scene_text, const std::string& after = "",
              double timeout_s = 60.0) {
    scene_ = folder_.write(scene_text);
    const std::string line =
        before + "exec '" + ricochet_binary() + "' run '" + scene_ + "' --out '" + out() + "' " + after;
    return run_command({"/bin/sh", "-c", line}, folder_.path().string(), timeout_s);
  }
  [[nodiscard]] std::string out() const { return folder_.path().string() + "/out"; }
  [[nodiscard]] nlohmann::json summary() const { return nlohmann::json::parse(file_text(out() + "/summary.json")); }
  void expect_no_halves() const {
    for (const auto& entry : std::filesystem::recursive_directory_iterator(out())) {
      EXPECT_NE(entry.path().extension(), ".part") << entry.path();
    }
    EXPECT_TRUE(wait_until([&] { return processes_with("--scene " + scene_).empty(); }, 5.0));
  }

  const TemporaryFolder folder_;
  std::string scene_;
};

TEST_F(Machine, too_few_file_descriptors) {
  const auto outcome = run("ulimit -n 10; ", bars(few_windows));
  EXPECT_EQ(outcome.code, 7);
  EXPECT_THAT(outcome.error, HasSubstr("may have 10 files open, it needs"));
}

TEST_F(Machine, a_low_soft_limit_of_file_descriptors_is_raised) {
  const auto outcome = run("ulimit -S -n 16; ", bars(few_windows));
  EXPECT_EQ(outcome.code, 0) << outcome.error;
}

TEST_F(Machine, closed_standard_files) {
  for (const std::string closed : {"<&-", ">&-", "2>&-", "<&- 2>&-", "<&- >&- 2>&-"}) {
    const auto outcome = run("", bars(few_windows), closed);
    EXPECT_EQ(outcome.code, 0) << closed;
    EXPECT_EQ(summary().at("status"), "done") << closed;
    const auto rows = lines_of(out() + "/history.csv");
    EXPECT_EQ(rows.size(), few_windows + 2U) << closed;
    for (const auto& row : rows)
      EXPECT_EQ(std::count(row.begin(), row.end(), ','), std::count(rows[0].begin(), rows[0].end(), ','));
  }
}

TEST_F(Machine, files_that_may_not_grow) {
  const auto outcome = run("ulimit -f 128; ", bars(few_windows));  // 128 blocks of 512 bytes
  EXPECT_EQ(outcome.code, 7) << outcome.error;
  EXPECT_THAT(outcome.error, HasSubstr("File too large (errno 27)"));
  EXPECT_THAT(outcome.error, HasSubstr(out()));
  EXPECT_EQ(summary().at("status"), "machine_failed");
  EXPECT_EQ(summary().at("exit_code"), 7);
  expect_no_halves();
}

/// A file system of its own, as far as this machine lets a user have one.
TEST_F(Machine, a_full_disk) {
  const std::string mount = "mount -t tmpfs -o size=200k none '" + out() + "'";
  std::filesystem::create_directories(out());
  if (run_command({"/bin/sh", "-c", "unshare -rm sh -c \"" + mount + "\""}, folder_.path().string()).code != 0) {
    GTEST_SKIP() << "no user namespaces here";
  }
  for (const std::string fields : {"0", "100"}) {
    const std::string scene = folder_.write(with_key(bars(few_windows), "output", "fields_every", fields));
    const std::string line = mount + " && { '" + ricochet_binary() + "' run '" + scene + "' --out '" + out() +
                             "'; code=$?; cat '" + out() + "/summary.json'; find '" + out() +
                             "' -name '*.part'; exit $code; }";
    const auto outcome = run_command({"/usr/bin/unshare", "-rm", "sh", "-c", line}, folder_.path().string());
    EXPECT_EQ(outcome.code, 7) << outcome.error;
    EXPECT_THAT(outcome.error, HasSubstr("No space left on device (errno 28)"));
    EXPECT_THAT(outcome.out, HasSubstr("\"status\": \"machine_failed\""));
    EXPECT_THAT(outcome.out, testing::Not(HasSubstr(".part")));
  }
}

/// Wherever it happens: at the history, the summary, a log.
TEST_F(Machine, a_disk_without_room_for_one_file_more) {
  std::filesystem::create_directories(out());
  const std::string scene = folder_.write(apart(bars(few_windows)));
  for (int files = 4; files < 10; ++files) {
    const std::string mount = "mount -t tmpfs -o nr_inodes=" + std::to_string(files) + " none '" + out() + "'";
    if (run_command({"/usr/bin/unshare", "-rm", "sh", "-c", mount}, folder_.path().string()).code != 0)
      GTEST_SKIP() << "no user namespaces here";
    const std::string line = mount + " && exec '" + ricochet_binary() + "' run '" + scene + "' --out '" + out() + "'";
    const auto outcome = run_command({"/usr/bin/unshare", "-rm", "sh", "-c", line}, folder_.path().string());
    EXPECT_EQ(outcome.code, 7) << files << ": " << outcome.error;
    EXPECT_THAT(outcome.error, HasSubstr("No space left on device (errno 28)")) << files;
  }
}

TEST_F(Machine, a_scene_that_needs_more_memory_than_there_is) {
  std::string text = config_text("kim_impact");
  for (int body = 0; body < 2; ++body) text = replaced(text, "elements = [10, 160]", "elements = [1000, 1000]");
  const auto outcome = run("ulimit -v 1000000; ", text, "", 10.0);
  EXPECT_EQ(outcome.code, 7) << outcome.error;
  EXPECT_THAT(outcome.error, HasSubstr("memory: about 4.2 GB needed, 1.0 GB available"));
}

/// The estimate by the number of nodes lets the scene pass; what it does not know of, the factor of many unknowns, then
/// takes more than a process may have.
TEST_F(Machine, a_participant_whose_memory_runs_out_is_named) {
  std::string text = config_text("kim_impact");
  for (int body = 0; body < 2; ++body) text = replaced(text, "elements = [10, 160]", "elements = [40, 640]");
  text = with_key(with_protocol(text, "all_implicit"), "time", "end_s", "5.4e-7");
  const auto refused = run("ulimit -v 100000; ", text);
  EXPECT_EQ(refused.code, 7) << refused.error;
  EXPECT_THAT(refused.error, HasSubstr("memory: about 129 MB needed, 103 MB available"));
  const auto outcome = run("ulimit -v 300000; ", text);
  EXPECT_EQ(outcome.code, 7) << outcome.error;
  EXPECT_THAT(outcome.error, HasSubstr("participant 'implicit' failed during start-up: out of memory"));
  EXPECT_EQ(summary().at("status"), "machine_failed");
  EXPECT_EQ(summary().at("exit_code"), 7);
  expect_no_halves();
}

/// An empty folder in place of /proc, for this command alone.
TEST_F(Machine, without_proc_the_run_says_what_it_needs) {
  const std::string hide = "mount -t tmpfs none /proc";
  if (run_command({"/usr/bin/unshare", "-m", "sh", "-c", hide}, folder_.path().string()).code != 0) {
    GTEST_SKIP() << "this user may not mount anything in a namespace of its own";
  }
  std::string own =
      with_participants(bars(few_windows), "explicit", "executable = \"" + program("explicit_solver") + "\"",
                        "executable = \"" + program("implicit_solver") + "\"");
  for (const auto& text : {bars(few_windows), own}) {
    const auto scene = folder_.write(text);
    for (const auto& command : {"check '" + scene + "'", "run '" + scene + "' --out '" + out() + "'"}) {
      const std::string line = hide + " && exec '" + ricochet_binary() + "' " + command;
      const auto outcome = run_command({"/usr/bin/unshare", "-m", "sh", "-c", line}, folder_.path().string(), 30.0);
      EXPECT_EQ(outcome.code, 7) << command << outcome.error;
      EXPECT_THAT(outcome.error, HasSubstr("No such file or directory (errno 2); ricochet needs /proc"));
      EXPECT_FALSE(std::filesystem::exists(out())) << "nothing was begun";
    }
  }
}

}  // namespace
}  // namespace ricochet::test

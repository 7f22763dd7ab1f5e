// Files of checkpoints: the manifest comes last, two are kept, what is damaged is named.
#include <gmock/gmock.h>
#include <sys/stat.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "common/base/error.hpp"
#include "common/base/sha256.hpp"
#include "coupler/results/checkpoint.hpp"
#include "coupler/results/field_digests.hpp"
#include "tests/support/places.hpp"
#include "tests/support/scene_file.hpp"

namespace ricochet::coupler {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class CheckpointFolderTest : public testing::Test {
 protected:
  static Checkpoint at(std::int64_t window) {
    Checkpoint checkpoint;
    checkpoint.scene_path = "/scene.toml";
    checkpoint.scene_sha256 = "5e";
    checkpoint.protocol = "kim";
    checkpoint.window = window;
    checkpoint.time_s = 2e-6;
    checkpoint.history = {4 * window, sha256_hex(history().substr(0, static_cast<std::size_t>(4 * window)))};
    checkpoint.probes = {2 * window, sha256_hex(std::string(static_cast<std::size_t>(2 * window), 'p'))};
    checkpoint.coupler = std::string("\0coupler", 8);
    checkpoint.parts = {{"a", "bytes of a"}, {"b", ""}};
    return checkpoint;
  }
  /// The history of the run: longer than what any of these checkpoints needs.
  static std::string history() { return std::string(500, 'h'); }
  void SetUp() override {
    write("history.csv", history());
    write("probes.csv", std::string(500, 'p'));
  }
  void write(const std::string& name, const std::string& text) const {
    std::filesystem::create_directories((temporary_.path() / name).parent_path());
    std::ofstream(temporary_.path() / name) << text;
  }
  [[nodiscard]] std::string manifest_of_7() const {
    std::ifstream read(file("7.json"));
    return {std::istreambuf_iterator<char>(read), {}};
  }
  [[nodiscard]] std::string file(const std::string& name) const { return folder_.path() + "/" + name; }
  std::optional<Checkpoint> last() {
    damaged_.clear();
    return folder_.last(damaged_);
  }

  test::TemporaryFolder temporary_;
  CheckpointFolder folder_{(temporary_.path() / "checkpoint").string()};
  std::vector<std::string> damaged_;
};

TEST_F(CheckpointFolderTest, IsPassedOverIfProbesAreNotWhatWasWritten) {
  folder_.write(at(3));
  folder_.write(at(7));
  write("probes.csv", std::string(10, 'p') + "x" + std::string(20, 'p'));
  const auto found = last();
  ASSERT_TRUE(found);
  EXPECT_EQ(found->window, 3);
  EXPECT_EQ(found->probes.bytes, 6);
  ASSERT_EQ(damaged_.size(), 1U);
  EXPECT_THAT(damaged_[0], HasSubstr("probes.csv is not what was written"));
}

TEST_F(CheckpointFolderTest, GivesBackTheLastOne) {
  EXPECT_FALSE(last());
  folder_.write(at(3));
  folder_.write(at(7));
  const auto found = last();
  ASSERT_TRUE(found);
  EXPECT_THAT(damaged_, IsEmpty());
  EXPECT_EQ(found->scene_path, "/scene.toml");
  EXPECT_EQ(found->scene_sha256, "5e");
  EXPECT_EQ(found->protocol, "kim");
  EXPECT_EQ(found->window, 7);
  EXPECT_EQ(found->time_s, 2e-6);
  EXPECT_EQ(found->history.bytes, 28);
  EXPECT_EQ(found->history.sha256, at(7).history.sha256);
  EXPECT_EQ(found->coupler, std::string("\0coupler", 8));
  ASSERT_EQ(found->parts.size(), 2U);
  EXPECT_EQ(found->parts[0].participant, "a");
  EXPECT_EQ(found->parts[0].bytes, "bytes of a");
  EXPECT_EQ(found->parts[1].bytes, "");
}

TEST_F(CheckpointFolderTest, KeepsTwo) {
  for (const int window : {9, 10, 11, 100}) folder_.write(at(window));
  EXPECT_THAT(folder_.windows(), ElementsAre(11, 100));
  std::size_t files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder_.path()))
    files += entry.is_regular_file() ? 1 : 0;
  EXPECT_EQ(files, 2U * 4U);
}

TEST_F(CheckpointFolderTest, WithoutAManifestThereIsNone) {
  folder_.write(at(3));
  folder_.write(at(7));
  std::filesystem::remove(file("7.json"));
  EXPECT_EQ(last()->window, 3);
  folder_.forget_after(3);
  EXPECT_FALSE(std::filesystem::exists(file("7.a.state"))) << "what has no manifest goes";
  EXPECT_EQ(last()->window, 3);
}

TEST_F(CheckpointFolderTest, PassesOverWhatIsDamagedAndNamesIt) {
  folder_.write(at(3));
  folder_.write(at(7));
  std::ofstream(file("7.a.state")) << "bytes of b";
  EXPECT_EQ(last()->window, 3);
  EXPECT_THAT(damaged_, ElementsAre(HasSubstr("7.a.state is not what was written")));
  std::ofstream(file("7.json")) << "{";
  EXPECT_EQ(last()->window, 3);
  EXPECT_THAT(damaged_, ElementsAre(HasSubstr("7.json is not a manifest of a checkpoint")));
  std::filesystem::remove(file("3.state"));
  EXPECT_FALSE(last());
  EXPECT_THAT(damaged_, ElementsAre(HasSubstr("7.json"), HasSubstr("3.state is missing")));
}

/// A number that is no count is not cast to one.
TEST_F(CheckpointFolderTest, RefusesCountsThatAreNone) {
  folder_.write(at(7));
  const auto manifest = manifest_of_7();
  const std::string key = "\"bytes\": ";  // of the history, which comes first
  const auto value = manifest.find(key) + key.size();
  for (const char* wrong : {"-1", "1.5", "1e22", "11844674407370955161500", "18446744073709551615", "true"}) {
    damaged_.clear();
    std::ofstream(file("7.json")) << manifest.substr(0, value) << wrong << manifest.substr(manifest.find(',', value));
    EXPECT_FALSE(last()) << wrong;
    EXPECT_THAT(damaged_, ElementsAre(HasSubstr("7.json says bytes = "))) << wrong;
  }
}

/// Whatever of it is changed, and whatever it is renamed to.
TEST_F(CheckpointFolderTest, AManifestHoldsForItself) {
  folder_.write(at(7));
  const auto manifest = manifest_of_7();
  for (const std::string key : {"scene_sha256", "protocol", "time_s", "wall_s", "stepping_s"}) {
    const auto value = manifest.find(':', manifest.find("\"" + key + "\"")) + 2, end = manifest.find(',', value);
    const bool text = manifest[value] == '"';
    std::ofstream(file("7.json")) << manifest.substr(0, value) << (text ? "\"other\"" : "0.25") << manifest.substr(end);
    EXPECT_FALSE(last()) << key;
    EXPECT_THAT(damaged_, ElementsAre(HasSubstr("7.json is not what was written"))) << key;
  }
  std::ofstream(file("7.json")) << manifest;
  EXPECT_TRUE(last());
  for (const std::string name : {"json", "state", "a.state", "b.state"})
    std::filesystem::rename(file("7." + name), file("8." + name));
  EXPECT_FALSE(last());
  EXPECT_THAT(damaged_, ElementsAre(HasSubstr("8.json is not what was written")));
}

/// Else the fuzzer of manifests would begin with refusals alone.
TEST_F(CheckpointFolderTest, TheSeedOfItsFuzzerIsWhole) {
  write("checkpoint/7.state", "abc");
  write("checkpoint/7.implicit.state", "abc");
  std::filesystem::copy(test::source_folder() + "/tests/fuzz/seeds/manifest/two_parts", file("7.json"));
  EXPECT_TRUE(last());
  EXPECT_THAT(damaged_, IsEmpty());
}

TEST_F(CheckpointFolderTest, OfAnotherHistoryIsPassedOver) {
  folder_.write(at(3));
  folder_.write(at(7));
  auto other = history();
  other[20] = 'x';  // of what 7 needs, and 3 does not
  write("history.csv", other);
  EXPECT_EQ(last()->window, 3);
  EXPECT_THAT(damaged_, ElementsAre(HasSubstr("history.csv is not what was written: its first 28 bytes")));
  write("history.csv", "short");
  EXPECT_FALSE(last());
  EXPECT_THAT(damaged_, ElementsAre(HasSubstr("history.csv has 5 bytes, expected at least 28"),
                                    HasSubstr("history.csv has 5 bytes, expected at least 12")));
}

/// Each field is read when the first checkpoint after it is made, and stands on the list in the order of the windows.
TEST_F(CheckpointFolderTest, HoldsForTheFieldsSoFar) {
  FieldDigests fields(temporary_.path().string(), {"a", "b"});
  const auto cut = [&](std::int64_t window) {
    auto checkpoint = at(window);
    checkpoint.fields = fields.take(window);
    folder_.write(checkpoint);
  };
  write("fields/b_00000000.vtu", "b at 0");
  write("fields/a_00000002.vtu", "a at 2");
  write("fields/a_00000005.vtu", "a at 5");
  write("fields/mine.vtu", "no field of a participant");
  cut(3);
  cut(7);
  std::ifstream list(file("fields.sha256"));
  std::vector<std::string> lines;
  for (std::string line; std::getline(list, line);) lines.push_back(line);
  EXPECT_THAT(lines, ElementsAre(sha256_hex("b at 0") + "  fields/b_00000000.vtu",
                                 sha256_hex("a at 2") + "  fields/a_00000002.vtu",
                                 sha256_hex("a at 5") + "  fields/a_00000005.vtu"));
  EXPECT_EQ(last()->window, 7);
  write("fields/a_00000005.vtu", "a at 6");
  EXPECT_EQ(last()->window, 3);
  EXPECT_THAT(damaged_, ElementsAre(HasSubstr("fields/a_00000005.vtu is not what was written")));
  std::filesystem::remove(temporary_.path() / "fields/b_00000000.vtu");
  EXPECT_FALSE(last());
  EXPECT_THAT(damaged_, ElementsAre(HasSubstr("b_00000000.vtu is missing"), HasSubstr("b_00000000.vtu is missing")));
}

/// A run that goes on adds to what the run before had listed up to its checkpoint.
TEST_F(CheckpointFolderTest, TheListOfFieldsGoesOnFromACheckpoint) {
  const auto results = temporary_.path().string();
  FieldDigests before(results, {"a"});
  write("fields/a_00000001.vtu", "1");
  write("fields/a_00000004.vtu", "4");
  const auto first = before.take(1), both = before.take(4);
  FieldDigests after(results, {"a"}, 1, first);
  EXPECT_EQ(after.take(3).sha256, first.sha256);
  EXPECT_EQ(after.take(4).sha256, both.sha256);
  FieldDigests::require(results, both);
  write("checkpoint/fields.sha256", "another list");
  EXPECT_THROW(FieldDigests(results, {"a"}, 1, first), ConfigError);
}

/// Without a key, and with that of another user, nothing shows who made it.
TEST_F(CheckpointFolderTest, KnowsWhetherThisUserMadeIt) {
  const auto with_state_in = [this](const std::string& folder) {
    setenv("XDG_STATE_HOME", (temporary_.path() / folder).c_str(), 1);
    return last()->by_this_user;
  };
  const char* state = std::getenv("XDG_STATE_HOME");
  const std::string before = state ? state : "";
  setenv("XDG_STATE_HOME", (temporary_.path() / "mine").c_str(), 1);
  folder_.write(at(3));
  EXPECT_TRUE(with_state_in("mine"));
  EXPECT_FALSE(with_state_in("another"));
  EXPECT_FALSE(with_state_in("history.csv")) << "which is no folder";
  std::filesystem::permissions(temporary_.path() / "mine/ricochet/key", std::filesystem::perms::all);
  EXPECT_FALSE(with_state_in("mine")) << "everybody can read this key";
  if (state) setenv("XDG_STATE_HOME", before.c_str(), 1);
  if (!state) unsetenv("XDG_STATE_HOME");
}

TEST_F(CheckpointFolderTest, WhatIsNoFileIsNotRead) {
  folder_.write(at(7));
  for (const std::string name : {"7.json", "7.a.state"}) {
    std::filesystem::rename(file(name), file("aside"));
    ASSERT_EQ(mkfifo(file(name).c_str(), 0600), 0);
    EXPECT_FALSE(last());
    EXPECT_THAT(damaged_, ElementsAre(HasSubstr(name + " is a FIFO, allowed is a regular file")));
    std::filesystem::remove(file(name));
    std::filesystem::create_symlink("/dev/zero", file(name));
    EXPECT_FALSE(last());
    EXPECT_THAT(damaged_, ElementsAre(HasSubstr(name + " is a device")));
    std::filesystem::remove(file(name));
    std::filesystem::rename(file("aside"), file(name));
  }
  EXPECT_TRUE(last());
}

TEST_F(CheckpointFolderTest, ForgetsWhatComesLater) {
  folder_.write(at(3));
  folder_.write(at(7));
  folder_.forget_after(5);
  EXPECT_THAT(folder_.windows(), ElementsAre(3));
  folder_.write(at(7));
  EXPECT_EQ(last()->window, 7);
}

/// A checkpoint that cannot be written leaves nothing, and the one before stays.
TEST_F(CheckpointFolderTest, OneThatFailsLeavesNothing) {
  folder_.write(at(3));
  std::filesystem::create_directories(file("7.b.state/somebody"));
  EXPECT_THROW(folder_.write(at(7)), Error);
  EXPECT_EQ(last()->window, 3);
  EXPECT_FALSE(std::filesystem::exists(file("7.a.state")));
}

}  // namespace
}  // namespace ricochet::coupler

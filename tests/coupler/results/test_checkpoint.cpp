// Files of checkpoints: the manifest comes last, two are kept, what is damaged is named.
#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "common/base/error.hpp"
#include "coupler/results/checkpoint.hpp"
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
    checkpoint.window_size_s = 1e-7;
    checkpoint.history_bytes = 1000 * window;
    checkpoint.coupler = std::string("\0coupler", 8);
    checkpoint.parts = {{"a", "bytes of a"}, {"b", ""}};
    return checkpoint;
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
  EXPECT_EQ(found->window_size_s, 1e-7);
  EXPECT_EQ(found->history_bytes, 7000);
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

/// What is no count is not cast to one.
TEST_F(CheckpointFolderTest, RefusesCountsThatAreNone) {
  folder_.write(at(7));
  std::ifstream before(file("7.json"));
  const std::string manifest{std::istreambuf_iterator<char>(before), {}};
  const std::string key = "\"history_bytes\": ";
  const auto value = manifest.find(key) + key.size();
  for (const char* wrong : {"-1", "1.5", "1e22", "11844674407370955161500", "18446744073709551615", "true"}) {
    damaged_.clear();
    std::ofstream(file("7.json")) << manifest.substr(0, value) << wrong << manifest.substr(manifest.find(',', value));
    EXPECT_FALSE(last()) << wrong;
    EXPECT_THAT(damaged_, ElementsAre(HasSubstr("7.json says history_bytes = "))) << wrong;
  }
}

TEST_F(CheckpointFolderTest, ForgetsWhatComesLater) {
  folder_.write(at(3));
  folder_.write(at(7));
  folder_.forget_after(5);
  EXPECT_THAT(folder_.windows(), ElementsAre(3));
  folder_.write(at(7));
  EXPECT_EQ(last()->window, 7);
}

/// What cannot be written leaves nothing, and the one before stays.
TEST_F(CheckpointFolderTest, OneThatFailsLeavesNothing) {
  folder_.write(at(3));
  std::filesystem::create_directories(file("7.b.state/somebody"));
  EXPECT_THROW(folder_.write(at(7)), Error);
  EXPECT_EQ(last()->window, 3);
  EXPECT_FALSE(std::filesystem::exists(file("7.a.state")));
}

}  // namespace
}  // namespace ricochet::coupler

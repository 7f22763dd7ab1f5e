#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>

// The table of rooms and who may include whom (docs/contributing.md, "Rooms"), checked against the #include lines.

namespace {

namespace fs = std::filesystem;

const std::map<std::string, std::set<std::string>>& allowed() {
  static const std::map<std::string, std::set<std::string>> table = {
      {"common/base", {}},
      {"common/fem", {"common/base"}},
      {"common/wire", {"common/base"}},
      {"common/scene", {"common/base", "common/fem"}},
      {"common/participant", {"common/wire", "common/base"}},
      {"common/solver", {"common/fem", "common/scene", "common/participant", "common/base"}},
      {"explicit_solver", {"common/solver", "common/fem", "common/scene", "common/participant", "common/base"}},
      {"implicit_solver/contact", {"common/solver", "common/fem", "common/scene", "common/base"}},
      {"implicit_solver",
       {"implicit_solver/contact", "common/solver", "common/fem", "common/scene", "common/participant", "common/base"}},
      {"coupler/protocols", {"common/wire", "common/base"}},
      {"coupler/report", {"common/base"}},
      {"coupler/stability", {"coupler/protocols", "common/base"}},
      {"coupler", {"coupler/protocols", "coupler/stability", "coupler/report", "common/wire", "common/scene", "common/base"}},
  };
  return table;
}

/// Longest room name that `path` (relative to the root) begins with; empty if none.
std::string room_of(const std::string& path) {
  std::string best;
  for (const auto& [room, unused] : allowed()) {
    if (path.rfind(room + "/", 0) == 0 && room.size() > best.size()) best = room;
  }
  return best;
}

struct Include {
  std::string file, target;
};

std::vector<Include> project_includes() {
  std::vector<Include> includes;
  const fs::path root = RICOCHET_SOURCE;
  const std::regex line_pattern("^\\s*#\\s*include\\s+\"([^\"]+)\"");
  for (const char* top : {"common", "explicit_solver", "implicit_solver", "coupler"}) {
    for (const auto& entry : fs::recursive_directory_iterator(root / top)) {
      const auto extension = entry.path().extension();
      if (extension != ".hpp" && extension != ".cpp") continue;
      std::ifstream file(entry.path());
      for (std::string line; std::getline(file, line);) {
        std::smatch match;
        if (std::regex_search(line, match, line_pattern)) {
          includes.push_back({fs::relative(entry.path(), root).string(), match[1]});
        }
      }
    }
  }
  return includes;
}

TEST(Architecture, EveryIncludeStaysWithinTheTableOfRooms) {
  const auto includes = project_includes();
  ASSERT_GT(includes.size(), 100U) << "the scan found too few includes to be believed";
  for (const auto& [file, target] : includes) {
    const std::string from = room_of(file), to = room_of(target);
    ASSERT_FALSE(from.empty()) << file << " lies in no room of the table";
    ASSERT_FALSE(to.empty()) << file << " includes \"" << target << "\", which is no path from the root into a room";
    if (from == to) continue;
    EXPECT_THAT(allowed().at(from), testing::Contains(to)) << file << " includes \"" << target << '"';
  }
}

TEST(Architecture, RoomsDoNotIncludeEachOtherInACycle) {
  for (const auto& [room, targets] : allowed()) {
    for (const auto& target : targets) {
      EXPECT_THAT(allowed().at(target), testing::Not(testing::Contains(room))) << room << " <-> " << target;
    }
  }
}

TEST(Architecture, TheCouplerKnowsNoElements) {
  for (const auto& [file, target] : project_includes()) {
    if (file.rfind("coupler/", 0) != 0) continue;
    EXPECT_NE(room_of(target), "common/fem") << file;
  }
}

TEST(Architecture, ParticipantHeaderNeedsNeitherEigenNorFiniteElements) {
  std::ifstream file(std::string(RICOCHET_SOURCE) + "/common/participant/participant.hpp");
  const std::string text((std::istreambuf_iterator<char>(file)), {});
  ASSERT_FALSE(text.empty());
  EXPECT_EQ(text.find("Eigen/"), std::string::npos);
  EXPECT_EQ(text.find("common/fem"), std::string::npos);
}

TEST(Architecture, TheTableOfRoomsForContributorsIsThisTable) {
  std::ifstream file(std::string(RICOCHET_SOURCE) + "/docs/contributing.md");
  const std::regex row("^\\| `([a-z_/]+)` \\| [^|]* \\| ([^|]*) \\|$");
  int rows = 0;
  for (std::string line; std::getline(file, line);) {
    std::smatch match;
    if (!std::regex_match(line, match, row) || !allowed().count(match[1])) continue;
    ++rows;
    std::set<std::string> named;
    std::string word;
    for (std::istringstream words(match[2]); std::getline(words >> std::ws, word, ',');) named.insert(word);
    std::set<std::string> expected;
    for (const auto& target : allowed().at(match[1])) {
      const bool own_sub_room = target.rfind(match[1].str() + "/", 0) == 0;
      if (!own_sub_room) expected.insert(target.rfind("common/", 0) == 0 ? target.substr(7) : target);
    }
    if (expected.empty()) expected.insert("\u2013 ");
    for (const auto& room : expected) EXPECT_TRUE(named.count(room) || room == "\u2013 ") << match[1] << " may include " << room;
    for (const auto& room : named) EXPECT_TRUE(expected.count(room) || room == "\u2013") << match[1] << ": docs/contributing.md says " << room;
  }
  EXPECT_EQ(rows, 9);
}

TEST(Architecture, TheReadmeMapsEveryFloor) {
  std::ifstream file(std::string(RICOCHET_SOURCE) + "/README.md");
  const std::regex row("^\\| `([a-z_/]+)` \\| [^|]* \\|$");
  std::set<std::string> mapped;
  for (std::string line; std::getline(file, line);) {
    std::smatch match;
    if (std::regex_match(line, match, row) && fs::is_directory(fs::path(RICOCHET_SOURCE) / match[1].str())) mapped.insert(match[1]);
  }
  for (const auto& [room, unused] : allowed()) {
    const std::string floor = room.rfind("common/", 0) == 0 ? room : room.substr(0, room.find('/'));
    EXPECT_TRUE(mapped.count(floor)) << room;
  }
}

TEST(Architecture, TopLevelHoldsWhatTheReadmeMaps) {
  const std::set<std::string> expected = {"CMakeLists.txt", "README.md", "LICENSE", "CHANGELOG.md", "ricochet", "docs",
                                          "common", "explicit_solver", "implicit_solver", "coupler", "tests", "configs"};
  for (const auto& entry : fs::directory_iterator(RICOCHET_SOURCE)) {
    const std::string name = entry.path().filename().string();
    if (name[0] == '.' || name.rfind("build", 0) == 0 || name == "out") continue;
    EXPECT_TRUE(expected.count(name)) << name << " does not belong to the top level";
  }
}

}  // namespace

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>

#include "tests/support/places.hpp"

// The table of docs/rooms.md against the folders of the tree and their #include lines.

namespace {

namespace fs = std::filesystem;

struct Room {
  std::set<std::string> may_include, reaches_never;
};
using Rooms = std::map<std::string, Room>;

std::set<std::string> rooms_named_in(const std::string& cell) {
  std::set<std::string> names;
  const std::regex name("`([a-z_/]+)`");
  for (std::sregex_iterator match(cell.begin(), cell.end(), name), end; match != end; ++match)
    names.insert((*match)[1]);
  return names;
}

const Rooms& table() {
  static const Rooms rooms = [] {
    Rooms read;
    std::ifstream file(ricochet::test::source_folder() + "/docs/rooms.md");
    const std::regex row("^\\| `([a-z_/]+)` \\| [^|]+ \\| ([^|]+) \\| ([^|]+) \\|$");
    for (std::string line; std::getline(file, line);) {
      std::smatch match;
      if (std::regex_match(line, match, row)) read[match[1]] = {rooms_named_in(match[2]), rooms_named_in(match[3])};
    }
    return read;
  }();
  return rooms;
}

struct Include {
  std::string file, target;
};

std::vector<Include> project_includes() {
  std::vector<Include> includes;
  const fs::path root = ricochet::test::source_folder();
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

std::string room_of(const std::string& file) { return fs::path(file).parent_path().string(); }

std::set<std::string> rooms_of_the_tree() {
  std::set<std::string> rooms;
  for (const auto& [file, target] : project_includes()) rooms.insert({room_of(file), room_of(target)});
  return rooms;
}

/// All rooms that a room reaches through the arrows of the table; itself only if they lead back.
std::set<std::string> reached_from(const std::string& room) {
  std::set<std::string> reached;
  std::vector<std::string> open(table().at(room).may_include.begin(), table().at(room).may_include.end());
  while (!open.empty()) {
    const std::string next = open.back();
    open.pop_back();
    if (!table().count(next) || !reached.insert(next).second) continue;
    open.insert(open.end(), table().at(next).may_include.begin(), table().at(next).may_include.end());
  }
  return reached;
}

TEST(Architecture, EveryFolderWithSourcesIsARoomOfTheTableAndEveryRoomAFolder) {
  std::set<std::string> named;
  for (const auto& [room, unused] : table()) named.insert(room);
  EXPECT_EQ(named, rooms_of_the_tree());
  for (const auto& [room, arrows] : table()) {
    for (const auto& target : arrows.may_include) EXPECT_TRUE(named.count(target)) << room << " may include " << target;
    for (const auto& target : arrows.reaches_never)
      EXPECT_TRUE(named.count(target)) << room << " never reaches " << target;
  }
}

TEST(Architecture, EveryIncludeStaysWithinTheTableOfRooms) {
  const auto includes = project_includes();
  ASSERT_GT(includes.size(), 100U) << "the scan found too few includes to be believed";
  for (const auto& [file, target] : includes) {
    const std::string from = room_of(file), to = room_of(target);
    ASSERT_TRUE(table().count(to)) << file << " includes \"" << target
                                   << "\", which is no path from the root into a room";
    if (from == to) continue;
    EXPECT_THAT(table().at(from).may_include, testing::Contains(to)) << file << " includes \"" << target << '"';
  }
}

TEST(Architecture, NoArrowIsWithoutAnInclude) {
  std::map<std::string, std::set<std::string>> used;
  for (const auto& [file, target] : project_includes()) used[room_of(file)].insert(room_of(target));
  for (const auto& [room, arrows] : table()) {
    for (const auto& target : arrows.may_include)
      EXPECT_TRUE(used[room].count(target)) << room << " includes nothing of " << target;
  }
}

TEST(Architecture, NoArrowLeadsBackAndNoneToWhatARoomMustNotKnow) {
  ASSERT_GT(table().size(), 20U) << "the table of docs/rooms.md was not read";
  for (const auto& [room, arrows] : table()) {
    const auto reached = reached_from(room);
    EXPECT_FALSE(reached.count(room)) << room << " reaches itself";
    for (const auto& forbidden : arrows.reaches_never)
      EXPECT_FALSE(reached.count(forbidden)) << room << " reaches " << forbidden;
  }
}

TEST(Architecture, TheCouplerIncludesNoElements) {
  for (const auto& [file, target] : project_includes()) {
    if (file.rfind("coupler/", 0) == 0) {
      EXPECT_NE(room_of(target), "common/fem") << file;
    }
  }
}

TEST(Architecture, ParticipantHeaderNeedsNeitherEigenNorFiniteElements) {
  std::ifstream file(ricochet::test::source_folder() + "/common/participant/participant.hpp");
  const std::string text((std::istreambuf_iterator<char>(file)), {});
  ASSERT_FALSE(text.empty());
  EXPECT_EQ(text.find("Eigen/"), std::string::npos);
  EXPECT_EQ(text.find("common/fem"), std::string::npos);
}

TEST(Architecture, NoFileHasMoreThan350Lines) {
  for (const char* top : {"common", "explicit_solver", "implicit_solver", "coupler"}) {
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(ricochet::test::source_folder()) / top)) {
      const auto extension = entry.path().extension();
      if (extension != ".hpp" && extension != ".cpp") continue;
      std::ifstream file(entry.path());
      int lines = 0;
      for (std::string line; std::getline(file, line);) ++lines;
      EXPECT_LE(lines, 350) << entry.path();
    }
  }
}

TEST(Architecture, TheReadmeMapsEveryFloor) {
  std::ifstream file(ricochet::test::source_folder() + "/README.md");
  const std::regex row("^\\| `([a-z_/]+)` \\| [^|]* \\|$");
  std::set<std::string> mapped;
  for (std::string line; std::getline(file, line);) {
    std::smatch match;
    if (std::regex_match(line, match, row)) mapped.insert(match[1]);
  }
  for (const auto& [room, unused] : table()) {
    const auto first = room.find('/'), end = room.rfind("common/", 0) == 0 ? room.find('/', first + 1) : first;
    const std::string floor = room.substr(0, end);
    EXPECT_TRUE(mapped.count(floor)) << room;
  }
}

TEST(Architecture, TopLevelHoldsWhatTheReadmeMaps) {
  const std::set<std::string> expected = {"CMakeLists.txt",  "README.md", "LICENSE", "CHANGELOG.md",
                                          "ricochet",        "docs",      "common",  "explicit_solver",
                                          "implicit_solver", "coupler",   "tests",   "configs"};
  for (const auto& entry : fs::directory_iterator(ricochet::test::source_folder())) {
    const std::string name = entry.path().filename().string();
    if (name[0] == '.' || name.rfind("build", 0) == 0 || name == "out") continue;
    EXPECT_TRUE(expected.count(name)) << name << " does not belong to the top level";
  }
}

}  // namespace

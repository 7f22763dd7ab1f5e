#include "tests/support/page.hpp"

#include <filesystem>
#include <regex>
#include <sstream>

#include "tests/support/places.hpp"
#include "tests/support/process.hpp"

namespace ricochet::test {

std::vector<std::string> pages() {
  std::vector<std::string> names = {"README.md", "CHANGELOG.md"};
  for (const auto& entry : std::filesystem::directory_iterator(source_folder() + "/docs")) {
    if (entry.path().extension() == ".md") names.push_back(std::filesystem::path("docs") / entry.path().filename());
  }
  return names;
}

std::string page_text(const std::string& name) { return file_text(std::filesystem::path(source_folder()) / name); }

std::set<std::string> all_tests() {
  std::set<std::string> names;
  const std::regex test("TEST(?:_P|_F)?\\((\\w+), (\\w+)\\)");
  for (const auto& entry : std::filesystem::recursive_directory_iterator(source_folder() + "/tests")) {
    if (entry.path().extension() != ".cpp") continue;
    const std::string text = file_text(entry.path().string());
    for (std::sregex_iterator it(text.begin(), text.end(), test), end; it != end; ++it)
      names.insert((*it)[1].str() + "." + (*it)[2].str());
  }
  return names;
}

std::vector<Block> blocks_of(const std::string& page) {
  std::vector<Block> blocks;
  std::istringstream lines(page);
  bool inside = false;
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind("```", 0) != 0) {
      if (inside) blocks.back().text += line + "\n";
      continue;
    }
    inside = !inside;
    if (inside) blocks.push_back({line.substr(3), ""});
  }
  return blocks;
}

}  // namespace ricochet::test

#pragma once

#include <set>
#include <string>
#include <vector>

/// Pages of the documentation as the tests read them.
namespace ricochet::test {

/// README.md and everything in docs/, relative to the root.
std::vector<std::string> pages();

std::string page_text(const std::string& name);

/// "Suite.Name" of every test under tests/.
std::set<std::string> all_tests();

/// A fenced block; `language` is what stands behind its opening fence.
struct Block {
  std::string language, text;
};

std::vector<Block> blocks_of(const std::string& page);

}  // namespace ricochet::test

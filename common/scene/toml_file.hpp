#pragma once

#include <map>
#include <stdexcept>
#include <string>
#include <toml.hpp>
#include <vector>

namespace ricochet::scene {

/// The parser takes the last element of an array where a key goes on behind its name, `t = []` and then `t.x = 1`, and
/// does not ask whether there is one (toml11 3.7).
template <class Element>
class TomlArray : public std::vector<Element> {
 public:
  using std::vector<Element>::vector;
  [[nodiscard]] Element& back() {
    if (this->empty())
      throw std::out_of_range("found a key of an array without elements, as t.x after t = []; allowed: of a table");
    return std::vector<Element>::back();
  }
};
/// In the order of the keys, so that a file that was changed has the same text whichever key was changed first.
using Toml = toml::basic_value<toml::discard_comments, std::map, TomlArray>;

/// The bytes of a file. Throws ConfigError if it cannot be read.
[[nodiscard]] std::string read_text(const std::string& path);
/// False, too, for a name that no file can have, or in a folder that may not be looked into.
[[nodiscard]] bool is_file(const std::string& path);

/// The text of a scene or study file as TOML 1.0; `path` is for messages. Throws ConfigError naming file and line, also
/// for what `check_text` refuses. The only place that instantiates the parser: it takes the compiler ten seconds.
[[nodiscard]] Toml parse_toml(const std::string& path, const std::string& text);

}  // namespace ricochet::scene

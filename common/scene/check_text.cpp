#include "common/scene/check_text.hpp"

#include <fmt/format.h>

#include <string_view>

#include "common/base/error.hpp"

namespace ricochet::scene {
namespace {

/// End of what stands in quotation marks from `begin` on, behind the closing ones.
std::size_t end_of_string(std::string_view text, std::size_t begin) {
  const char mark = text[begin];
  const std::string triple(3, mark);
  const bool several_lines = text.substr(begin, 3) == triple;
  for (std::size_t i = begin + (several_lines ? 3 : 1); i < text.size(); ++i) {
    if (mark == '"' && text[i] == '\\') {
      ++i;
    } else if (several_lines ? text.substr(i, 3) == triple : text[i] == mark) {
      return i + (several_lines ? 3 : 1);
    } else if (!several_lines && text[i] == '\n') {
      return i;  // never closed, which the parser will say
    }
  }
  return text.size();
}

/// Reads a text as TOML just far enough to count.
class Counter {
 public:
  explicit Counter(const std::string& path) : path_(path) {}
  void read(std::string_view text) {
    for (std::size_t i = 0; i < text.size(); ++i) {
      const char c = text[i];
      if (c == '#') {
        i = std::min(text.find('\n', i), text.size()) - 1;
      } else if (c == '"' || c == '\'') {
        const auto end = end_of_string(text, i);
        for (const char inside : text.substr(i, end - i)) line_ += inside == '\n' ? 1 : 0;
        i = end - 1;
      } else {
        count(c);
      }
    }
  }

 private:
  void count(char c) {
    if (c == '\n') ++line_;
    if (c == '[' || c == '{') ++depth_;
    if ((c == ']' || c == '}') && depth_ > 0) --depth_;
    if (c == '.') ++dots_;
    if (c == '\n' || c == '=' || c == ',' || c == '[' || c == '{') dots_ = 0;
    if (depth_ > deepest_nesting) refuse("brackets nested", depth_, deepest_nesting);
    if (dots_ >= most_key_parts) refuse("parts of a key", dots_ + 1, most_key_parts);
  }
  [[noreturn]] void refuse(const char* what, int found, int allowed) const {
    throw ConfigError(
        fmt::format("{}:{}: {}: found {} or more, allowed: at most {}", path_, line_, what, found, allowed));
  }

  const std::string& path_;
  int line_ = 1, depth_ = 0, dots_ = 0;
};

}  // namespace

void check_text(const std::string& path, const std::string& text) {
  if (text.size() > most_bytes) {
    throw ConfigError(fmt::format("{}: found a file of {} bytes, allowed: at most {}", path, text.size(), most_bytes));
  }
  Counter(path).read(text);
}

}  // namespace ricochet::scene

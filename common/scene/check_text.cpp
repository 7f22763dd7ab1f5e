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

/// Bytes of the character at the beginning, as UTF-8 has it: no longer than needed, no half of a pair, none beyond
/// U+10FFFF; 0 if it is none.
std::size_t size_of_character(std::string_view text) {
  const auto byte = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0U; };
  const unsigned first = byte(0), second = byte(1);
  const std::size_t size = first < 0x80   ? 1
                           : first < 0xc2 ? 0
                           : first < 0xe0 ? 2
                           : first < 0xf0 ? 3
                           : first < 0xf5 ? 4
                                          : 0;
  for (std::size_t i = 1; i < size; ++i) {
    if ((byte(i) & 0xc0U) != 0x80) return 0;
  }
  const bool longer_than_needed = (first == 0xe0 && second < 0xa0) || (first == 0xf0 && second < 0x90);
  const bool half_of_a_pair = first == 0xed && second >= 0xa0;
  const bool beyond = first == 0xf4 && second >= 0x90;
  return longer_than_needed || half_of_a_pair || beyond ? 0 : size;
}

/// TOML is UTF-8. The parser would say so, too, but reads beyond its memory while it does (toml11 3.7).
void require_utf8(const std::string& path, std::string_view text) {
  int line = 1;
  for (std::size_t i = 0, size = 0; i < text.size(); i += size) {
    size = size_of_character(text.substr(i));
    if (size == 0) {
      throw ConfigError(fmt::format("{}:{}: found the byte {:#04x}, which is no UTF-8 there; allowed: a text in UTF-8",
                                    path, line, static_cast<unsigned char>(text[i])));
    }
    line += text[i] == '\n' ? 1 : 0;
  }
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
    if (c == 'b' && last_ == '0') {
      binary_digits_ = 0;
    } else {
      binary_digits_ = binary_digits_ >= 0 && (c == '0' || c == '1' || c == '_') ? binary_digits_ + 1 : -1;
    }
    last_ = c;
    if (depth_ > deepest_nesting) refuse("brackets nested", depth_, deepest_nesting);
    if (dots_ >= most_key_parts) refuse("parts of a key", dots_ + 1, most_key_parts);
    if (binary_digits_ > most_binary_digits) refuse("digits of a binary number", binary_digits_, most_binary_digits);
  }
  [[noreturn]] void refuse(const char* what, int found, int allowed) const {
    throw ConfigError(
        fmt::format("{}:{}: {}: found {} or more, allowed: at most {}", path_, line_, what, found, allowed));
  }

  const std::string& path_;
  int line_ = 1, depth_ = 0, dots_ = 0;
  int binary_digits_ = -1;  // since 0b; -1: behind no such
  char last_ = '\n';
};

}  // namespace

void check_text(const std::string& path, const std::string& text) {
  if (text.size() > most_bytes) {
    throw ConfigError(fmt::format("{}: found a file of {} bytes, allowed: at most {}", path, text.size(), most_bytes));
  }
  require_utf8(path, text);
  Counter(path).read(text);
}

}  // namespace ricochet::scene

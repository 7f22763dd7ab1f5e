#include "coupler/report/parts/text.hpp"

#include <algorithm>
#include <cctype>
#include <stdexcept>

#include "common/base/process.hpp"

namespace ricochet::report {
namespace {

std::string fill(std::string_view text, std::string_view open, std::string_view close,
                 const std::map<std::string, std::string>& values) {
  std::string filled;
  for (;;) {
    const auto begin = text.find(open);
    filled += text.substr(0, begin);
    if (begin == std::string_view::npos) return filled;
    text.remove_prefix(begin + open.size());
    const auto end = text.find(close);
    const std::string key(text.substr(0, end));
    const auto value = values.find(key);
    if (end == std::string_view::npos || value == values.end()) throw std::logic_error("template: no value for " + key);
    filled += value->second;
    text.remove_prefix(end + close.size());
  }
}

bool begins_with(std::string_view text, std::string_view lower_case) {
  return text.size() >= lower_case.size() &&
         std::equal(lower_case.begin(), lower_case.end(), text.begin(),
                    [](char a, char b) { return a == std::tolower(static_cast<unsigned char>(b)); });
}

}  // namespace

std::string escape_html(std::string_view text) {
  return with_replaced(printable(text),
                       {{'&', "&amp;"}, {'<', "&lt;"}, {'>', "&gt;"}, {'"', "&quot;"}, {'\'', "&#39;"}});
}

std::string inside_script(std::string_view code) {
  constexpr std::string_view line_separators = "\xe2\x80";  // U+2028, U+2029: end a line of JavaScript, in strings, too
  std::string safe;
  safe.reserve(code.size());
  while (!code.empty()) {
    const auto* special = std::find_if(code.begin(), code.end(), [](char c) { return c == '<' || c == '\xe2'; });
    safe.append(code.begin(), special);
    code = {special, code.end()};
    if (code.empty()) break;
    // \u003c is the same character in the strings of JSON and JavaScript.
    const bool html = begins_with(code, "</script") || begins_with(code, "<script") || begins_with(code, "<!--");
    const char last = code.size() > line_separators.size() ? code[line_separators.size()] : '\0';
    if (code.starts_with(line_separators) && (last == '\xa8' || last == '\xa9')) {
      safe += last == '\xa8' ? "\\u2028" : "\\u2029";
      code.remove_prefix(line_separators.size() + 1);
      continue;
    }
    safe += html ? "\\u003c" : code.substr(0, 1);
    code.remove_prefix(1);
  }
  return safe;
}

std::string fill_page(std::string_view page, const std::map<std::string, std::string>& values) {
  return fill(page, "{{", "}}", values);
}

std::string fill_json(std::string_view json, const std::map<std::string, std::string>& values) {
  return fill(json, "\"{{", "}}\"", values);
}

}  // namespace ricochet::report

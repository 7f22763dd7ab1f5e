#include "coupler/report/parts/text.hpp"

#include <algorithm>
#include <cctype>
#include <stdexcept>

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
  std::string escaped;
  for (const char c : text) {
    switch (c) {
      case '&': escaped += "&amp;"; break;
      case '<': escaped += "&lt;"; break;
      case '>': escaped += "&gt;"; break;
      case '"': escaped += "&quot;"; break;
      case '\'': escaped += "&#39;"; break;
      default: escaped += c;
    }
  }
  return escaped;
}

std::string inside_script(std::string_view code) {
  std::string safe;
  safe.reserve(code.size());
  for (;;) {
    const auto bracket = code.find('<');
    safe += code.substr(0, bracket);
    if (bracket == std::string_view::npos) return safe;
    code.remove_prefix(bracket);
    // \u003c is the same character in the strings of JSON and JavaScript.
    const bool html = begins_with(code, "</script") || begins_with(code, "<script") || begins_with(code, "<!--");
    safe += html ? "\\u003c" : "<";
    code.remove_prefix(1);
  }
}

std::string fill_page(std::string_view page, const std::map<std::string, std::string>& values) {
  return fill(page, "{{", "}}", values);
}

std::string fill_json(std::string_view json, const std::map<std::string, std::string>& values) {
  return fill(json, "\"{{", "}}\"", values);
}

}  // namespace ricochet::report

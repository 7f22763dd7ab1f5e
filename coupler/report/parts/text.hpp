#pragma once

#include <map>
#include <string>
#include <string_view>

namespace ricochet::report {

/// `text` for HTML content and quoted attributes: & < > " ' become entities.
[[nodiscard]] std::string escape_html(std::string_view text);

/// JSON or JavaScript for the inside of <script>: where a string of it holds "</script", "<script" or "<!--", which
/// HTML would take for its own, the < becomes \u003c, the same character to JSON and JavaScript.
[[nodiscard]] std::string inside_script(std::string_view code);

/// Replaces every {{key}} of an HTML template by its value; values are not searched again.
/// Throws std::logic_error for a key without value.
[[nodiscard]] std::string fill_page(std::string_view page, const std::map<std::string, std::string>& values);

/// The same for JSON templates, where the placeholder is the string "{{key}}" and the value any JSON.
[[nodiscard]] std::string fill_json(std::string_view json, const std::map<std::string, std::string>& values);

}  // namespace ricochet::report

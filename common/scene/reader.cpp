#include "common/scene/reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "common/base/names.hpp"

namespace ricochet::scene {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
/// Nothing in SI units of this field is as large; toml11 turns an overflowing literal into the largest double.
constexpr double largest_number = 1e100;

}  // namespace

std::string value_text(const Toml& value) {
  switch (value.type()) {
    case toml::value_t::table: return "a table";
    case toml::value_t::array: return fmt::format("an array of {}", value.as_array().size());
    case toml::value_t::string: return fmt::format("\"{}\"", value.as_string().str);
    case toml::value_t::floating: return fmt::format("{:.10g}", value.as_floating());
    case toml::value_t::integer: return fmt::format("{}", value.as_integer());
    case toml::value_t::boolean: return value.as_boolean() ? "true" : "false";
    default: return "a date or time";
  }
}

bool Range::contains(double x) const {
  return (low_included ? x >= low : x > low) && (high_included ? x <= high : x < high);
}

std::string Range::text() const {
  std::string text = "a number";
  if (low > -infinity) text += fmt::format(" {} {}", low_included ? ">=" : ">", low);
  if (low > -infinity && high < infinity) text += " and";
  if (high < infinity) text += fmt::format(" {} {}", high_included ? "<=" : "<", high);
  return text;
}

Range any_number() { return {-infinity, infinity, false, false}; }
Range above(double low) { return {low, infinity, false, false}; }
Range at_least(double low) { return {low, infinity, true, false}; }

std::string one_of(const std::vector<std::string>& allowed) {
  if (allowed.empty()) return "nothing";
  std::string text;
  for (std::size_t i = 0; i < allowed.size(); ++i) {
    if (i > 0) text += i + 1 < allowed.size() ? ", " : " or ";
    text += "\"" + allowed[i] + "\"";
  }
  return text;
}

TableReader::TableReader(const Toml& value, std::string kind, std::string path, Context context)
    : value_(&value), kind_(std::move(kind)), path_(std::move(path)), context_(std::move(context)) {
  if (!value.is_table()) fail(value, path_, value_text(value), "a table");
  const std::vector<std::string>& known = context_.schema->at(kind_);
  std::map<std::pair<std::size_t, std::string>, const Toml*> unknown;  // the first in the file is reported
  for (const auto& [key, entry] : value.as_table())
    if (std::find(known.begin(), known.end(), key) == known.end()) unknown[{entry.location().line(), key}] = &entry;
  if (!unknown.empty()) {
    const auto& [place, entry] = *unknown.begin();
    const std::string& key = place.second;
    fail(*entry, full(key), fmt::format("unknown key \"{}\"{}", key, did_you_mean(key, known)), one_of(known));
  }
  rename(path_);
}

void TableReader::rename(const std::string& path) {
  path_ = path;
  context_.lines[path_] = static_cast<int>(value_->location().line());
}

std::string TableReader::full(const std::string& key) const {
  if (path_.empty() || key.empty()) return path_ + key;
  return path_ + "." + key;
}

bool TableReader::has(const std::string& key) const { return value_->contains(key); }

bool TableReader::is_text(const std::string& key) const { return has(key) && value_->at(key).is_string(); }

bool TableReader::is_array(const std::string& key) const { return has(key) && value_->at(key).is_array(); }

const Toml* TableReader::take(const std::string& key) {
  const std::vector<std::string>& known = context_.schema->at(kind_);
  if (std::find(known.begin(), known.end(), key) == known.end())
    throw std::logic_error("schema of " + kind_ + " lacks " + key);
  taken_.insert(key);
  if (!has(key)) return nullptr;
  const Toml& value = value_->at(key);
  context_.lines[full(key)] = static_cast<int>(value.location().line());
  return &value;
}

const Toml& TableReader::need(const std::string& key, const std::string& allowed) {
  const Toml* value = take(key);
  if (value == nullptr) missing(key, allowed);
  return *value;
}

void TableReader::fail(const Toml& at, const std::string& key, const std::string& found,
                       const std::string& allowed) const {
  const std::string title = fmt::format("{}:{}: {}{}found {}; allowed: {}", context_.file, at.location().line(), key,
                                        key.empty() ? "" : ": ", found, allowed);
  const std::string text = toml::format_error(title, at, "here");
  throw ConfigError(text.substr(text.find(title)));  // without toml11's "[error] "
}

void TableReader::refuse(const std::string& key, const std::string& found, const std::string& allowed) const {
  fail(has(key) ? value_->at(key) : *value_, full(key), found, allowed);
}

void TableReader::missing(const std::string& key, const std::string& allowed) const {
  fail(*value_, full(key), "nothing: the key is missing", allowed);
}

double TableReader::to_number(const Toml& value, const std::string& key, const Range& range) const {
  if (!value.is_floating() && !value.is_integer()) fail(value, full(key), value_text(value), range.text());
  const double x = value.is_integer() ? static_cast<double>(value.as_integer()) : value.as_floating();
  const bool finite = std::isfinite(x) && std::abs(x) < largest_number;
  if (!finite || !range.contains(x))
    fail(value, full(key), value_text(value), range.text() + (finite ? "" : ", finite"));
  return x;
}

int TableReader::to_integer(const Toml& value, const std::string& key, int low, int high) const {
  const std::string allowed = fmt::format("an integer from {} to {}", low, high);
  if (!value.is_integer()) fail(value, full(key), value_text(value), allowed);
  const auto x = value.as_integer();
  if (x < low || x > high) fail(value, full(key), value_text(value), allowed);
  return static_cast<int>(x);
}

const std::string& TableReader::to_text(const Toml& value, const std::string& key) const {
  if (!value.is_string() || value.as_string().str.empty())
    fail(value, full(key), value_text(value), "a text in quotes, not empty");
  return value.as_string().str;
}

const std::vector<Toml>& TableReader::to_array(const Toml& value, const std::string& key, const std::string& of,
                                               std::size_t size) const {
  const std::string allowed = size > 0 ? fmt::format("an array of {} {}", size, of) : "a non-empty array of " + of;
  const bool fits = value.is_array() && (size > 0 ? value.as_array().size() == size : !value.as_array().empty());
  if (!fits) fail(value, full(key), value_text(value), allowed);
  return value.as_array();
}

double TableReader::number(const std::string& key, const Range& range) {
  return to_number(need(key, range.text()), key, range);
}

double TableReader::number(const std::string& key, const Range& range, double otherwise) {
  const Toml* value = take(key);
  return value != nullptr ? to_number(*value, key, range) : otherwise;
}

int TableReader::integer(const std::string& key, int low, int high) {
  return to_integer(need(key, fmt::format("an integer from {} to {}", low, high)), key, low, high);
}

int TableReader::integer(const std::string& key, int low, int high, int otherwise) {
  const Toml* value = take(key);
  return value != nullptr ? to_integer(*value, key, low, high) : otherwise;
}

bool TableReader::boolean(const std::string& key, bool otherwise) {
  const Toml* value = take(key);
  if (value == nullptr) return otherwise;
  if (!value->is_boolean()) fail(*value, full(key), value_text(*value), "true or false");
  return value->as_boolean();
}

std::string TableReader::text(const std::string& key) { return to_text(need(key, "a text in quotes"), key); }

std::string TableReader::text(const std::string& key, const std::string& otherwise) {
  const Toml* value = take(key);
  return value != nullptr ? to_text(*value, key) : otherwise;
}

std::string TableReader::name(const std::string& key) {
  const std::string found = text(key);
  const auto fits = [](unsigned char c) { return std::isalnum(c) != 0 || c == '_' || c == '-'; };
  if (!std::all_of(found.begin(), found.end(), fits))
    refuse(key, "\"" + found + "\"", "a name of letters, digits, '_' and '-'");
  return found;
}

std::string TableReader::word(const std::string& key, const std::vector<std::string>& allowed) {
  const std::string found = to_text(need(key, one_of(allowed)), key);
  if (std::find(allowed.begin(), allowed.end(), found) == allowed.end())
    refuse(key, "\"" + found + "\"" + did_you_mean(found, allowed), one_of(allowed));
  return found;
}

std::vector<double> TableReader::numbers(const std::string& key, const Range& range, std::size_t size) {
  const Toml& value = need(key, "an array of numbers");
  std::vector<double> result;
  for (const Toml& entry : to_array(value, key, "numbers", size))
    result.push_back(to_number(entry, fmt::format("{}[{}]", key, result.size()), range));
  return result;
}

std::vector<int> TableReader::integers(const std::string& key, int low, int high, std::size_t size) {
  const Toml& value = need(key, fmt::format("an array of {} integers", size));
  std::vector<int> result;
  for (const Toml& entry : to_array(value, key, "integers", size))
    result.push_back(to_integer(entry, fmt::format("{}[{}]", key, result.size()), low, high));
  return result;
}

std::vector<std::string> TableReader::texts(const std::string& key) {
  const Toml& value = need(key, "an array of texts");
  std::vector<std::string> result;
  for (const Toml& entry : to_array(value, key, "texts", 0))
    result.push_back(to_text(entry, fmt::format("{}[{}]", key, result.size())));
  return result;
}

std::vector<std::string> TableReader::words(const std::string& key, const std::vector<std::string>& allowed) {
  const std::vector<std::string> found = texts(key);
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (std::find(allowed.begin(), allowed.end(), found[i]) == allowed.end())
      refuse(key, "\"" + found[i] + "\"" + did_you_mean(found[i], allowed), one_of(allowed));
    if (std::count(found.begin(), found.end(), found[i]) > 1) refuse(key, "\"" + found[i] + "\" twice", "each once");
  }
  return found;
}

TableReader TableReader::table(const std::string& key, const std::string& kind) {
  return {need(key, "a table"), kind, full(key), context_};
}

std::vector<TableReader> TableReader::tables(const std::string& key, const std::string& kind) {
  std::vector<TableReader> result;
  const Toml* value = take(key);
  if (value == nullptr) return result;
  for (const Toml& entry : to_array(*value, key, "tables", 0))
    result.emplace_back(entry, kind, fmt::format("{}[{}]", full(key), result.size()), context_);
  return result;
}

std::vector<TableReader> TableReader::table_or_tables(const std::string& key, const std::string& kind) {
  if (!has(key) || is_array(key)) return tables(key, kind);
  std::vector<TableReader> one;
  one.push_back(table(key, kind));
  return one;
}

std::map<std::string, TableReader> TableReader::tables_by_name(const std::string& key, const std::string& kind) {
  std::map<std::string, TableReader> result;
  const Toml* value = take(key);
  if (value == nullptr) return result;
  if (!value->is_table()) fail(*value, full(key), value_text(*value), "tables, each with a name: [" + key + ".NAME]");
  for (const auto& [name, entry] : value->as_table())
    result.emplace(name, TableReader(entry, kind, full(key) + "." + name, context_));
  return result;
}

const Toml& TableReader::body_table(const std::string& key, const std::vector<std::string>& allowed) {
  const Toml& value = need(key, "a table of bodies");
  if (!value.is_table() || value.as_table().empty()) fail(value, full(key), value_text(value), "a table of bodies");
  for (const auto& [body, entry] : value.as_table()) {
    context_.lines[full(key) + "." + body] = static_cast<int>(entry.location().line());
    if (std::find(allowed.begin(), allowed.end(), body) == allowed.end())
      fail(entry, full(key), fmt::format("\"{}\"{}", body, did_you_mean(body, allowed)), one_of(allowed));
  }
  return value;
}

std::map<std::string, double> TableReader::numbers_by_name(const std::string& key, const Range& range,
                                                           const std::vector<std::string>& allowed) {
  std::map<std::string, double> result;
  for (const auto& [body, entry] : body_table(key, allowed).as_table())
    result[body] = to_number(entry, key + "." + body, range);
  return result;
}

std::map<std::string, std::vector<std::string>> TableReader::texts_by_name(const std::string& key,
                                                                           const std::vector<std::string>& allowed) {
  std::map<std::string, std::vector<std::string>> result;
  for (const auto& [body, entry] : body_table(key, allowed).as_table())
    for (const Toml& text : to_array(entry, key + "." + body, "texts", 0))
      result[body].push_back(to_text(text, key + "." + body));
  return result;
}

void TableReader::only_if(bool condition, const std::string& key, const std::string& needs) {
  if (!condition && has(key)) refuse(key, value_text(value_->at(key)), "only with " + needs);
}

void TableReader::finish() const {
  for (const auto& [key, entry] : value_->as_table())
    if (taken_.count(key) == 0) throw std::logic_error("the loader of " + kind_ + " never reads " + key);
}

}  // namespace ricochet::scene

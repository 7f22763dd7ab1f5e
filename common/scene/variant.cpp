#include "common/scene/variant.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <sstream>

#include "common/base/error.hpp"
#include "common/base/names.hpp"
#include "common/base/write_file.hpp"
#include "common/scene/toml_file.hpp"

namespace ricochet::scene {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> split(const std::string& key) {
  std::vector<std::string> words;
  std::istringstream stream(key);
  for (std::string word; std::getline(stream, word, '.');) words.push_back(word);
  return words;
}

/// The table of that `name` in an array of tables (bodies, contacts, participants).
Toml& named(Toml& tables, const std::string& name, const Override& change) {
  std::vector<std::string> names;
  for (auto& table : tables.as_array()) {
    if (!table.is_table() || !table.contains("name") || !table.at("name").is_string()) continue;
    names.push_back(table.at("name").as_string().str);
    if (names.back() == name) return table;
  }
  throw ConfigError(fmt::format("{}: found \"{}\", allowed are {}{}", change.key, name,
                                names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", ")),
                                did_you_mean(name, names)));
}

Toml to_toml(double number) {
  // Keys that count want integers, and those that measure take them, too.
  if (number == std::round(number) && std::abs(number) < 1e15) return static_cast<std::int64_t>(number);
  return number;
}

Toml to_toml(const decltype(Override::value)& value) {
  if (const auto* text = std::get_if<std::string>(&value)) return *text;
  if (const auto* number = std::get_if<double>(&value)) return to_toml(*number);
  if (const auto* answer = std::get_if<bool>(&value)) return *answer;
  Toml::array_type list;
  if (const auto* texts = std::get_if<std::vector<std::string>>(&value)) {
    for (const auto& text : *texts) list.push_back(text);
    return list;
  }
  for (const double number : std::get<std::vector<double>>(value)) list.push_back(to_toml(number));
  return list;
}

void set(Toml& root, const Override& change) {
  const auto words = split(change.key);
  if (words.size() < 2) {
    throw ConfigError(
        fmt::format("found the key \"{}\", allowed: TABLE.KEY as in docs/scene.md, for example "
                    "time.step_s or body.NAME.material.youngs_modulus_pa",
                    change.key));
  }
  Toml* at = &root;
  for (std::size_t i = 0; i + 1 < words.size(); ++i) {
    if (at->is_array()) {
      at = &named(*at, words[i], change);
      continue;
    }
    if (at->is_table() && !at->contains(words[i])) at->as_table()[words[i]] = Toml::table_type{};
    if (at->is_table()) at = &at->as_table()[words[i]];
  }
  if (!at->is_table()) {
    throw ConfigError(fmt::format("found the key \"{}\", but \"{}\" is no table; allowed: a key of docs/scene.md",
                                  change.key, words[words.size() - 2]));
  }
  if (change.key == "time.step_s") {
    for (const char* other : {"safety_factor", "largest_step_s"}) at->as_table().erase(other);
  }
  if (words.front() == "output" && words.size() == 2) {  // a count takes the place of a time
    const bool count = words.back().size() > 6 && words.back().compare(words.back().size() - 6, 6, "_every") == 0;
    at->as_table().erase(count ? words.back() + "_s" : words.back().substr(0, words.back().rfind("_s")));
  }
  at->as_table()[words.back()] = to_toml(change.value);
}

/// Paths that count from the folder of the scene file.
void make_absolute(Toml& table, const char* key, const fs::path& folder) {
  if (!table.is_table() || !table.contains(key) || !table.at(key).is_string()) return;
  const std::string path = table.at(key).as_string().str;
  const bool program_on_path = std::string(key) == "executable" && path.find('/') == std::string::npos;
  if (!program_on_path) table.as_table()[key] = fs::absolute(folder / path).lexically_normal().string();
}

void keep_mesh_paths(Toml& mesh, const fs::path& folder) {
  for (const char* key : {"gmsh", "inp"}) make_absolute(mesh, key, folder);
  if (!mesh.is_table() || !mesh.contains("piece") || !mesh.at("piece").is_array()) return;
  for (Toml& piece : mesh.at("piece").as_array()) keep_mesh_paths(piece, folder);
}

void keep_paths(Toml& root, const fs::path& folder) {
  const auto each = [&root](const char* name, const auto& act) {
    if (!root.contains(name) || !root.at(name).is_array()) return;
    for (auto& table : root.at(name).as_array()) act(table);
  };
  each("body", [&](Toml& body) {
    if (body.is_table() && body.contains("mesh")) keep_mesh_paths(body.at("mesh"), folder);
    for (const char* key : {"interface_nodes", "interface_faces"}) make_absolute(body, key, folder);
  });
  each("participant", [&](Toml& participant) { make_absolute(participant, "executable", folder); });
}

std::optional<double> number_in(const Toml& value) {
  if (value.is_floating()) return value.as_floating();
  if (value.is_integer()) return static_cast<double>(value.as_integer());
  return std::nullopt;
}

std::string trimmed(const std::string& text) {
  const char* const blanks = " \t";
  const std::size_t first = text.find_first_not_of(blanks);
  return first == std::string::npos ? "" : text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

/// The value behind the '=', as TOML has it; nothing if TOML has no such value.
std::optional<Toml> toml_value(const std::string& text) {
  try {
    return parse_toml("--set", "value = " + text).at("value");
  } catch (const ConfigError&) {
    return std::nullopt;
  }
}

/// A list of numbers, or of texts.
decltype(Override::value) list_in(const Toml& value, const std::string& argument) {
  std::vector<double> numbers;
  std::vector<std::string> texts;
  for (const Toml& entry : value.as_array()) {
    if (const auto number = number_in(entry)) numbers.push_back(*number);
    if (entry.is_string()) texts.push_back(entry.as_string().str);
  }
  if (numbers.size() == value.size()) return numbers;
  if (texts.size() == value.size()) return texts;
  throw ConfigError("--set " + argument + ": found a list of several kinds; allowed: numbers, or texts in quotes");
}

}  // namespace

Override parse_override(const std::string& argument) {
  const std::size_t equals = argument.find('=');
  const std::string key = trimmed(argument.substr(0, equals));
  const std::string text = equals == std::string::npos ? "" : trimmed(argument.substr(equals + 1));
  if (key.empty() || text.empty())
    throw ConfigError(fmt::format("--set: found \"{}\", allowed: KEY=VALUE, for example time.step_s=1e-7", argument));
  const auto value = toml_value(text);
  if (!value) return {key, text};
  if (const auto number = number_in(*value)) return {key, *number};
  if (value->is_boolean()) return {key, value->as_boolean()};
  if (value->is_string()) return {key, value->as_string().str};
  if (value->is_array()) return {key, list_in(*value, argument)};
  throw ConfigError(fmt::format("--set {}: found {}, allowed: a number, a text, true, false or a list", argument,
                                value->is_table() ? "a table" : "a date"));
}

std::string to_argument(const Override& change) {
  if (const auto* text = std::get_if<std::string>(&change.value)) return change.key + "=" + *text;
  if (const auto* number = std::get_if<double>(&change.value)) return fmt::format("{}={}", change.key, *number);
  if (const auto* numbers = std::get_if<std::vector<double>>(&change.value))
    return fmt::format("{}=[{}]", change.key, fmt::join(*numbers, ","));
  return change.key + "=" + toml::format(to_toml(change.value));
}

void write_variant(const std::string& scene_path, const std::vector<Override>& overrides, const std::string& out_path) {
  if (!is_file(scene_path)) throw ConfigError(scene_path + ": no such scene file");
  Toml root = parse_toml(scene_path, read_text(scene_path));
  for (const auto& change : overrides) set(root, change);
  keep_paths(root, fs::absolute(scene_path).parent_path());
  write_atomically(out_path, toml::format(root, 120, 17));
}

}  // namespace ricochet::scene

#include "coupler/study/study_keys.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>
#include <utility>

#include "common/base/names.hpp"

namespace ricochet::coupler {
namespace {

using scene::Override;
using scene::TableReader;

/// Nested tables are dotted keys: { time.step_s = 1 } and { "time.step_s" = 1 } are the same. In the file's order.
void collect(const scene::Toml& table, const std::string& path, std::vector<Leaf>& leaves) {
  for (const auto& [key, value] : table.as_table()) {
    const std::string full = path.empty() ? key : path + "." + key;
    if (value.is_table()) {
      collect(value, full, leaves);
    } else {
      leaves.push_back({full, &value});
    }
  }
}

std::vector<std::string> words_of(const std::string& key) {
  std::vector<std::string> words;
  std::istringstream stream(key);
  for (std::string word; std::getline(stream, word, '.');) words.push_back(word);
  return words;
}

/// Follows a key through the tables of a scene; below a list of tables (body, participant, several contacts) comes a
/// name.
void check_scene_key(const TableReader& reader, const std::string& at, const Leaf& leaf) {
  const auto& schema = scene::scene_schema();
  const auto words = words_of(leaf.key);
  std::string kind = "scene";
  for (std::size_t i = 0; i < words.size(); ++i) {
    const auto& known = schema.at(kind);
    if (std::find(known.begin(), known.end(), words[i]) == known.end()) {
      reader.fail(*leaf.value, at,
                  fmt::format("\"{}\" in the key {}{}", words[i], leaf.key, did_you_mean(words[i], known)),
                  scene::one_of(known));
    }
    if (schema.count(words[i]) == 0) return;  // a key, or a table of names of bodies
    kind = words[i];
    const bool several_contacts = kind == "contact" && i + 2 < words.size();  // its own keys are no tables
    if (kind == "body" || kind == "participant" || several_contacts) ++i;
  }
  reader.fail(*leaf.value, at, fmt::format("the table \"{}\"", leaf.key),
              "one of its keys: " + scene::one_of(schema.at(kind)));
}

bool is_number(const scene::Toml& value) { return value.is_floating() || value.is_integer(); }
double number_of(const scene::Toml& value) {
  return value.is_integer() ? static_cast<double>(value.as_integer()) : value.as_floating();
}

}  // namespace

std::vector<Leaf> leaves_of(const TableReader& reader, const scene::Toml& table, const std::string& at) {
  if (!table.is_table()) reader.fail(table, at, scene::value_text(table), "a table of keys of the scene");
  std::vector<Leaf> leaves;
  collect(table, "", leaves);
  if (leaves.empty()) reader.fail(table, at, "an empty table", "keys of the scene");
  const auto place = [](const Leaf& leaf) { return std::make_pair(leaf.value->location().line(), leaf.key); };
  std::sort(leaves.begin(), leaves.end(), [&](const Leaf& a, const Leaf& b) { return place(a) < place(b); });
  for (const auto& leaf : leaves) check_scene_key(reader, at, leaf);
  return leaves;
}

Override override_of(const TableReader& reader, const std::string& at, const std::string& key,
                     const scene::Toml& value) {
  if (is_number(value)) return {key, number_of(value)};
  if (value.is_string()) return {key, value.as_string().str};
  const bool list = value.is_array() && !value.as_array().empty() &&
                    std::all_of(value.as_array().begin(), value.as_array().end(), is_number);
  if (!list) reader.fail(value, at + "." + key, scene::value_text(value), "a number, a text or a list of numbers");
  std::vector<double> numbers;
  for (const auto& entry : value.as_array()) numbers.push_back(number_of(entry));
  return {key, numbers};
}

std::vector<Override> load_changes(TableReader& reader, const std::string& key) {
  std::vector<Override> changes;
  const scene::Toml* table = reader.open(key);
  if (table == nullptr) return changes;
  const std::string at = reader.path() + "." + key;
  for (const auto& leaf : leaves_of(reader, *table, at)) {
    if (leaf.key == "coupling.protocol")
      reader.fail(*leaf.value, at, "the protocol", "a key of its own for that: protocol = ...");
    changes.push_back(override_of(reader, at, leaf.key, *leaf.value));
  }
  return changes;
}

}  // namespace ricochet::coupler

#include "coupler/study_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <sstream>

#include "common/base/names.hpp"
#include "common/scene/protocols.hpp"
#include "common/scene/reader.hpp"
#include "coupler/report/history_table.hpp"
#include "coupler/study_measures.hpp"

namespace ricochet::coupler {
namespace {

namespace fs = std::filesystem;
using scene::Override;
using scene::TableReader;

constexpr int most_repeats = 1000;

const scene::Schema& study_schema() {
  static const scene::Schema tables{
      {"study", {"scene", "methods", "vary", "quantities", "repeats", "reference"}},
      {"reference", {"exact", "protocol", "changes", "refine"}},
  };
  return tables;
}

/// A value below a table whose keys are those of a scene: its whole key in the scene, and where it stands.
struct Leaf {
  std::string key;
  const toml::value* value;
};

/// Nested tables are dotted keys: { time.step_s = 1 } and { "time.step_s" = 1 } are the same. In the file's order.
void collect(const toml::value& table, const std::string& path, std::vector<Leaf>& leaves) {
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

/// Follows a key through the tables of a scene; below a list of tables (body, participant) comes a name.
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
    if (kind == "body" || kind == "participant") ++i;
  }
  reader.fail(*leaf.value, at, fmt::format("the table \"{}\"", leaf.key),
              "one of its keys: " + scene::one_of(schema.at(kind)));
}

std::vector<Leaf> leaves_of(const TableReader& reader, const toml::value& table, const std::string& at) {
  if (!table.is_table()) reader.fail(table, at, scene::value_text(table), "a table of keys of the scene");
  std::vector<Leaf> leaves;
  collect(table, "", leaves);
  if (leaves.empty()) reader.fail(table, at, "an empty table", "keys of the scene");
  const auto place = [](const Leaf& leaf) { return std::make_pair(leaf.value->location().line(), leaf.key); };
  std::sort(leaves.begin(), leaves.end(), [&](const Leaf& a, const Leaf& b) { return place(a) < place(b); });
  for (const auto& leaf : leaves) check_scene_key(reader, at, leaf);
  return leaves;
}

bool is_number(const toml::value& value) { return value.is_floating() || value.is_integer(); }
double number_of(const toml::value& value) {
  return value.is_integer() ? static_cast<double>(value.as_integer()) : value.as_floating();
}

Override override_of(const TableReader& reader, const std::string& at, const std::string& key,
                     const toml::value& value) {
  if (is_number(value)) return {key, number_of(value)};
  if (value.is_string()) return {key, value.as_string().str};
  const bool list = value.is_array() && !value.as_array().empty() &&
                    std::all_of(value.as_array().begin(), value.as_array().end(), is_number);
  if (!list) reader.fail(value, at + "." + key, scene::value_text(value), "a number, a text or a list of numbers");
  std::vector<double> numbers;
  for (const auto& entry : value.as_array()) numbers.push_back(number_of(entry));
  return {key, numbers};
}

Variation load_variation(const TableReader& reader, const toml::value& table, const std::string& at) {
  Variation variation;
  for (const auto& leaf : leaves_of(reader, table, at)) {
    const std::string full = at + "." + leaf.key;
    if (!leaf.value->is_array() || leaf.value->as_array().empty()) {
      reader.fail(*leaf.value, full, scene::value_text(*leaf.value), "a list of the values that the key takes");
    }
    const auto& values = leaf.value->as_array();
    if (variation.settings.empty()) variation.settings.resize(values.size());
    if (values.size() != variation.settings.size()) {
      reader.fail(*leaf.value, full, fmt::format("{} values", values.size()),
                  fmt::format("{}, as many as {} has: keys of one table take their values together",
                              variation.settings.size(), variation.keys.front()));
    }
    if (leaf.key == "coupling.protocol") reader.fail(*leaf.value, full, "the protocol", "methods = [...] for that");
    variation.keys.push_back(leaf.key);
    for (std::size_t i = 0; i < values.size(); ++i) {
      variation.settings[i].push_back(override_of(reader, at, leaf.key, values[i]));
    }
  }
  return variation;
}

std::vector<Variation> load_variations(TableReader& root) {
  std::vector<Variation> variations;
  const toml::value* value = root.open("vary");
  if (value == nullptr) return variations;
  if (!value->is_array()) root.refuse("vary", scene::value_text(*value), "[[vary]] tables");
  std::set<std::string> seen;
  for (const auto& table : value->as_array()) {
    const std::string at = fmt::format("vary[{}]", variations.size());
    variations.push_back(load_variation(root, table, at));
    for (const auto& key : variations.back().keys) {
      if (!seen.insert(key).second) root.fail(table, at, key + " a second time", "each key in one table");
    }
  }
  return variations;
}

std::vector<Override> load_changes(TableReader& reader, const std::string& key) {
  std::vector<Override> changes;
  const toml::value* table = reader.open(key);
  if (table == nullptr) return changes;
  const std::string at = reader.path() + "." + key;
  for (const auto& leaf : leaves_of(reader, *table, at))
    changes.push_back(override_of(reader, at, leaf.key, *leaf.value));
  return changes;
}

void load_computed(TableReader& reader, ReferenceSpec& reference) {
  reference.changes = load_changes(reader, "changes");
  reference.refine = load_changes(reader, "refine");
  if (reference.refine.empty())
    reader.missing("refine", "what one more refinement changes, for the reference's own error");
  reference.changes.push_back({"coupling.protocol", reader.word("protocol", scene::protocol_names())});
}

ReferenceSpec load_reference(TableReader reader) {
  ReferenceSpec reference;
  reference.exact = reader.has("exact");
  if (reference.exact) (void)reader.word("exact", {"impedance_theory"});
  for (const char* key : {"protocol", "changes", "refine"})
    reader.only_if(!reference.exact, key, "a computed reference");
  if (!reference.exact) load_computed(reader, reference);
  reader.finish();
  return reference;
}

toml::value parse(const std::string& path, const std::string& text) {
  toml::value file;
  try {
    std::istringstream stream(text);
    file = toml::parse(stream, path);
  } catch (const std::exception& error) {
    throw ConfigError(fmt::format("{}: not a TOML file; allowed: TOML 1.0\n{}", path, error.what()));
  }
  if (file.as_table().empty()) {
    throw ConfigError(path + ":1: the study file is empty; allowed: scene, methods, reference and more");
  }
  return file;
}

}  // namespace

StudyFile load_study(const std::string& path) {
  if (!fs::is_regular_file(path)) throw ConfigError(path + ": no such study file");
  StudyFile study;
  study.path = fs::absolute(path).lexically_normal().string();
  study.text = report::read_text(study.path);
  const toml::value file = parse(study.path, study.text);
  std::map<std::string, int> lines;
  TableReader root(file, "study", "", {study.path, lines, &study_schema()});
  study.scene = (fs::path(study.path).parent_path() / root.text("scene")).lexically_normal().string();
  if (!fs::is_regular_file(study.scene))
    root.refuse("scene", "no file " + study.scene, "a scene file, from this folder");
  study.methods = root.words("methods", scene::protocol_names());
  study.variations = load_variations(root);
  study.quantities = quantity_names();
  if (root.has("quantities")) study.quantities = root.words("quantities", quantity_names());
  study.repeats = root.integer("repeats", 1, most_repeats, study.repeats);
  study.reference = load_reference(root.table("reference", "reference"));
  root.finish();
  return study;
}

std::vector<std::vector<Override>> combinations(const std::vector<Variation>& variations) {
  std::vector<std::vector<Override>> all{{}};
  for (const auto& variation : variations) {
    std::vector<std::vector<Override>> more;
    for (const auto& begun : all) {
      for (const auto& setting : variation.settings) {
        more.push_back(begun);
        more.back().insert(more.back().end(), setting.begin(), setting.end());
      }
    }
    all = std::move(more);
  }
  return all;
}

std::string text_of(const Override& change) {
  if (const auto* text = std::get_if<std::string>(&change.value)) return *text;
  if (const auto* number = std::get_if<double>(&change.value)) return fmt::format("{}", *number);
  return fmt::format("{}", fmt::join(std::get<std::vector<double>>(change.value), " "));
}

}  // namespace ricochet::coupler

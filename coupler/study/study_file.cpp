#include "coupler/study/study_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>
#include <utility>

#include "common/base/names.hpp"
#include "common/problem/probes.hpp"
#include "common/scene/protocols.hpp"
#include "common/scene/reader.hpp"
#include "common/scene/toml_file.hpp"
#include "coupler/study/study_keys.hpp"
#include "coupler/study/study_measures.hpp"

namespace ricochet::coupler {
namespace {

namespace fs = std::filesystem;
using scene::Override;
using scene::TableReader;

constexpr int most_repeats = 1000;

const scene::Schema& study_schema() {
  static const scene::Schema tables{
      {"study",
       {"scene", "methods", "method", "vary", "quantities", "values", "repeats", "reference", "along", "axis",
        "histories", "published", "measured"}},
      {"method", {"name", "protocol", "changes"}},
      {"reference", {"exact", "protocol", "changes", "refine", "follow"}},
      {"histories", {"quantity", "over_pa", "over_name", "compare_to"}},
      {"published", {"methods", "over", "at", "time_ratio", "source"}},
      {"axis", {"title", "at"}},
      {"measured", {"value", "at", "measured", "error", "source"}},
  };
  return tables;
}

/// Takes `methods` out of a [[vary]] table: of which methods it is.
std::vector<std::string> take_methods(const TableReader& reader, const std::vector<std::string>& known,
                                      const std::string& at, scene::Toml& table) {
  std::vector<std::string> methods;
  if (!table.is_table() || !table.contains("methods")) return methods;
  const scene::Toml value = table.at("methods");
  const std::string full = at + ".methods", allowed = "a list of methods of the study: " + scene::one_of(known);
  if (!value.is_array() || value.as_array().empty()) reader.fail(value, full, scene::value_text(value), allowed);
  for (const auto& entry : value.as_array()) {
    const std::string name = entry.is_string() ? entry.as_string().str : "";
    if (std::find(known.begin(), known.end(), name) == known.end())
      reader.fail(entry, full, scene::value_text(entry) + did_you_mean(name, known), allowed);
    methods.push_back(name);
  }
  table.as_table().erase("methods");
  return methods;
}

Variation load_variation(const TableReader& reader, scene::Toml table, const std::vector<std::string>& methods,
                         const std::string& at) {
  Variation variation{take_methods(reader, methods, at, table), {}, {}};
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

std::vector<Variation> load_variations(TableReader& root, const std::vector<std::string>& methods) {
  std::vector<Variation> variations;
  const scene::Toml* value = root.open("vary");
  if (value == nullptr) return variations;
  if (!value->is_array()) root.refuse("vary", scene::value_text(*value), "[[vary]] tables");
  std::set<std::pair<std::string, std::string>> seen;  // keys of methods
  for (const auto& table : value->as_array()) {
    const std::string at = fmt::format("vary[{}]", variations.size());
    variations.push_back(load_variation(root, table, methods, at));
    const auto& of = variations.back().methods.empty() ? methods : variations.back().methods;
    for (const auto& key : variations.back().keys) {
      for (const auto& method : of)
        if (!seen.insert({key, method}).second)
          root.fail(table, at, fmt::format("{} a second time for \"{}\"", key, method),
                    "each key in one table of a method");
    }
  }
  return variations;
}

void load_methods(TableReader& root, StudyFile& study) {
  for (const auto& protocol : root.words("methods", scene::protocol_names()))
    study.methods.push_back({protocol, protocol, {}});
  for (auto& reader : root.tables("method", "method")) {
    const Method method{reader.text("name"), reader.word("protocol", scene::protocol_names()),
                        load_changes(reader, "changes")};
    const auto known = method_names(study);
    if (std::find(known.begin(), known.end(), method.name) != known.end())
      reader.refuse("name", fmt::format("\"{}\" a second time", method.name), "each method once");
    study.methods.push_back(method);
    reader.finish();
  }
}

/// Keys that differ from reference to reference cannot be changed by it as well.
void load_follow(TableReader& reader, const StudyFile& study, ReferenceSpec& reference) {
  if (!reader.has("follow")) return;
  reference.follow = reader.words("follow", varied_keys(study));
  for (const auto* changes : {&reference.changes, &reference.refine}) {
    for (const auto& change : *changes) {
      if (std::count(reference.follow.begin(), reference.follow.end(), change.key) > 0)
        reader.refuse("follow", fmt::format("\"{}\", which the reference changes", change.key), "another varied key");
    }
  }
}

void load_computed(TableReader& reader, const StudyFile& study, ReferenceSpec& reference) {
  reference.changes = load_changes(reader, "changes");
  reference.refine = load_changes(reader, "refine");
  if (reference.refine.empty())
    reader.missing("refine", "what one more refinement changes, for the reference's own error");
  load_follow(reader, study, reference);
  reference.changes.push_back({"coupling.protocol", reader.word("protocol", scene::protocol_names())});
}

ReferenceSpec load_reference(TableReader reader, const StudyFile& study) {
  ReferenceSpec reference;
  reference.exact = reader.has("exact");
  if (reference.exact) (void)reader.word("exact", {"impedance_theory"});
  for (const char* key : {"protocol", "changes", "refine", "follow"})
    reader.only_if(!reference.exact, key, "a computed reference");
  if (!reference.exact) load_computed(reader, study, reference);
  reader.finish();
  return reference;
}

std::string text_at(const scene::Toml& table, const char* key) {
  if (!table.is_table() || !table.contains(key) || !table.at(key).is_string()) return "";
  return table.at(key).as_string();
}

/// The model; any for a scene that is refused when it runs.
fem::Model model_of(const std::string& name) {
  const auto known = std::find(fem::model_names.begin(), fem::model_names.end(), name);
  return known == fem::model_names.end() ? fem::Model::axisymmetric
                                         : static_cast<fem::Model>(known - fem::model_names.begin());
}

/// Whether its body yields or is heated is not known: what it does not tell has no error.
void add_probes(const scene::Toml& output, fem::Model model, MeasuredScene& scene) {
  const auto add = [&](const char* key, const auto& columns_of) {
    if (!output.is_table() || !output.contains(key) || !output.at(key).is_array()) return;
    for (const auto& place : output.at(key).as_array()) {
      const auto columns = columns_of(text_at(place, "name"));
      scene.probes.insert(scene.probes.end(), columns.begin(), columns.end());
    }
  };
  add("probe", [model](const std::string& name) { return scene::columns_of_probe(model, name, true, true); });
  add("gauge", [](const std::string& name) { return scene::columns_of_gauge(name); });
}

/// The properties that a study can measure of its scene, which may still lack what the study gives it.
MeasuredScene measured_scene(const std::string& path) {
  const scene::Toml file = scene::parse_toml(path, scene::read_text(path));
  const fem::Model model = model_of(text_at(file, "model"));
  MeasuredScene scene{.solid = model == fem::Model::solid};
  if (file.contains("output")) add_probes(file.at("output"), model, scene);
  if (!file.contains("contact") || !file.at("contact").is_array() || file.at("contact").size() < 2) return scene;
  for (const auto& contact : file.at("contact").as_array()) scene.contacts.push_back(text_at(contact, "name"));
  return scene;
}

std::vector<std::string> load_quantities(TableReader& root, const MeasuredScene& scene) {
  auto names = quantity_names(scene);
  if (!root.has("quantities")) return names;
  const auto more = more_quantity_names(scene);
  names.insert(names.end(), more.begin(), more.end());
  return root.words("quantities", names);
}

HistoriesSpec load_histories(TableReader& root, const StudyFile& study, const MeasuredScene& scene) {
  HistoriesSpec histories;
  if (!root.has("histories")) return histories;
  auto reader = root.table("histories", "histories");
  histories.quantity = reader.word("quantity", history_names(scene));
  histories.over_pa = reader.number("over_pa", scene::above(0.0));
  histories.over_name = reader.text("over_name");
  histories.compare_to = reader.word("compare_to", method_names(study));
  reader.finish();
  return histories;
}

/// Texts of the values of a varied key, each once, in the file's order.
std::vector<std::string> values_of_key(const StudyFile& study, const std::string& key) {
  std::vector<std::string> values;
  for (const auto& variation : study.variations) {
    for (const auto& settings : variation.settings) {
      for (const auto& known : settings) {
        const std::string text = text_of(known);
        if (known.key == key && std::find(values.begin(), values.end(), text) == values.end()) values.push_back(text);
      }
    }
  }
  return values;
}

/// A key that is varied, with one of its values.
void check_setting(const TableReader& reader, const StudyFile& study, const Override& setting) {
  const auto values = values_of_key(study, setting.key);
  const auto keys = varied_keys(study);
  if (values.empty())
    reader.refuse("at", fmt::format("\"{}\"{}", setting.key, did_you_mean(setting.key, keys)), scene::one_of(keys));
  if (std::find(values.begin(), values.end(), text_of(setting)) == values.end()) {
    reader.refuse("at", fmt::format("{} = {}", setting.key, text_of(setting)),
                  fmt::format("a value that the study varies: {}", fmt::join(values, ", ")));
  }
}

std::vector<PublishedRatio> load_published(TableReader& root, const StudyFile& study) {
  std::vector<PublishedRatio> all;
  for (auto& reader : root.tables("published", "published")) {
    auto& entry = all.emplace_back();
    entry.methods = reader.words("methods", method_names(study));
    entry.over = reader.word("over", method_names(study));
    entry.at = load_changes(reader, "at");
    for (const auto& setting : entry.at) check_setting(reader, study, setting);
    entry.time_ratio = reader.number("time_ratio", scene::above(0.0));
    entry.source = reader.text("source");
    reader.finish();
  }
  return all;
}

std::optional<StudyAxis> load_axis(TableReader& root, const StudyFile& study) {
  root.only_if(!study.along.empty(), "axis", "along");
  if (!root.has("axis")) return {};
  auto reader = root.table("axis", "axis");
  StudyAxis axis;
  axis.title = reader.text("title");
  const auto values = values_of_key(study, study.along);
  const auto numbers = reader.numbers("at", scene::any_number(), values.size());
  for (std::size_t i = 0; i < values.size(); ++i) axis.at.emplace_back(values[i], numbers[i]);
  reader.finish();
  return axis;
}

std::vector<Measurement> load_measured(TableReader& root, const StudyFile& study) {
  root.only_if(study.axis.has_value(), "measured", "axis");
  std::vector<Measurement> all;
  for (auto& reader : root.tables("measured", "measured")) {
    auto& entry = all.emplace_back();
    entry.value = reader.word("value", study.values);
    entry.at = reader.numbers("at", scene::any_number(), 0);
    entry.measured = reader.numbers("measured", scene::any_number(), entry.at.size());
    entry.error = reader.number("error", scene::above(0.0), 0.0);
    entry.source = reader.text("source");
    reader.finish();
  }
  return all;
}

scene::Toml parse(const std::string& path, const std::string& text) {
  scene::Toml file = scene::parse_toml(path, text);
  if (file.as_table().empty()) {
    throw ConfigError(path + ":1: the study file is empty; allowed: scene, methods, reference and more");
  }
  return file;
}

}  // namespace

StudyFile load_study(const std::string& path) {
  if (!scene::is_file(path)) throw ConfigError(path + ": no such study file");
  StudyFile study;
  study.path = fs::absolute(path).lexically_normal().string();
  study.text = scene::read_text(study.path);
  const scene::Toml file = parse(study.path, study.text);
  std::map<std::string, int> lines;
  TableReader root(file, "study", "", {study.path, lines, &study_schema()});
  study.scene = (fs::path(study.path).parent_path() / root.text("scene")).lexically_normal().string();
  if (!scene::is_file(study.scene)) root.refuse("scene", "no file " + study.scene, "a scene file, from this folder");
  load_methods(root, study);
  study.variations = load_variations(root, method_names(study));
  const MeasuredScene measured = measured_scene(study.scene);
  study.quantities = load_quantities(root, measured);
  if (root.has("values")) study.values = root.words("values", scene::load_scene(study.scene).quantities_with_bars());
  study.repeats = root.integer("repeats", 1, most_repeats, study.repeats);
  study.reference = load_reference(root.table("reference", "reference"), study);
  if (root.has("along")) study.along = root.word("along", varied_keys(study));
  study.axis = load_axis(root, study);
  study.histories = load_histories(root, study, measured);
  study.published = load_published(root, study);
  study.measurements = load_measured(root, study);
  root.finish();
  return study;
}

}  // namespace ricochet::coupler

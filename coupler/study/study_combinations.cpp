// Methods and settings of a study: which runs there are.
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "coupler/study/study_file.hpp"

namespace ricochet::coupler {

using scene::Override;

std::vector<std::string> method_names(const StudyFile& file) {
  std::vector<std::string> names;
  for (const auto& method : file.methods) names.push_back(method.name);
  return names;
}

namespace {

std::vector<std::string> keys_of(const std::vector<Variation>& variations) {
  std::vector<std::string> all;
  for (const auto& variation : variations) {
    for (const auto& key : variation.keys)
      if (std::find(all.begin(), all.end(), key) == all.end()) all.push_back(key);
  }
  return all;
}

}  // namespace

std::vector<std::string> varied_keys(const StudyFile& file) { return keys_of(file.variations); }

std::vector<std::string> telling_keys(const Variation& variation) {
  for (std::size_t k = 0; k < variation.keys.size(); ++k) {
    std::set<std::string> values;
    for (const auto& setting : variation.settings) values.insert(text_of(setting[k]));
    if (values.size() == variation.settings.size()) return {variation.keys[k]};
  }
  return variation.keys;
}

namespace {

bool is_varied(const Variation& variation, const std::string& method) {
  return variation.methods.empty() ||
         std::find(variation.methods.begin(), variation.methods.end(), method) != variation.methods.end();
}

}  // namespace

std::vector<std::vector<Override>> combinations(const std::vector<Variation>& variations, const std::string& method) {
  std::vector<std::map<std::string, Override>> all{{}};
  for (const auto& variation : variations) {
    if (!is_varied(variation, method)) continue;
    std::vector<std::map<std::string, Override>> more;
    for (const auto& begun : all) {
      for (const auto& setting : variation.settings) {
        more.push_back(begun);
        for (const auto& of_key : setting) more.back().insert({of_key.key, of_key});
      }
    }
    all = std::move(more);
  }
  std::vector<std::vector<Override>> in_order(all.size());
  for (const auto& key : keys_of(variations)) {
    for (std::size_t i = 0; i < all.size(); ++i) {
      const auto found = all[i].find(key);
      in_order[i].push_back(found == all[i].end() ? Override{key, std::string()} : found->second);
    }
  }
  return in_order;
}

bool same_settings(const std::vector<Override>& a, const std::vector<Override>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const Override& x, const Override& y) { return x.key == y.key && text_of(x) == text_of(y); });
}

bool is_of(const std::vector<std::vector<Override>>& combinations, const std::vector<Override>& settings) {
  return std::any_of(combinations.begin(), combinations.end(),
                     [&](const auto& other) { return same_settings(other, settings); });
}

std::vector<std::vector<Override>> all_combinations(const StudyFile& file) {
  std::vector<std::vector<Override>> all;
  for (const auto& method : file.methods)
    for (auto& settings : combinations(file.variations, method.name))
      if (!is_of(all, settings)) all.push_back(std::move(settings));
  return all;
}

std::vector<Override> of_all_methods(const StudyFile& file, const std::vector<Override>& settings) {
  std::vector<Override> result;
  for (const auto& setting : settings) {
    const auto has_key = [&](const Variation& variation) {
      return variation.methods.empty() &&
             std::find(variation.keys.begin(), variation.keys.end(), setting.key) != variation.keys.end();
    };
    if (std::any_of(file.variations.begin(), file.variations.end(), has_key)) result.push_back(setting);
  }
  return result;
}

std::vector<Override> merged(std::vector<Override> settings, const std::vector<Override>& changes) {
  settings.insert(settings.end(), changes.begin(), changes.end());
  std::vector<Override> result;
  for (auto change = settings.begin(); change != settings.end(); ++change) {
    const auto again = [&](const Override& later) { return later.key == change->key; };
    const bool last = std::none_of(change + 1, settings.end(), again);
    if (last && !text_of(*change).empty()) result.push_back(*change);
  }
  return result;
}

std::string text_of(const Override& change) {
  if (const auto* text = std::get_if<std::string>(&change.value)) return *text;
  if (const auto* number = std::get_if<double>(&change.value)) return fmt::format("{}", *number);
  return fmt::format("{}", fmt::join(std::get<std::vector<double>>(change.value), " "));
}

}  // namespace ricochet::coupler

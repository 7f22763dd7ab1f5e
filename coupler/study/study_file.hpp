#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/scene/variant.hpp"

namespace ricochet::coupler {

/// The method of the runs: a protocol, and what it changes in the scene whatever is varied.
struct Method {
  std::string name, protocol;
  std::vector<scene::Override> changes;
};

/// One [[vary]] table: keys of the scene that take their values together, in the runs of all methods or of some.
struct Variation {
  std::vector<std::string> methods;  ///< empty: all
  std::vector<std::string> keys;
  std::vector<std::vector<scene::Override>> settings;  ///< one entry a setting, each with all keys
};

/// Runs of a study are compared with this: impedance theory, or a run of the scene with `changes`, whose own error
/// is its difference to a run with `refine` on top. One reference for every setting of the varied keys in `follow`.
struct ReferenceSpec {
  bool exact = false;
  std::vector<scene::Override> changes, refine;
  std::vector<std::string> follow;
};

/// Which histories are drawn over each other, over a stress with a name, and the method whose run at the same settings
/// the others are compared with (Eq. 29 of the paper); no quantity: none.
struct HistoriesSpec {
  std::string quantity;  ///< "contact_pressure" | "contact_pressure/CONTACT" | "principal_stress"
  double over_pa = 1.0;
  std::string over_name, compare_to;
  [[nodiscard]] bool wanted() const { return !quantity.empty(); }
};

/// A ratio of calculation times from elsewhere, set beside those of `methods` over `over` at the settings `at`.
struct PublishedRatio {
  std::vector<std::string> methods;
  std::string over;
  std::vector<scene::Override> at;
  double time_ratio = 0.0;
  std::string source;
};

/// Numbers that stand for the values of `along` on the axis of the charts over it.
struct StudyAxis {
  std::string title;                               ///< with its unit
  std::vector<std::pair<std::string, double>> at;  ///< text of each value of `along`, and its number
};

/// Measurements of one of the study's values, over the axis.
struct Measurement {
  std::string value;
  std::vector<double> at, measured;
  double error = 0.0;  ///< of each; 0: not known
  std::string source;
};

/// A study file, see docs/studies.md.
struct StudyFile {
  std::string path, scene;  ///< absolute
  std::string text;         ///< of the study file
  std::vector<Method> methods;
  std::vector<Variation> variations;
  std::vector<std::string> quantities;
  std::vector<std::string> values;  ///< of Scene::quantities_with_bars, told of each run beside its errors
  int repeats = 1;
  ReferenceSpec reference;
  std::string along;  ///< varied key over which errors and times are drawn; empty: none
  std::optional<StudyAxis> axis;
  HistoriesSpec histories;
  std::vector<PublishedRatio> published;
  std::vector<Measurement> measurements;
};

/// Reads a study file strictly: a key, value or scene key that does not exist is a ConfigError with file, line, key,
/// what was found and what is allowed.
[[nodiscard]] StudyFile load_study(const std::string& path);

[[nodiscard]] std::vector<std::string> method_names(const StudyFile& file);

/// The scene's keys that the study varies, each once, in the file's order.
[[nodiscard]] std::vector<std::string> varied_keys(const StudyFile& file);

/// Keys that tell the settings of a variation apart: its first key whose values all differ, else all of them.
[[nodiscard]] std::vector<std::string> telling_keys(const Variation& variation);

/// Every combination of the settings of a method's variations, with all varied keys in their order; one empty one
/// without variations. Keys that no variation of the method has have the empty text.
[[nodiscard]] std::vector<std::vector<scene::Override>> combinations(const std::vector<Variation>& variations,
                                                                     const std::string& method);

/// Those of all methods, each once.
[[nodiscard]] std::vector<std::vector<scene::Override>> all_combinations(const StudyFile& file);
[[nodiscard]] bool same_settings(const std::vector<scene::Override>& a, const std::vector<scene::Override>& b);
[[nodiscard]] bool is_of(const std::vector<std::vector<scene::Override>>& combinations,
                         const std::vector<scene::Override>& settings);

/// Settings of keys that all methods vary.
[[nodiscard]] std::vector<scene::Override> of_all_methods(const StudyFile& file,
                                                          const std::vector<scene::Override>& settings);

/// `changes` over `settings`: of a key that is set twice the last value counts; an empty text leaves the scene's own.
[[nodiscard]] std::vector<scene::Override> merged(std::vector<scene::Override> settings,
                                                  const std::vector<scene::Override>& changes);

/// A value as text: numbers with up to 17 digits, as few as tell it; lists with blanks between.
[[nodiscard]] std::string text_of(const scene::Override& change);

}  // namespace ricochet::coupler

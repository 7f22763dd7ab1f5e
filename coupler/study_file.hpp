#pragma once

#include <string>
#include <vector>

#include "common/scene/variant.hpp"

namespace ricochet::coupler {

/// One [[vary]] table: keys of the scene that take their values together.
struct Variation {
  std::vector<std::string> keys;
  std::vector<std::vector<scene::Override>> settings;  ///< one entry a setting, each with all keys
};

/// What the runs of a study are compared with: impedance theory, or a run of the scene with `changes`, whose own error
/// is its difference to a run with `refine` on top.
struct ReferenceSpec {
  bool exact = false;
  std::vector<scene::Override> changes, refine;
};

/// A study file, see docs/studies.md.
struct StudyFile {
  std::string path, scene;           ///< absolute
  std::string text;                  ///< of the study file
  std::vector<std::string> methods;  ///< protocols
  std::vector<Variation> variations;
  std::vector<std::string> quantities;
  int repeats = 1;
  ReferenceSpec reference;
};

/// Reads a study file strictly: a key, value or scene key that does not exist is a ConfigError with file, line, key,
/// what was found and what is allowed.
[[nodiscard]] StudyFile load_study(const std::string& path);

/// Every combination of the settings of all variations; one empty one without variations.
[[nodiscard]] std::vector<std::vector<scene::Override>> combinations(const std::vector<Variation>& variations);

/// A value as text: numbers with up to 17 digits, as few as tell it; lists with blanks between.
[[nodiscard]] std::string text_of(const scene::Override& change);

}  // namespace ricochet::coupler

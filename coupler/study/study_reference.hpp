#pragma once

#include <optional>
#include <string>
#include <vector>

#include "coupler/study/study_file.hpp"
#include "coupler/study/study_measures.hpp"

namespace ricochet::coupler {

/// The answer that the runs with some settings are compared with.
struct StudyReference {
  std::vector<scene::Override> follows;  ///< settings of the varied keys that it follows
  std::string text, key;                 ///< what it is; name of its folder, "exact" for theory
  Observation seen;
  std::vector<std::optional<double>> errors;  ///< its own, of the study's quantities
};

/// Computes what is not in `folder` yet, one reference for every setting of what it follows, and prints their own
/// errors. Throws what ends one of them.
[[nodiscard]] std::vector<StudyReference> find_references(const StudyFile& file, const std::string& folder);

/// The one that follows these settings.
[[nodiscard]] const StudyReference& reference_of(const std::vector<StudyReference>& references,
                                                 const std::vector<scene::Override>& settings);

}  // namespace ricochet::coupler

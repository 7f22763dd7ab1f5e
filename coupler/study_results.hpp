#pragma once

#include <optional>
#include <string>
#include <vector>

#include "coupler/study_case.hpp"
#include "coupler/study_file.hpp"

namespace ricochet::coupler {

/// A method with one setting of every variation.
struct StudyRow {
  std::string method;
  std::vector<scene::Override> settings;
  StudyCase run;
  std::vector<std::optional<double>> errors;  ///< of the study's quantities
};

/// "kim time.step_s=1e-07".
[[nodiscard]] std::string label_of(const StudyRow& row);

/// The scene's keys that the study varies, in the file's order.
[[nodiscard]] std::vector<std::string> varied_keys(const StudyFile& file);

/// results.csv: one line a row; times are medians over the repeats.
[[nodiscard]] std::string to_csv(const StudyFile& file, const std::vector<StudyRow>& rows);

/// The table at the end of a study.
[[nodiscard]] std::string to_table(const StudyFile& file, const std::vector<StudyRow>& rows);

}  // namespace ricochet::coupler

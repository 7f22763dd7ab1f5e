#pragma once

#include <optional>
#include <string>
#include <vector>

#include "coupler/study/companions.hpp"
#include "coupler/study/study_case.hpp"
#include "coupler/study/study_file.hpp"
#include "coupler/study/study_reference.hpp"

namespace ricochet::coupler {

/// A method with one setting of every variation.
struct StudyRow {
  std::string method;
  std::vector<scene::Override> settings;
  StudyCase run;
  std::optional<Observation> seen;            ///< once there is a repeat
  std::vector<std::optional<double>> errors;  ///< of the study's quantities
  Values values;                              ///< those that the run has
  /// RMS of the difference of the study's history from that of the reference, and from that of the method it is
  /// compared with at the same settings, over the study's stress (Eq. 29).
  std::optional<double> rms_reference, rms_compared;
};

/// "kim time.step_s=1e-07", by the keys that tell settings apart.
[[nodiscard]] std::string label_of(const StudyFile& file, const StudyRow& row);

/// results.csv: one line a row; times are medians over the repeats.
[[nodiscard]] std::string to_csv(const StudyFile& file, const std::vector<StudyRow>& rows);

/// histories.csv: the study's history of every reference and of every run that there is, over the study's stress.
[[nodiscard]] std::string histories_csv(const StudyFile& file, const std::vector<StudyReference>& references,
                                        const std::vector<StudyRow>& rows);

/// The table at the end of a study.
[[nodiscard]] std::string to_table(const StudyFile& file, const std::vector<StudyRow>& rows);

}  // namespace ricochet::coupler

#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/sha256.hpp"
#include "coupler/results/beginning.hpp"

namespace ricochet::coupler {

/// The window and the body that the name of a file of fields tells.
struct FieldName {
  std::int64_t window = 0;
  std::string body;  ///< "": a participant that is not ours wrote all its bodies into one file
};

/// Reads "<participant>.<body>_<window>.vtu" or "<participant>_<window>.vtu"; nothing if it is neither. (Names of
/// participants and bodies have no dot.)
[[nodiscard]] std::optional<FieldName> field_name(std::string_view file, std::string_view participant);

/// The SHA-256 of every result field that a run has written, in the file `checkpoint/fields.sha256` of its results: one
/// line each, in the order of the windows, as `sha256sum --check` reads them in the folder of the results.
///
/// Each field is read once in a run, when the first checkpoint after it is written. The list only grows, and a
/// checkpoint holds for its first bytes.
class FieldDigests {
 public:
  FieldDigests(std::string results, std::vector<std::string> participants);
  /// After a checkpoint at that window, whose list, which is whole, began so.
  FieldDigests(std::string results, std::vector<std::string> participants, std::int64_t window, const Beginning& list);

  /// Adds the fields up to that window which are not on the list yet. Throws as write_all would, and ConfigError.
  Beginning take(std::int64_t window);

  static constexpr const char* list_name = "checkpoint/fields.sha256";
  /// That the list begins so, and each field that it then names is as it was. Throws ConfigError that names the file.
  static void require(const std::string& results, const Beginning& list);

 private:
  [[nodiscard]] std::string lines_until(std::int64_t window) const;

  std::string results_;
  std::vector<std::string> participants_;
  std::int64_t window_ = -1;  ///< the last that is on the list
  std::int64_t bytes_ = 0;
  Sha256 digest_;  ///< of the list
};

}  // namespace ricochet::coupler

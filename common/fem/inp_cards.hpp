#pragma once

#include <string>
#include <vector>

namespace ricochet::fem {

struct InpParameter {
  std::string key;    ///< upper case
  std::string value;  ///< as written; empty where there is none
};

struct InpLine {
  int line = 0;
  std::vector<std::string> fields;  ///< without blanks around them
  bool goes_on = false;             ///< ends with a comma
};

/// One keyword line of an Abaqus or CalculiX input file and the data lines after it.
struct InpCard {
  int line = 0;
  std::string keyword;  ///< upper case, without blanks and the star: "NODE", "RIGIDBODY"
  std::vector<InpParameter> parameters;
  std::vector<InpLine> data;

  [[nodiscard]] const InpParameter* find(const std::string& key) const;
};

[[nodiscard]] std::string upper_case(std::string text);

/// The cards of a file, without comments; data lines of `kept` keywords alone. Throws ConfigError "file:line: ..." for
/// a file that cannot be read and for data before the first card.
[[nodiscard]] std::vector<InpCard> read_inp_cards(const std::string& path, const std::vector<std::string>& kept);

}  // namespace ricochet::fem

#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "common/base/archive.hpp"

namespace ricochet::coupler {

/// One way in which a run has left the model: small strain, small displacement, linear elastic, contact nodes that stay
/// opposite.
struct Departed {
  std::string kind;  ///< "strain" | "rotation" | "slip" | "inverted_element" | "off_partner" | "penetration" | "yield"
                     ///< | "tension" | "overlap"
  std::string body;
  double size = 0.0;                   ///< largest; what it is in `text`
  double first_s = 0.0, time_s = 0.0;  ///< of the first look that found it; of the largest
  double within_s = 0.0;               ///< of the last look that did not find it
  std::array<double, 3> place_m{};     ///< of the largest, in the reference configuration
  double first_size = 0.0;             ///< largest of the first look that found it
  std::array<double, 3> first_place_m{};
  std::int64_t looks = 0;  ///< that found it
  bool wrong = false;      ///< results are wrong from then on; else they have an error, which `text` says
  std::string text;

  void archive(Archive& a) {
    a(kind, body, size, first_s, time_s, within_s, place_m, first_size, first_place_m, looks, wrong, text);
  }
};

}  // namespace ricochet::coupler

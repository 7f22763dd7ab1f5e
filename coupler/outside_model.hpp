#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "coupler/overlap_watch.hpp"
#include "coupler/protocols/link.hpp"

namespace ricochet::coupler {

/// One way in which a run has left the model: small strain, small displacement, linear elastic, contact nodes that stay opposite.
struct Departed {
  std::string kind;  ///< "strain" | "rotation" | "slip" | "inverted_element" | "off_partner" | "penetration" | "overlap"
  std::string body;
  double size = 0.0;  ///< largest; what it is in `text`
  double first_s = 0.0, time_s = 0.0;  ///< of the first look that found it; of the largest
  double within_s = 0.0;               ///< of the last look that did not find it
  double x_m = 0.0, y_m = 0.0;         ///< place of the largest, in the reference configuration
  std::int64_t looks = 0;              ///< that found it
  bool wrong = false;                  ///< results are wrong from then on; else they have an error, which `text` says
  std::string text;
};

/// Collects what the participants tell of what has left the model, and sees for itself whether bodies overlap.
class OutsideModel {
 public:
  OutsideModel(const scene::Problem& problem, double window_size_s) : window_size_s_(window_size_s), overlaps_(problem, window_size_s) {}

  /// Call when the links have brought history rows; `window`: the last that all have accepted. Returns the texts of what was not
  /// known before.
  std::vector<std::string> update(const std::vector<Link>& links, std::int64_t window);
  /// History rows are to come often, whatever the protocol, since with them comes where bodies are that could meet.
  [[nodiscard]] bool watches_overlaps() const { return overlaps_.watches(); }
  [[nodiscard]] const std::vector<Departed>& found() const { return found_; }
  /// Up to when what was written is valid, if it is not to the end.
  [[nodiscard]] std::optional<double> valid_until_s() const;
  /// Throws ModelError if results are wrong.
  void stop_if_wrong() const;

 private:
  void take(const Link& link, std::vector<std::string>& news);
  void add(Departed departed, std::vector<std::string>& news);

  double window_size_s_;
  OverlapWatch overlaps_;
  std::vector<Departed> found_;
};

}  // namespace ricochet::coupler

#pragma once

#include <cstdint>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "coupler/interface/link.hpp"
#include "coupler/results/departed.hpp"
#include "coupler/watch/overlap_watch.hpp"

namespace ricochet::coupler {

/// Collects what the participants tell of what has left the model, and sees for itself whether bodies overlap.
class OutsideModel {
 public:
  /// `problem` must outlive it.
  explicit OutsideModel(const scene::Problem& problem) : problem_(problem), overlaps_(problem) {}

  /// Call when the links have brought history rows; `window`: the last that all have accepted. Returns the texts of
  /// what was not known before.
  std::vector<std::string> update(const std::vector<Link>& links, std::int64_t window);
  /// History rows are to come often, whatever the protocol, since with them comes where bodies are that could meet.
  [[nodiscard]] bool watches_overlaps() const { return overlaps_.watches(); }
  [[nodiscard]] const std::vector<Departed>& found() const { return found_; }
  /// Up to when what was written is valid, if it is not to the end.
  [[nodiscard]] std::optional<double> valid_until_s() const;
  void archive(Archive& a) { a(overlaps_, found_, last_update_s_); }
  /// A strain or a rotation from here on stops a run, unless coupling.outside_model has it go on [1, rad].
  static constexpr double strain_limit = 0.1, rotation_limit = std::numbers::pi / 18.0;
  /// Throws ModelError if results are wrong.
  void stop_if_wrong() const;

 private:
  void take(const Link& link, std::vector<std::string>& news);
  void add(Departed departed, std::vector<std::string>& news);
  [[nodiscard]] bool too_far(const Departed& departed) const;
  [[nodiscard]] std::string text_of(const Departed& departed) const;
  [[nodiscard]] std::string stress_text(const Departed& departed) const;
  [[nodiscard]] std::string place(const Departed& departed) const;

  const scene::Problem& problem_;
  OverlapWatch overlaps_;
  std::vector<Departed> found_;
  double last_update_s_ = 0.0;
};

}  // namespace ricochet::coupler

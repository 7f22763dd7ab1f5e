#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/base/archive.hpp"
#include "common/base/separation.hpp"
#include "common/body/body_state.hpp"
#include "common/contact/contact_surface.hpp"
#include "common/participant/participant.hpp"
#include "common/solver/axial_stress_shares.hpp"
#include "common/solver/model_watch.hpp"
#include "common/solver/probe_shares.hpp"
#include "common/solver/shape_recorder.hpp"
#include "common/solver/watched_outline.hpp"

namespace ricochet::solver {

/// A shipped solver tells this of its bodies beside the answers to the link: stress on the axis, probes and gauges,
/// what left the model, outlines, pictures, and how its contact stands. `states`: always the same whole parts.
class Reporting {
 public:
  /// Adds the columns of `axial_stress` and `probes` to the description.
  void describe(const scene::Problem& problem, const std::vector<BodyState>& states, participant::Description& d);
  /// Before the first window. `pressing`: of who enforces the contact; what it names must outlive this object unmoved.
  /// `windows_are_cheap`: see ModelWatch.
  void begin(const scene::Problem& problem, const std::vector<BodyState>& states, const participant::Setup& setup,
             const std::string& participant, PressedSurface pressing, bool windows_are_cheap);

  /// Whether `note` needs the states of `window`.
  [[nodiscard]] bool due(std::int64_t window) const { return model_watch_.due(window) || picture_due(window); }
  /// For who can do without a look at the model, where the states would cost more than windows do.
  [[nodiscard]] bool picture_due(std::int64_t window) const { return shapes_->due(window); }
  /// See ShapeRecorder.
  void note_touch(bool closed) { shapes_->note_touch(closed); }
  /// The motion at the start.
  void note_start() { shapes_->note(0); }
  /// After a window is accepted. `of_surface`: see ModelWatch::look.
  void note(std::int64_t window, const std::vector<BodyState>& states, const std::vector<BodyState>& of_surface);
  /// After the last one.
  void finish(std::int64_t window, const std::vector<BodyState>& states, const std::vector<BodyState>& of_surface);
  /// After a window is accepted, of who enforces the contact.
  void note_contact(std::int64_t window, const std::vector<BodyState>& of_surface, int pairs_closed);

  [[nodiscard]] participant::ContactStatus contact_status() const { return status_; }
  void append_axial_stress(const std::vector<BodyState>& states, std::int64_t window, std::vector<double>& row) {
    axial_stress_.append(states, window, row);
  }
  void append_probes(const std::vector<BodyState>& states, std::int64_t window, std::vector<double>& row) const {
    probes_.append(states, window, row);
  }
  /// The degrees of freedom of a part that `append_probes` reads.
  [[nodiscard]] std::vector<int> probed_dofs(std::size_t part, int components) const {
    return probes_.dofs_of(part, components);
  }
  [[nodiscard]] const std::vector<participant::Departure>& departures() const { return model_watch_.departures(); }
  [[nodiscard]] std::vector<participant::OutlineNode> outline(const std::vector<BodyState>& states) const {
    return outline_.nodes(states);
  }

  /// Part of the solver's state: the same contacts separate at the same windows.
  [[nodiscard]] const SeparationWatch& separation() const { return separation_; }
  void restore(const SeparationWatch& separation) { separation_ = separation; }
  /// All that was found and kept so far.
  void archive(Archive& a) { a(model_watch_, *shapes_); }

 private:
  const participant::Setup* setup_ = nullptr;  ///< from `begin` on
  const ContactSurface* surface_ = nullptr;
  AxialStressShares axial_stress_;
  ProbeShares probes_;
  ModelWatch model_watch_;
  WatchedOutline outline_;
  std::optional<ShapeRecorder> shapes_;  ///< from `begin` on
  SeparationWatch separation_;
  participant::ContactStatus status_;
};

}  // namespace ricochet::solver

#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "common/base/archive.hpp"
#include "common/body/body_state.hpp"
#include "common/contact/contact_surface.hpp"
#include "common/participant/participant.hpp"
#include "common/solver/stress_watch.hpp"

namespace ricochet::solver {

/// Looks for what small strain, small displacement and node pairs that stay opposite do not describe; of a part with a
/// frame strain and rotation are those in it:
///   strain      largest |principal strain| at an element's middle, hoop strain included
///   rotation    of the middle, atan2(H_21 - H_12, 2 + H_11 + H_22) of the displacement gradient H, of a solid with
///               twice the length of H's axial vector and 2 + tr H: exact for any rotation [rad]
///   inverted    smallest Jacobian at a corner of the moved element over that of the reference, <= 0
///   slip        of a closed pair of two bodies, or of a body and what is round, over the shorter edge at its nodes: so
///               far they are from being opposite
///   off_partner of a closed pair: how far a node is past the end of the other surface, over the edge there. From 1/2
///               on nothing of the surface that the node stands for faces the other body, which the slip says; from 1
///               on that is no matter of half an element, and a force there is wrong
///   penetration of a pair, over the depth of the shallower element behind it
///   yield, tension: see StressWatch
/// A look costs less than K u and is made every `every` windows. Once pairs have slipped, how far is looked at after
/// each, since a contact may be over sooner. At the stress of materials with a limit it looks after each window, or
/// every `stress_every` windows where that would cost too much of a window: of explicit elements that are no bars.
class ModelWatch {
 public:
  static constexpr std::int64_t every = 32, stress_every = 8;
  static constexpr double strain_limit = 0.02;
  static constexpr double rotation_limit = 0.034906585039886591;  ///< 2 degrees
  static constexpr double slip_limit = 0.5, off_limit = 1.0, penetration_limit = 1.0;

  ModelWatch() = default;  ///< looks at nothing
  /// `surface`: of who enforces the contact, else null; it must outlive the watch unmoved. `windows_are_cheap`: those
  /// of an explicit solver.
  ModelWatch(const scene::Problem& problem, const std::vector<BodyState>& states, const ContactSurface* surface,
             bool windows_are_cheap = false);

  /// After a window is accepted; `last`: no other follows, so it looks whatever the window is. Elements are looked at
  /// in `states`, and need to be up to date where it is `due` only; pairs in `of_surface`, whose numbering theirs is.
  void look(std::int64_t window, const std::vector<BodyState>& states, const std::vector<BodyState>& of_surface,
            bool last = false);
  void look(std::int64_t window, const std::vector<BodyState>& states, bool last = false) {
    look(window, states, states, last);
  }
  [[nodiscard]] bool due(std::int64_t window) const { return window % every == 0 || stress_due(window); }
  [[nodiscard]] const std::vector<participant::Departure>& departures() const { return found_; }
  /// All that was found so far, and since when.
  void archive(Archive& a) {
    a(slipped_, last_look_, last_stress_look_, last_window_);
    a.any_size(found_);
  }

 private:
  /// The numbers that an element's look needs of the reference.
  struct Element {
    Eigen::Matrix3d inverse_diagonals;  ///< of the kind's diagonals, one a dimension; identity beyond
    double shortest_edge_m = 0.0;
  };
  struct PairPlace {
    std::array<double, 2> along_m{};  ///< of its nodes in the reference, along the tangent and n x t
    double edge_m = 0.0;              ///< shorter edge at its nodes
    double depth_m = 0.0;             ///< smaller depth of the elements at its nodes
    Eigen::Vector3d x{0.0, 0.0, 0.0};
  };
  void prepare_elements(const std::vector<BodyState>& states);
  struct Ends {
    std::size_t low = 0, high = 0;  ///< pairs
  };
  /// The pairs of one contact.
  struct Stretch {
    std::size_t begin = 0, end = 0;
    bool places_differ = false;  ///< else a rigid plane, on which all places are alike
    bool follows = false;        ///< the rows follow what slides: nothing to say of it
    std::vector<Ends> ends;  ///< of matching surfaces, along the tangent and, of a solid, n x t; none if they repeat
  };
  void prepare_pairs(const scene::Problem& problem);
  void prepare_pairs(const scene::Problem& problem, const scene::ContactGeometry& contact,
                     const std::string& first_surface);
  void set_ends(const fem::Mesh& mesh, const scene::ContactGeometry& contact, const std::string& first_surface,
                Stretch& stretch);
  template <int dimension>
  void look_at_element(const Element& element, const fem::Element& nodes, const std::array<Eigen::Vector3d, 8>& u,
                       const Eigen::Vector3d& place, Worst& strain, Worst& rotation) const;
  void look_at_elements(std::int64_t window, const std::vector<BodyState>& states);
  void look_at_stress(std::int64_t window, const std::vector<BodyState>& states);
  [[nodiscard]] bool stress_due(std::int64_t window) const { return stress_.watches() && window % stress_every_ == 0; }
  void look_at_following(const std::vector<BodyState>& states, Worst& penetration) const;
  void look_at_pairs(std::int64_t window, const std::vector<BodyState>& states);
  void look_at_slipped(std::int64_t before, std::int64_t window, const std::vector<BodyState>& states);
  [[nodiscard]] double slip(std::size_t pair, const std::vector<BodyState>& states) const;
  [[nodiscard]] double along(std::size_t direction, std::size_t pair, Side side,
                             const std::vector<BodyState>& states) const;
  [[nodiscard]] double past_end(std::size_t pair, const std::vector<Ends>& ends,
                                const std::vector<BodyState>& states) const;
  void report(participant::DepartureKind kind, int part, std::int64_t last_without, std::int64_t window,
              const Worst& worst);

  std::vector<std::vector<Element>> elements_;  ///< per part
  const ContactSurface* surface_ = nullptr;
  std::vector<Pair> rows_;  ///< of the start
  std::vector<PairPlace> pairs_;
  std::vector<Stretch> stretches_;  ///< a contact each
  bool slipped_ = false;
  StressWatch stress_;
  std::int64_t stress_every_ = 1;
  std::int64_t last_look_ = 0, last_stress_look_ = 0, last_window_ = 0;
  std::vector<participant::Departure> found_;
};

}  // namespace ricochet::solver

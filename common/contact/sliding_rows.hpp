#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "common/base/archive.hpp"
#include "common/body/body_state.hpp"
#include "common/contact/contact_surface.hpp"
#include "common/problem/problem.hpp"

namespace ricochet::solver {

/// Writes the rows of contacts anew whose bodies slide along each other (ContactGeometry::sliding), for the place that
/// the second body has got to against the first:
///   s = l + d_B - d_A,   d = sum m u / sum m over the nodes of the body that are here
/// with l what it was lifted by at the start. A body slides as a whole, in its reference shape, and g0 is such that
/// g0 + N u is the gap of the surfaces there. (A participant that has a layer of a body alone takes that layer's mean.)
/// Along a coordinate in which a support holds nodes of its surface, as at a plane of symmetry, a body does not slide:
/// its mean displacement there is strain.
///
/// A body with large_rotation turns, too: by the rotation R that fits its nodes here best, in the measure of their
/// masses (rotation_of), about their centre. The rows are then those of the turned surfaces, anew when a node of
/// them has moved so far by the turn.
///
/// Rows are written with the second body moved from s along the normal n to where it touches the first, so that what
/// it moves along n, apart or together, leaves them right; the next rows are written when it has moved by `slide_share`
/// of the shortest edge of the first surface across n, then half that share ahead, so that in the mean forces act where
/// the bodies are. Each set of rows has forces that keep momentum and, in their place, angular momentum.
/// While bodies are apart by more than an edge the contact sleeps: rows are written where the bodies are, and stay
/// until these may be half an edge from each other.
///
/// Bodies deform, and the rows do not turn with them: rows that are written anew have other gaps g' than the old ones g
/// at the same motion, and the forces r do work sum r (g - g') while they close them. All gaps of a curved contact
/// therefore have an offset,
///   c = sum r (g - g') / sum r,   |c| <= slide_share of the edge,
/// with which that work is none. A pair that opens by more than that bound has left, and its work counts for nothing.
/// A pair without a force that overlaps with the new rows would be pushed apart within a window, at overlap over dt: a
/// corner that comes in from beside the other surface, or where c is negative. It has an offset of its own, by which it
/// touches as it is. Each is handed back as soon as it can be: c where no pair has a force, the other as its pair
/// opens.
class SlidingRows {
 public:
  static constexpr double slide_share = 0.01;

  /// `problem` must outlive it.
  SlidingRows(const scene::Problem& problem, const std::vector<BodyState>& states);

  /// Whether any contact may slide.
  [[nodiscard]] bool any() const { return !contacts_.empty(); }
  /// Brings the pairs to where the bodies are `ahead_s` later, at their present velocities. `forces` of the pairs in
  /// the window before work on jumps of gaps as these are `middle_s` later. Returns whether it wrote them anew.
  bool follow(const std::vector<BodyState>& states, double ahead_s, double middle_s,
              const std::vector<PairForce>& forces, std::vector<Pair>& pairs);

  struct Slide {
    bool follows = false, asleep = false;    ///< rows are others than those of the start; written apart
    Eigen::Vector3d shift_m{0.0, 0.0, 0.0};  ///< that the rows are written for
    Eigen::Vector3d normal{0.0, 0.0, 0.0};   ///< n, where the bodies then touch
    Eigen::Vector3d place_m{0.0, 0.0, 0.0};  ///< s when they were
    double free_m = 0.0;                     ///< how far from there it may get before it may touch
    double offset_m = 0.0;                   ///< c, that all gaps have
    /// Offset of one pair, by its node of the surface with the rows and its patch [m].
    struct Own {
      int node = -1, patch = 0;
      double offset_m = 0.0;

      void archive(Archive& a) { a(node, patch, offset_m); }
    };
    std::vector<Own> own{};  ///< of pairs that new rows would have overlap
    /// R of both bodies that the rows are written for.
    Eigen::Matrix3d turn_a = Eigen::Matrix3d::Identity(), turn_b = Eigen::Matrix3d::Identity();

    [[nodiscard]] double own_of(const Pair& pair) const;  ///< 0 where it has none [m]
    void archive(Archive& a) {
      a(follows, asleep, shift_m, normal, place_m, free_m, offset_m, turn_a, turn_b);
      a.any_size(own);
    }
  };
  using State = std::vector<Slide>;  ///< per contact of the scene that may slide
  [[nodiscard]] State state() const;
  /// Also writes the pairs of that state, if they are others than those of the start. Returns whether it wrote them.
  bool restore(const State& state, std::vector<Pair>& pairs);

 private:
  /// A body that turns: where its nodes here have their centre at the start, and how far from that its surface reaches.
  struct Turning {
    bool turns = false;
    Eigen::Vector3d centre_m{0.0, 0.0, 0.0};
    double reach_m = 0.0;
  };
  struct Sliding {
    std::size_t contact;
    Eigen::Vector3d moves_a, moves_b;  ///< per component 1, or 0 where a support holds some of the body's surface
    Turning turning_a, turning_b;
    Slide slide;
    std::optional<scene::TurnedSurfaces> turned{};  ///< of the slide
    bool changed = false;                           ///< rows are to be written
  };
  /// Where bodies are, and how they have turned.
  struct Pose {
    Eigen::Vector3d place_m;
    Eigen::Matrix3d turn_a, turn_b;
  };
  [[nodiscard]] Pose pose(const Sliding& sliding, const std::vector<BodyState>& states, double ahead_s) const;
  [[nodiscard]] bool stays(const Sliding& sliding, const Pose& pose, const std::vector<BodyState>& states,
                           const std::vector<Pair>& pairs) const;
  void move(Sliding& sliding, const Pose& pose, double gap_m) const;
  void turn(Sliding& sliding) const;
  [[nodiscard]] Turning turning_of(const scene::ContactGeometry& geometry, int body,
                                   const std::vector<BodyState>& states) const;
  [[nodiscard]] Eigen::Vector3d mean_motion(int body, const std::vector<BodyState>& states, double ahead_s) const;
  void write(std::vector<Pair>& pairs);
  void balance(const std::vector<Pair>& before, const std::vector<PairForce>& forces,
               const std::vector<BodyState>& states, double middle_s, const std::vector<Pair>& pairs);
  void offset(std::vector<Pair>& pairs);

  const scene::Problem* problem_;
  std::vector<PartNodes> parts_;
  std::vector<Sliding> contacts_;
};

/// Per pair of `to` the index of the same one (Pair::own_node) in `from`, or -1: what a law keeps stays with it.
[[nodiscard]] std::vector<int> same_pairs(const std::vector<Pair>& from, const std::vector<Pair>& to);

/// Values of pairs in the order of others (same_pairs); new ones are `fresh`.
template <class T>
[[nodiscard]] std::vector<T> carried(const std::vector<int>& same, const std::vector<T>& values, const T& fresh = {}) {
  std::vector<T> result;
  for (const int i : same) result.push_back(i < 0 ? fresh : values[static_cast<std::size_t>(i)]);
  return result;
}

}  // namespace ricochet::solver

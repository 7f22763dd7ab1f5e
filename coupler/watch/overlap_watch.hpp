#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "common/problem/outline.hpp"
#include "coupler/interface/link.hpp"

namespace ricochet::coupler {

/// Whether bodies overlap that have no contact between them, or have passed through one another since the last look: on
/// the straight way of every outline node from where it was to where it is, in steps that no body is thin enough to be
/// missed in. A body that not all participants tell the outline of is not watched.
class OverlapWatch {
 public:
  /// `problem` must outlive it.
  explicit OverlapWatch(const scene::Problem& problem);

  struct Found {
    std::string body, other;
    double depth_m = 0.0, time_s = 0.0,
           within_s = 0.0;  ///< within_s: end of the last window that is known to be without
    Eigen::Vector3d place{0.0, 0.0, 0.0};
  };
  /// What the links have told last, at the end of this window.
  std::vector<Found> update(const std::vector<Link>& links, std::int64_t window);
  [[nodiscard]] bool watches() const { return !pairs_.empty(); }
  void archive(Archive& a);

 private:
  struct Body {
    std::string name;
    scene::Shape shape;
    std::vector<bool> told;  ///< per node of the outline
    std::vector<Eigen::Vector3d> before, now;

    void archive(Archive& a);
  };
  void take(const Link& link);
  /// Moves a body to a share of the way since the last look.
  static void move(Body& body, double share);
  [[nodiscard]] int steps(const Body& a, const Body& b) const;
  static scene::Shape::Overlap overlap_at(Body& a, Body& b, double share);
  [[nodiscard]] double first_overlap(Body& a, Body& b) const;

  const scene::Problem& problem_;
  std::vector<scene::BodyPair> pairs_;
  std::vector<Body> bodies_;
  std::int64_t last_window_ = 0;
};

}  // namespace ricochet::coupler

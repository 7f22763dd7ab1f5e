#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "common/problem/outline.hpp"
#include "coupler/interface/link.hpp"

namespace ricochet::coupler {

/// Whether bodies overlap where no contact holds them apart, or have passed through one another since the last look: on
/// the straight way of every outline node from where it was to where it is, in steps that no body is thin enough to be
/// missed in. Watched are bodies that have no contact between them, and such of which other places may meet than the
/// contact's surfaces (scene::contacts_to_watch); rigid planes, too. A body that not all participants tell the outline
/// of is not watched.
class OverlapWatch {
 public:
  /// `problem` must outlive it.
  explicit OverlapWatch(const scene::Problem& problem);

  struct Found {
    std::string body, other;
    bool beside_contact = false;  ///< of the two, which have one
    double depth_m = 0.0, time_s = 0.0,
           within_s = 0.0;  ///< within_s: end of the last window that is known to be without
    Eigen::Vector3d place{0.0, 0.0, 0.0};
  };
  /// Takes what the links have told last, at the end of this window.
  std::vector<Found> update(const std::vector<Link>& links, std::int64_t window);
  [[nodiscard]] bool watches() const { return !bodies_.empty(); }
  void archive(Archive& a);

 private:
  struct Body {
    std::string name;
    scene::Shape shape;
    std::vector<bool> told;  ///< per node of the outline
    std::vector<Eigen::Vector3d> before, now;

    [[nodiscard]] bool all_told() const;
    void archive(Archive& a);
  };
  struct Pair {
    int first = 0, second = 0;  ///< indices into bodies_
    double tolerance_m = 0.0;
    Eigen::Vector3d lifted_m{0.0, 0.0, 0.0};  ///< ContactGeometry's: the second body is off its mesh
    bool beside_contact = false;
  };
  /// An obstacle, and the body that has a contact with it.
  struct Rigid {
    int body = 0;
    const char* name;
    scene::RigidShape shape;
    double tolerance_m = 0.0;
  };
  void take(const Link& link);
  void look_at(const Pair& pair, std::int64_t window, std::vector<Found>& found);
  void look_at(const Rigid& rigid, std::int64_t window, std::vector<Found>& found);
  [[nodiscard]] double time_s(std::int64_t window, double share) const;
  /// Moves a body to a share of the way since the last look.
  static void move(Body& body, double share, const Eigen::Vector3d& lifted_m = {0.0, 0.0, 0.0});
  [[nodiscard]] int steps(const Body& a, const Body& b) const;
  scene::Shape::Overlap overlap_at(const Pair& pair, double share);
  [[nodiscard]] double first_overlap(const Pair& pair);

  const scene::Problem& problem_;
  std::vector<Pair> pairs_;
  std::vector<Rigid> rigid_;
  std::vector<Body> bodies_;
  std::int64_t last_window_ = 0;
};

}  // namespace ricochet::coupler

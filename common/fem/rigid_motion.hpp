#pragma once

#include <Eigen/Core>

namespace ricochet::fem {

/// A motion without strain: X goes to `to_m` + R (X - `from_m`). In a plane R turns about the third axis.
struct RigidMotion {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  ///< R
  Eigen::Vector3d from_m{0.0, 0.0, 0.0}, to_m{0.0, 0.0, 0.0};

  [[nodiscard]] Eigen::Vector3d displacement(const Eigen::Vector3d& place) const {
    return to_m + rotation * (place - from_m) - place;
  }
};

}  // namespace ricochet::fem

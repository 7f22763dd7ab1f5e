#pragma once

#include <Eigen/Core>
#include <vector>

namespace ricochet::coupler {

/// Numbers of the wire as a vector to compute with, without a copy.
[[nodiscard]] inline Eigen::Map<const Eigen::VectorXd> view(const std::vector<double>& values) {
  return {values.data(), static_cast<Eigen::Index>(values.size())};
}

[[nodiscard]] inline std::vector<double> to_vector(const Eigen::VectorXd& values) {
  return {values.data(), values.data() + values.size()};
}

}  // namespace ricochet::coupler

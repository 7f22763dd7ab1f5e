#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/base/archive.hpp"

namespace ricochet::coupler {

/// Numbers of the wire as a vector to compute with, without a copy.
[[nodiscard]] inline Eigen::Map<const Eigen::VectorXd> view(const std::vector<double>& values) {
  return {values.data(), static_cast<Eigen::Index>(values.size())};
}

[[nodiscard]] inline std::vector<double> to_vector(const Eigen::VectorXd& values) {
  return {values.data(), values.data() + values.size()};
}

/// Keeps the size that it has.
inline void archive_matrix(Archive& a, Eigen::MatrixXd& matrix) {
  Eigen::VectorXd numbers = Eigen::Map<const Eigen::VectorXd>(matrix.data(), matrix.size());
  a(numbers);
  if (numbers.size() != matrix.size()) a.refuse("another interface");
  Eigen::Map<Eigen::VectorXd>(matrix.data(), matrix.size()) = numbers;
}

}  // namespace ricochet::coupler

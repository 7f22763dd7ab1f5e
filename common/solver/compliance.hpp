#pragma once

#include <Eigen/Core>
#include <functional>
#include <utility>

namespace ricochet::solver {

/// D of the contact problem [m/N], symmetric positive definite: contact forces x move their own gaps and slips by D x.
/// A small one is a dense matrix, which can be factored. Of a large one, D = G A^-1 G^T with A the sparse operator of a
/// whole body, nothing but the product is had, at the price of a solve with A; a dense one would cost the cube of the
/// number of contact pairs.
class Compliance {
 public:
  /// y = D x.
  using Product = std::function<void(const Eigen::VectorXd& x, Eigen::VectorXd& y)>;

  Compliance(Eigen::MatrixXd dense) : dense_(std::move(dense)), alone_(dense_.diagonal()) {}  // NOLINT: a matrix is one
  /// `bound`: diagonal, B - D positive semidefinite, as G M^-1 G^T is where A >= M; 0 where an unknown moves nothing.
  Compliance(Product product, Eigen::VectorXd bound) : product_(std::move(product)), alone_(std::move(bound)) {}

  [[nodiscard]] Eigen::Index size() const { return alone_.size(); }
  /// What an unknown moves its own row by; of a large one a bound.
  [[nodiscard]] double alone(Eigen::Index unknown) const { return alone_[unknown]; }
  /// Null if only the product is had.
  [[nodiscard]] const Eigen::MatrixXd* dense() const { return product_ ? nullptr : &dense_; }
  /// y = D x; they are not the same vector, and of one size.
  void times(const Eigen::VectorXd& x, Eigen::VectorXd& y) const {
    if (product_ && x.isZero(0.0)) {  // nothing touches
      y.setZero();
    } else if (product_) {
      product_(x, y);
    } else {
      y.noalias() = dense_ * x;
    }
  }

 private:
  Eigen::MatrixXd dense_;
  Product product_;
  Eigen::VectorXd alone_;
};

}  // namespace ricochet::solver

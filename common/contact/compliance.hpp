#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <array>
#include <functional>
#include <utility>

namespace ricochet::solver {

/// y += M x with the first columns of M, as many as x has, four at a time of those whose x is not zero: where a ball
/// touches, few pairs have a force, and those that have none change no bit.
inline void add_product(const Eigen::MatrixXd& m, const Eigen::VectorXd& x, Eigen::VectorXd& y) {
  std::array<Eigen::Index, 4> columns{};
  std::size_t found = 0;
  for (Eigen::Index column = 0; column < x.size(); ++column) {
    if (x[column] == 0.0) continue;
    columns[found++] = column;
    if (found < columns.size()) continue;
    const auto [a, b, c, d] = columns;
    y += x[a] * m.col(a) + x[b] * m.col(b) + x[c] * m.col(c) + x[d] * m.col(d);
    found = 0;
  }
  for (std::size_t k = 0; k < found; ++k) y += x[columns[k]] * m.col(columns[k]);
}

/// D of the contact problem [m/N], symmetric positive definite (a dense one, of contact inside local steps, but nearly
/// symmetric): contact forces x move their own gaps and slips by D x.
/// A small one is a dense matrix, which can be factored. For a large one, D = G A^-1 G^T with A the sparse operator of
/// a whole body, a dense one would cost the cube of the number of contact pairs. Where forces move little but what is
/// near, it is a sparse matrix; else nothing but the product is had, at the price of a solve with A.
class Compliance {
 public:
  using Sparse = Eigen::SparseMatrix<double, Eigen::RowMajor>;
  /// y = D x.
  using Product = std::function<void(const Eigen::VectorXd& x, Eigen::VectorXd& y)>;

  Compliance(Eigen::MatrixXd dense) : dense_(std::move(dense)), alone_(dense_.diagonal()) {}  // NOLINT: a matrix is one
  Compliance(Sparse sparse) : sparse_(std::move(sparse)), alone_(sparse_.diagonal()) {}       // NOLINT: a matrix is one
  /// `bound`: diagonal, B - D positive semidefinite, as G M^-1 G^T is where A >= M; 0 where an unknown moves nothing.
  Compliance(Product product, Eigen::VectorXd bound) : product_(std::move(product)), alone_(std::move(bound)) {}

  [[nodiscard]] Eigen::Index size() const { return alone_.size(); }
  /// The motion that an unknown gives its own row; where only the product is had, a bound.
  [[nodiscard]] double alone(Eigen::Index unknown) const { return alone_[unknown]; }
  /// Null if it is not dense, and if it is not sparse.
  [[nodiscard]] const Eigen::MatrixXd* dense() const { return has_columns() && !sparse() ? &dense_ : nullptr; }
  [[nodiscard]] const Sparse* sparse() const { return sparse_.size() > 0 ? &sparse_ : nullptr; }
  /// Whether a column costs less than all of them: not where only the product is had.
  [[nodiscard]] bool has_columns() const { return !product_; }
  /// y += D e change, e of the unknown.
  void add_column(Eigen::Index unknown, double change, Eigen::VectorXd& y) const {
    if (!sparse()) {
      y += change * dense_.col(unknown);
      return;
    }
    for (Sparse::InnerIterator it(sparse_, unknown); it; ++it) y[it.col()] += change * it.value();  // D is symmetric
  }
  [[nodiscard]] double entry(Eigen::Index row, Eigen::Index column) const {
    return sparse() ? sparse_.coeff(row, column) : dense_(row, column);
  }
  /// y = D x; they are not the same vector, and of one size.
  void times(const Eigen::VectorXd& x, Eigen::VectorXd& y) const {
    if (x.isZero(0.0)) {  // nothing touches
      y.setZero();
    } else if (product_) {
      product_(x, y);
    } else if (sparse()) {
      y.noalias() = sparse_ * x;
    } else {
      y.setZero();
      add_product(dense_, x, y);
    }
  }

 private:
  Eigen::MatrixXd dense_;
  Sparse sparse_;
  Product product_;
  Eigen::VectorXd alone_;
};

}  // namespace ricochet::solver

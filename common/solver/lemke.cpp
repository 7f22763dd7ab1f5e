#include "common/solver/lemke.hpp"

#include <cmath>
#include <vector>

namespace ricochet::solver {
namespace {

/// Pivots below this share of the tableau's entries are round-off.
constexpr double smallest_pivot = 1e-11;
constexpr int pivots_per_unknown = 50;

/// Rows basis = q + ..., columns w (0 .. n-1), z (n .. 2n-1), the covering variable z0 (2n), the right-hand side (2n +
/// 1).
class Tableau {
 public:
  Tableau(const Eigen::MatrixXd& m, const Eigen::VectorXd& q)
      : n_(static_cast<int>(q.size())), rows_(n_, 2 * n_ + 2), basis_(static_cast<std::size_t>(n_)) {
    rows_.leftCols(n_).setIdentity();
    rows_.middleCols(n_, n_) = -m;
    rows_.col(2 * n_).setConstant(-1.0);
    rows_.col(2 * n_ + 1) = q;
    for (int i = 0; i < n_; ++i) basis_[static_cast<std::size_t>(i)] = i;
  }
  [[nodiscard]] int covering() const { return 2 * n_; }
  [[nodiscard]] int complement(int variable) const { return variable < n_ ? variable + n_ : variable - n_; }

  /// Brings `entering` into the basis at `row`; the variable that leaves.
  int pivot(int row, int entering) {
    rows_.row(row) /= rows_(row, entering);
    for (int i = 0; i < n_; ++i) {
      const double factor = rows_(i, entering);
      if (i != row && factor != 0.0) rows_.row(i) -= factor * rows_.row(row);
    }
    std::swap(basis_[static_cast<std::size_t>(row)], entering);
    return entering;
  }
  /// Row of the smallest ratio; where ratios are equal the covering variable's, else that of the largest pivot. -1:
  /// none.
  [[nodiscard]] int leaving(int entering) const {
    const double threshold = smallest_pivot * rows_.col(entering).cwiseAbs().maxCoeff();
    int best = -1;
    double least = 0.0;
    for (int i = 0; i < n_; ++i) {
      const double pivot = rows_(i, entering);
      if (!(pivot > threshold)) continue;
      const double ratio = std::max(0.0, rows_(i, 2 * n_ + 1)) / pivot;
      const double tie = 1e-12 * (1.0 + least);
      const bool better = best < 0 || ratio < least - tie;
      const bool equal = best >= 0 && !better && ratio <= least + tie;
      const auto covers = [&](int row) { return basis_[static_cast<std::size_t>(row)] == covering(); };
      if (better || (equal && !covers(best) && (covers(i) || pivot > rows_(best, entering)))) {
        best = i;
        least = ratio;
      }
    }
    return best;
  }
  [[nodiscard]] Eigen::VectorXd solution() const {
    Eigen::VectorXd z = Eigen::VectorXd::Zero(n_);
    for (int i = 0; i < n_; ++i) {
      const int variable = basis_[static_cast<std::size_t>(i)];
      if (variable >= n_ && variable < 2 * n_) z[variable - n_] = std::max(0.0, rows_(i, 2 * n_ + 1));
    }
    return z;
  }

 private:
  int n_;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> rows_;
  std::vector<int> basis_;
};

}  // namespace

int solve_lemke(const Eigen::MatrixXd& m, const Eigen::VectorXd& q, Eigen::VectorXd& z) {
  z.resize(0);
  const double scale = q.cwiseAbs().maxCoeff();
  Eigen::Index first = 0;
  if (!(q.minCoeff(&first) < 0.0)) {
    z.setZero(q.size());
    return 0;
  }
  Tableau tableau(m, q / scale);
  int entering = tableau.complement(tableau.pivot(static_cast<int>(first), tableau.covering()));
  const int most = pivots_per_unknown * static_cast<int>(q.size());
  for (int pivots = 2; pivots <= most; ++pivots) {
    const int row = tableau.leaving(entering);
    if (row < 0) return pivots;
    const int left = tableau.pivot(row, entering);
    if (left == tableau.covering()) {
      z = scale * tableau.solution();
      return pivots;
    }
    entering = tableau.complement(left);
  }
  return most;
}

}  // namespace ricochet::solver

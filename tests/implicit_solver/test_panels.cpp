#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "implicit_solver/panels.hpp"

namespace ricochet::implicit_solver {
namespace {

Eigen::MatrixXd random_matrix(int rows, int columns) {
  std::mt19937 random(static_cast<unsigned>(100 * rows + columns));
  std::normal_distribution<double> normal;
  return Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return normal(random); });
}

/// A matrix in panels, and vectors to multiply it by, with zeros behind y.
struct InPanels {
  Eigen::MatrixXd a;
  Eigen::VectorXd x, y;
  std::vector<double> values;

  InPanels(int rows, int columns)
      : a(random_matrix(rows, columns)),
        x(random_matrix(columns, 1)),
        y(Eigen::VectorXd::Zero(padded(rows))),
        values(panel_values(rows, columns)) {
    y.head(rows) = random_matrix(rows, 1);
    store_in_panels(a, values.data());
  }
  [[nodiscard]] int rows() const { return static_cast<int>(a.rows()); }
  [[nodiscard]] int columns() const { return static_cast<int>(a.cols()); }
  [[nodiscard]] Eigen::VectorXd product(const std::vector<int>& shares) const {
    Eigen::VectorXd result = Eigen::VectorXd::Constant(padded(rows()), -7.0);
    for (std::size_t k = 1; k < shares.size(); ++k)
      times_panels(values.data(), rows(), columns(), shares[k - 1], shares[k], x.data(), result.data());
    return result;
  }
  [[nodiscard]] Eigen::VectorXd transposed_product(const std::vector<int>& shares) const {
    Eigen::VectorXd result = Eigen::VectorXd::Constant(columns(), -7.0), sums(4 * columns());
    for (std::size_t k = 1; k < shares.size(); ++k)
      times_transposed_panels(values.data(), rows(), columns(), shares[k - 1], shares[k], y.data(), result.data(),
                              sums.data());
    return result;
  }
};

TEST(Panels, MultiplyAsTheMatrixDoesThatIsStoredInThem) {
  for (int rows = 1; rows < 53; ++rows) {
    for (int columns = 1; columns <= rows && columns < 19; ++columns) {
      const InPanels in(rows, columns);
      const Eigen::VectorXd product = in.product({0, panels_of(rows)});
      EXPECT_LT((product.head(rows) - in.a * in.x).cwiseAbs().maxCoeff(), 1e-13) << rows << " x " << columns;
      EXPECT_LT((in.transposed_product({0, columns}) - in.a.transpose() * in.y.head(rows)).cwiseAbs().maxCoeff(), 1e-13)
          << rows << " x " << columns;
    }
  }
}

TEST(Panels, ArePartedWithoutAChangeOfAnyBit) {
  for (int rows = 49; rows <= 64; ++rows) {
    const InPanels in(rows, 18);
    EXPECT_EQ(in.product({0, 1, 3, 4}), in.product({0, 4})) << rows;
    EXPECT_EQ(in.transposed_product({0, 1, 6, 11, 18}), in.transposed_product({0, 18})) << rows;
  }
}

}  // namespace
}  // namespace ricochet::implicit_solver

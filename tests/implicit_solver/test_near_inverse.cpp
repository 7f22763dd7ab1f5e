#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>

#include "implicit_solver/contact/near_inverse.hpp"

namespace ricochet::implicit_solver {
namespace {

/// Two rows of nodes, 1 m apart, with two degrees of freedom each. From node to node A^-1 falls by the same power.
struct Rows {
  std::vector<NearNode> nodes;
  Eigen::MatrixXd operator_matrix;
  int solves = 0;

  Rows(int count, double coupling) {
    for (int i = 0; i < 2 * count; ++i)
      nodes.push_back({Eigen::Vector3d(i % count, 0.0, i / count), i / count, {2 * i, 2 * i + 1}});
    operator_matrix = Eigen::MatrixXd::Identity(4 * count, 4 * count);
    for (int i = 0; i < 2 * count; ++i) {
      operator_matrix.block<2, 2>(2 * i, 2 * i) << 1.0 + 0.1 * (i % 3), 0.05, 0.05, 0.8;
      if (i % count > 0) couple(i - 1, i, coupling);
    }
  }
  void couple(int i, int j, double by) {
    for (const auto& [row, column] : {std::pair{2 * i, 2 * j}, std::pair{2 * i + 1, 2 * j + 1}})
      operator_matrix(row, column) = operator_matrix(column, row) = -by;
  }
  std::optional<Eigen::SparseMatrix<double, Eigen::RowMajor>> inverse(int most_solves = 800) {
    const Eigen::LLT<Eigen::MatrixXd> factor(operator_matrix);
    const auto solve = [&](const Eigen::VectorXd& forces, Eigen::VectorXd& motion) {
      ++solves;
      motion = factor.solve(forces);
    };
    const auto groups = near_groups(nodes, most_solves, solve);
    return groups ? near_inverse(nodes, *groups, solve) : std::nullopt;
  }
};

TEST(NearInverse, IsTheInverseInFewEntriesAndAsManySolvesForAnyNumberOfNodes) {
  int of_few = 0;
  for (const int count : {100, 300}) {
    Rows rows(count, 0.1);
    const auto found = rows.inverse();
    ASSERT_TRUE(found);
    const Eigen::MatrixXd exact = rows.operator_matrix.inverse();
    EXPECT_LT((Eigen::MatrixXd(*found) - exact).cwiseAbs().maxCoeff(), 1e-15 * exact.maxCoeff());
    EXPECT_LT(found->nonZeros(), 80 * found->rows());
    EXPECT_LT(rows.solves, 150);
    EXPECT_EQ(rows.solves, of_few > 0 ? of_few : rows.solves);
    of_few = rows.solves;
  }
}

TEST(NearInverse, IsNotHadWhereForcesMoveWhatIsFar) {
  EXPECT_TRUE(Rows(100, 0.1).inverse(100));
  EXPECT_FALSE(Rows(100, 0.38).inverse(100)) << "falls by a third from node to node only";
}

/// As of a row that is periodic: the distance that is measured elsewhere says nothing of its two ends.
TEST(NearInverse, IsNotHadWhereAProductWithItIsWrong) {
  Rows rows(200, 0.1);
  rows.couple(28, 86, 0.1);
  EXPECT_FALSE(rows.inverse());
}

TEST(NearInverse, OfAnOperatorWithoutCouplingIsItsDiagonal) {
  Rows rows(20, 0.0);
  for (int i = 0; i < 80; i += 2) rows.operator_matrix(i, i + 1) = rows.operator_matrix(i + 1, i) = 0.0;
  const auto found = rows.inverse();
  ASSERT_TRUE(found);
  EXPECT_EQ(found->nonZeros(), 80);
}

}  // namespace
}  // namespace ricochet::implicit_solver

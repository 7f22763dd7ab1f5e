#include <gtest/gtest.h>

#include <Eigen/Core>

#include "implicit_solver/contact/kept_columns.hpp"

namespace ricochet::implicit_solver {
namespace {

/// Rows come and go as surfaces slide: the columns of other rows are no columns of these.
TEST(KeptColumns, BeginAnewForForcesOfAnotherNumber) {
  Eigen::MatrixXd a = Eigen::MatrixXd::Random(4, 4);
  int solves = 0;
  KeptColumns kept(
      [&](const Eigen::VectorXd& forces, Eigen::VectorXd& motion) {
        ++solves;
        motion = a * forces;
      },
      2, 6);
  Eigen::VectorXd motion;
  for (const Eigen::Index size : {4, 90, 3}) {
    a = Eigen::MatrixXd::Random(size, size);
    solves = 0;
    for (const double force : {1.0, 2.0}) {
      const Eigen::VectorXd forces = force * Eigen::VectorXd::Unit(size, size - 1);
      kept(forces, motion);
      EXPECT_LT((motion - a * forces).norm(), 1e-14) << size;
    }
    EXPECT_EQ(solves, 1) << size << ": the second time it is kept";
    kept(Eigen::VectorXd::Ones(size), motion);
    EXPECT_LT((motion - a.rowwise().sum()).norm(), 1e-13 * static_cast<double>(size)) << "more than it keeps at once";
  }
}

}  // namespace
}  // namespace ricochet::implicit_solver

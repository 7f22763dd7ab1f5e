#include <gtest/gtest.h>

#include <Eigen/Core>

#include "implicit_solver/contact/kept_columns.hpp"

namespace ricochet::implicit_solver {
namespace {

constexpr Eigen::Index size = 40;

/// A dense matrix whose products are counted.
struct Counted {
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Random(size, size);
  int products = 0;

  KeptColumns columns(Eigen::Index most_pushed, Eigen::Index most_kept) {
    const auto product = [this](const Eigen::VectorXd& forces, Eigen::VectorXd& motion) {
      ++products;
      motion = matrix * forces;
    };
    return {product, most_pushed, most_kept};
  }
};

/// Forces on `count` from `first` on, others zero.
Eigen::VectorXd forces_on(Eigen::Index first, Eigen::Index count) {
  Eigen::VectorXd forces = Eigen::VectorXd::Zero(size);
  forces.segment(first, count) = Eigen::VectorXd::LinSpaced(count, 1.0, 2.0);
  return forces;
}

TEST(KeptColumns, OfFewForcesAskForEachColumnOnce) {
  Counted of;
  auto columns = of.columns(5, 20);
  Eigen::VectorXd motion;
  for (int again = 0; again < 3; ++again) {
    columns(forces_on(3, 5), motion);
    EXPECT_LT((motion - of.matrix * forces_on(3, 5)).cwiseAbs().maxCoeff(), 1e-14);
    EXPECT_EQ(of.products, 5);
  }
  columns(forces_on(6, 4), motion);
  EXPECT_EQ(of.products, 7) << "two of the four are new";
}

TEST(KeptColumns, OfManyForcesAskForTheProduct) {
  Counted of;
  auto columns = of.columns(5, 20);
  Eigen::VectorXd motion;
  columns(forces_on(3, 6), motion);
  EXPECT_EQ(motion, of.matrix * forces_on(3, 6)) << "its bits";
  EXPECT_EQ(of.products, 1);
}

/// The columns that a run has kept which goes on from a checkpoint are not what one has that was never stopped.
TEST(KeptColumns, GiveTheSameBitsWhateverIsKept) {
  Counted of;
  auto wandered = of.columns(5, 10), fresh = of.columns(5, 10);
  Eigen::VectorXd motion, anew;
  for (Eigen::Index first = 0; first + 5 <= size; first += 3) wandered(forces_on(first, 5), motion);
  wandered(forces_on(2, 5), motion);
  fresh(forces_on(2, 5), anew);
  EXPECT_EQ(motion, anew);
}

TEST(KeptColumns, GoWhereAContactThatWandersHasLeftThemBehind) {
  Counted of;
  auto columns = of.columns(5, 10);
  Eigen::VectorXd motion;
  for (const Eigen::Index first : {0, 5, 10, 10}) columns(forces_on(first, 5), motion);
  EXPECT_EQ(of.products, 15);
  columns(forces_on(0, 5), motion);
  EXPECT_EQ(of.products, 20) << "they were dropped for the third five";
}

/// Rows come and go as surfaces slide: the columns of other rows are no columns of these.
TEST(KeptColumns, BeginAnewForForcesOfAnotherNumber) {
  Counted of;
  auto columns = of.columns(2, 6);
  Eigen::VectorXd motion;
  for (const Eigen::Index rows : {size, size + 50, Eigen::Index{3}}) {
    of.matrix = Eigen::MatrixXd::Random(rows, rows);
    of.products = 0;
    for (const double force : {1.0, 2.0}) {
      columns(force * Eigen::VectorXd::Unit(rows, rows - 1), motion);
      EXPECT_EQ(motion, force * of.matrix.col(rows - 1)) << rows;
    }
    EXPECT_EQ(of.products, 1) << rows << ": the second time it is kept";
    columns(Eigen::VectorXd::Ones(rows), motion);
    EXPECT_EQ(motion.size(), rows) << "more than it keeps at once";
    EXPECT_EQ(of.products, 2) << rows;
  }
}

}  // namespace
}  // namespace ricochet::implicit_solver

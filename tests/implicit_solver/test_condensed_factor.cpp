#include <SuiteSparse_config.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <new>
#include <random>
#include <string>

#include "common/base/error.hpp"
#include "implicit_solver/condensed_factor.hpp"

namespace ricochet::implicit_solver {
namespace {

/// Five-point stencil on a grid, shifted to be positive definite.
fem::SparseMatrix grid_operator(int nx, int ny, double shift) {
  std::vector<Eigen::Triplet<double>> entries;
  const auto node = [&](int i, int j) { return j * nx + i; };
  for (int j = 0; j < ny; ++j) {
    for (int i = 0; i < nx; ++i) {
      entries.emplace_back(node(i, j), node(i, j), 4.0 + shift);
      if (i + 1 < nx)
        entries.emplace_back(node(i, j), node(i + 1, j), -1.0), entries.emplace_back(node(i + 1, j), node(i, j), -1.0);
      if (j + 1 < ny)
        entries.emplace_back(node(i, j), node(i, j + 1), -1.0), entries.emplace_back(node(i, j + 1), node(i, j), -1.0);
    }
  }
  fem::SparseMatrix a(nx * ny, nx * ny);
  a.setFromTriplets(entries.begin(), entries.end());
  return a;
}

struct Case {
  fem::SparseMatrix a = grid_operator(13, 9, 0.1);
  std::vector<bool> active = std::vector<bool>(117, true);
  std::vector<int> root = {5, 50, 3, 116, 77};
  Eigen::VectorXd b;

  Case() {
    active[10] = active[60] = false;
    std::mt19937 random(3);
    std::normal_distribution<double> normal;
    b = Eigen::VectorXd::NullaryExpr(117, [&] { return normal(random); });
  }
  /// Dense A with the inactive rows and columns replaced by the identity.
  [[nodiscard]] Eigen::MatrixXd dense() const {
    Eigen::MatrixXd d = a;
    for (int i = 0; i < 117; ++i) {
      if (active[static_cast<std::size_t>(i)]) continue;
      d.row(i).setZero();
      d.col(i).setZero();
      d(i, i) = 1.0;
    }
    return d;
  }
};

TEST(CondensedFactor, ForwardRootBackwardEqualsADenseSolve) {
  const Case c;
  CondensedFactor factor(c.a, c.active, c.root);
  factor.forward(c.b);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(117);
  factor.backward(factor.root_inverse() * factor.root_rhs(), x);
  Eigen::VectorXd masked = c.b;
  masked[10] = masked[60] = 0.0;
  const Eigen::VectorXd expected = c.dense().ldlt().solve(masked);
  EXPECT_LT((x - expected).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(CondensedFactor, RootInverseIsTheRootBlockOfTheInverse) {
  const Case c;
  const CondensedFactor factor(c.a, c.active, c.root);
  const Eigen::MatrixXd inverse = c.dense().inverse();
  for (std::size_t i = 0; i < c.root.size(); ++i) {
    for (std::size_t j = 0; j < c.root.size(); ++j) {
      EXPECT_NEAR(factor.root_inverse()(static_cast<int>(i), static_cast<int>(j)), inverse(c.root[i], c.root[j]),
                  1e-13);
    }
  }
}

TEST(CondensedFactor, ForcesOnTheRootNeedNoSecondElimination) {
  const Case c;
  CondensedFactor factor(c.a, c.active, c.root);
  Eigen::VectorXd loaded = c.b, force = Eigen::VectorXd::LinSpaced(5, -1.0, 2.0);
  for (std::size_t i = 0; i < c.root.size(); ++i) loaded[c.root[i]] += force[static_cast<int>(i)];
  factor.forward(c.b);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(117), y = x;
  factor.backward(factor.root_inverse() * (factor.root_rhs() + force), x);
  factor.forward(loaded);
  factor.backward(factor.root_inverse() * factor.root_rhs(), y);
  EXPECT_LT((x - y).cwiseAbs().maxCoeff(), 1e-13);
}

/// Blocks are stored as the inverse of their triangle: that must not cost digits where the operator is hardly definite.
TEST(CondensedFactor, LeavesTheResidualOfRoundOffOfAnIllConditionedOperator) {
  const int nodes = 60 * 40;
  constexpr double pi = 3.14159265358979323846;
  const double least_eigenvalue = 4.0 - 2.0 * std::cos(pi / 61.0) - 2.0 * std::cos(pi / 41.0);  // without a shift
  const fem::SparseMatrix a = grid_operator(60, 40, -least_eigenvalue * (1.0 - 1e-9));          // condition 1e12
  const std::vector<int> root = {5, 50, 2399};
  const Eigen::VectorXd b = Eigen::VectorXd::NullaryExpr(nodes, [](Eigen::Index i) { return std::sin(1.7 * i); });
  CondensedFactor factor(a, std::vector<bool>(static_cast<std::size_t>(nodes), true), root);
  factor.forward(b);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(nodes);
  factor.backward(factor.root_inverse() * factor.root_rhs(), x);
  const double size = 8.0 * x.cwiseAbs().maxCoeff() + b.cwiseAbs().maxCoeff();  // of what is summed
  EXPECT_LT((a * x - b).cwiseAbs().maxCoeff(), 1e-14 * size);
}

/// Solves A x = b by some threads; b is rough.
Eigen::VectorXd solve_by(int threads, const fem::SparseMatrix& a, const std::vector<int>& root) {
  std::vector<bool> active(static_cast<std::size_t>(a.rows()), true);
  active[7] = false;
  CondensedFactor factor(a, active, root, threads > 0 ? std::make_shared<Parallel>(threads) : nullptr);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(a.rows()), b(a.rows());
  for (int i = 0; i < b.size(); ++i) b[i] = std::sin(1.7 * i);
  factor.forward(b);
  factor.backward(factor.root_inverse() * factor.root_rhs(), x);
  const Eigen::VectorXd once = x;
  factor.forward(b);  // what the first solve left behind does not count
  factor.backward(factor.root_inverse() * factor.root_rhs(), x);
  EXPECT_EQ(x, once);
  Eigen::VectorXd residual = a * x - b;
  residual[7] = 0.0;
  EXPECT_LT(residual.cwiseAbs().maxCoeff(), 1e-12);
  return x;
}

TEST(CondensedFactor, HasTheSameBitsByAnyNumberOfThreads) {
  const fem::SparseMatrix a = grid_operator(150, 140, 0.01);
  for (const std::vector<int>& root : {std::vector<int>{}, std::vector<int>{5, 20000, 3, 9000}}) {
    const Eigen::VectorXd alone = solve_by(0, a, root);
    for (const int threads : {1, 2, 3, 7}) EXPECT_EQ(solve_by(threads, a, root), alone) << threads;
  }
}

TEST(CondensedFactor, RefusesAnOperatorThatIsNotPositiveDefinite) {
  const Case c;
  EXPECT_THROW(CondensedFactor(grid_operator(13, 9, -4.5), c.active, c.root), SolverError);
}

TEST(CondensedFactor, HoldsASingleUnknownToo) {
  for (const std::vector<int>& root : {std::vector<int>{}, std::vector<int>{1}}) {
    const fem::SparseMatrix a = grid_operator(3, 1, 0.5);
    CondensedFactor factor(a, {false, true, false}, root);
    factor.forward(Eigen::Vector3d(7.0, 9.0, 7.0));
    Eigen::VectorXd x = Eigen::VectorXd::Zero(3);
    factor.backward(factor.root_inverse() * factor.root_rhs(), x);
    EXPECT_LT((x - Eigen::Vector3d(0.0, 2.0, 0.0)).norm(), 1e-15) << root.size();
  }
}

/// Lets CHOLMOD have so many allocations and no more.
class ScarceMemory {
 public:
  explicit ScarceMemory(int allocations) {
    left = allocations;
    SuiteSparse_config.malloc_func = [](std::size_t size) { return left-- > 0 ? std::malloc(size) : nullptr; };
    SuiteSparse_config.calloc_func = [](std::size_t n, std::size_t size) {
      return left-- > 0 ? std::calloc(n, size) : nullptr;
    };
    SuiteSparse_config.realloc_func = [](void* p, std::size_t size) {
      return left-- > 0 ? std::realloc(p, size) : nullptr;
    };
  }
  ScarceMemory(const ScarceMemory&) = delete;
  ScarceMemory& operator=(const ScarceMemory&) = delete;
  ~ScarceMemory() {
    SuiteSparse_config.malloc_func = std::malloc;
    SuiteSparse_config.calloc_func = std::calloc;
    SuiteSparse_config.realloc_func = std::realloc;
  }

 private:
  static inline int left = 0;
};

TEST(CondensedFactor, SaysSoWhenCholmodRunsOutOfMemoryWhereverThatIs) {
  const Case c;
  int allocations = 0;
  for (bool done = false; !done; ++allocations) {
    ASSERT_LT(allocations, 1000);
    const ScarceMemory scarce(allocations);
    try {
      const CondensedFactor factor(c.a, c.active, c.root);
      done = true;
    } catch (const std::bad_alloc&) {  // SolverError would blame the scene
    }
  }
  EXPECT_GT(allocations, 20);
}

}  // namespace
}  // namespace ricochet::implicit_solver

// The linear problem of RootProblem for the present states: by a dense factor, or by products alone.
#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCore>
#include <functional>

#include "common/solver/root_problem.hpp"

namespace ricochet::solver {
class StatesMatrix;
}
// This and the product below are what Eigen's manual asks for ("Matrix-free solvers").
template <>
struct Eigen::internal::traits<ricochet::solver::StatesMatrix>
    : public Eigen::internal::traits<Eigen::SparseMatrix<double>> {};

namespace ricochet::solver {
/// A matrix of which BiCGSTAB gets products only.
class StatesMatrix : public Eigen::EigenBase<StatesMatrix> {
 public:
  using Scalar = double;
  using RealScalar = double;
  using StorageIndex = int;
  enum { ColsAtCompileTime = Eigen::Dynamic, MaxColsAtCompileTime = Eigen::Dynamic, IsRowMajor = false };

  StatesMatrix(std::function<void(const Eigen::VectorXd&, Eigen::VectorXd&)> times, Eigen::Index size)
      : times_(std::move(times)), size_(size) {}
  [[nodiscard]] Eigen::Index rows() const { return size_; }
  [[nodiscard]] Eigen::Index cols() const { return size_; }
  [[nodiscard]] Eigen::VectorXd times(const Eigen::VectorXd& x) const {
    Eigen::VectorXd y(size_);
    times_(x, y);
    return y;
  }
  template <class Right>
  Eigen::Product<StatesMatrix, Right, Eigen::AliasFreeProduct> operator*(const Eigen::MatrixBase<Right>& x) const {
    return {*this, x.derived()};
  }

 private:
  std::function<void(const Eigen::VectorXd&, Eigen::VectorXd&)> times_;
  Eigen::Index size_;
};
}  // namespace ricochet::solver

template <class Right>
struct Eigen::internal::generic_product_impl<ricochet::solver::StatesMatrix, Right, Eigen::SparseShape,
                                             Eigen::DenseShape, Eigen::GemvProduct>
    : Eigen::internal::generic_product_impl_base<
          ricochet::solver::StatesMatrix, Right,
          Eigen::internal::generic_product_impl<ricochet::solver::StatesMatrix, Right>> {
  template <class To>
  static void scaleAndAddTo(To& to, const ricochet::solver::StatesMatrix& matrix, const Right& x, double factor) {
    to.noalias() += factor * matrix.times(x);
  }
};

namespace ricochet::solver {
namespace {
constexpr double linear_tolerance = 1e-14;  ///< of the right-hand side
constexpr int max_linear_iterations = 500;
}  // namespace

/// The unknowns of closed pairs, those without a tangential force left out; all others are zero.
void RootProblem::find_involved() {
  involved_.clear();
  for (int direction = 0; direction < (cone_ ? 3 : friction_ ? 2 : 1); ++direction) {
    for (int i = 0; i < pairs_; ++i) {
      const auto& state = states_[static_cast<std::size_t>(i)];
      const int unknown = direction * pairs_ + i;
      const bool involved = state.closed && (direction == 0 || state.tangent != Tangent::none);
      place_[static_cast<std::size_t>(unknown)] = involved ? static_cast<int>(involved_.size()) : -1;
      if (involved) involved_.push_back(unknown);
    }
  }
}

/// matrix_(row, .) += factor D(unknown, .) of the involved unknowns.
void RootProblem::add_compliance(int row, double factor, int unknown) {
  const Eigen::MatrixXd& compliance = *compliance_.dense();
  for (std::size_t column = 0; column < involved_.size(); ++column)
    matrix_(row, static_cast<Eigen::Index>(column)) += factor * compliance(involved_[column], unknown);  // symmetric
}

/// Rows of the present states, of the involved unknowns: a ball that touches with thirty of two hundred pairs has a
/// matrix of thirty. It is filled up with identity rows to a multiple of thirty-two, so that few changes of state ask
/// for memory. Rows of compliances [m/N] are divided by what their unknown moves alone, so that they and the rows
/// of forces [N] are of one size.
void RootProblem::assemble() {
  constexpr int multiple = 32;
  find_involved();
  const int involved = static_cast<int>(involved_.size());
  const int size = (involved + multiple - 1) / multiple * multiple;
  matrix_.setZero(size, size);
  involved_rhs_.setZero(size);
  for (int row = involved; row < size; ++row) matrix_(row, row) = 1.0;
  for (int i = 0; i < pairs_; ++i) {
    const auto& state = states_[static_cast<std::size_t>(i)];
    if (!state.closed) continue;
    const int normal = place(i);
    add_compliance(normal, 1.0, i);
    matrix_(normal, normal) += slack(i);
    matrix_.row(normal) /= alone(i);
    if (state.tangent == Tangent::none) continue;
    if (cone_) {
      assemble_cone(i);
      continue;
    }
    const int t = pairs_ + i, row = place(t);
    const double mu = friction_of(i);
    matrix_(row, row) = state.tangent == Tangent::stick ? slack(i) : 1.0;
    switch (state.tangent) {
      case Tangent::none:
      case Tangent::slip: break;
      case Tangent::stick:
        add_compliance(row, 1.0, t);
        matrix_.row(row) /= alone(t);
        break;
      case Tangent::slip_plus: matrix_(row, normal) = -mu; break;
      case Tangent::slip_minus: matrix_(row, normal) = mu; break;
      case Tangent::regularised:
        add_compliance(row, slip_slope_[i], t);
        matrix_(row, normal) += cone_slope_[i];
        break;
    }
  }
}

/// The same rows times x.
void RootProblem::times_matrix(const Eigen::VectorXd& x, Eigen::VectorXd& y) const {
  compliance_.times(x, y);
  for (int i = 0; i < pairs_; ++i) {
    const auto& state = states_[static_cast<std::size_t>(i)];
    y[i] = state.closed ? (y[i] + slack(i) * x[i]) / alone(i) : x[i];
    if (!friction_) continue;
    if (cone_) {
      times_cone(i, x, y);
      continue;
    }
    const int t = pairs_ + i;
    const double mu = friction_of(i);
    switch (state.tangent) {
      case Tangent::slip: break;
      case Tangent::none: y[t] = x[t]; break;
      case Tangent::stick: y[t] = (y[t] + slack(i) * x[t]) / alone(t); break;
      case Tangent::slip_plus: y[t] = x[t] - mu * x[i]; break;
      case Tangent::slip_minus: y[t] = x[t] + mu * x[i]; break;
      case Tangent::regularised: y[t] = slip_slope_[i] * y[t] + x[t] + cone_slope_[i] * x[i]; break;
    }
  }
}

/// Forces of the present states, from `rhs_`.
void RootProblem::solve_states() {
  if (compliance_.dense()) {
    if (turns() || factored_states_ != states_) {
      assemble();
      factor_.compute(matrix_);
      factored_states_ = states_;
    }
    for (std::size_t k = 0; k < involved_.size(); ++k) involved_rhs_[static_cast<Eigen::Index>(k)] = rhs_[involved_[k]];
    involved_force_ = factor_.solve(involved_rhs_);
    solution_.force.setZero();
    for (std::size_t k = 0; k < involved_.size(); ++k)
      solution_.force[involved_[k]] = involved_force_[static_cast<Eigen::Index>(k)];
    return;
  }
  // Forces that a state has not are zero from the start on, and stay it: neither the right-hand side nor a product has
  // anything there.
  Eigen::VectorXd start = solution_.force;
  for (int i = 0; i < pairs_; ++i) {
    const auto& state = states_[static_cast<std::size_t>(i)];
    if (!state.closed) start[i] = 0.0;
    if (friction_ && state.tangent == Tangent::none) start[pairs_ + i] = 0.0;
    if (cone_ && state.tangent == Tangent::none) start[2 * pairs_ + i] = 0.0;
  }
  const StatesMatrix matrix([this](const Eigen::VectorXd& x, Eigen::VectorXd& y) { times_matrix(x, y); },
                            compliance_.size());
  Eigen::BiCGSTAB<StatesMatrix, Eigen::IdentityPreconditioner> solver;
  solver.setTolerance(linear_tolerance);
  solver.setMaxIterations(max_linear_iterations);
  solver.compute(matrix);
  solution_.force = solver.solveWithGuess(rhs_, start);
}

}  // namespace ricochet::solver

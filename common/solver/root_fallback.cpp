// What RootProblem does where the states of its pairs cycle.
#include <algorithm>
#include <cmath>

#include "common/solver/lemke.hpp"
#include "common/solver/root_problem.hpp"

namespace ricochet::solver {
namespace {
constexpr int max_sweeps = 5000;
}  // namespace

/// Slow, but without friction it cannot cycle, and with little of it it does not.
int RootProblem::sweep(const Eigen::VectorXd& gap_free, const Eigen::VectorXd& slip_free,
                       const Eigen::VectorXd& slip_velocity, const Solution& last) {
  int sweeps = 0;
  for (double change = 1.0, largest = 0.0; sweeps < max_sweeps && change > 1e-13 * largest; ++sweeps) {
    change = compliance_.has_rows() ? gauss_seidel_sweep(gap_free, slip_free, slip_velocity, last)
                                    : jacobi_sweep(gap_free, slip_free, slip_velocity, last);
    largest = solution_.force.cwiseAbs().maxCoeff();
  }
  states_of_forces();
  return sweeps;
}

/// One pair after the other; returns the largest change.
double RootProblem::gauss_seidel_sweep(const Eigen::VectorXd& gap_free, const Eigen::VectorXd& slip_free,
                                       const Eigen::VectorXd& slip_velocity, const Solution& last) {
  auto& x = solution_.force;
  double change = 0.0;
  for (int i = 0; i < pairs_; ++i) {
    const double normal_before = x[i];
    const double gap = gap_free[i] + compliance_.row_times(i, x) + slack(i) * x[i];
    x[i] = std::max(0.0, x[i] - gap / alone(i));
    change = std::max(change, std::abs(x[i] - normal_before));
    if (held(i)) continue;
    if (cone_) {
      for (const int unknown : {pairs_ + i, 2 * pairs_ + i}) motion_[unknown] = compliance_.row_times(unknown, x);
      change = std::max(change, set_along(i, cone_alone(i, slip_free, slip_velocity, last)));
      continue;
    }
    const int t = pairs_ + i;
    const double before = x[t];
    x[t] = tangential_alone(i, slip_free[i] + compliance_.row_times(t, x), slip_velocity[i], last.force[t]);
    change = std::max(change, std::abs(x[t] - before));
  }
  return change;
}

/// All pairs at once, a projected gradient step of the size that the bound of the compliance allows; returns the
/// largest change.
double RootProblem::jacobi_sweep(const Eigen::VectorXd& gap_free, const Eigen::VectorXd& slip_free,
                                 const Eigen::VectorXd& slip_velocity, const Solution& last) {
  auto& x = solution_.force;
  compliance_.times(x, motion_);
  before_ = x;
  for (int i = 0; i < pairs_; ++i) {
    const double gap = gap_free[i] + motion_[i] + slack(i) * x[i];
    x[i] = std::max(0.0, x[i] - gap / alone(i));
    if (held(i)) continue;
    if (cone_) {
      set_along(i, cone_alone(i, slip_free, slip_velocity, last));
      continue;
    }
    const int t = pairs_ + i;
    x[t] = tangential_alone(i, slip_free[i] + motion_[t], slip_velocity[i], last.force[t]);
  }
  return (x - before_).cwiseAbs().maxCoeff();
}

/// The unknowns are x_n, the two directions of x_t, and the slip against friction; the last row is the cone:
///   gap >= 0 with x_n,   slip_against +- slip >= 0 with x_t+ and x_t-,   mu x_n - x_t+ - x_t- >= 0 with slip_against
int RootProblem::lemke(const Eigen::VectorXd& gap_free, const Eigen::VectorXd& slip_free, const Solution& last) {
  const Eigen::MatrixXd& dense = *compliance_.dense();
  std::vector<int> sliding;
  for (int i = 0; i < pairs_; ++i)
    if (!held(i)) sliding.push_back(i);
  const int tangents = static_cast<int>(sliding.size()), size = pairs_ + 3 * tangents;
  const double unit = dense.diagonal().head(pairs_).maxCoeff();  // forces are sought in units of length
  Eigen::MatrixXd m = Eigen::MatrixXd::Zero(size, size);
  Eigen::VectorXd q = Eigen::VectorXd::Zero(size);
  const auto compliance = [&](int row, int column) {
    return (dense(row, column) + (row == column ? slack(row % pairs_) : 0.0)) / unit;
  };
  for (int i = 0; i < pairs_; ++i) {
    q[i] = gap_free[i];
    for (int j = 0; j < pairs_; ++j) m(i, j) = compliance(i, j);
  }
  for (int k = 0; k < tangents; ++k) {
    const int i = sliding[static_cast<std::size_t>(k)], t = pairs_ + i;
    for (const double sign : {1.0, -1.0}) {
      const int row = pairs_ + (sign > 0.0 ? 0 : tangents) + k;
      q[row] = sign * (slip_free[i] - slack(i) * last.force[t]);
      for (int j = 0; j < pairs_; ++j) {
        m(row, j) = sign * compliance(t, j);
        m(j, row) = sign * compliance(j, t);
      }
      for (int l = 0; l < tangents; ++l) {
        const double value = compliance(t, pairs_ + sliding[static_cast<std::size_t>(l)]);
        m(row, pairs_ + l) = sign * value;
        m(row, pairs_ + tangents + l) = -sign * value;
      }
      m(row, pairs_ + 2 * tangents + k) = 1.0;
      m(pairs_ + 2 * tangents + k, row) = -1.0;
    }
    m(pairs_ + 2 * tangents + k, i) = friction_of(i);
  }
  Eigen::VectorXd z;
  const int pivots = solve_lemke(m, q, z);
  if (z.size() == 0) return pivots;
  solution_.force.setZero();
  solution_.force.head(pairs_) = z.head(pairs_) / unit;
  for (int k = 0; k < tangents; ++k)
    solution_.force[pairs_ + sliding[static_cast<std::size_t>(k)]] = (z[pairs_ + k] - z[pairs_ + tangents + k]) / unit;
  states_of_forces();
  return pivots;
}

}  // namespace ricochet::solver

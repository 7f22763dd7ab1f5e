#include "common/contact/pair_system.hpp"

#include <algorithm>
#include <limits>

namespace ricochet::solver {
namespace {
constexpr double linear_tolerance = 1e-14;  ///< of the right-hand side
constexpr int max_linear_iterations = 500;
/// The dense matrix is filled up with identity rows to a multiple of so many, so that few changes of state ask for
/// memory.
constexpr Eigen::Index multiple = 32;

/// A factor of more unknowns costs more than products until it may be used again. Measured: solids that stick with 676
/// pairs, 2028 unknowns.
constexpr std::ptrdiff_t most_factored = 1000;
/// The same of a sparse D, where products have not led to the solution.
constexpr std::ptrdiff_t most_factored_of_sparse = 300;

/// BiCGSTAB (van der Vorst 1992) for A x = b from the present x: `times(x, y)` sets y = A x. It starts anew where its
/// residuals have become orthogonal to the first. Returns whether x is as near as `linear_tolerance`.
template <class Times>
bool bicgstab(const Times& times, const Eigen::VectorXd& b, Eigen::VectorXd& x) {
  const double enough = linear_tolerance * linear_tolerance * b.squaredNorm();
  if (b.isZero(0.0)) {
    x.setZero();
    return true;
  }
  Eigen::VectorXd v = Eigen::VectorXd::Zero(b.size()), p = v, t(b.size()), s;
  times(x, t);
  Eigen::VectorXd r = b - t, first = r;
  double rho = 1.0, alpha = 1.0, omega = 1.0, of_first = r.squaredNorm();
  for (int i = 0; i < max_linear_iterations && r.squaredNorm() > enough; ++i) {
    const double before = rho;
    rho = first.dot(r);
    if (std::abs(rho) < std::numeric_limits<double>::epsilon() * std::numeric_limits<double>::epsilon() * of_first) {
      times(x, t);
      first = r = b - t;
      rho = of_first = r.squaredNorm();
    }
    p = r + rho / before * (alpha / omega) * (p - omega * v);
    times(p, v);
    alpha = rho / first.dot(v);
    s = r - alpha * v;
    times(s, t);
    omega = t.isZero(0.0) ? 0.0 : t.dot(s) / t.squaredNorm();
    x += alpha * p + omega * s;
    r = s - omega * t;
  }
  return r.squaredNorm() <= enough;
}

/// How many have rows that are not idle.
std::ptrdiff_t unknowns_of(const std::vector<PairRows>& rows, Eigen::Index directions) {
  std::ptrdiff_t count = 0;
  for (const PairRows& of : rows)
    for (int d = 0; d < directions; ++d) count += of.idle(d) ? 0 : 1;
  return count;
}

bool same_matrix(const std::vector<PairRows>& a, const std::vector<PairRows>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const PairRows& x, const PairRows& y) { return x.own == y.own && x.of_motion == y.of_motion; });
}
}  // namespace

void PairSystem::solve(const Compliance& compliance, const std::vector<PairRows>& rows, Eigen::VectorXd& x) {
  const auto pairs = static_cast<Eigen::Index>(rows.size()), directions = compliance.size() / pairs;
  const bool kept = factored_ && same_matrix(rows, rows_);
  rows_ = rows;
  const auto unknowns = unknowns_of(rows, directions);
  if (compliance.dense() && unknowns <= most_factored) {
    if (!kept) compute_factor(compliance, directions);
    factored_ = true;
  } else {
    factored_ = false;
    if (solve_by_products(compliance, directions, x) || !compliance.sparse() || unknowns > most_factored_of_sparse)
      return;
    compute_factor(compliance, directions);
  }
  for (std::size_t k = 0; k < involved_.size(); ++k) {
    const Eigen::Index unknown = involved_[k];
    involved_rhs_[static_cast<Eigen::Index>(k)] = rows[static_cast<std::size_t>(unknown % pairs)].rhs[unknown / pairs];
  }
  involved_force_ = factor_.solve(involved_rhs_);
  x.setZero();
  for (std::size_t k = 0; k < involved_.size(); ++k) x[involved_[k]] = involved_force_[static_cast<Eigen::Index>(k)];
}

/// Factors the unknowns whose rows are not idle: a ball that touches with thirty of two hundred pairs has a matrix of
/// thirty.
void PairSystem::compute_factor(const Compliance& compliance, Eigen::Index directions) {
  const auto pairs = static_cast<Eigen::Index>(rows_.size());
  involved_.clear();
  place_.assign(static_cast<std::size_t>(directions * pairs), -1);
  for (Eigen::Index unknown = 0; unknown < directions * pairs; ++unknown) {
    if (rows_[static_cast<std::size_t>(unknown % pairs)].idle(static_cast<int>(unknown / pairs))) continue;
    place_[static_cast<std::size_t>(unknown)] = std::ssize(involved_);
    involved_.push_back(unknown);
  }
  const auto involved = static_cast<Eigen::Index>(involved_.size());
  const Eigen::Index size = (involved + multiple - 1) / multiple * multiple;
  matrix_.setZero(size, size);
  involved_rhs_.setZero(size);
  for (Eigen::Index row = involved; row < size; ++row) matrix_(row, row) = 1.0;
  for (Eigen::Index row = 0; row < involved; ++row) {
    const Eigen::Index unknown = involved_[static_cast<std::size_t>(row)], pair = unknown % pairs;
    const auto& of = rows_[static_cast<std::size_t>(pair)];
    for (Eigen::Index d = 0; d < directions; ++d) {
      const double factor = of.of_motion(unknown / pairs, d), own = of.own(unknown / pairs, d);
      const Eigen::Index other = d * pairs + pair, place = place_[static_cast<std::size_t>(other)];
      if (factor != 0.0) {
        for (Eigen::Index column = 0; column < involved; ++column)
          matrix_(row, column) += factor * compliance.entry(other, involved_[static_cast<std::size_t>(column)]);
      }
      if (own != 0.0 && place >= 0) matrix_(row, place) += own;
    }
  }
  factor_.compute(matrix_);
}

/// Forces of idle rows are zero from the start on, and stay it: neither the right-hand side nor a product has anything
/// there.
bool PairSystem::solve_by_products(const Compliance& compliance, Eigen::Index directions, Eigen::VectorXd& x) const {
  const auto pairs = static_cast<Eigen::Index>(rows_.size());
  Eigen::VectorXd rhs(x.size());
  for (Eigen::Index unknown = 0; unknown < x.size(); ++unknown) {
    const auto& rows = rows_[static_cast<std::size_t>(unknown % pairs)];
    rhs[unknown] = rows.rhs[unknown / pairs];
    if (rows.idle(static_cast<int>(unknown / pairs))) x[unknown] = 0.0;
  }
  const auto times = [&](const Eigen::VectorXd& of, Eigen::VectorXd& y) {
    compliance.times(of, y);
    for (Eigen::Index i = 0; i < pairs; ++i) {
      const auto& rows = rows_[static_cast<std::size_t>(i)];
      Eigen::Vector3d row(0.0, 0.0, 0.0);
      for (Eigen::Index r = 0; r < directions; ++r) {
        for (Eigen::Index d = 0; d < directions; ++d)
          row[r] += rows.own(r, d) * of[d * pairs + i] + rows.of_motion(r, d) * y[d * pairs + i];
      }
      for (Eigen::Index d = 0; d < directions; ++d) y[d * pairs + i] = row[d];
    }
  };
  return bicgstab(times, rhs, x);
}

}  // namespace ricochet::solver

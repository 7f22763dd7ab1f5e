#include "explicit_solver/reduced/lowest_modes.hpp"

#include <arpack/arpack.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "common/base/computer.hpp"
#include "common/base/error.hpp"

namespace ricochet::explicit_solver {
namespace {

/// More than are asked for: of modes with one frequency it may find one late.
constexpr int spare_modes = 8;
constexpr int most_restarts = 300;
/// A frequency below that share of the scale, squared, is rounding: the part moves as a rigid body.
constexpr double rigid_share = 1e-8;
/// The shift of the factor for R, over the square of the highest frequency that is kept: each term of the series in
/// `others` then is at most that share of the one before, and rounding of K is far below it.
constexpr double shift_share = 1e-6;
constexpr double tolerance = 1e-12;  ///< of a mode

/// Neither parallel to a mode nor another one every time.
Eigen::VectorXd start_of(Eigen::Index size) {
  Eigen::VectorXd start(size);
  double value = 0.5;
  for (double& entry : start) {
    value = std::fmod(value * 97.0 + 0.1234567, 1.0);
    entry = value - 0.5;
  }
  return start;
}

}  // namespace

LowestModes::LowestModes(const fem::SparseMatrix& stiffness, const Eigen::VectorXd& mass, int count, double scale)
    : mass_(mass) {
  use_one_thread_in_cholmod();
  std::vector<int> free_of(static_cast<std::size_t>(mass.size()), -1);
  for (int dof = 0; dof < mass.size(); ++dof) {
    if (!(mass[dof] > 0.0)) continue;
    free_of[static_cast<std::size_t>(dof)] = static_cast<int>(free_.size());
    free_.push_back(dof);
  }
  std::vector<Eigen::Triplet<double>> entries;
  for (const int dof : free_) {
    for (fem::SparseMatrix::InnerIterator it(stiffness, dof); it; ++it) {
      const int row = free_of[static_cast<std::size_t>(it.row())], column = free_of[static_cast<std::size_t>(it.col())];
      if (column >= 0 && row >= column) entries.emplace_back(row, column, it.value());
    }
  }
  const auto size = static_cast<Eigen::Index>(free_.size());
  stiffness_.resize(size, size);
  stiffness_.setFromTriplets(entries.begin(), entries.end());
  factor_.setMode(Eigen::CholmodSupernodalLLt);
  factor_.cholmod().print = 0;
  factor(scale);
  find(count);
  for (double& value : omega_squared_) value = value < rigid_share * scale ? 0.0 : value;
  const double highest = omega_squared_.tail(1).value();
  factor(shift_share * (highest > 0.0 ? highest : scale));
}

void LowestModes::factor(double shift) {
  shift_ = shift;
  Eigen::SparseMatrix<double> shifted = stiffness_;
  for (int i = 0; i < shifted.cols(); ++i) shifted.coeffRef(i, i) += shift * mass_[free_[static_cast<std::size_t>(i)]];
  factor_.compute(shifted);
  if (factor_.info() != Eigen::Success)
    throw SolverError(
        "the stiffness of a part that is reduced to its modes is not positive semidefinite: check its material");
}

Eigen::MatrixXd LowestModes::solve(const Eigen::MatrixXd& forces) const {
  const Eigen::MatrixXd u = factor_.solve(Eigen::MatrixXd(forces(free_, Eigen::all)));
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(forces.rows(), forces.cols());
  all(free_, Eigen::all) = u;
  return all;
}

/// The largest eigenvalues 1/(omega^2 + shift) of M^1/2 (K + shift M)^-1 M^1/2, whose vectors are M^1/2 phi.
void LowestModes::find(int count) {
  const int size = static_cast<int>(free_.size());
  const int wanted = std::min(count + spare_modes, size - 1);
  const int basis = std::min(size, std::max(2 * wanted, wanted + 20)), work_size = basis * (basis + 8);
  int request = 0, info = 1;  // 1: begin with `start`
  int settings[11] = {1, 0, most_restarts, 1, 0, 0, 1, 0, 0, 0, 0}, places[14] = {};
  Eigen::VectorXd start = start_of(size), work(work_size), ends(3 * Eigen::Index{size});
  Eigen::MatrixXd vectors(size, basis);
  Eigen::VectorXd root(size);
  for (int i = 0; i < size; ++i) root[i] = std::sqrt(mass_[free_[static_cast<std::size_t>(i)]]);
  while (true) {
    dsaupd_c(&request, "I", size, "LM", wanted, tolerance, start.data(), basis, vectors.data(), size, settings, places,
             ends.data(), work.data(), work_size, &info);
    if (request != 1 && request != -1) break;
    const auto given = ends.segment(places[0] - 1, size);
    Eigen::VectorXd of_free = factor_.solve((root.array() * given.array()).matrix()).eval();
    ends.segment(places[1] - 1, size) = root.array() * of_free.array();
  }
  if (info != 0 || settings[4] < wanted)
    throw SolverError(fmt::format(
        "of the {} lowest modes of a part with {} degrees of freedom ARPACK found {} (it says {}); ask for others",
        count, size, settings[4], info));
  Eigen::VectorXd values(wanted);
  Eigen::MatrixXd found(size, wanted);
  std::vector<int> select(static_cast<std::size_t>(basis));
  dseupd_c(1, "A", select.data(), values.data(), found.data(), size, 0.0, "I", size, "LM", wanted, tolerance,
           start.data(), basis, vectors.data(), size, settings, places, ends.data(), work.data(), work_size, &info);
  if (info != 0) throw SolverError(fmt::format("ARPACK could not tell the modes that it found (it says {})", info));
  omega_squared_.resize(count);
  shapes_.setZero(mass_.size(), count);
  for (int mode = 0; mode < count; ++mode) {  // values ascend, frequencies descend
    const int at = wanted - 1 - mode;
    omega_squared_[mode] = 1.0 / values[at] - shift_;
    for (int i = 0; i < size; ++i) shapes_(free_[static_cast<std::size_t>(i)], mode) = found(i, at) / root[i];
  }
}

/// With S = (K + s M)^-1 among the modes that are left out, R = S + s S M S + s^2 S M S M S + ...
Eigen::MatrixXd LowestModes::others(const Eigen::MatrixXd& forces, double error) const {
  const auto of_others = [&](Eigen::MatrixXd loads) {
    loads -= mass_.asDiagonal() * (shapes_ * (shapes_.transpose() * loads)).eval();
    Eigen::MatrixXd u = solve(loads);
    u -= shapes_ * (shapes_.transpose() * (mass_.asDiagonal() * u).eval()).eval();
    return u;
  };
  Eigen::MatrixXd term = of_others(forces), sum = term;
  double last = term.norm(), share = shift_share;  // of the term to come
  while (share * last > error * sum.norm()) {
    term = of_others(shift_ * (mass_.asDiagonal() * term));
    const double now = term.norm();
    if (!(now < last)) break;
    sum += term;
    share = std::max(share, now / last);
    last = now;
  }
  return sum;
}

}  // namespace ricochet::explicit_solver

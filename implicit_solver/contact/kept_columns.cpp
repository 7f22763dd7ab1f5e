#include "implicit_solver/contact/kept_columns.hpp"

#include <algorithm>
#include <utility>

namespace ricochet::implicit_solver {
namespace {
constexpr Eigen::Index more = 64;  ///< columns, room for so many more at a time
}  // namespace

KeptColumns::KeptColumns(SolveFor product, Eigen::Index most_pushed, Eigen::Index most_kept)
    : product_(std::move(product)), most_pushed_(most_pushed), most_kept_(most_kept) {}

void KeptColumns::keep(Eigen::Index force) {
  unit_[force] = 1.0;
  product_(unit_, column_motion_);
  unit_[force] = 0.0;
  if (kept_ == columns_.cols()) columns_.conservativeResize(unit_.size(), kept_ + more);
  columns_.col(kept_) = column_motion_;
  column_[static_cast<std::size_t>(force)] = static_cast<int>(kept_++);
}

void KeptColumns::operator()(const Eigen::VectorXd& forces, Eigen::VectorXd& motion) {
  if (unit_.size() != forces.size()) {
    unit_.setZero(forces.size());
    columns_.resize(0, 0);
    column_.assign(static_cast<std::size_t>(forces.size()), -1);
    kept_ = 0;
  }
  pushed_.clear();
  Eigen::Index missing = 0;
  for (Eigen::Index j = 0; j < forces.size(); ++j) {
    if (forces[j] == 0.0) continue;
    pushed_.push_back(j);
    missing += column_[static_cast<std::size_t>(j)] < 0 ? 1 : 0;
  }
  if (std::ssize(pushed_) > most_pushed_) {
    product_(forces, motion);
    return;
  }
  if (kept_ + missing > most_kept_) {  // a contact that wanders has left them behind
    std::fill(column_.begin(), column_.end(), -1);
    kept_ = 0;
  }
  motion.setZero(forces.size());
  for (const Eigen::Index j : pushed_) {
    if (column_[static_cast<std::size_t>(j)] < 0) keep(j);
    motion += forces[j] * columns_.col(column_[static_cast<std::size_t>(j)]);
  }
}

}  // namespace ricochet::implicit_solver

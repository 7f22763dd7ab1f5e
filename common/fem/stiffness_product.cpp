#include "common/fem/stiffness_product.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>

// Vectors pass between functions of this file only, so how a processor without AVX-512 passes them is nobody's
// business.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace ricochet::fem {
namespace {

constexpr int lanes = StiffnessProduct::rows_of_slice, nodes_of_slice = lanes / 2;
using Vector = double __attribute__((vector_size(lanes * sizeof(double))));

Vector load(const double* from) {
  Vector v;
  std::memcpy(&v, from, sizeof v);
  return v;
}

Vector load_pairs(const double* u, const int* dof) {
  Vector v;
  for (int n = 0; n < nodes_of_slice; ++n) {
    v[2 * n] = u[dof[n]];
    v[2 * n + 1] = u[dof[n] + 1];
  }
  return v;
}

/// Whether K maps a constant component to zero, up to round-off.
bool maps_to_zero(const SparseMatrix& stiffness, int components, int component) {
  constexpr double round_off = 1e-9;
  double largest_sum = 0.0, largest_entry = 0.0;
  for (int row = 0; row < stiffness.rows(); ++row) {
    double sum = 0.0;
    for (SparseMatrix::InnerIterator it(stiffness, row); it; ++it) {
      if (it.col() % components == component) sum += it.value();
      largest_entry = std::max(largest_entry, std::abs(it.value()));
    }
    largest_sum = std::max(largest_sum, std::abs(sum));
  }
  return largest_sum <= round_off * largest_entry;
}

}  // namespace

StiffnessProduct::StiffnessProduct(const SparseMatrix& stiffness, int components) : components_(components) {
  for (int c = 0; c < components; ++c) follows_[c] = maps_to_zero(stiffness, components, c) ? 1.0 : 0.0;
  const int slices = components == 2 ? static_cast<int>(stiffness.rows()) / lanes : 0;
  slice_start_.push_back(0);
  for (int slice = 0; slice < slices; ++slice) add_slice(stiffness, slice);
  first_row_ = slices * lanes;
  rows_ = stiffness.bottomRows(stiffness.rows() - first_row_);
  rows_.makeCompressed();
}

void StiffnessProduct::add_slice(const SparseMatrix& stiffness, int slice) {
  // Blocks of the four nodes by the distance of the neighbour's number: one distance, one slot of neighbours in a row.
  std::map<int, std::array<bool, nodes_of_slice>> by_distance;
  const int first_node = slice * nodes_of_slice;
  for (int n = 0; n < nodes_of_slice; ++n) {
    for (int r = 0; r < 2; ++r) {
      for (SparseMatrix::InnerIterator it(stiffness, 2 * (first_node + n) + r); it; ++it) {
        by_distance[static_cast<int>(it.col()) / 2 - (first_node + n)][static_cast<std::size_t>(n)] = true;
      }
    }
  }
  const int nodes = static_cast<int>(stiffness.rows()) / 2;
  std::array<std::vector<int>, nodes_of_slice> scattered;   // neighbours that share no slot in a row
  std::vector<std::array<int, nodes_of_slice>> neighbours;  // node numbers per slot; -1: none
  std::vector<bool> in_a_row;
  for (const auto& [distance, present] : by_distance) {
    const int first = first_node + distance, count = static_cast<int>(std::count(present.begin(), present.end(), true));
    const bool fits = first >= 0 && first + nodes_of_slice <= nodes;
    std::array<int, nodes_of_slice> slot{};
    for (int n = 0; n < nodes_of_slice; ++n) {
      const bool here = present[static_cast<std::size_t>(n)];
      slot[static_cast<std::size_t>(n)] = here ? first + n : -1;
      if (here && !(fits && count > 2)) scattered[static_cast<std::size_t>(n)].push_back(first + n);
    }
    if (!(fits && count > 2)) continue;
    neighbours.push_back(slot);
    in_a_row.push_back(true);
  }
  std::size_t longest = 0;
  for (const auto& list : scattered) longest = std::max(longest, list.size());
  for (std::size_t k = 0; k < longest; ++k) {
    std::array<int, nodes_of_slice> slot{};
    for (std::size_t n = 0; n < slot.size(); ++n) slot[n] = k < scattered[n].size() ? scattered[n][k] : -1;
    neighbours.push_back(slot);
    in_a_row.push_back(false);
  }
  for (std::size_t k = 0; k < neighbours.size(); ++k) {
    Coefficients block;
    Slot slot;
    slot.first = -1;
    slot.gathered = static_cast<int>(gathered_.size());
    for (int n = 0; n < nodes_of_slice; ++n) {
      const int neighbour = neighbours[k][static_cast<std::size_t>(n)], row = 2 * (first_node + n);
      if (!in_a_row[k]) gathered_.push_back(neighbour >= 0 ? 2 * neighbour : 0);
      if (neighbour < 0) continue;
      if (in_a_row[k]) slot.first = 2 * (neighbour - n);
      for (int r = 0; r < 2; ++r) {
        block.same[2 * n + r] = stiffness.coeff(row + r, 2 * neighbour + r);
        block.cross[2 * n + r] = stiffness.coeff(row + r, 2 * neighbour + 1 - r);
      }
    }
    slots_.push_back(slot);
    coefficients_.push_back(block);
  }
  slice_start_.push_back(static_cast<int>(slots_.size()));
}

void StiffnessProduct::multiply(const Eigen::VectorXd& u, Eigen::VectorXd& result) const {
  multiply(u, result, 0, static_cast<int>(u.size()));
}

void StiffnessProduct::multiply(const Eigen::VectorXd& u, Eigen::VectorXd& result, int first, int last) const {
  const double* values = u.data();
  const double x = follows_[0], y = follows_[1];
  const Vector follows = {x, y, x, y, x, y, x, y};
  const int end_slice = std::min(last, first_row_) / lanes;
  for (int s = first / lanes; s < end_slice; ++s) {
    const Vector own = follows * load(values + s * lanes);
    Vector same_sum{}, cross_sum{};
    const int end = slice_start_[static_cast<std::size_t>(s) + 1];
    for (int k = slice_start_[static_cast<std::size_t>(s)]; k < end; ++k) {
      const Slot& slot = slots_[static_cast<std::size_t>(k)];
      const Coefficients& c = coefficients_[static_cast<std::size_t>(k)];
      const Vector neighbour =
          (slot.first >= 0 ? load(values + slot.first)
                           : load_pairs(values, &gathered_[static_cast<std::size_t>(slot.gathered)])) -
          own;
      same_sum += load(c.same) * neighbour;
      cross_sum += load(c.cross) * __builtin_shufflevector(neighbour, neighbour, 1, 0, 3, 2, 5, 4, 7, 6);
    }
    const Vector sum = same_sum + cross_sum;
    std::memcpy(result.data() + s * lanes, &sum, sizeof sum);
  }
  if (last > first_row_) multiply_rows(u, result, std::max(first, first_row_), last);
}

void StiffnessProduct::multiply_rows(const Eigen::VectorXd& u, Eigen::VectorXd& result, int first, int last) const {
  for (int row = first; row < last; ++row) {
    double own[2] = {0.0, 0.0}, sum = 0.0;
    const int node = row / components_;
    for (int c = 0; c < components_; ++c) own[c] = follows_[c] * u[node * components_ + c];
    for (SparseMatrix::InnerIterator it(rows_, row - first_row_); it; ++it)
      sum += it.value() * (u[it.col()] - own[it.col() % components_]);
    result[row] = sum;
  }
}

double StiffnessProduct::contiguous_share() const {
  const auto count = std::count_if(slots_.begin(), slots_.end(), [](const Slot& slot) { return slot.first >= 0; });
  return slots_.empty() ? 0.0 : static_cast<double>(count) / static_cast<double>(slots_.size());
}

}  // namespace ricochet::fem

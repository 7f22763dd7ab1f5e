#include "common/fem/stiffness_product.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>

// Vectors pass between functions of this file only, so how a processor without AVX passes them is nobody's business.
#pragma GCC diagnostic ignored "-Wpsabi"

// A program for any x86-64 holds the loop twice and asks the processor which one it may take; one that is compiled for
// a processor with AVX2 has nothing to ask. Twice as wide, with AVX-512, was no faster.
#if defined(__x86_64__) && !defined(__AVX2__)
#define RICOCHET_ASK_FOR_AVX2
#endif

namespace ricochet::fem {
namespace {

constexpr int slice_rows = StiffnessProduct::rows_of_slice(2), nodes_of_slice = slice_rows / 2;
#ifdef __AVX2__
constexpr int usual_width = 4;
#else
constexpr int usual_width = 2;
#endif

#ifdef RICOCHET_ASK_FOR_AVX2
const bool has_avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
#endif

/// Rows that are worth a thread: some ten microseconds of work, where handing it over takes one or two.
constexpr int least_rows(int components) { return components == 3 ? 2000 : 4000; }

/// So many doubles that the processor computes at once.
template <int width>
struct Pack {
  using Vector __attribute__((vector_size(width * sizeof(double)))) = double;
};
template <int width>
using Vector = typename Pack<width>::Vector;

// What the loop calls must become part of it: only then is it compiled for the loop's processor.
template <int width>
[[gnu::always_inline]] inline Vector<width> load(const double* from) {
  Vector<width> v;
  std::memcpy(&v, from, sizeof v);
  return v;
}

template <int width>
[[gnu::always_inline]] inline Vector<width> load_pairs(const double* u, const int* dof) {
  Vector<width> v;
  for (int n = 0; n < width / 2; ++n) {
    v[2 * n] = u[dof[n]];
    v[2 * n + 1] = u[dof[n] + 1];
  }
  return v;
}

template <int width>
[[gnu::always_inline]] inline Vector<width> swap_components(const Vector<width>& v) {
  if constexpr (width == 2) {
    return __builtin_shufflevector(v, v, 1, 0);
  } else {
    return __builtin_shufflevector(v, v, 1, 0, 3, 2);
  }
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

StiffnessProduct::StiffnessProduct(const SparseMatrix& stiffness, int components, const Numbering& numbering)
    : components_(components) {
  for (int c = 0; c < components; ++c) follows_[c] = maps_to_zero(stiffness, components, c) ? 1.0 : 0.0;
  if (components == 3) {
    stencils_ = NodeStencils(stiffness);
    return;
  }
  const int slices = components == 2 ? static_cast<int>(stiffness.rows()) / slice_rows : 0;
  slice_start_.push_back(0);
  for (int slice = 0; slice < slices; ++slice) add_slice(stiffness, slice, numbering);
  first_row_ = slices * slice_rows;
  rows_ = stiffness.bottomRows(stiffness.rows() - first_row_);
  rows_.makeCompressed();
}

void StiffnessProduct::add_slice(const SparseMatrix& stiffness, int slice, const Numbering& numbering) {
  using Neighbours = std::array<int, nodes_of_slice>;  // of the four nodes; -1: none
  const int first_node = slice * nodes_of_slice, nodes = static_cast<int>(stiffness.rows()) / 2;
  const auto number = [&](int node) { return numbering.number.empty() ? node : numbering.number[at(node)]; };
  const int numbered = numbering.number.empty() ? nodes : numbering.count;
  // Blocks of the four nodes by the distance of the neighbour's number: one distance, one slot of neighbours in a row.
  std::map<int, Neighbours> by_distance;
  for (int n = 0; n < nodes_of_slice; ++n) {
    for (int r = 0; r < 2; ++r) {
      for (SparseMatrix::InnerIterator it(stiffness, 2 * (first_node + n) + r); it; ++it) {
        const int neighbour = static_cast<int>(it.col()) / 2;
        auto& row = by_distance.insert({number(neighbour) - number(first_node + n), {-1, -1, -1, -1}}).first->second;
        row[at(n)] = neighbour;
      }
    }
  }
  std::array<std::vector<int>, nodes_of_slice> scattered;  // neighbours that share no slot in a row
  std::vector<Neighbours> slots;
  for (const auto& [distance, row] : by_distance) {
    const int first = number(first_node) + distance, missing = static_cast<int>(std::count(row.begin(), row.end(), -1));
    if (first >= 0 && first + nodes_of_slice <= numbered && nodes_of_slice - missing > 2) {
      slots.push_back(row);
      continue;
    }
    for (std::size_t n = 0; n < row.size(); ++n) {
      if (row[n] >= 0) scattered[n].push_back(row[n]);
    }
  }
  std::size_t longest = 0;
  for (const auto& list : scattered) longest = std::max(longest, list.size());
  for (std::size_t k = 0; k < longest; ++k) {
    Neighbours& slot = slots.emplace_back();
    for (std::size_t n = 0; n < slot.size(); ++n) slot[n] = k < scattered[n].size() ? scattered[n][k] : -1;
  }
  for (const Neighbours& neighbours : slots) {
    add_slot(neighbours, nodes);
    Coefficients& block = coefficients_.emplace_back();
    for (int n = 0; n < nodes_of_slice; ++n) {
      const int neighbour = neighbours[at(n)], row = 2 * (first_node + n);
      if (neighbour < 0) continue;
      for (int r = 0; r < 2; ++r) {
        block.same[2 * n + r] = stiffness.coeff(row + r, 2 * neighbour + r);
        block.cross[2 * n + r] = stiffness.coeff(row + r, 2 * neighbour + 1 - r);
      }
    }
  }
  slice_start_.push_back(static_cast<int>(slots_.size()));
}

/// One load where all four, those that are missing included, could be nodes in a row.
void StiffnessProduct::add_slot(const std::array<int, 4>& neighbours, int nodes) {
  Slot& slot = slots_.emplace_back();
  slot.gathered = static_cast<int>(gathered_.size());
  const auto known = std::find_if(neighbours.begin(), neighbours.end(), [](int node) { return node >= 0; });
  const int first = *known - static_cast<int>(known - neighbours.begin());
  bool in_a_row = first >= 0 && first + nodes_of_slice <= nodes;
  int present = 0;
  for (int n = 0; n < nodes_of_slice; ++n) {
    const int neighbour = neighbours[at(n)];
    in_a_row = in_a_row && (neighbour < 0 || neighbour == first + n);
    present += neighbour >= 0 ? 1 : 0;
  }
  slot.first = in_a_row && present > 2 ? 2 * first : -1;
  if (slot.first >= 0) return;
  for (const int neighbour : neighbours) gathered_.push_back(neighbour >= 0 ? 2 * neighbour : 0);
}

void StiffnessProduct::multiply(const Eigen::VectorXd& u, Eigen::VectorXd& result) const {
  multiply(u, result, 0, static_cast<int>(u.size()));
}

template <int width>
[[gnu::always_inline]] inline void StiffnessProduct::multiply_slice(int slice, const double* u, double* result) const {
  constexpr int parts = slice_rows / width;
  Vector<width> follows, own[parts], same_sum[parts] = {}, cross_sum[parts] = {};
  for (int i = 0; i < width; ++i) follows[i] = follows_[i % 2];
  for (int p = 0; p < parts; ++p) own[p] = follows * load<width>(u + slice * slice_rows + p * width);
  const int end = slice_start_[static_cast<std::size_t>(slice) + 1];
  for (int k = slice_start_[static_cast<std::size_t>(slice)]; k < end; ++k) {
    const Slot& slot = slots_[static_cast<std::size_t>(k)];
    const Coefficients& c = coefficients_[static_cast<std::size_t>(k)];
    for (int p = 0; p < parts; ++p) {
      const int i = p * width;
      const Vector<width> neighbour =
          (slot.first >= 0 ? load<width>(u + slot.first + i)
                           : load_pairs<width>(u, &gathered_[static_cast<std::size_t>(slot.gathered + i / 2)])) -
          own[p];
      same_sum[p] += load<width>(c.same + i) * neighbour;
      cross_sum[p] += load<width>(c.cross + i) * swap_components<width>(neighbour);
    }
  }
  for (int p = 0; p < parts; ++p) {
    const Vector<width> sum = same_sum[p] + cross_sum[p];
    std::memcpy(result + slice * slice_rows + p * width, &sum, sizeof sum);
  }
}

#ifdef RICOCHET_ASK_FOR_AVX2
[[gnu::target("avx2,fma")]] void StiffnessProduct::multiply_slices_by_avx2(int first, int end, const double* u,
                                                                           double* result) const {
  for (int slice = first; slice < end; ++slice) multiply_slice<4>(slice, u, result);
}
#endif

void StiffnessProduct::multiply_slices(int first, int end, const double* u, double* result) const {
#ifdef RICOCHET_ASK_FOR_AVX2
  if (has_avx2) {
    multiply_slices_by_avx2(first, end, u, result);
    return;
  }
#endif
  for (int slice = first; slice < end; ++slice) multiply_slice<usual_width>(slice, u, result);
}

void StiffnessProduct::multiply(const Eigen::VectorXd& u, Eigen::VectorXd& result, int first, int last) const {
  const int pieces = parallel_ ? std::min(parallel_->threads(), (last - first) / least_rows(components_)) : 1;
  if (pieces <= 1) {
    multiply_here(u, result, first, last);
    return;
  }
  const int slice = rows_of_slice(components_), slices = (last - first + slice - 1) / slice;
  const auto begin = [&](int piece) {  // in 64 bits: slices times threads
    const auto before = static_cast<int>(std::int64_t{slices} * piece / pieces);
    return std::min(first + before * slice, last);
  };
  parallel_->for_each(pieces,
                      [&](int piece, int) noexcept { multiply_here(u, result, begin(piece), begin(piece + 1)); });
}

void StiffnessProduct::multiply_here(const Eigen::VectorXd& u, Eigen::VectorXd& result, int first, int last) const {
  if (components_ == 3) {
    stencils_.multiply(u.data(), result.data(), first / 3, last / 3, follows_);
    return;
  }
  multiply_slices(first / slice_rows, std::min(last, first_row_) / slice_rows, u.data(), result.data());
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

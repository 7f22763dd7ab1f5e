#include "common/fem/stiffness_product.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <unordered_map>

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

/// As many doubles as the processor computes at once.
template <int width>
struct Pack {
  using Vector __attribute__((vector_size(width * sizeof(double)))) = double;
};
template <int width>
using Vector = typename Pack<width>::Vector;

// All that the loop calls must become part of it: only then is it compiled for the loop's processor.
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

/// Per component, whether K maps a constant one to zero, up to round-off.
template <int components>
std::array<bool, components> maps_to_zero(const SparseMatrix& stiffness) {
  constexpr double round_off = 1e-9;
  std::array<double, components> largest_sum{};
  double largest_entry = 0.0;
  for (int row = 0; row < stiffness.rows(); ++row) {
    std::array<double, components> sum{};
    for (SparseMatrix::InnerIterator it(stiffness, row); it; ++it) {
      sum[static_cast<std::size_t>(it.col() % components)] += it.value();
      largest_entry = std::max(largest_entry, std::abs(it.value()));
    }
    for (std::size_t c = 0; c < components; ++c) largest_sum[c] = std::max(largest_sum[c], std::abs(sum[c]));
  }
  std::array<bool, components> to_zero{};
  for (std::size_t c = 0; c < components; ++c) to_zero[c] = largest_sum[c] <= round_off * largest_entry;
  return to_zero;
}

}  // namespace

/// Finds the slots of each slice, and which slices have the same.
class StiffnessProduct::Builder {
 public:
  Builder(StiffnessProduct& product, const SparseMatrix& stiffness, const Numbering& numbering)
      : product_(product),
        stiffness_(stiffness),
        numbering_(numbering),
        nodes_(static_cast<int>(stiffness.rows()) / 2) {}

  void add(int slice) {
    find_neighbours(slice);
    Slots slots;
    for (const Neighbours& neighbours : neighbours_) {
      slots.slots.push_back(slot_of(slice, neighbours));
      slots.coefficients.push_back(coefficients_of(slice, neighbours));
    }
    const std::size_t hash = hash_of(slots);
    const auto [low, high] = known_.equal_range(hash);
    auto same = low;
    while (same != high && !stored_as(same->second, slots)) ++same;
    product_.slots_of_.push_back(same != high ? same->second : product_.distinct_slices());
    if (same != high) return;
    known_.insert({hash, product_.distinct_slices()});
    product_.slots_.insert(product_.slots_.end(), slots.slots.begin(), slots.slots.end());
    product_.coefficients_.insert(product_.coefficients_.end(), slots.coefficients.begin(), slots.coefficients.end());
    product_.start_.push_back(static_cast<int>(product_.slots_.size()));
  }

 private:
  using Neighbours = std::array<int, nodes_of_slice>;  // of the four nodes; -1: none

  [[nodiscard]] int number(int node) const { return numbering_.number.empty() ? node : numbering_.number[at(node)]; }

  /// Blocks of the four nodes by the distance of the neighbour's number: one distance, one slot of neighbours in a row.
  void find_neighbours(int slice) {
    const int first_node = slice * nodes_of_slice, numbered = numbering_.number.empty() ? nodes_ : numbering_.count;
    by_distance_.clear();
    for (int n = 0; n < nodes_of_slice; ++n) {
      const int row = 2 * (first_node + n), own = number(first_node + n);
      for (SparseMatrix::InnerIterator it(stiffness_, row); it; ++it) {
        const int neighbour = static_cast<int>(it.col()) / 2, distance = number(neighbour) - own;
        if (!by_distance_.empty() && last_ == std::pair(n, neighbour)) continue;  // its other component
        last_ = {n, neighbour};
        const auto place = std::lower_bound(by_distance_.begin(), by_distance_.end(), distance,
                                            [](const auto& entry, int value) { return entry.first < value; });
        const bool there = place != by_distance_.end() && place->first == distance;
        auto& row_of = there ? *place : *by_distance_.insert(place, {distance, {-1, -1, -1, -1}});
        row_of.second[at(n)] = neighbour;
      }
    }
    std::array<std::vector<int>, nodes_of_slice> scattered;  // neighbours that share no slot in a row
    neighbours_.clear();
    for (const auto& [distance, row] : by_distance_) {
      const int first = number(first_node) + distance,
                missing = static_cast<int>(std::count(row.begin(), row.end(), -1));
      if (first >= 0 && first + nodes_of_slice <= numbered && nodes_of_slice - missing > 2) {
        neighbours_.push_back(row);
        continue;
      }
      for (std::size_t n = 0; n < row.size(); ++n) {
        if (row[n] >= 0) scattered[n].push_back(row[n]);
      }
    }
    std::size_t longest = 0;
    for (const auto& list : scattered) longest = std::max(longest, list.size());
    for (std::size_t k = 0; k < longest; ++k) {
      Neighbours& slot = neighbours_.emplace_back();
      for (std::size_t n = 0; n < slot.size(); ++n) slot[n] = k < scattered[n].size() ? scattered[n][k] : -1;
    }
  }

  /// One load where all four, those that are missing included, could be nodes in a row.
  [[nodiscard]] Slot slot_of(int slice, const Neighbours& neighbours) const {
    const int first_dof = slice * slice_rows;
    const auto known = std::find_if(neighbours.begin(), neighbours.end(), [](int node) { return node >= 0; });
    const int first = *known - static_cast<int>(known - neighbours.begin());
    bool in_a_row = first >= 0 && first + nodes_of_slice <= nodes_;
    int present = 0;
    Slot slot;
    for (int n = 0; n < nodes_of_slice; ++n) {
      const int neighbour = neighbours[at(n)];
      in_a_row = in_a_row && (neighbour < 0 || neighbour == first + n);
      present += neighbour >= 0 ? 1 : 0;
      slot.distance[at(n)] = neighbour >= 0 ? 2 * neighbour - first_dof : 0;
    }
    slot.in_a_row = in_a_row && present > 2;
    if (slot.in_a_row) slot.distance = {2 * first - first_dof, 0, 0, 0};
    return slot;
  }

  [[nodiscard]] Coefficients coefficients_of(int slice, const Neighbours& neighbours) const {
    Coefficients block;
    for (int n = 0; n < nodes_of_slice; ++n) {
      const int neighbour = neighbours[at(n)], row = slice * slice_rows + 2 * n;
      if (neighbour < 0) continue;
      for (int r = 0; r < 2; ++r) {
        block.same[2 * n + r] = stiffness_.coeff(row + r, 2 * neighbour + r);
        block.cross[2 * n + r] = stiffness_.coeff(row + r, 2 * neighbour + 1 - r);
      }
    }
    return block;
  }

  static std::size_t hash_of(const Slots& slots) {
    std::size_t hash = slots.slots.size();
    const auto mix = [&hash](std::size_t value) { hash = (hash ^ value) * 0x9e3779b97f4a7c15ULL + (hash >> 29); };
    for (const Slot& slot : slots.slots) mix(static_cast<std::size_t>(static_cast<unsigned>(slot.distance[0])));
    for (const Coefficients& block : slots.coefficients) {
      mix(std::hash<double>()(block.same[0]));
      mix(std::hash<double>()(block.cross[3]));
    }
    return hash;
  }

  [[nodiscard]] bool stored_as(int k, const Slots& slots) const {
    const int first = product_.start_[at(k)], end = product_.start_[at(k) + 1];
    if (end - first != static_cast<int>(slots.slots.size())) return false;
    if (end == first) return true;  // of nodes that another process steps
    return std::equal(slots.slots.begin(), slots.slots.end(), product_.slots_.begin() + first) &&
           std::memcmp(slots.coefficients.data(), &product_.coefficients_[at(first)],
                       slots.coefficients.size() * sizeof(Coefficients)) == 0;
  }

  StiffnessProduct& product_;
  const SparseMatrix& stiffness_;
  const Numbering& numbering_;
  int nodes_;
  std::unordered_multimap<std::size_t, int> known_;  ///< by the hash of slots that are stored, which
  std::vector<std::pair<int, Neighbours>> by_distance_;
  std::pair<int, int> last_{-1, -1};    ///< node of the slice and neighbour seen last
  std::vector<Neighbours> neighbours_;  ///< of the slice, per slot
};

StiffnessProduct::StiffnessProduct(const SparseMatrix& stiffness, int components, const Numbering& numbering)
    : components_(components) {
  const auto set_follows = [&](const auto& to_zero) {
    for (std::size_t c = 0; c < to_zero.size(); ++c) follows_[c] = to_zero[c] ? 1.0 : 0.0;
  };
  if (components == 1) set_follows(maps_to_zero<1>(stiffness));
  if (components == 2) set_follows(maps_to_zero<2>(stiffness));
  if (components == 3) set_follows(maps_to_zero<3>(stiffness));
  if (components == 3) {
    stencils_ = NodeStencils(stiffness);
    return;
  }
  const int slices = components == 2 ? static_cast<int>(stiffness.rows()) / slice_rows : 0;
  Builder builder(*this, stiffness, numbering);
  for (int slice = 0; slice < slices; ++slice) builder.add(slice);
  first_row_ = slices * slice_rows;
  rows_ = stiffness.bottomRows(stiffness.rows() - first_row_);
  rows_.makeCompressed();
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
  const int stored = slots_of_[static_cast<std::size_t>(slice)], end = start_[static_cast<std::size_t>(stored) + 1];
  const double* const here = u + slice * slice_rows;
  for (int k = start_[static_cast<std::size_t>(stored)]; k < end; ++k) {
    const Slot& slot = slots_[static_cast<std::size_t>(k)];
    const Coefficients& c = coefficients_[static_cast<std::size_t>(k)];
    for (int p = 0; p < parts; ++p) {
      const int i = p * width;
      const Vector<width> neighbour =
          (slot.in_a_row ? load<width>(here + slot.distance[0] + i)
                         : load_pairs<width>(here, &slot.distance[static_cast<std::size_t>(i / 2)])) -
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
  components_ == 1 ? multiply_rows_of<1>(u.data(), result.data(), first, last)
                   : multiply_rows_of<2>(u.data(), result.data(), first, last);
}

template <int components>
void StiffnessProduct::multiply_rows_of(const double* u, double* result, int first, int last) const {
  const int *const start = rows_.outerIndexPtr(), *const column = rows_.innerIndexPtr();
  const double* const value = rows_.valuePtr();
  for (int row = first; row < last; ++row) {
    double own[components], sum = 0.0;
    for (int c = 0; c < components; ++c) own[c] = follows_[c] * u[row - row % components + c];
    for (int i = start[row - first_row_]; i < start[row - first_row_ + 1]; ++i)
      sum += value[i] * (u[column[i]] - own[column[i] % components]);
    result[row] = sum;
  }
}

double StiffnessProduct::contiguous_share() const {
  const auto count = std::count_if(slots_.begin(), slots_.end(), [](const Slot& slot) { return slot.in_a_row; });
  return slots_.empty() ? 0.0 : static_cast<double>(count) / static_cast<double>(slots_.size());
}

}  // namespace ricochet::fem

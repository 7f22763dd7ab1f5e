#include "common/fem/node_stencils.hpp"

#include <algorithm>
#include <cstring>
#include <string_view>
#include <unordered_map>

// Vectors pass between functions of this file only, so how a processor without AVX passes them is nobody's business.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace ricochet::fem {
namespace {

using Quad __attribute__((vector_size(4 * sizeof(double)))) = double;  // three components, and what follows them

/// One node's rows of K.
struct Rows {
  std::vector<int> distance;
  std::vector<StencilBlock> coefficient;

  Rows(const SparseMatrix& stiffness, int node) {
    for (int r = 0; r < 3; ++r) {
      for (SparseMatrix::InnerIterator it(stiffness, 3 * node + r); it; ++it) {
        const int to = 3 * (static_cast<int>(it.col()) / 3 - node);
        if (distance.empty() || distance.back() != to) distance.push_back(to);
      }
    }
    std::sort(distance.begin(), distance.end());
    distance.erase(std::unique(distance.begin(), distance.end()), distance.end());
    coefficient.resize(distance.size());
    for (int r = 0; r < 3; ++r) {
      std::size_t block = 0;  // columns ascend
      for (SparseMatrix::InnerIterator it(stiffness, 3 * node + r); it; ++it) {
        const int column = static_cast<int>(it.col());
        while (distance[block] != 3 * (column / 3 - node)) ++block;
        coefficient[block].column[column % 3][r] = it.value();
      }
    }
  }
  [[nodiscard]] std::size_t hash() const {
    const auto bytes = [](const auto& values) {
      return std::string_view(reinterpret_cast<const char*>(values.data()), values.size() * sizeof values[0]);
    };
    return std::hash<std::string_view>()(bytes(distance)) ^ std::hash<std::string_view>()(bytes(coefficient));
  }
};

// All that the loop calls must become part of it: only then is it compiled for the loop's processor.
[[gnu::always_inline]] inline Quad load_quad(const double* from) {
  Quad quad;
  std::memcpy(&quad, from, sizeof quad);
  return quad;
}

/// The three components of a node and, where `more` follow it, whatever does.
template <bool more>
[[gnu::always_inline]] inline Quad load_node(const double* from) {
  if constexpr (more) return load_quad(from);
  return Quad{from[0], from[1], from[2], 0.0};
}

/// Sums of a block's columns by component of the neighbour.
struct Sums {
  Quad by_x{}, by_y{}, by_z{};

  [[gnu::always_inline]] void add(const StencilBlock& block, const Quad& u) {
    by_x += load_quad(block.column[0]) * __builtin_shufflevector(u, u, 0, 0, 0, 0);
    by_y += load_quad(block.column[1]) * __builtin_shufflevector(u, u, 1, 1, 1, 1);
    by_z += load_quad(block.column[2]) * __builtin_shufflevector(u, u, 2, 2, 2, 2);
  }
};

}  // namespace

NodeStencils::NodeStencils(const SparseMatrix& stiffness) {
  std::unordered_multimap<std::size_t, int> known;
  const auto equal = [&](int stencil, const Rows& rows) {
    const int first = begin_[at(stencil)], end = begin_[at(stencil) + 1];
    if (end - first != static_cast<int>(rows.distance.size())) return false;
    if (end == first) return true;  // of a node that another process steps
    return std::equal(rows.distance.begin(), rows.distance.end(), distance_.begin() + first) &&
           std::memcmp(rows.coefficient.data(), &coefficient_[at(first)],
                       rows.coefficient.size() * sizeof(StencilBlock)) == 0;
  };
  for (int node = 0; node < static_cast<int>(stiffness.rows()) / 3; ++node) {
    const Rows rows(stiffness, node);
    const std::size_t hash = rows.hash();
    const auto [low, high] = known.equal_range(hash);
    auto same = low;
    while (same != high && !equal(same->second, rows)) ++same;
    stencil_.push_back(same != high ? same->second : distinct());
    if (same != high) continue;
    known.insert({hash, distinct()});
    distance_.insert(distance_.end(), rows.distance.begin(), rows.distance.end());
    coefficient_.insert(coefficient_.end(), rows.coefficient.begin(), rows.coefficient.end());
    begin_.push_back(static_cast<int>(distance_.size()));
  }
}

template <bool more>
[[gnu::always_inline]] inline void NodeStencils::multiply_node(const double* u, double* result, int node,
                                                               const double* follows) const {
  const double* own = u + 3 * node;
  const Quad base = load_node<more>(own) * Quad{follows[0], follows[1], follows[2], 0.0};
  const int stencil = stencil_[at(node)], end = begin_[at(stencil) + 1];
  int block = begin_[at(stencil)];
  Sums even, odd;  // two, for a sum must wait for the one before it
  for (; block + 1 < end; block += 2) {
    even.add(coefficient_[at(block)], load_node<more>(own + distance_[at(block)]) - base);
    odd.add(coefficient_[at(block + 1)], load_node<more>(own + distance_[at(block + 1)]) - base);
  }
  if (block < end) even.add(coefficient_[at(block)], load_node<more>(own + distance_[at(block)]) - base);
  const Quad sum = (even.by_x + odd.by_x) + (even.by_y + odd.by_y) + (even.by_z + odd.by_z);
  std::memcpy(result + 3 * node, &sum, 3 * sizeof(double));
}

[[gnu::always_inline]] inline void NodeStencils::multiply_nodes(const double* u, double* result, int first, int end,
                                                                const double* follows) const {
  for (int node = first; node < end; ++node) {
    const int stencil = stencil_[at(node)], blocks = begin_[at(stencil) + 1];
    const int furthest = blocks > begin_[at(stencil)] ? std::max(0, distance_[at(blocks - 1)]) : 0;  // they ascend
    const bool last = 3 * node + furthest >= 3 * (nodes() - 1);  // nothing follows the last node's
    if (last) {
      multiply_node<false>(u, result, node, follows);
    } else {
      multiply_node<true>(u, result, node, follows);
    }
  }
}

#if defined(__x86_64__) && !defined(__AVX2__)
[[gnu::target("avx2,fma")]] void NodeStencils::multiply_nodes_by_avx2(const double* u, double* result, int first,
                                                                      int end, const double* follows) const {
  multiply_nodes(u, result, first, end, follows);
}
#endif

void NodeStencils::multiply(const double* u, double* result, int first, int end, const double* follows) const {
#if defined(__x86_64__) && !defined(__AVX2__)
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) {
    multiply_nodes_by_avx2(u, result, first, end, follows);
    return;
  }
#endif
  multiply_nodes(u, result, first, end, follows);
}

}  // namespace ricochet::fem

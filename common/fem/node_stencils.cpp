#include "common/fem/node_stencils.hpp"

#include <algorithm>
#include <cstring>
#include <map>
#include <string_view>
#include <unordered_map>

// Vectors pass between functions of this file only, so how a processor without AVX passes them is nobody's business.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace ricochet::fem {
namespace {

using Column __attribute__((vector_size(4 * sizeof(double)))) = double;  // of a block, and what follows it

constexpr int block_size = 9;

/// One node's rows of K.
struct Rows {
  std::vector<int> distance;
  std::vector<double> coefficient;

  Rows(const SparseMatrix& stiffness, int node) {
    std::map<int, int> place;  // of the neighbour's block
    for (int r = 0; r < 3; ++r) {
      for (SparseMatrix::InnerIterator it(stiffness, 3 * node + r); it; ++it) place[static_cast<int>(it.col()) / 3] = 0;
    }
    for (auto& [neighbour, block] : place) {
      block = static_cast<int>(distance.size());
      distance.push_back(3 * (neighbour - node));
    }
    coefficient.assign(block_size * distance.size(), 0.0);
    for (int r = 0; r < 3; ++r) {
      for (SparseMatrix::InnerIterator it(stiffness, 3 * node + r); it; ++it) {
        const int column = static_cast<int>(it.col());
        coefficient[at(block_size * place[column / 3] + 3 * (column % 3) + r)] = it.value();
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

// What the loop calls must become part of it: only then is it compiled for the loop's processor.
[[gnu::always_inline]] inline Column load_column(const double* from) {
  Column column;
  std::memcpy(&column, from, sizeof column);
  return column;
}

}  // namespace

NodeStencils::NodeStencils(const SparseMatrix& stiffness) {
  std::unordered_multimap<std::size_t, int> known;
  const auto equal = [&](int stencil, const Rows& rows) {
    const int first = begin_[at(stencil)], end = begin_[at(stencil) + 1];
    return end - first == static_cast<int>(rows.distance.size()) &&
           std::equal(rows.distance.begin(), rows.distance.end(), distance_.begin() + first) &&
           std::equal(rows.coefficient.begin(), rows.coefficient.end(), coefficient_.begin() + block_size * first);
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
  coefficient_.push_back(0.0);
}

[[gnu::always_inline]] inline void NodeStencils::multiply_nodes(const double* u, double* result, int first, int end,
                                                                const double* follows) const {
  for (int node = first; node < end; ++node) {
    const double* own = u + 3 * node;
    const double own_x = follows[0] * own[0], own_y = follows[1] * own[1], own_z = follows[2] * own[2];
    const int stencil = stencil_[at(node)], blocks_end = begin_[at(stencil) + 1];
    Column by_x{}, by_y{}, by_z{};
    for (int block = begin_[at(stencil)]; block < blocks_end; ++block) {
      const double* neighbour = own + distance_[at(block)];
      const double* columns = &coefficient_[at(block_size * block)];
      by_x += load_column(columns) * (neighbour[0] - own_x);
      by_y += load_column(columns + 3) * (neighbour[1] - own_y);
      by_z += load_column(columns + 6) * (neighbour[2] - own_z);
    }
    const Column sum = by_x + by_y + by_z;
    std::memcpy(result + 3 * node, &sum, 3 * sizeof(double));
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

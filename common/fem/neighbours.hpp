#pragma once

#include <vector>

#include "common/fem/element_kind.hpp"

namespace ricochet::fem {

/// Which nodes share an element, and so have an entry of K: those of node i, itself among them, are node[start[i]] ...
/// node[start[i + 1] - 1], ascending.
struct Neighbours {
  std::vector<int> start{0}, node;
};

/// The neighbours by elements of the nodes 0 ... nodes - 1. Takes time in proportion to what it returns.
[[nodiscard]] Neighbours neighbours_of(const std::vector<Element>& elements, int nodes);

}  // namespace ricochet::fem

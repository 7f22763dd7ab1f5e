#include "common/fem/neighbours.hpp"

#include <algorithm>

#include "common/fem/mesh.hpp"

namespace ricochet::fem {

Neighbours neighbours_of(const std::vector<Element>& elements, int nodes) {
  std::vector<int> start(at(nodes) + 1, 0);  // of each node's elements
  for (const auto& element : elements) {
    for (const int node : element) ++start[at(node) + 1];
  }
  for (int i = 0; i < nodes; ++i) start[at(i) + 1] += start[at(i)];
  std::vector<int> of_node(at(start.back())), next(start.begin(), start.end() - 1);
  for (int e = 0; e < static_cast<int>(elements.size()); ++e) {
    for (const int node : elements[at(e)]) of_node[at(next[at(node)]++)] = e;
  }
  Neighbours neighbours;
  std::vector<int> found_by(at(nodes), -1);
  for (int i = 0; i < nodes; ++i) {
    const auto first = neighbours.node.size();
    for (int k = start[at(i)]; k < start[at(i) + 1]; ++k) {
      for (const int node : elements[at(of_node[at(k)])]) {
        if (found_by[at(node)] == i) continue;
        found_by[at(node)] = i;
        neighbours.node.push_back(node);
      }
    }
    std::sort(neighbours.node.begin() + static_cast<std::ptrdiff_t>(first), neighbours.node.end());
    neighbours.start.push_back(static_cast<int>(neighbours.node.size()));
  }
  return neighbours;
}

}  // namespace ricochet::fem

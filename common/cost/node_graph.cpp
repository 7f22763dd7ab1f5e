#include "common/cost/node_graph.hpp"

#include <cholmod.h>

#include <algorithm>
#include <new>

namespace ricochet::cost {

using fem::at;

NodeGraph node_graph(const fem::Mesh& mesh, const std::vector<bool>& of_element) {
  NodeGraph graph;
  std::vector<int> place(mesh.position.size(), -1);
  std::vector<fem::Element> elements;
  for (std::size_t e = 0; e < mesh.elements.size(); ++e) {
    if (!of_element[e]) continue;
    elements.push_back(mesh.elements[e]);
    for (const int node : mesh.elements[e]) place[at(node)] = 0;
  }
  for (std::size_t node = 0; node < place.size(); ++node) {
    if (place[node] < 0) continue;
    place[node] = graph.nodes();
    graph.node.push_back(static_cast<int>(node));
  }
  for (auto& element : elements) {
    for (int& node : element) node = place[at(node)];
  }
  graph.neighbours = fem::neighbours_of(elements, graph.nodes());
  return graph;
}

FactorSize factor_size(const NodeGraph& graph, int components) {
  if (graph.node.empty()) return {};
  cholmod_common common;
  cholmod_start(&common);
  common.print = 0;
  common.supernodal = CHOLMOD_SIMPLICIAL;
  const auto nodes = graph.node.size();
  // The columns of the upper triangle: of node i its neighbours up to i.
  cholmod_sparse* pattern =
      cholmod_allocate_sparse(nodes, nodes, graph.neighbours.node.size(), 1, 1, 1, CHOLMOD_PATTERN, &common);
  FactorSize size;
  if (pattern) {
    auto* start = static_cast<int*>(pattern->p);
    auto* row = static_cast<int*>(pattern->i);
    start[0] = 0;
    for (std::size_t i = 0; i < nodes; ++i) {
      start[i + 1] = start[i];
      for (int k = graph.neighbours.start[i]; k < graph.neighbours.start[i + 1]; ++k)
        if (graph.neighbours.node[at(k)] <= static_cast<int>(i)) row[start[i + 1]++] = graph.neighbours.node[at(k)];
    }
    cholmod_factor* symbolic = cholmod_analyze(pattern, &common);
    // An entry between two nodes is a block, of a node with itself half a one.
    const double c = components, n = static_cast<double>(nodes);
    size = {c * c * (common.lnz - n) + 0.5 * c * (c + 1.0) * n, c * c * c * common.fl};
    if (symbolic) cholmod_free_factor(&symbolic, &common);
    cholmod_free_sparse(&pattern, &common);
  }
  const bool analysed = common.status == CHOLMOD_OK;
  cholmod_finish(&common);
  if (!analysed) throw std::bad_alloc();
  return size;
}

double reached_share(const NodeGraph& graph, const std::vector<int>& driven, double steps) {
  std::vector<bool> reached(graph.node.size(), false);
  std::vector<int> front;
  for (const int node : driven) {
    const auto found = std::lower_bound(graph.node.begin(), graph.node.end(), node);
    if (found == graph.node.end() || *found != node) continue;
    const int i = static_cast<int>(found - graph.node.begin());
    if (!reached[at(i)]) front.push_back(i);
    reached[at(i)] = true;
  }
  double sum = 0.0;
  for (double step = 0.0; step < steps && !front.empty(); step += 1.0) {
    sum += static_cast<double>(front.size()) * (steps - step);
    std::vector<int> next;
    for (const int i : front) {
      for (int k = graph.neighbours.start[at(i)]; k < graph.neighbours.start[at(i + 1)]; ++k) {
        const int j = graph.neighbours.node[at(k)];
        if (!reached[at(j)]) next.push_back(j);
        reached[at(j)] = true;
      }
    }
    front.swap(next);
  }
  return graph.node.empty() ? 0.0 : sum / (steps * static_cast<double>(graph.node.size()));
}

}  // namespace ricochet::cost

#include "explicit_solver/ranks/shares.hpp"

#include <fmt/format.h>
#include <metis.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <set>
#include <utility>

#include "common/base/error.hpp"
#include "common/fem/hanging_nodes.hpp"
#include "explicit_solver/block_sums.hpp"

namespace ricochet::explicit_solver {

using fem::at;
using solver::BodyState;

namespace {

/// Per node of the part: the first rank's, whatever METIS says.
std::vector<bool> of_first_rank(const scene::Problem& problem, const BodyState& state, const fem::LocalSteps& steps,
                                int layers) {
  const int components = fem::components(state.part.mesh.model);
  std::vector<bool> first(at(state.part.nodes()), false);
  std::vector<int> front = state.shared_nodes;
  front.insert(front.end(), steps.reached().begin(), steps.reached().end());
  for (const int node : scene::contact_nodes(problem.contacts, state.body)) {
    const auto& nodes = state.part.body_node;
    const auto found = std::lower_bound(nodes.begin(), nodes.end(), node);
    if (found != nodes.end() && *found == node) front.push_back(static_cast<int>(found - nodes.begin()));
  }
  const auto carriers = fem::carriers_of(state.part.mesh, front);
  front.insert(front.end(), carriers.begin(), carriers.end());
  for (const int node : front) first[at(node)] = true;
  for (int layer = 0; layer < layers; ++layer) {
    std::vector<int> next;
    for (const int node : front) {
      for (fem::SparseMatrix::InnerIterator it(state.part.stiffness, node * components); it; ++it) {
        const int neighbour = static_cast<int>(it.col()) / components;
        if (first[at(neighbour)]) continue;
        first[at(neighbour)] = true;
        next.push_back(neighbour);
      }
    }
    front.swap(next);
  }
  return first;
}

/// Blocks as METIS wants them. All of the first rank are one vertex.
struct Graph {
  std::vector<int> vertex_of_block;
  bool has_first = false;  ///< vertex 0 is what the first rank must have
  std::vector<idx_t> weight, start{0}, neighbour, edges_between;
};

Graph graph_of(const BodyState& state, const std::vector<bool>& first, const fem::LocalSteps& steps) {
  const int components = fem::components(state.part.mesh.model), blocks = blocks_of(state.part.nodes());
  Graph graph;
  graph.vertex_of_block.assign(at(blocks), -1);
  for (int node = 0; node < state.part.nodes(); ++node) {
    if (first[at(node)]) graph.vertex_of_block[at(node / block_nodes)] = 0;
  }
  graph.has_first = std::count(graph.vertex_of_block.begin(), graph.vertex_of_block.end(), 0) > 0;
  int vertices = graph.has_first ? 1 : 0;
  for (int& vertex : graph.vertex_of_block) {
    if (vertex < 0) vertex = vertices++;
  }
  graph.weight.assign(at(vertices), 0);
  std::vector<std::map<int, idx_t>> near(at(vertices));
  for (int node = 0; node < state.part.nodes(); ++node) {
    const int vertex = graph.vertex_of_block[at(node / block_nodes)];
    ++graph.weight[at(vertex)];
    for (fem::SparseMatrix::InnerIterator it(state.part.stiffness, node * components); it; ++it) {
      const int other = graph.vertex_of_block[at(static_cast<int>(it.col()) / components / block_nodes)];
      if (other != vertex) ++near[at(vertex)][other];
    }
  }
  if (steps.any()) graph.weight[0] += static_cast<idx_t>(steps.extra_rows() * state.part.nodes());
  for (const auto& others : near) {
    for (const auto& [other, edges] : others) {
      graph.neighbour.push_back(other);
      graph.edges_between.push_back(edges);
    }
    graph.start.push_back(static_cast<idx_t>(graph.neighbour.size()));
  }
  return graph;
}

/// The graph without vertex 0.
Graph without_first(const Graph& graph) {
  Graph rest;
  rest.weight.assign(graph.weight.begin() + 1, graph.weight.end());
  for (std::size_t v = 1; v < graph.weight.size(); ++v) {
    for (idx_t e = graph.start[v]; e < graph.start[v + 1]; ++e) {
      if (graph.neighbour[at(e)] == 0) continue;
      rest.neighbour.push_back(graph.neighbour[at(e)] - 1);
      rest.edges_between.push_back(graph.edges_between[at(e)]);
    }
    rest.start.push_back(static_cast<idx_t>(rest.neighbour.size()));
  }
  return rest;
}

/// Per vertex of the graph its rank; what the first rank must have is with rank 0.
std::vector<int> ranks_of(Graph graph, int ranks) {
  const idx_t all = std::accumulate(graph.weight.begin(), graph.weight.end(), idx_t{0});
  if (graph.has_first && ranks > 1 && graph.weight.front() >= all / ranks) {  // more than a share: it gets no other
    std::vector<int> rank = ranks_of(without_first(graph), ranks - 1);
    for (int& r : rank) ++r;
    rank.insert(rank.begin(), 0);
    return rank;
  }
  auto vertices = static_cast<idx_t>(graph.weight.size()), parts = static_cast<idx_t>(ranks), cut = idx_t{0},
       constraints = idx_t{1};
  std::vector<idx_t> rank(graph.weight.size(), 0);
  if (vertices < 2 * parts) {  // METIS wants more vertices than parts
    for (idx_t v = 0; v < vertices; ++v) rank[static_cast<std::size_t>(v)] = v % parts;
  } else if (parts > 1) {
    idx_t options[METIS_NOPTIONS];
    METIS_SetDefaultOptions(options);
    options[METIS_OPTION_SEED] = 1;
    const int status =
        METIS_PartGraphKway(&vertices, &constraints, graph.start.data(), graph.neighbour.data(), graph.weight.data(),
                            nullptr, graph.edges_between.data(), &parts, nullptr, nullptr, options, &cut, rank.data());
    if (status != METIS_OK)
      throw SolverError(fmt::format("METIS could not share out {} blocks of nodes among {} ranks", vertices, ranks));
  }
  const idx_t first = graph.has_first ? rank[0] : 0;
  for (idx_t& r : rank) r = r == first ? 0 : r == 0 ? first : r;
  return {rank.begin(), rank.end()};
}

}  // namespace

std::vector<int> moved_by(const fem::Mesh& mesh, const fem::Element& element) {
  std::vector<int> nodes(element.begin(), element.end());
  if (mesh.hanging.empty()) return nodes;
  fem::for_each_carrier(mesh, element, [&](int node) { nodes.push_back(node); });
  return nodes;
}

int SharedPart::rank_of(int node) const { return rank_of_block[at(node / block_nodes)]; }

std::vector<SharedPart> share_out(const scene::Problem& problem, const std::vector<BodyState>& whole,
                                  const std::vector<fem::LocalSteps>& steps, int layers, int ranks) {
  const bool slides = std::any_of(problem.contacts.begin(), problem.contacts.end(),
                                  [](const scene::ContactGeometry& contact) { return contact.sliding != nullptr; });
  std::vector<SharedPart> parts;
  const fem::LocalSteps none;
  for (std::size_t b = 0; b < whole.size(); ++b) {
    const BodyState& state = whole[b];
    const fem::LocalSteps& own = steps.empty() ? none : steps[b];
    Graph graph = graph_of(state, of_first_rank(problem, state, own, layers), own);
    auto& part = parts.emplace_back();
    part.body = state.body;
    part.nodes = state.part.body_node;
    part.slides = slides && problem.scene.coupling.protocol.layout == scene::Layout::all_explicit;
    part.loaded = !state.external.zero();
    if (state.frame) part.frame = state.frame->whole();
    part.booked = static_cast<int>(state.booked().size());
    part.rank_of_block = std::move(graph.vertex_of_block);
    const auto rank = ranks_of(std::move(graph), ranks);
    for (int& entry : part.rank_of_block) entry = rank[at(entry)];
  }
  return parts;
}

scene::ParticipantPart part_of_rank(const scene::Problem& problem, const scene::ParticipantSpec& participant,
                                    const SharedPart& shared, int rank) {
  // Whole blocks come with every node that is read, so that slices stay slices (Numbering).
  const int nodes = static_cast<int>(shared.nodes.size());
  std::vector<int> local(problem.bodies[at(shared.body)].mesh.position.size(), -1), own;
  for (int node = 0; node < nodes; ++node) {
    local[at(shared.nodes[at(node)])] = node;
    if (shared.rank_of(node) == rank) own.push_back(shared.nodes[at(node)]);
  }
  std::set<int> blocks;
  const auto& body = problem.bodies[at(shared.body)];
  for (const auto& element : body.mesh.elements) {
    const auto moving = moved_by(body.mesh, element);
    const auto of_part = [&](int node) { return local[at(node)] >= 0; };
    const auto mine = [&](int node) { return of_part(node) && shared.rank_of(local[at(node)]) == rank; };
    if (std::none_of(moving.begin(), moving.end(), mine)) continue;
    for (const int node : moving) {
      if (of_part(node)) blocks.insert(local[at(node)] / block_nodes);
    }
  }
  std::vector<int> with;
  for (const int block : blocks) {
    const auto begin = shared.nodes.begin() + block * block_nodes;
    with.insert(with.end(), begin, shared.nodes.begin() + std::min((block + 1) * block_nodes, nodes));
  }
  return scene::part_share(problem, shared.body, participant, shared.nodes, own, with);
}

}  // namespace ricochet::explicit_solver

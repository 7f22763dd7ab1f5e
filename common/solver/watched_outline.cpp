#include "common/solver/watched_outline.hpp"

#include <algorithm>

#include "common/problem/outline.hpp"

namespace ricochet::solver {

WatchedOutline::WatchedOutline(const scene::Problem& problem, const std::vector<BodyState>& states) {
  const auto pairs = scene::pairs_without_contact(problem);
  const auto contacts = scene::contacts_to_watch(problem);
  for (std::size_t part = 0; part < states.size(); ++part) {
    const int body = states[part].body;
    const bool watched =
        std::any_of(pairs.begin(), pairs.end(), [&](const auto& p) { return p.first == body || p.second == body; }) ||
        std::any_of(contacts.begin(), contacts.end(), [&](auto* c) { return c->body_a == body || c->body_b == body; });
    if (!watched) continue;
    const auto outline = scene::outline_of(problem.bodies[static_cast<std::size_t>(body)].mesh);
    const auto& own = states[part].part.body_node;
    for (int local = 0; local < static_cast<int>(own.size()); ++local) {
      const int node = own[static_cast<std::size_t>(local)];
      if (std::binary_search(outline.nodes.begin(), outline.nodes.end(), node)) nodes_.push_back({part, local});
    }
  }
}

std::vector<participant::OutlineNode> WatchedOutline::nodes(const std::vector<BodyState>& states) const {
  std::vector<participant::OutlineNode> result;
  for (const auto& [part, local] : nodes_) {
    const auto& state = states[part];
    const int components = fem::components(state.part.mesh.model);
    participant::OutlineNode node{static_cast<int>(part), state.part.body_node[static_cast<std::size_t>(local)], {}};
    for (int c = 0; c < components; ++c) node.displacement_m.push_back(state.u[local * components + c]);
    result.push_back(std::move(node));
  }
  return result;
}

}  // namespace ricochet::solver

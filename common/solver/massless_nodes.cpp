#include "common/solver/massless_nodes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/base/error.hpp"
#include "common/fem/element.hpp"

namespace ricochet::solver {
namespace {

/// Nodes that share an edge of an element with a contact node and are none themselves, per contact node of `contact`.
std::vector<std::vector<int>> inward_neighbours(const BodyState& state, const std::vector<int>& contact) {
  const auto corners = static_cast<std::size_t>(fem::nodes_per_element(state.part.mesh.model));
  std::vector<int> place(static_cast<std::size_t>(state.part.nodes()), -1);
  for (std::size_t i = 0; i < contact.size(); ++i) place[static_cast<std::size_t>(contact[i])] = static_cast<int>(i);
  std::vector<std::vector<int>> inward(contact.size());
  for (const auto& element : state.part.mesh.elements) {
    for (std::size_t i = 0; i < corners; ++i) {
      const int at = place[static_cast<std::size_t>(element[i])];
      if (at < 0) continue;
      auto& found = inward[static_cast<std::size_t>(at)];
      for (const std::size_t next : {(i + 1) % corners, (i + corners - 1) % corners}) {
        const int other = element[next];
        if (place[static_cast<std::size_t>(other)] >= 0 || std::find(found.begin(), found.end(), other) != found.end()) continue;
        found.push_back(other);
      }
    }
  }
  return inward;
}

[[noreturn]] void refuse(const BodyState& state, int node) {
  const auto& x = state.part.mesh.position[static_cast<std::size_t>(node)];
  throw ConfigError(fmt::format(
      "contact.multiplier_update = \"massless\": the contact node {} of body '{}' at ({:.6g}, {:.6g}) m has no neighbour behind the "
      "contact surface among the elements of its participant to take its mass; give it a layer of elements, or use "
      "\"trapezoidal_reset\"", state.part.body_node[static_cast<std::size_t>(node)], state.name, x[0], x[1]));
}

}  // namespace

MasslessNodes::MasslessNodes(const std::vector<Pair>& pairs, const Eigen::Vector2d& normal, std::vector<BodyState>& states)
    : inward_(pairs.size()), debt_j_(pairs.size(), 0.0), trial_debt_j_(pairs.size(), 0.0) {
  for (std::size_t part = 0; part < states.size(); ++part) {
    auto& state = states[part];
    const int components = fem::components(state.part.mesh.model);
    std::vector<std::pair<std::size_t, double>> sides;  // pair, +1 for B
    std::vector<int> contact;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      for (const auto& [side, sign] : {std::pair{pairs[i].a, -1.0}, std::pair{pairs[i].b, 1.0}}) {
        if (side.part != static_cast<int>(part)) continue;
        sides.emplace_back(i, sign);
        contact.push_back(side.node);
      }
    }
    const auto inward = inward_neighbours(state, contact);
    for (std::size_t k = 0; k < contact.size(); ++k) {
      if (inward[k].empty()) refuse(state, contact[k]);
      const double share = 1.0 / static_cast<double>(inward[k].size());
      for (int c = 0; c < components; ++c) {
        const int dof = contact[k] * components + c;
        if (normal[c] == 0.0 || !state.free[static_cast<std::size_t>(dof)]) continue;
        for (const int other : inward[k]) {
          const int to = other * components + c;
          state.mass[to] += share * state.mass[dof];
          if (state.free[static_cast<std::size_t>(to)]) state.inverse_mass[to] = 1.0 / state.mass[to];
          inward_[sides[k].first].push_back({part, to, sides[k].second * share * normal[c]});
        }
        state.mass[dof] = state.inverse_mass[dof] = 0.0;
      }
    }
  }
}

double MasslessNodes::give_back(std::size_t pair, double made_j, double most_n_s, const std::vector<BodyState>& states,
                                const std::vector<double*>& velocity) {
  double& debt = trial_debt_j_[pair];
  debt = debt_j_[pair] + made_j;
  double rate = 0.0, inverse_mass = 0.0;
  for (const auto& share : inward_[pair]) {
    rate += share.of_rate * velocity[share.part][share.dof];
    inverse_mass += share.of_rate * share.of_rate * states[share.part].inverse_mass[share.dof];
  }
  if (debt == 0.0 || inverse_mass == 0.0 || !(most_n_s > 0.0)) return 0.0;
  // J rate + J^2 inverse_mass / 2 = -debt, the root next to zero; without one, what stops the rate
  const double square = rate * rate - 2.0 * debt * inverse_mass;
  const double after = square > 0.0 ? std::copysign(std::sqrt(square), rate) : 0.0;
  const double impulse = std::clamp((after - rate) / inverse_mass, -most_n_s, most_n_s);
  const double work = impulse * (rate + 0.5 * impulse * inverse_mass);
  for (const auto& share : inward_[pair]) {
    velocity[share.part][share.dof] += share.of_rate * states[share.part].inverse_mass[share.dof] * impulse;
  }
  debt += work;
  trial_work_j_ += work;
  return impulse;
}

}  // namespace ricochet::solver

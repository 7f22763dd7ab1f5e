#include "common/cost/reduced_cost.hpp"

#include <algorithm>
#include <set>

#include "common/fem/hanging_nodes.hpp"

namespace ricochet::cost {
namespace {

constexpr double fixed_s = 10e-6,
                 dense_entry_s = 0.45e-9;  // of a window; of an entry of a dense matrix, times a vector
/// Solves: for a mode that is kept; for a shared unknown, three of many columns at once, a fifth of the price.
constexpr double solves_of_mode = 6.0, solves_of_shared = 0.6;
/// Windows between looks at all nodes, and pictures of a run.
constexpr double looks_apart = 256.0, pictures = 60.0;
/// Vectors of all unknowns: shapes, and those that ARPACK keeps and finds, per mode; columns of a solve, with copies.
constexpr double vectors_of_mode = 4.0, columns_at_once = 200.0;

/// Unknowns of the elements that are modes: all, and those shared with implicit ones.
struct Unknowns {
  double all = 0.0, shared = 0.0;
};

Unknowns unknowns_of(const scene::BodyProblem& body, const std::vector<bool>& owned) {
  std::set<int> nodes;
  for (std::size_t e = 0; e < owned.size(); ++e)
    if (owned[e]) fem::for_each_carrier(body.mesh, body.mesh.elements[e], [&](int node) { nodes.insert(node); });
  const auto shared =
      std::count_if(nodes.begin(), nodes.end(), [&](int node) { return bool{body.implicit_node[fem::at(node)]}; });
  const int components = fem::components(body.mesh.model);
  return {static_cast<double>(nodes.size()) * components, static_cast<double>(shared) * components};
}

}  // namespace

ReducedCost reduced_cost(const scene::Problem& problem, const scene::BodyProblem& body, const std::vector<bool>& owned,
                         const FactorSize& factor, double factor_s, double solve_s, double windows) {
  const double modes = problem.scene.partition.reduced_modes.at(body.name);
  const auto [all, shared] = unknowns_of(body, owned);
  const double products = shared * shared + 2.0 * modes * shared;
  const double shown = 1.0 / looks_apart + (windows > pictures ? pictures / windows : 1.0);
  return {fixed_s + 2.0 * dense_entry_s * products + shown * solve_s,
          2.0 * factor_s + solve_s * (solves_of_mode * modes + solves_of_shared * shared),
          8.0 * (factor.entries + all * (vectors_of_mode * modes + columns_at_once))};
}

}  // namespace ricochet::cost

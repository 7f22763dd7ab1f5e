#include "common/cost/reduced_cost.hpp"

#include <set>

#include "common/fem/hanging_nodes.hpp"

namespace ricochet::cost {
namespace {

constexpr double fixed_s = 10e-6,
                 dense_entry_s = 0.45e-9;  // of a window; of an entry of a dense matrix, times a vector
/// Solves: for a mode that is kept; for a shared unknown, three of many columns at once, a fifth of the price.
constexpr double solves_of_mode = 6.0, solves_of_shared = 0.6;
constexpr double factor_entry_s = 15e-9, factor_flop_s = 0.08e-9;
/// Windows between looks at all nodes, and pictures of a run.
constexpr double looks_apart = 256.0, pictures = 60.0;

double shared_unknowns(const scene::BodyProblem& body, const std::vector<bool>& owned) {
  std::set<int> shared;
  for (std::size_t e = 0; e < owned.size(); ++e) {
    if (!owned[e]) continue;
    fem::for_each_carrier(body.mesh, body.mesh.elements[e], [&](int node) {
      if (body.implicit_node[fem::at(node)]) shared.insert(node);
    });
  }
  return static_cast<double>(shared.size()) * fem::components(body.mesh.model);
}

}  // namespace

ReducedCost reduced_cost(const scene::Problem& problem, const scene::BodyProblem& body, const std::vector<bool>& owned,
                         const FactorSize& factor, double solve_s, double windows) {
  const double modes = problem.scene.partition.reduced_modes.at(body.name), shared = shared_unknowns(body, owned);
  const double products = shared * shared + 2.0 * modes * shared;
  const double shown = 1.0 / looks_apart + (windows > pictures ? pictures / windows : 1.0);
  return {fixed_s + 2.0 * dense_entry_s * products + shown * solve_s,
          2.0 * (factor_entry_s * factor.entries + factor_flop_s * factor.flops) +
              solve_s * (solves_of_mode * modes + solves_of_shared * shared)};
}

}  // namespace ricochet::cost

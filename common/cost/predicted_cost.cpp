#include "common/cost/predicted_cost.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <utility>

#include "common/check/check_switch.hpp"
#include "common/cost/machine_speed.hpp"
#include "common/cost/node_graph.hpp"
#include "common/cost/nonlinear_cost.hpp"
#include "common/cost/reached.hpp"
#include "common/cost/reduced_cost.hpp"
#include "common/cost/rewrites.hpp"
#include "common/fem/vtk_output.hpp"
#include "common/problem/critical_step.hpp"
#include "common/problem/local_steps.hpp"
#include "common/problem/mass_scaling.hpp"
#include "common/scene/protocols.hpp"

namespace ricochet::cost {
namespace {

using fem::at;

/// Times of the machine on which docs/speed.md was measured [s]: `./ricochet bench` and runs of the shipped scenes.
// Participants, a window or (explicit) a step:
constexpr double explicit_s = 1.2e-6, implicit_s = 2.0e-6;
constexpr double explicit_unknown_s = 1.3e-9;  // apart from K u
constexpr double implicit_unknown_s = 8e-9;    // apart from the factor
// An entry of the factor takes so long in a solve where all of it is in the processor's cache; where none of it is,
// the entry is read so many times:
constexpr double cached_entry_s = 0.42e-9, reads = 2.3, cached_entries = 2.5e6, uncached_entries = 6.5e6;
constexpr double root_entry_s = 0.35e-9;  // of the dense inverse of the root, in a solve
// A contact pair: on the implicit side; on the explicit one, there of the entries of its rows besides.
constexpr double implicit_pair_s = 0.3e-6, explicit_pair_s = 0.12e-6, explicit_pair_entry_s = 13e-9;
// A pair whose rows are written anew, where touching places of curved surfaces are sought and where not, in the
// plane and of solids; on the implicit side, of an entry of the rows times a column of the compliance besides:
constexpr double rewritten_pair_s = 15e-6, rewritten_solid_pair_s = 70e-6, flat_share = 0.35;
constexpr double rewritten_entry_s = 1.0e-9;
// Output:
constexpr double explicit_row_unknown_s = 1.2e-9, implicit_row_unknown_s = 2.2e-9;  // of a row of history.csv
constexpr double field_element_s = 0.85e-6;                                         // of a file of fields
// The coupler, a window, and of what is exchanged with a value of the interface:
constexpr double coupler_s = 3.0e-6, exchange_s = 4.0e-6, exchange_value_s = 6e-9;
/// Share of the shorter of explicit and implicit window that is computed beside the longer.
constexpr double overlap = 0.7;
constexpr double bytes_of_entry = 17.0;  // of the factor: CHOLMOD's and ours are there at once

// Set-up: an element, an entry of the factor (ordering it, writing it as blocks), an operation of the factorisation:
constexpr double setup_element_s = 4e-6, setup_entry_s = 15e-9, setup_flop_s = 0.08e-9;

constexpr int sample_elements = 8000;
/// The elements of a body that a participant owns, or all of them.
struct Share {
  const scene::BodyProblem* body;
  std::vector<bool> owned;  ///< per element
  NodeGraph graph;
  /// Products with K in a step, of which those with the rows that step locally are shares.
  double products = 1.0;
  std::shared_ptr<const fem::Part> assembled = nullptr;  ///< of a whole body, once asked for

  [[nodiscard]] double elements() const { return static_cast<double>(std::count(owned.begin(), owned.end(), true)); }
  [[nodiscard]] double unknowns() const {
    return static_cast<double>(graph.nodes()) * fem::components(body->section.model);
  }
};

Share share_of(const scene::BodyProblem& body, std::vector<bool> owned) {
  NodeGraph graph = node_graph(body.mesh, owned);
  return {&body, std::move(owned), std::move(graph)};
}

/// A whole body, assembled once for all that ask. `scaled`: with the masses of mass scaling, if it has any.
const fem::Part& part_of(Share& whole, bool scaled) {
  const scene::BodyProblem& body = *whole.body;
  if (whole.assembled && (scaled || body.density_factor.empty())) return *whole.assembled;
  std::vector<int> elements(whole.owned.size());
  std::iota(elements.begin(), elements.end(), 0);
  whole.assembled = std::make_shared<const fem::Part>(
      scaled ? scene::body_part(body, elements)
             : fem::extract_part(body.mesh, body.name, body.section, body.material, elements));
  return *whole.assembled;
}

/// K u of one step of the whole share [s], from as many of its elements as a sample takes.
double product_s(const Share& share) {
  std::vector<int> sample;
  for (std::size_t e = 0; e < share.owned.size() && std::ssize(sample) < sample_elements; ++e)
    if (share.owned[e]) sample.push_back(static_cast<int>(e));
  if (sample.empty()) return 0.0;
  const auto& body = *share.body;
  const fem::Part part = fem::extract_part(body.mesh, body.name, body.section, body.material, sample);
  return time_product(part) * share.unknowns() / part.dofs();
}

double solve_of_entries_s(double entries) {
  if (entries <= cached_entries) return entries * cached_entry_s;
  const double in_memory = std::min((entries - cached_entries) / (uncached_entries - cached_entries), 1.0);
  return entries * ((1.0 - in_memory) * cached_entry_s + in_memory * std::max(cached_entry_s, reads * memory_read_s()));
}

/// The time that the participants of a scene, or of a baseline on it, take.
class Predictor {
 public:
  Predictor(const scene::Problem& problem, double slowness, std::vector<double> rewrites)
      : problem_(problem), slowness_(slowness), rewrites_(std::move(rewrites)) {}

  /// `steps` of a run, of which a window has `steps_of_window`; with the contact or without [s].
  [[nodiscard]] double explicit_window_s(const std::vector<Share>& shares, double steps, double steps_of_window,
                                         bool contact) const {
    double of_step = slowness_ * explicit_s, of_window = 0.0;
    for (const Share& share : shares) {
      const int index = static_cast<int>(share.body - problem_.bodies.data());
      const double reached = reached_share(problem_, index, share.graph, steps);
      const scene::Body& spec = problem_.scene.bodies[at(index)];
      of_step += (reached + spreads(spec) * (share.products - 1.0)) * product_s(share);
      of_step += slowness_ *
                 (explicit_unknown_s * share.unknowns() + nonlinear_step_s(spec, share.elements(), share.unknowns()));
      of_window += output_s(share, explicit_row_unknown_s);
    }
    if (contact) {
      of_step += slowness_ * explicit_contact_s();
      for (std::size_t i = 0; i < rewrites_.size(); ++i) of_step += slowness_ * rewrites_[i] * rewrite_s(i) / steps;
    }
    return steps_of_window * of_step + of_window;
  }

  /// `interface`: unknowns shared with others; `windows` of a run.
  [[nodiscard]] double implicit_window_s(const std::vector<Share>& shares, double entries, double interface,
                                         double windows) const {
    double of_window = slowness_ * implicit_s, roots = interface, times = 1.0;
    for (const Share& share : shares)
      times = std::max(times, solves(problem_.scene.bodies[at(static_cast<int>(share.body - problem_.bodies.data()))]));
    for (const Share& share : shares)
      of_window += slowness_ * times * implicit_unknown_s * share.unknowns() + output_s(share, implicit_row_unknown_s);
    for (int body = 0; body < static_cast<int>(problem_.bodies.size()); ++body)
      roots += static_cast<double>(scene::contact_nodes(problem_.contacts, body).size()) * problem_.scene.components();
    const double solve_s = solve_of_entries_s(entries);
    for (const auto& contact : problem_.contacts)
      of_window += slowness_ * implicit_pair_s * static_cast<double>(contact.pairs.size());
    const bool dense = root_entry_s * roots * roots < solve_s;
    for (std::size_t i = 0; i < rewrites_.size(); ++i)
      of_window +=
          slowness_ * rewrites_[i] * (rewrite_s(i) + (dense ? compliance_s(i, roots - interface) : 0.0)) / windows;
    // A root whose dense inverse costs more is none (WindowSolver).
    return of_window + slowness_ * times * (solve_s + std::min(solve_s, root_entry_s * roots * roots));
  }

 private:
  [[nodiscard]] double explicit_contact_s() const {
    const double block = problem_.scene.components() * problem_.scene.components();
    double time_s = 0.0;
    for (const auto& contact : problem_.contacts)
      for (const auto& pair : contact.pairs)
        time_s += explicit_pair_s + explicit_pair_entry_s * block * static_cast<double>(1 + pair.b.size());
    return time_s;
  }

  /// The time of the rows of a contact that are written anew.
  [[nodiscard]] double rewrite_s(std::size_t contact) const {
    const auto& geometry = problem_.contacts[contact];
    const double of_pair_s = problem_.scene.components() == 3 ? rewritten_solid_pair_s : rewritten_pair_s;
    return (geometry.flat ? flat_share : 1.0) * of_pair_s * static_cast<double>(geometry.pairs.size());
  }

  /// The time of the motion that forces on these rows cause, from the dense inverse of the root.
  [[nodiscard]] double compliance_s(std::size_t contact, double roots) const {
    const int components = problem_.scene.components();
    const double directions = problem_.scene.friction() ? components : 1.0;
    double rows = 0.0, entries = 0.0;
    for (const auto& pair : problem_.contacts[contact].pairs) {
      rows += directions;
      entries += directions * components * static_cast<double>(1 + pair.b.size());
    }
    return rewritten_entry_s * entries * (roots + rows);
  }

  /// Rows of history and files of fields, spread over the windows [s].
  [[nodiscard]] double output_s(const Share& share, double row_unknown_s) const {
    const auto& output = problem_.scene.output;
    double time_s = row_unknown_s * share.unknowns() / output.history_every;
    if (output.fields_every > 0) time_s += field_element_s * share.elements() / output.fields_every;
    return slowness_ * time_s;
  }

  const scene::Problem& problem_;
  double slowness_;
  std::vector<double> rewrites_;  ///< per contact, in a run
};

FactorSize factor_of(const std::vector<Share>& shares) {
  FactorSize factor;
  for (const Share& share : shares) factor += factor_size(share.graph, fem::components(share.body->section.model));
  return factor;
}

/// The size of the file of its fields.
double field_bytes(const Share& share) {
  double corners = 0.0;
  for (std::size_t e = 0; e < share.owned.size(); ++e)
    if (share.owned[e]) corners += static_cast<double>(share.body->mesh.elements[e].size());
  return fem::vtu_bytes(share.graph.nodes(), share.elements(), corners);
}

/// Time until a participant is initialized: its elements, their stiffness and, of the implicit one, the factor [s].
double setup_s(const std::vector<Share>& shares, const FactorSize& factor) {
  double elements = 0.0;
  for (const Share& share : shares) elements += share.elements();
  return setup_element_s * elements + setup_entry_s * factor.entries + setup_flop_s * factor.flops;
}

std::vector<Share> shares_of(const scene::Problem& problem, const scene::ParticipantSpec& owner) {
  std::vector<Share> shares;
  for (const auto& body : problem.bodies) {
    auto owned = scene::owned_elements(problem.scene, body, owner);
    if (std::find(owned.begin(), owned.end(), true) != owned.end()) shares.push_back(share_of(body, std::move(owned)));
  }
  return shares;
}

std::vector<Share> whole_bodies(const scene::Problem& problem) {
  std::vector<Share> shares;
  for (const auto& body : problem.bodies)
    shares.push_back(share_of(body, std::vector<bool>(body.mesh.elements.size(), true)));
  return shares;
}

/// The scene's step, or what all elements together allow. That they bear the scene's is known where the implicit side
/// is to switch to it and can.
double all_explicit_step_s(const scene::Problem& problem, const scene::Plan& plan, std::vector<Share>& whole) {
  const double own_s = problem.clock.largest_size_s() / problem.scene.substeps().most;
  if (scene::is_to_switch(problem) && plan.switch_obstacle.empty()) return own_s;
  double critical_s = std::numeric_limits<double>::infinity();
  for (Share& share : whole)
    critical_s = std::min(critical_s, scene::critical_time_step(*share.body, part_of(share, true), false,
                                                                problem.clock.largest_size_s()));
  return std::min(own_s, problem.scene.time.safety_factor * critical_s);
}

/// The products of windows with the local steps of the plan.
void add_planned_steps(const scene::Plan& plan, std::vector<Share>& shares) {
  for (Share& share : shares)
    for (const auto& steps : plan.local_steps)
      if (steps.body == share.body->name) share.products += steps.extra_rows;
}

/// The same of windows of the scene's steps, if all elements took local steps where they need some.
void add_local_steps(const scene::Problem& problem, std::vector<Share>& whole) {
  for (std::size_t b = 0; b < whole.size(); ++b) {
    const auto steps =
        scene::expected_local_steps(*whole[b].body, part_of(whole[b], false), problem.clock.largest_size_s());
    whole[b].products += scene::extra_rows(problem, static_cast<int>(b), steps);
  }
}

/// Before the first window each unknown of the contact is pushed, for what it moves within the small steps [s].
double unit_forces_s(const scene::Problem& problem, const std::vector<Share>& shares) {
  if (problem.scene.coupling.protocol.coupled()) return 0.0;
  const double directions = problem.scene.friction() ? problem.scene.components() : 1.0;
  double time_s = 0.0;
  for (const Share& share : shares) {
    const int index = static_cast<int>(share.body - problem.bodies.data());
    const auto nodes = static_cast<double>(scene::contact_nodes(problem.contacts, index).size());
    if (share.products > 1.0) time_s += directions * nodes * (share.products - 1.0) * product_s(share);
  }
  return time_s;
}

}  // namespace

PredictedCost predict_cost(const scene::Problem& problem, const scene::Plan& plan, double end_s,
                           const MachineSpeed& speed, const std::vector<double>& contact_s) {
  const auto& scene = problem.scene;
  const double slowness = speed.slowness;
  const double of_coupler_s = slowness * coupler_s / scene.output.history_every;
  const Predictor predictor(problem, slowness, rewrites(problem, end_s, contact_s));
  PredictedCost cost;
  cost.windows = problem.clock.window_at(end_s);

  double together_s = 0.0, longest_s = 0.0, shared = 0.0;
  for (std::size_t p = 0; p < scene.participants.size(); ++p) {
    const auto& spec = scene.participants[p];
    const double interface = plan.participants[p].interface_nodes * scene.components();
    auto shares = shares_of(problem, spec);
    for (const Share& share : shares) cost.field_bytes += field_bytes(share);
    cost.field_files += static_cast<double>(shares.size());
    double window_s = 0.0;
    if (spec.role == Role::implicit_solver) {
      const FactorSize factor = factor_of(shares);
      cost.factor_bytes += bytes_of_entry * factor.entries;
      cost.setup_s = std::max(cost.setup_s, slowness * setup_s(shares, factor));
      window_s = predictor.implicit_window_s(shares, factor.entries, interface, cost.windows);
    } else if (spec.reduced) {
      double modes_s = 0.0;
      for (const Share& share : shares) {
        const FactorSize factor = factor_of({share});
        const auto of_body = reduced_cost(problem, *share.body, share.owned, factor, setup_s({}, factor),
                                          solve_of_entries_s(factor.entries), cost.windows);
        modes_s += of_body.setup_s;
        cost.factor_bytes += of_body.bytes;
        window_s += slowness * of_body.window_s;
      }
      cost.setup_s = std::max(cost.setup_s, slowness * (setup_s(shares, {}) + modes_s));
    } else {
      add_planned_steps(plan, shares);
      cost.setup_s = std::max(cost.setup_s, slowness * setup_s(shares, {}) + unit_forces_s(problem, shares));
      const double substeps = spec.substeps;
      window_s =
          predictor.explicit_window_s(shares, substeps * cost.windows, substeps, !scene.coupling.protocol.coupled());
    }
    cost.participants.push_back({spec.name, window_s});
    together_s += window_s;
    longest_s = std::max(longest_s, window_s);
    shared += interface;
  }
  cost.window_s = of_coupler_s + together_s;
  if (scene.coupling.protocol.coupled()) {
    const double at_once = speed.processors > 1 ? overlap * (together_s - longest_s) : 0.0;
    cost.window_s += slowness * (exchange_s + exchange_value_s * shared) - at_once;
  }

  const auto layout = scene.coupling.protocol.layout;
  auto whole = whole_bodies(problem);
  cost.all_implicit_s = layout == scene::Layout::all_implicit
                            ? cost.stepping_s()
                            : cost.windows * (of_coupler_s + predictor.implicit_window_s(
                                                                 whole, factor_of(whole).entries, 0.0, cost.windows));
  if (layout == scene::Layout::all_explicit && !scene.coupling.protocol.local_steps) {
    cost.all_explicit_step_s = problem.clock.largest_size_s();
    cost.all_explicit_s = cost.stepping_s();
  } else {
    cost.all_explicit_step_s = all_explicit_step_s(problem, plan, whole);
    const double steps = std::ceil(end_s / cost.all_explicit_step_s);
    cost.all_explicit_s = steps * (of_coupler_s + predictor.explicit_window_s(whole, steps, 1.0, true));
  }
  if (scene.coupling.protocol.local_steps) {
    cost.local_explicit_s = cost.stepping_s();
  } else if (scene::takes_local_steps(problem)) {
    add_local_steps(problem, whole);
    cost.local_explicit_s = cost.windows * (of_coupler_s + predictor.explicit_window_s(whole, cost.windows, 1.0, true));
  }
  return cost;
}

}  // namespace ricochet::cost

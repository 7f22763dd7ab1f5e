#include "common/cost/predicted_cost.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "common/base/parallel.hpp"
#include "common/cost/node_graph.hpp"
#include "common/fem/stiffness_product.hpp"
#include "common/problem/critical_step.hpp"
#include "common/scene/protocols.hpp"

namespace ricochet::cost {
namespace {

using fem::at;

/// Of the machine on which docs/speed.md was measured [s].
constexpr double reference_product_s = 6.0e-6;  // K u of the patch below
constexpr double step_s = 2.5e-6;               // of an explicit participant, apart from its unknowns
constexpr double step_of_unknown_s = 1.3e-9;    // of an explicit step, apart from K u
constexpr double solve_of_unknown_s = 3.8e-9;   // of an implicit window, apart from the factor
constexpr double entry_in_cache_s = 0.68e-9;    // of the factor, in a solve
constexpr double entry_in_memory_s = 1.7e-9;
constexpr double cache_entries = 2.5e6, memory_entries = 6.5e6;  // of factors that are in the cache, and out of it
constexpr double explicit_row_of_unknown_s = 1.2e-9, implicit_row_of_unknown_s = 2.2e-9;  // of a row of history.csv
constexpr double window_of_coupler_s = 3.0e-6;                                            // with a row of history.csv
constexpr double exchange_s = 12.0e-6, exchange_of_value_s = 10e-9;                       // of a hybrid, both ways
constexpr double field_of_element_s = 0.85e-6;                                            // of a VTU file
constexpr double root_entry_s = 0.35e-9;  // of the dense inverse of the root, in a solve
constexpr double overlap =
    0.5;  // share of the shorter of explicit and implicit window that is computed beside the longer
constexpr double bytes_of_entry = 17.0;  // of the factor: CHOLMOD's and ours are there at once

constexpr int sample_elements = 8000;

template <class Work>
double least_time_s(int repeats, const Work& work) {
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < repeats; ++i) {
    const auto start = std::chrono::steady_clock::now();
    work();
    least = std::min(least, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  return least;
}

/// K u of some elements of a mesh [s], and of how many rows.
struct Product {
  double time_s = 0.0, rows = 0.0;
};
Product time_product(const fem::Part& part) {
  constexpr int repeats = 5;
  const fem::StiffnessProduct product(part.stiffness, fem::components(part.mesh.model));
  Eigen::VectorXd u = Eigen::VectorXd::LinSpaced(part.dofs(), 0.0, 1.0), force = Eigen::VectorXd::Zero(part.dofs());
  return {least_time_s(repeats, [&] { product.multiply(u, force); }), static_cast<double>(part.dofs())};
}

/// The elements of a body that a participant owns, or all of them.
struct Share {
  const scene::BodyProblem* body;
  std::vector<bool> owned;  ///< per element
  NodeGraph graph;

  [[nodiscard]] double elements() const { return static_cast<double>(std::count(owned.begin(), owned.end(), true)); }
  [[nodiscard]] double unknowns() const {
    return static_cast<double>(graph.nodes()) * fem::components(body->section.model);
  }
};

Share share_of(const scene::BodyProblem& body, std::vector<bool> owned) {
  NodeGraph graph = node_graph(body.mesh, owned);
  return {&body, std::move(owned), std::move(graph)};
}

/// K u of one step of the whole share [s], from as many of its elements as a sample takes.
double product_s(const Share& share) {
  std::vector<int> sample;
  for (std::size_t e = 0; e < share.owned.size() && std::ssize(sample) < sample_elements; ++e)
    if (share.owned[e]) sample.push_back(static_cast<int>(e));
  if (sample.empty()) return 0.0;
  const auto& body = *share.body;
  const Product product = time_product(fem::extract_part(body.mesh, body.name, body.section, body.material, sample));
  return product.time_s * share.unknowns() / product.rows;
}

double solve_of_entries_s(double entries) {
  const double in_memory = std::clamp((entries - cache_entries) / (memory_entries - cache_entries), 0.0, 1.0);
  return entries * ((1.0 - in_memory) * entry_in_cache_s + in_memory * entry_in_memory_s);
}

/// What moves a body from the start on: contact, interface, loads, prescribed motion.
std::vector<int> driven_nodes(const scene::Problem& problem, int index) {
  const scene::BodyProblem& body = problem.bodies[at(index)];
  const scene::Body& spec = problem.scene.bodies[at(index)];
  std::vector<int> nodes = scene::contact_nodes(problem.contacts, index);
  const auto add_surface = [&](const std::string& surface) {
    const auto more = fem::surface_nodes(body.mesh, surface);
    nodes.insert(nodes.end(), more.begin(), more.end());
  };
  for (const auto& traction : spec.tractions) add_surface(traction.surface);
  for (const auto& prescribed : spec.prescribed) add_surface(prescribed.surface);
  for (const auto& support : spec.supports) add_surface(support.surface);
  for (int node = 0; node < static_cast<int>(body.implicit_node.size()); ++node)
    if (body.implicit_node[at(node)]) nodes.push_back(node);
  return nodes;
}

bool moves_everywhere(const scene::Body& spec) {
  const auto any = [](const std::vector<double>& values) {
    return std::any_of(values.begin(), values.end(), [](double x) { return x != 0.0; });
  };
  return any(spec.gravity_m_s2) || any(spec.initial_displacement_start_m) || any(spec.initial_displacement_end_m);
}

/// What the participants of a scene, or of a baseline on it, take.
class Predictor {
 public:
  Predictor(const scene::Problem& problem, double slowness) : problem_(problem), slowness_(slowness) {}

  /// `steps` of a run, of which a window has `steps_of_window` [s].
  [[nodiscard]] double explicit_window_s(const std::vector<Share>& shares, double steps, double steps_of_window) const {
    double of_step = slowness_ * step_s, of_window = 0.0;
    for (const Share& share : shares) {
      const int index = static_cast<int>(share.body - problem_.bodies.data());
      const double reached = moves_everywhere(problem_.scene.bodies[at(index)])
                                 ? 1.0
                                 : reached_share(share.graph, driven_nodes(problem_, index), steps);
      of_step += reached * product_s(share) + slowness_ * step_of_unknown_s * share.unknowns();
      of_window += output_s(share, explicit_row_of_unknown_s);
    }
    return steps_of_window * of_step + of_window;
  }

  /// `interface`: unknowns shared with others.
  [[nodiscard]] double implicit_window_s(const std::vector<Share>& shares, double entries, double interface) const {
    double of_window = slowness_ * step_s, roots = interface;
    for (const Share& share : shares)
      of_window += slowness_ * solve_of_unknown_s * share.unknowns() + output_s(share, implicit_row_of_unknown_s);
    for (int body = 0; body < static_cast<int>(problem_.bodies.size()); ++body)
      roots += static_cast<double>(scene::contact_nodes(problem_.contacts, body).size()) * problem_.scene.components();
    const double solve_s = solve_of_entries_s(entries);
    // A root whose dense inverse costs more is none (NewmarkWindow).
    return of_window + slowness_ * (solve_s + std::min(solve_s, root_entry_s * roots * roots));
  }

 private:
  /// Rows of history and files of fields, spread over the windows [s].
  [[nodiscard]] double output_s(const Share& share, double row_of_unknown_s) const {
    const auto& output = problem_.scene.output;
    double time_s = row_of_unknown_s * share.unknowns() / output.history_every;
    if (output.fields_every > 0) time_s += field_of_element_s * share.elements() / output.fields_every;
    return slowness_ * time_s;
  }

  const scene::Problem& problem_;
  double slowness_;
};

double entries_of(const std::vector<Share>& shares) {
  double entries = 0.0;
  for (const Share& share : shares) entries += factor_entries(share.graph, fem::components(share.body->section.model));
  return entries;
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

}  // namespace

MachineSpeed measure_speed() {
  std::vector<double> lines;
  for (int i = 0; i <= 40; ++i) lines.push_back(1e-3 * i);
  const fem::Mesh mesh = fem::quadrilateral_mesh(fem::Model::plane_strain, lines, lines);
  std::vector<int> elements;
  for (int e = 0; e < static_cast<int>(mesh.elements.size()); ++e) elements.push_back(e);
  fem::Section section;
  section.model = fem::Model::plane_strain;
  const fem::Part patch = fem::extract_part(mesh, "patch", section, {2e11, 0.3, 7800.0}, elements);
  return {time_product(patch).time_s / reference_product_s, usable_processors()};
}

PredictedCost predict_cost(const scene::Problem& problem, const scene::Plan& plan, double end_s,
                           const MachineSpeed& speed) {
  const auto& scene = problem.scene;
  const double slowness = speed.slowness;
  const double coupler_s = slowness * window_of_coupler_s / scene.output.history_every;
  const Predictor predictor(problem, slowness);
  PredictedCost cost;
  cost.windows = std::ceil(end_s / problem.window_size_s - 1e-9);

  double together_s = 0.0, longest_s = 0.0, shared = 0.0;
  for (std::size_t p = 0; p < scene.participants.size(); ++p) {
    const auto& spec = scene.participants[p];
    const double interface = plan.participants[p].interface_nodes * scene.components();
    const auto shares = shares_of(problem, spec);
    double window_s = 0.0;
    if (spec.role == Role::implicit_solver) {
      const double entries = entries_of(shares);
      cost.factor_bytes += bytes_of_entry * entries;
      window_s = predictor.implicit_window_s(shares, entries, interface);
    } else {
      const double substeps = scene.coupling.substeps;
      window_s = predictor.explicit_window_s(shares, substeps * cost.windows, substeps);
    }
    cost.participants.push_back({spec.name, window_s});
    together_s += window_s;
    longest_s = std::max(longest_s, window_s);
    shared += interface;
  }
  cost.window_s = coupler_s + together_s;
  if (scene.coupling.protocol.coupled()) {
    const double at_once = speed.processors > 1 ? overlap * (together_s - longest_s) : 0.0;
    cost.window_s += slowness * (exchange_s + exchange_of_value_s * shared) - at_once;
  }

  const auto whole = whole_bodies(problem);
  cost.all_implicit_s = cost.windows * (coupler_s + predictor.implicit_window_s(whole, entries_of(whole), 0.0));
  double critical_s = std::numeric_limits<double>::infinity();
  for (const auto& share : whole)
    critical_s =
        std::min(critical_s, scene::critical_time_step(*share.body, share.owned, false, problem.window_size_s));
  cost.all_explicit_step_s =
      std::min(problem.window_size_s / scene.coupling.substeps, scene.time.safety_factor * critical_s);
  const double steps = std::ceil(end_s / cost.all_explicit_step_s);
  cost.all_explicit_s = steps * (coupler_s + predictor.explicit_window_s(whole, steps, 1.0));
  return cost;
}

}  // namespace ricochet::cost

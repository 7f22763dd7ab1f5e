#include "common/problem/critical_step.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/fem/element_copies.hpp"
#include "common/fem/hanging_nodes.hpp"
#include "common/problem/build.hpp"
#include "common/problem/mass_scaling.hpp"
#include "common/scene/protocols.hpp"

namespace ricochet::scene {
namespace {

constexpr double frequency_tolerance = 1e-9, rough_tolerance = 1e-3;
constexpr int products_of_a_bound = 10;

double step_of(double frequency_squared) {
  return frequency_squared > 0.0 ? 2.0 / std::sqrt(frequency_squared) : std::numeric_limits<double>::infinity();
}

fem::Part part_of(const BodyProblem& body, const std::vector<bool>& of_element) {
  std::vector<int> elements;
  for (std::size_t e = 0; e < of_element.size(); ++e)
    if (of_element[e]) elements.push_back(static_cast<int>(e));
  return body_part(body, elements);
}

/// Mass and supports of a part's nodes.
struct Inertia {
  Eigen::VectorXd mass;
  std::vector<bool> fixed_dof;
};

Inertia inertia_of(const BodyProblem& body, const fem::Part& part, bool own_mass) {
  const int components = fem::components(body.section.model);
  const bool all_own = own_mass || part.body_element.size() == body.mesh.elements.size();
  const Eigen::VectorXd whole_mass = all_own ? Eigen::VectorXd() : body_lumped_mass(body);
  Inertia inertia{part.lumped_mass, {}};
  for (int i = 0; i < part.nodes(); ++i) {
    const int node = part.body_node[at(i)];
    if (!all_own) inertia.mass[i] = whole_mass[node];
    for (int c = 0; c < components; ++c) inertia.fixed_dof.push_back(body.fixed_dof[at(node * components + c)]);
  }
  return inertia;
}

/// Known to `rough_tolerance`, it says on which side of the critical step this one is.
bool is_apart(double critical_s, double step_s) { return std::abs(critical_s / step_s - 1.0) > 2.0 * rough_tolerance; }

/// Stiffness, mass and supports of all bodies side by side, and the first node of each.
struct Whole {
  std::vector<Eigen::Triplet<double>> stiffness;
  std::vector<double> mass;
  std::vector<bool> fixed_dof;
  std::vector<int> first_node;
};

Whole assemble(const Problem& problem) {
  Whole whole;
  const int components = problem.scene.components();
  for (const BodyProblem& body : problem.bodies) {
    const fem::Part part = part_of(body, std::vector<bool>(body.mesh.elements.size(), true));
    const int first = static_cast<int>(whole.mass.size());
    whole.first_node.push_back(first);
    for (int row = 0; row < part.stiffness.outerSize(); ++row)
      for (fem::SparseMatrix::InnerIterator entry(part.stiffness, row); entry; ++entry)
        whole.stiffness.emplace_back(first * components + static_cast<int>(entry.row()),
                                     first * components + static_cast<int>(entry.col()), entry.value());
    whole.mass.insert(whole.mass.end(), part.lumped_mass.begin(), part.lumped_mass.end());
    whole.fixed_dof.insert(whole.fixed_dof.end(), body.fixed_dof.begin(), body.fixed_dof.end());
  }
  return whole;
}

/// alpha_n n n^T between the nodes of each pair.
void add_springs(const Problem& problem, const ContactGeometry& contact, Whole& whole) {
  const int components = problem.scene.components();
  for (const ContactPair& pair : contact.pairs) {
    std::vector<std::pair<int, double>> ends;
    for (const auto& [node, weight] : own_nodes(pair))
      ends.emplace_back(whole.first_node[at(contact.body_a)] + node, -weight);
    for (const auto& [node, weight] : pair.b) ends.emplace_back(whole.first_node[at(contact.body_b)] + node, weight);
    const double stiffness = problem.scene.contact_law().penalty_pa_m * pair.area_m2;
    for (const auto& [p, sign_p] : ends)
      for (const auto& [q, sign_q] : ends)
        for (int i = 0; i < components; ++i)
          for (int j = 0; j < components; ++j)
            whole.stiffness.emplace_back(p * components + i, q * components + j,
                                         stiffness * sign_p * sign_q * pair.normal[i] * pair.normal[j]);
  }
}

}  // namespace

/// In the order in which fem::extract_part sums, so that it gives the same bits.
Eigen::VectorXd body_lumped_mass(const BodyProblem& body) {
  Eigen::VectorXd mass = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(body.mesh.position.size()));
  for (int e = 0; e < static_cast<int>(body.mesh.elements.size()); ++e) {
    const Eigen::VectorXd own =
        fem::element_lumped_mass(body.section, fem::material_of(body, e), fem::element_geometry(body.mesh, e));
    for (Eigen::Index i = 0; i < own.size(); ++i)
      mass[body.mesh.elements[at(e)][static_cast<std::size_t>(i)]] += own[i];
  }
  add_scaled_mass(body, mass);
  fem::pass_on_masses(body.mesh.hanging, mass);
  return mass;
}

double critical_time_step(const BodyProblem& body, const std::vector<bool>& of_element, bool own_mass, double step_s) {
  return critical_time_step(body, part_of(body, of_element), own_mass, step_s);
}

double critical_time_step(const BodyProblem& body, const fem::Part& part, bool own_mass, double step_s) {
  if (part.body_element.empty()) return std::numeric_limits<double>::infinity();
  const Inertia inertia = inertia_of(body, part, own_mass);
  const auto critical_to = [&](double rough) {
    return step_of(fem::max_frequency_squared(part.stiffness, inertia.mass, fem::components(body.section.model),
                                              inertia.fixed_dof, frequency_tolerance, rough));
  };
  const double critical_s = critical_to(rough_tolerance);
  return is_apart(critical_s, step_s) ? critical_s : critical_to(frequency_tolerance);
}

bool is_stable_step(const BodyProblem& body, const std::vector<bool>& of_element, double step_s) {
  const fem::Part part = part_of(body, of_element);
  const Inertia inertia = inertia_of(body, part, false);
  const auto critical_to = [&](double tolerance) {
    return step_of(fem::max_frequency_squared(part.stiffness, inertia.mass, fem::components(body.section.model),
                                              inertia.fixed_dof, tolerance));
  };
  const double critical_s = critical_to(rough_tolerance);
  return step_s <= (is_apart(critical_s, step_s) ? critical_s : critical_to(frequency_tolerance));
}

double largest_critical_time_step(const BodyProblem& body, const fem::Part& part,
                                  const fem::StiffnessProduct& stiffness, bool own_mass) {
  if (part.body_element.empty()) return std::numeric_limits<double>::infinity();
  const Inertia inertia = inertia_of(body, part, own_mass);
  return step_of(fem::frequency_squared_at_least(stiffness, inertia.mass, fem::components(body.section.model),
                                                 inertia.fixed_dof, products_of_a_bound));
}

std::vector<bool> explicit_elements(const Problem& problem, const BodyProblem& body) {
  if (problem.scene.coupling.protocol.layout == Layout::all_implicit)
    return std::vector<bool>(body.mesh.elements.size(), true);
  if (problem.scene.is_reduced(body.name)) return std::vector<bool>(body.mesh.elements.size(), false);
  std::vector<bool> is_explicit = body.implicit_element;
  is_explicit.flip();
  return is_explicit;
}

std::vector<bool> limiting_elements(const Problem& problem, const BodyProblem& body,
                                    const ParticipantSpec& participant) {
  if (participant.reduced) return std::vector<bool>(body.mesh.elements.size(), false);
  if (problem.scene.coupling.protocol.dual) return owned_elements(problem.scene, body, participant);
  std::vector<bool> limiting = body.implicit_element;
  if (participant.role == Role::explicit_solver) limiting.flip();
  return limiting;
}

double critical_time_step(const Problem& problem, const ParticipantSpec& participant,
                          const std::vector<AssembledPart>& parts, double step_s) {
  const bool dual = problem.scene.coupling.protocol.dual;
  double smallest = std::numeric_limits<double>::infinity();
  for (const AssembledPart& assembled : parts) {
    const BodyProblem& body = problem.bodies[at(assembled.body)];
    if (participant.role == Role::explicit_solver && !body.small_steps.empty()) continue;
    const std::vector<bool> limiting = limiting_elements(problem, body, participant);
    if (!problem.critical_time_steps_s.empty() && limiting == explicit_elements(problem, body)) {
      smallest = std::min(smallest, problem.critical_time_steps_s[at(assembled.body)]);
      continue;
    }
    const bool same = std::count(limiting.begin(), limiting.end(), true) == std::ssize(assembled.part->body_element);
    smallest = std::min(smallest, same ? critical_time_step(body, *assembled.part, dual, step_s)
                                       : critical_time_step(body, limiting, dual, step_s));
  }
  return smallest;
}

double element_bound_time_step(const BodyProblem& body, const std::vector<bool>& of_element) {
  if (body.mesh.rigid_nodes > 0) return critical_time_step(body, of_element, false, 0.0);
  if (body.density_factor.empty()) return fem::element_critical_time_step(part_of(body, of_element));
  double smallest = std::numeric_limits<double>::infinity();
  for (int e = 0; e < static_cast<int>(of_element.size()); ++e) {
    if (!of_element[at(e)]) continue;
    const double frequency_squared = fem::element_max_frequency_squared(body.section, fem::material_of(body, e),
                                                                        fem::element_geometry(body.mesh, e));
    smallest = std::min(smallest, step_of(frequency_squared / body.density_factor[at(e)]));
  }
  return smallest;
}

double element_critical_step(const BodyProblem& body, int element) {
  return step_of(fem::element_max_frequency_squared(body.section, fem::material_of(body, element),
                                                    fem::element_geometry(body.mesh, element)));
}

std::vector<double> element_critical_steps(const Problem& problem) {
  std::vector<double> steps;
  for (int index = 0; index < static_cast<int>(problem.bodies.size()); ++index) {
    const BodyProblem& body = problem.bodies[at(index)];
    if (body.mesh.rigid_nodes > 0) continue;
    const std::vector<bool> at_contact = elements_at(body.mesh, contact_nodes(problem.contacts, index));
    fem::ElementCopies<double> copies(body.section.model);
    for (int e = 0; e < static_cast<int>(body.mesh.elements.size()); ++e) {
      if (at_contact[at(e)]) continue;
      const auto make = [&](const fem::ElementGeometry&) { return element_critical_step(body, e); };
      steps.push_back(copies.of(fem::element_geometry(body.mesh, e), make, fem::material_index(body.mesh, e)));
    }
  }
  return steps;
}

double penalty_critical_time_step(const Problem& problem) {
  Whole whole = assemble(problem);
  for (const ContactGeometry& contact : problem.contacts) add_springs(problem, contact, whole);
  const int components = problem.scene.components();
  const auto nodes = static_cast<Eigen::Index>(whole.mass.size());
  fem::SparseMatrix stiffness(nodes * components, nodes * components);
  stiffness.setFromTriplets(whole.stiffness.begin(), whole.stiffness.end());
  const Eigen::VectorXd mass = Eigen::Map<const Eigen::VectorXd>(whole.mass.data(), nodes);
  return step_of(fem::max_frequency_squared(stiffness, mass, components, whole.fixed_dof, frequency_tolerance));
}

}  // namespace ricochet::scene

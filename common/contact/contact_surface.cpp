#include "common/contact/contact_surface.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <set>
#include <utility>

#include "common/base/error.hpp"

namespace ricochet::solver {
namespace {

/// Pairs with less of the largest pressure are not closed: where nothing presses forces are rounding.
constexpr double pressing_share = 1e-3;

/// The largest entry of the normal's row on the first surface.
const RowEntry* largest_of_first(const Pair& pair) {
  const RowEntry* most = nullptr;
  for (const auto& e : pair.normal.entries) {
    if (e.side == Side::a && (most == nullptr || std::abs(e.coefficient) > std::abs(most->coefficient))) most = &e;
  }
  return most;
}

/// Coordinates, as bits, along the surface in which a support holds the first surface's node of a solid: there is a
/// plane of symmetry, and as much of the contact beyond it.
unsigned planes_at(const Pair& pair, const std::vector<BodyState>& states) {
  const RowEntry* most = largest_of_first(pair);
  const auto& free = states[static_cast<std::size_t>(most->part)].free;
  const int first = most->dof - most->dof % 3;
  unsigned planes = 0;
  for (int c = 0; c < 3; ++c) {
    if (first + c != most->dof && !free[static_cast<std::size_t>(first + c)]) planes |= 1U << c;
  }
  return planes;
}

}  // namespace

ContactSurface::ContactSurface(const scene::Problem& problem, const std::vector<BodyState>& states)
    : components(problem.scene.components()),
      directions(problem.scene.friction() ? components : 1),
      round(components == 3 || problem.scene.model == scene::Model::axisymmetric),
      pairs(contact_rows(problem, states)),
      stress(problem, states) {
  for (const auto& contact : problem.scene.contacts) contact_keys.push_back(contact.key());
  std::set<std::pair<int, int>> paired;
  for (const auto& pair : pairs) {
    for (const auto& e : pair.normal.entries) paired.emplace(e.part, e.dof / components);
  }
  for (std::size_t p = 0; p < states.size(); ++p) {
    const auto& own = states[p].part.body_node;
    for (const auto& contact : problem.contacts) {
      if (!contact.sliding) continue;
      for (const int node : scene::contact_nodes(contact, states[p].body)) {
        const auto found = std::lower_bound(own.begin(), own.end(), node);
        const int local = static_cast<int>(found - own.begin());
        if (found != own.end() && *found == node && paired.emplace(static_cast<int>(p), local).second)
          idle.push_back({static_cast<int>(p), local});
      }
    }
  }
}

void ContactSurface::require_one_a_pair(std::size_t count, std::size_t of_a_pair) const {
  if (count == of_a_pair * pairs.size()) return;
  throw ConfigError("the state is of another scene: its contact forces are those of other contact pairs");
}

namespace {

fem::ContactFields no_fields(const fem::Part& part) {
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  const auto nodes = part.nodes();
  return {Eigen::VectorXd::Zero(3 * nodes), Eigen::VectorXd::Constant(nodes, none),
          Eigen::VectorXd::Constant(nodes, none), std::vector<std::int32_t>(static_cast<std::size_t>(nodes), -1)};
}

/// Part and local number of the node that has the largest share in the pair's row on the first surface.
std::pair<std::size_t, int> carrier(const Pair& pair, int components) {
  const RowEntry* own = largest_of_first(pair);
  return {static_cast<std::size_t>(own->part), own->dof / components};
}

}  // namespace

std::vector<fem::ContactFields> ContactSurface::nodal_fields(const std::vector<BodyState>& states,
                                                             const std::vector<PairForce>& forces) const {
  std::vector<fem::ContactFields> fields;
  for (const auto& state : states) fields.push_back(no_fields(state.part));
  std::map<std::pair<std::size_t, int>, double> area_m2;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const auto& force = forces[i];
    const auto push = [&](const ContactRow& row, double size) {
      for (const auto& e : row.entries)
        fields[static_cast<std::size_t>(e.part)].force_n[e.dof / components * 3 + e.dof % components] +=
            e.coefficient * size;
    };
    push(pairs[i].normal, force.normal);
    push(pairs[i].tangent, force.tangential[0]);
    push(pairs[i].binormal, force.tangential[1]);
    const auto [part, node] = carrier(pairs[i], components);
    auto& of = fields[part];
    auto& state = of.state[static_cast<std::size_t>(node)];
    double &area = area_m2[{part, node}], &pressure = of.pressure_pa[node], &gap = of.gap_m[node];
    const double load_n = (state < 0 ? 0.0 : pressure * area) + force.normal,
                 gap_m = pairs[i].gap(displacement_of(states));
    area += pairs[i].area_m2;
    pressure = load_n / area;
    gap = state < 0 ? gap_m : std::min(gap, gap_m);
    state = std::max(state, static_cast<std::int32_t>(force.state));
  }
  return fields;
}

std::vector<int> nodes_in_whole(const fem::Part& own, const fem::Part& whole) {
  std::vector<int> nodes;
  for (const int node : own.body_node) {  // ascending in both
    const auto at = std::lower_bound(whole.body_node.begin(), whole.body_node.end(), node);
    nodes.push_back(static_cast<int>(at - whole.body_node.begin()));
  }
  return nodes;
}

std::vector<fem::ContactFields> of_whole_parts(const std::vector<fem::ContactFields>& fields,
                                               const std::vector<BodyState>& parts,
                                               const std::vector<BodyState>& whole) {
  std::vector<fem::ContactFields> result;
  for (std::size_t p = 0; p < whole.size(); ++p) {
    auto& of = result.emplace_back(no_fields(whole[p].part));
    const auto node = nodes_in_whole(parts[p].part, whole[p].part);
    for (std::size_t i = 0; i < node.size(); ++i) {
      const Eigen::Index to = node[i], from = static_cast<Eigen::Index>(i);
      of.force_n.segment<3>(3 * to) = fields[p].force_n.segment<3>(3 * from);
      of.pressure_pa[to] = fields[p].pressure_pa[from];
      of.gap_m[to] = fields[p].gap_m[from];
      of.state[static_cast<std::size_t>(to)] = fields[p].state[i];
    }
  }
  return result;
}

double ContactSurface::gap_min(const std::vector<BodyState>& states) const {
  double smallest = std::numeric_limits<double>::max();
  for (const auto& pair : pairs) smallest = std::min(smallest, pair.gap(displacement_of(states)));
  return smallest;
}

double ContactSurface::gap_rate_min(const std::vector<BodyState>& states) const {
  double smallest = std::numeric_limits<double>::max();
  for (const auto& pair : pairs) smallest = std::min(smallest, pair.normal.times(velocity_of(states)));
  return smallest;
}

ContactRecord ContactSurface::empty_record() const {
  ContactRecord record;
  if (contact_keys.size() > 1) record.contacts.resize(contact_keys.size());
  return record;
}

ContactImpulses ContactSurface::no_impulses() const { return ContactImpulses(contact_keys.size()); }

void ContactSurface::report(const std::vector<BodyState>& states, const std::vector<PairForce>& forces,
                            ContactAccount& account, ContactRecord& record) const {
  static_cast<ContactTotals&>(record) = totals(states, forces, account.impulses, std::nullopt);
  for (std::size_t i = 0; i < record.contacts.size(); ++i)
    record.contacts[i] = totals(states, forces, account.impulses, i);
  for (const auto& contact : record.contacts)
    record.contact_radius_m = std::max(record.contact_radius_m, contact.contact_radius_m);
  Eigen::VectorXd in_frame;
  record.principal_stress_mean_pa = stress.mean(
      [&](int part) -> const Eigen::VectorXd& { return states[static_cast<std::size_t>(part)].straining(in_frame); });
  record.contact_iterations = std::exchange(account.iterations, 0);
  record.contact_residual = std::exchange(account.largest_residual, 0.0);
  record.contact_unconverged = account.unconverged;
  record.energy_contact_j = account.work_normal_j;
  record.energy_friction_j = account.dissipated_friction_j;
}

void ContactSurface::append_forces(const std::vector<PairForce>& forces, std::vector<double>& row) const {
  const std::size_t first = row.size();
  row.resize(first + contact_keys.size(), 0.0);
  for (std::size_t i = 0; i < pairs.size(); ++i)
    row[first + pairs[i].contact] += pairs[i].to_contact(forces[i].normal, forces[i].tangential)[0];
}

ContactTotals ContactSurface::totals(const std::vector<BodyState>& states, const std::vector<PairForce>& forces,
                                     const ContactImpulses& impulses, std::optional<std::size_t> contact) const {
  ContactTotals totals;
  totals.gap_min_m = std::numeric_limits<double>::max();
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (contact && pairs[i].contact != *contact) continue;
    const Eigen::Vector3d normal = pairs[i].to_contact(forces[i].normal, Eigen::Vector2d::Zero()),
                          friction = pairs[i].to_contact(0.0, forces[i].tangential);
    totals.contact_force_n += normal[0] + friction[0];
    totals.friction_force_n += friction[1];
    totals.friction_force_b_n += friction[2];
    totals.normal_force_t_n += normal[1];
    totals.normal_force_b_n += normal[2];
    totals.pairs_open += forces[i].state == ContactState::open;
    totals.pairs_stick += forces[i].state == ContactState::stick;
    totals.pairs_slip += forces[i].state == ContactState::slip;
    totals.gap_min_m = std::min(totals.gap_min_m, pairs[i].gap(displacement_of(states)));
  }
  measure_pressure(states, forces, contact, totals);
  for (std::size_t i = 0; i < impulses.size(); ++i) {
    if (contact && i != *contact) continue;
    const auto& [normal, friction] = impulses[i];
    totals.contact_impulse_n_s += normal[0] + friction[0];
    totals.friction_impulse_n_s += friction[1];
    totals.friction_impulse_b_n_s += friction[2];
    totals.normal_impulse_t_n_s += normal[1];
    totals.normal_impulse_b_n_s += normal[2];
  }
  return totals;
}

/// The radius is that of one contact: of pi a^2 = sum of the areas of the closed pairs, with what lies beyond planes of
/// symmetry. The largest of several is told.
void ContactSurface::measure_pressure(const std::vector<BodyState>& states, const std::vector<PairForce>& forces,
                                      std::optional<std::size_t> contact, ContactTotals& totals) const {
  const auto counts = [&](std::size_t i) { return !contact || pairs[i].contact == *contact; };
  double& largest = totals.contact_pressure_max_pa;
  for (std::size_t i = 0; i < pairs.size(); ++i)
    if (counts(i)) largest = std::max(largest, forces[i].normal / pairs[i].area_m2);
  double area = 0.0, force = 0.0;
  unsigned planes = 0;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (!counts(i) || !(std::abs(forces[i].normal) > pressing_share * largest * pairs[i].area_m2)) continue;
    area += pairs[i].area_m2;
    force += forces[i].normal;
    if (components == 3) planes |= planes_at(pairs[i], states);
  }
  if (area > 0.0) totals.contact_pressure_mean_pa = force / area;
  if (!round || (!contact && contact_keys.size() > 1)) return;
  const double whole = area * static_cast<double>(1U << static_cast<unsigned>(std::popcount(planes)));
  totals.contact_radius_m = std::sqrt(whole / std::numbers::pi);
}

participant::ContactStatus contact_status(const ContactSurface& surface, const std::vector<BodyState>& states,
                                          int pairs_closed, std::int64_t window, const participant::Setup& setup,
                                          SeparationWatch& separation) {
  participant::ContactStatus status;
  status.pairs_closed = pairs_closed;
  status.gap_min_m = surface.gap_min(states);
  status.gap_rate_min_m_s = surface.gap_rate_min(states);
  separation.update(window, pairs_closed, status.gap_min_m);
  status.separated = separation.separated();
  const std::int64_t since = separation.separation_window();
  status.separation_time_s = since < 0 ? -1.0 : setup.clock.time_s(since);
  const double time_s = setup.clock.time_s(window);
  status.finished = setup.until_separated_plus_s >= 0.0 && status.separated &&
                    time_s >= status.separation_time_s + setup.until_separated_plus_s;
  return status;
}

}  // namespace ricochet::solver

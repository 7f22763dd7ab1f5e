#include "common/body/body_state.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "common/base/error.hpp"
#include "common/body/blocks.hpp"
#include "common/body/outer_sums.hpp"
#include "common/fem/hanging_nodes.hpp"

namespace ricochet::solver {

void BodyState::set_mass(const Eigen::VectorXd& node_mass) {
  const int components = fem::components(part.mesh.model);
  mass.setZero(part.dofs());
  inverse_mass.setZero(part.dofs());
  totals.mass_kg = 0.0;
  for (int dof = 0; dof < part.dofs(); ++dof) {
    if (!integrated[static_cast<std::size_t>(dof)]) continue;
    mass[dof] = node_mass[dof / components];
    inverse_mass[dof] = 1.0 / mass[dof];
    if (dof % components == 0) totals.mass_kg += mass[dof];
  }
  free = integrated;
  for (const auto& c : constrained) {
    inverse_mass[c.dof] = 0.0;
    free[static_cast<std::size_t>(c.dof)] = false;
  }
}

void Given::add(double dt, double force, double moved, int component, const Eigen::Vector3d& place) {
  work_j += force * moved;
  impulse_n_s[component] += dt * force;
  angular_impulse_kg_m2_s += dt * force * place.cross(Eigen::Vector3d::Unit(component));
}

namespace {

void add_angular_impulse(const Eigen::Vector3d& kg_m2_s, BodyTotals& totals) {
  totals.angular_impulse_x_kg_m2_s += kg_m2_s[0];
  totals.angular_impulse_y_kg_m2_s += kg_m2_s[1];
  totals.angular_impulse_z_kg_m2_s += kg_m2_s[2];
}

}  // namespace

void BodyState::give_angular_impulse(const Eigen::Vector3d& kg_m2_s) { add_angular_impulse(kg_m2_s, totals); }

void BodyState::take(const Given& given) {
  totals.energy_external_j += given.work_j;
  totals.impulse_n_kg_m_s += normal.dot(given.impulse_n_s);
  totals.impulse_t_kg_m_s += tangent.dot(given.impulse_n_s);
  totals.impulse_b_kg_m_s += binormal.dot(given.impulse_n_s);
  add_angular_impulse(given.angular_impulse_kg_m2_s, totals);
}

std::vector<int> BodyState::booked() const {
  std::vector<int> dofs;
  for_each_booked([&](int dof) { dofs.push_back(dof); });
  return dofs;
}

void BodyState::constrain_velocity(double time_s, double dt, Eigen::VectorXd& velocity) const {
  for (const auto& c : constrained) velocity[c.dof] = c.velocity(time_s, dt);
}

void BodyState::constrain_acceleration(double time_s, double dt, Eigen::VectorXd& acceleration) const {
  for (const auto& c : constrained) acceleration[c.dof] = c.acceleration(time_s, dt);
}

void BodyState::constrain_displacement(double time_s, Eigen::VectorXd& displacement) const {
  for (const auto& c : constrained) displacement[c.dof] = c.at(time_s);
}

namespace {

/// Sums of all components side by side: a stride would take twice the time of K u's rows. `lanes` is a multiple of the
/// components, so that one keeps its lanes.
template <Eigen::Index lanes>
Eigen::Vector3d momentum_by_lanes(const Eigen::VectorXd& mass, const Eigen::VectorXd& v, int components) {
  const Eigen::Index size = mass.size(), whole = size - size % lanes;
  Eigen::Array<double, lanes, 1> sums = Eigen::Array<double, lanes, 1>::Zero();
  for (Eigen::Index i = 0; i < whole; i += lanes) sums += mass.segment<lanes>(i).array() * v.segment<lanes>(i).array();
  for (Eigen::Index i = whole; i < size; ++i) sums[i - whole] += mass[i] * v[i];
  Eigen::Vector3d momentum = Eigen::Vector3d::Zero();
  for (Eigen::Index lane = 0; lane < lanes; ++lane) momentum[lane % components] += sums[lane];
  return momentum;
}

}  // namespace

void BodyState::move_hanging() {
  for (Eigen::VectorXd* of : {&u, &v, &a}) fem::follow(part.mesh.hanging, fem::components(part.mesh.model), *of);
}

const Eigen::VectorXd& BodyState::straining(Eigen::VectorXd& in_frame) const {
  if (!frame) return u;
  frame->straining(u, frame_motion(), in_frame);
  return in_frame;
}

Eigen::Matrix3d BodyState::rotation() const {
  return frame ? frame_motion().rotation : Eigen::Matrix3d(Eigen::Matrix3d::Identity());
}

fem::RigidMotion BodyState::frame_motion() const {
  return others != nullptr ? frame->last_fit().motion : frame->fit(u).motion;
}

void BodyState::update_momentum() {
  const int components = fem::components(part.mesh.model);
  const Eigen::Vector3d momentum =
      components == 3 ? momentum_by_lanes<24>(mass, v, components) : momentum_by_lanes<8>(mass, v, components);
  totals.momentum_n_kg_m_s = normal.dot(momentum);
  totals.momentum_t_kg_m_s = tangent.dot(momentum);
  totals.momentum_b_kg_m_s = binormal.dot(momentum);
  set_angular_momentum(angular_momentum_of(0, part.nodes()));
}

void BodyState::set_angular_momentum(const Eigen::Vector3d& kg_m2_s) {
  totals.angular_momentum_x_kg_m2_s = kg_m2_s[0];
  totals.angular_momentum_y_kg_m2_s = kg_m2_s[1];
  totals.angular_momentum_z_kg_m2_s = kg_m2_s[2];
}

namespace {

template <int components>
Eigen::Vector3d angular_momentum(const BodyState& state, int first_node, int last_node) {
  const double *const place = state.place.data(), *const u = state.u.data(), *const mass = state.mass.data(),
                      *const v = state.v.data();
  return turning_part(outer_sums<components, components>(
      first_node, last_node, [=](int node, int c) { return place[node * components + c] + u[node * components + c]; },
      [=](int node, int c) { return mass[node * components + c] * v[node * components + c]; }));
}

}  // namespace

Eigen::Vector3d BodyState::angular_momentum_of(int first_node, int last_node) const {
  if (place.size() == 0) return Eigen::Vector3d::Zero();
  return fem::components(part.mesh.model) == 3 ? angular_momentum<3>(*this, first_node, last_node)
                                               : angular_momentum<2>(*this, first_node, last_node);
}

namespace {

void set_directions(const scene::Problem& problem, BodyState& state) {
  state.normal = scene::momentum_normal(problem);
  state.tangent = scene::tangent_of(state.normal);
  state.binormal = Eigen::Vector3d::Zero();
  if (problem.scene.components() == 3) state.binormal = state.normal.cross(state.tangent);
}

/// A body that turns about an axis of symmetry, or along a bar, has no angular momentum.
void set_places(BodyState& state) {
  if (state.part.mesh.model != fem::Model::plane_strain && state.part.mesh.model != fem::Model::solid) return;
  const int components = fem::components(state.part.mesh.model);
  state.place.resize(state.part.dofs());
  for (int dof = 0; dof < state.part.dofs(); ++dof)
    state.place[dof] = state.part.mesh.position[static_cast<std::size_t>(dof / components)][dof % components];
}

void set_motion(const scene::Problem& problem, BodyState& state) {
  const auto& whole = problem.bodies[static_cast<std::size_t>(state.body)];
  const auto& spec = problem.scene.bodies[static_cast<std::size_t>(state.body)];
  const int components = problem.scene.components();
  state.u.resize(state.part.dofs());
  state.v.resize(state.part.dofs());
  state.a.setZero(state.part.dofs());
  for (int dof = 0; dof < state.part.dofs(); ++dof) {
    const int node = state.part.body_node[static_cast<std::size_t>(dof / components)];
    const auto whole_dof = static_cast<std::size_t>(node * components + dof % components);
    state.u[dof] = whole.initial_displacement_m[static_cast<Eigen::Index>(whole_dof)];
    state.v[dof] = whole.initial_velocity_m_s[static_cast<Eigen::Index>(whole_dof)];
    if (!whole.fixed_dof[whole_dof] || !state.integrated[static_cast<std::size_t>(dof)]) continue;
    const int held = static_cast<int>(whole_dof);
    state.constrained.push_back(
        {dof, scene::is_still(whole, held) ? scene::GivenMotion{state.u[dof]} : given_motion(spec, whole, held)});
  }
}

/// Dashpots of the nodes that only this participant moves; the implicit one takes those of shared nodes, whole.
void set_dashpots(const scene::BodyProblem& whole, scene::Role role, BodyState& state) {
  const int components = fem::components(state.part.mesh.model);
  std::vector<bool> mine = state.integrated;
  for (const int dof : state.shared_dofs) mine[static_cast<std::size_t>(dof)] = role == scene::Role::implicit_solver;
  for (int dof = 0; dof < state.part.dofs(); ++dof) {
    const int node = state.part.body_node[static_cast<std::size_t>(dof / components)];
    const double coefficient = whole.damping_kg_s[node * components + dof % components];
    if (coefficient > 0.0 && mine[static_cast<std::size_t>(dof)])
      state.dashpots.push_back({dof, coefficient, state.v[dof]});
  }
}

}  // namespace

BodyState initial_state(const scene::Problem& problem, scene::ParticipantPart&& owned, scene::Role role,
                        bool shared_integrated) {
  const int components = problem.scene.components();
  const auto index = static_cast<std::size_t>(owned.body);
  scene::ExternalForce external(problem.scene.bodies[index], owned.part);
  BodyState state;
  state.body = owned.body;
  state.name = problem.bodies[index].name;
  state.part = std::move(owned.part);
  state.shared_nodes = std::move(owned.shared);
  state.external = std::move(external);
  state.stiffness = fem::StiffnessProduct(state.part.stiffness, components, owned.numbering);
  state.integrated.assign(static_cast<std::size_t>(state.part.dofs()), true);
  state.own = std::move(owned.own);
  for (std::size_t dof = 0; dof < state.integrated.size() && !state.own.empty(); ++dof)
    state.integrated[dof] = state.own[dof / static_cast<std::size_t>(components)];
  for (const auto& hanging : state.part.mesh.hanging) {
    for (int c = 0; c < components; ++c)
      if (hanging.hangs(c)) state.integrated[static_cast<std::size_t>(hanging.node * components + c)] = false;
  }
  for (const int node : state.shared_nodes) {
    for (int c = 0; c < components; ++c) {
      state.shared_dofs.push_back(node * components + c);
      state.integrated[static_cast<std::size_t>(node * components + c)] = shared_integrated;
    }
  }
  set_directions(problem, state);
  set_places(state);
  set_motion(problem, state);
  set_dashpots(problem.bodies[index], role, state);
  state.set_mass(state.part.lumped_mass);
  if (problem.scene.bodies[index].large_rotation && !state.part.mesh.elements.empty())
    state.frame = std::make_shared<PartFrame>(state.part);
  if (problem.scene.bodies[index].yields()) state.plastic = std::make_shared<PlasticState>(state.part);
  return state;
}

namespace {

/// Unless the scene says: the share of the processors that this process may use which falls to one process of the
/// participant. All participants compute at the same time, and the coupler waits meanwhile.
int threads_of(const scene::Scene& scene, const scene::ParticipantSpec& participant) {
  if (participant.threads) return *participant.threads;
  return std::max(1, usable_processors() / static_cast<int>(scene.participants.size()) / participant.ranks.value_or(1));
}

}  // namespace

void compute_with_threads(const scene::Scene& scene, const scene::ParticipantSpec& participant,
                          std::vector<BodyState>& states) {
  const auto parallel = std::make_shared<Parallel>(threads_of(scene, participant));
  for (auto& state : states) {
    state.parallel = parallel;
    state.stiffness.compute_with(parallel);
  }
}

std::vector<BodyState> initial_states(const scene::Problem& problem, const scene::ParticipantSpec& participant,
                                      bool shared_integrated) {
  std::vector<BodyState> states;
  for (auto& owned : scene::participant_parts(problem, participant))
    states.push_back(initial_state(problem, std::move(owned), participant.role, shared_integrated));
  compute_with_threads(problem.scene, participant, states);
  return states;
}

void take_interface_mass(const std::vector<double>& interface_mass_kg, std::vector<BodyState>& states) {
  std::size_t next = 0;
  for (auto& state : states) {
    Eigen::VectorXd node_mass = state.part.lumped_mass;
    for (const int node : state.shared_nodes) node_mass[node] = interface_mass_kg[next++];
    state.set_mass(node_mass);
  }
}

Moments block_moments(const BodyState& state, double ahead_s, int block) {
  const int components = fem::components(state.part.mesh.model), rows = block_nodes * components,
            last = std::min((block + 1) * rows, state.part.dofs());
  Moments moments;
  for (int c = 0; c < components; ++c) {
    for (int dof = block * rows + c; dof < last; dof += components) {
      moments.moved_kg_m[c] += state.mass[dof] * (state.u[dof] + ahead_s * state.v[dof]);
      moments.mass_kg[c] += state.mass[dof];
    }
  }
  return moments;
}

namespace {
template <int components>
Eigen::Matrix3d turn_of_nodes(const BodyState& state, const Eigen::Vector3d& centre_m, double ahead_s, int first,
                              int last) {
  const double *const u = state.u.data(), *const v = state.v.data(), *const mass = state.mass.data(),
                      *const centre = centre_m.data();
  const Eigen::Vector3d* const place = state.part.mesh.position.data();
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  sum.topLeftCorner<components, components>() = outer_sums<components, components>(
      first, last,
      [=](int node, int c) {
        return (place[node][c] - centre[c]) + (u[node * components + c] + ahead_s * v[node * components + c]);
      },
      [=](int node, int c) { return mass[node * components] * (place[node][c] - centre[c]); });
  return sum;
}
}  // namespace

Eigen::Matrix3d block_turn(const BodyState& state, const Eigen::Vector3d& centre_m, double ahead_s, int block) {
  const int first = block * block_nodes, last = std::min(first + block_nodes, state.part.nodes());
  return fem::components(state.part.mesh.model) == 2 ? turn_of_nodes<2>(state, centre_m, ahead_s, first, last)
                                                     : turn_of_nodes<3>(state, centre_m, ahead_s, first, last);
}

std::vector<BodyMotion> motions_of(const std::vector<BodyState>& states) { return {states.begin(), states.end()}; }

void restore_motions(const std::vector<BodyMotion>& motions, std::vector<BodyState>& states) {
  for (std::size_t b = 0; b < states.size(); ++b) static_cast<BodyMotion&>(states[b]) = motions[b];
}

void require_finite(const BodyState& state, const Eigen::VectorXd& u, std::int64_t window) {
  if ((0.0 * u.array()).sum() == 0.0) return;  // 0 * inf is nan; several times faster than allFinite()
  const int components = fem::components(state.part.mesh.model);
  Eigen::Index dof = 0;
  while (std::isfinite(u[dof])) ++dof;
  const auto node = static_cast<std::size_t>(dof / components);
  const auto& x = state.part.mesh.position[node];
  throw SolverError(
      fmt::format("window {}: the displacement of body '{}' is not finite at node {} {}; the time step exceeds a "
                  "critical time step or the contact is too stiff for it: run `ricochet check` on the scene",
                  window, state.name, state.part.body_node[node], fem::place_text(state.part.mesh.model, x)));
}

}  // namespace ricochet::solver

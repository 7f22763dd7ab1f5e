#include "common/check/check_contact.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "common/base/error.hpp"
#include "common/fem/element.hpp"
#include "common/problem/build.hpp"
#include "common/problem/contact_pairs.hpp"
#include "common/problem/critical_step.hpp"
#include "common/scene/protocols.hpp"

namespace ricochet::scene {
namespace {

/// Delay of the release in units of tau = Z / (2 alpha_n), from the exact solution of two equal bars with a penalty.
constexpr double delay_per_tau = 1.678347;
/// Intermittent contact halves what central difference stands.
constexpr double intermittent_share = 0.5;
/// mu N dt / (2 m) over 1/xi from which regularised friction rings. Measured, docs/limits.md.
constexpr double ringing_ratio = 10.0;
/// With bodies of unequal impedance the reset law gains energy where a window is more than so many times as long as a
/// wave takes through a contact element of one body, and more than so many times as many as through one of the other.
/// Measured, docs/contact_laws.md.
constexpr double longest_reset_window = 5.0, most_unequal_windows = 8.0, most_unequal_impedances = 2.0;
/// Strain that counts as small.
constexpr double small_strain = 0.02;

/// The longest of windows in which bodies may touch.
double contact_step_s(const Problem& problem) {
  const Time& time = problem.scene.time;
  return time.flight_step_s ? *time.step_s : problem.clock.largest_size_s();
}

/// A body on one side of the contact, and its node of a pair.
struct Sides {
  std::vector<const BodyProblem*> body;
  std::vector<const fem::Material*> material;  ///< at the contact

  Sides(const Problem& problem, const ContactGeometry& contact) {
    for (const int index : {contact.body_a, contact.body_b}) {
      if (index < 0) continue;
      body.push_back(&problem.bodies[at(index)]);
      material.push_back(&contact_material(problem, contact, index));
    }
  }
  /// Its node, or the one of largest weight of several.
  [[nodiscard]] static int node(const ContactPair& pair, std::size_t side) {
    if (side == 0) return pair.node_a;
    const auto lighter = [](const WeightedNode& x, const WeightedNode& y) { return x.weight < y.weight; };
    return std::max_element(pair.b.begin(), pair.b.end(), lighter)->node;
  }
};

double modulus(Model model, const fem::Material& material) {
  const double speed = fem::longitudinal_wave_speed(model, material);
  return material.density_kg_m3 * speed * speed;
}

/// Impedance per area rho c [kg/(m^2 s)].
double impedance(Model model, const fem::Material& material) {
  return material.density_kg_m3 * fem::longitudinal_wave_speed(model, material);
}

/// The smaller mass of each pair's nodes [kg].
std::vector<double> pair_masses(const Problem& problem, const ContactGeometry& contact) {
  std::vector<double> mass(contact.pairs.size(), std::numeric_limits<double>::infinity());
  const Sides sides(problem, contact);
  for (std::size_t side = 0; side < sides.body.size(); ++side) {
    const Eigen::VectorXd nodal = body_lumped_mass(*sides.body[side]);
    for (std::size_t i = 0; i < mass.size(); ++i)
      mass[i] = std::min(mass[i], nodal[Sides::node(contact.pairs[i], side)]);
  }
  return mass;
}

/// Smallest extent along the normal of the elements at a node [m].
double element_depth(const BodyProblem& body, int node, const Eigen::Vector3d& normal) {
  double depth = std::numeric_limits<double>::infinity();
  for (int e = 0; e < static_cast<int>(body.mesh.elements.size()); ++e) {
    const auto& nodes = body.mesh.elements[at(e)];
    if (std::find(nodes.begin(), nodes.end(), node) == nodes.end()) continue;
    depth = std::min(depth, fem::extent_along(fem::element_geometry(body.mesh, e), normal));
  }
  return depth;
}

/// Extent of a body along the normal [m].
double thickness(const BodyProblem& body, const Eigen::Vector3d& normal) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Eigen::Vector3d& x : body.mesh.position) {
    low = std::min(low, normal.dot(x));
    high = std::max(high, normal.dot(x));
  }
  return high - low;
}

double stiffness_ratio(const Problem& problem, const ContactGeometry& contact) {
  const Sides sides(problem, contact);
  double stiffness = 0.0;  // per area, k / A
  for (std::size_t side = 0; side < sides.body.size(); ++side) {
    const BodyProblem& body = *sides.body[side];
    const ContactPair& pair = contact.pairs.front();
    const int node = Sides::node(pair, side);
    const double share = problem.scene.model == Model::bar ? body.section.measure / pair.area_m2 : 1.0;
    stiffness = std::max(stiffness, share * modulus(problem.scene.model, *sides.material[side]) /
                                        element_depth(body, node, contact.normal));
  }
  return problem.scene.contact_law().penalty_pa_m / stiffness;
}

/// 1.678347 tau, tau = 1 / (alpha_n (1/Z_a + 1/Z_b)); a rigid plane has no 1/Z_b.
double release_delay(const Problem& problem, const ContactGeometry& contact) {
  double compliance = 0.0;
  const Sides sides(problem, contact);
  for (std::size_t side = 0; side < sides.body.size(); ++side)
    compliance += 1.0 / (impedance(problem.scene.model, *sides.material[side]) * sides.body[side]->section.measure);
  const double stiffness = problem.scene.contact_law().penalty_pa_m * contact.pairs.front().area_m2;
  return delay_per_tau / (stiffness * compliance);
}

void check_explicit_penalty(const Problem& problem, Plan& plan) {
  plan.penalty_critical_s = penalty_critical_time_step(problem);
  const Scene& scene = problem.scene;
  const double ratio = contact_step_s(problem) / plan.penalty_critical_s;
  if (ratio > 1.0 + 1e-9)
    throw ConfigError(fmt::format(
        "{}: found {:.6g} Pa/m with a step of {:.6g} s, {:.4g} times the critical time step {:.6g} s of central "
        "difference with this penalty; allowed: step_s = {:.3g} or less, a softer penalty, or enforcement = "
        "\"multiplier\"",
        scene.where(scene.contact_law().key() + ".penalty_pa_m"), scene.contact_law().penalty_pa_m,
        contact_step_s(problem), ratio, plan.penalty_critical_s, intermittent_share * plan.penalty_critical_s));
  if (ratio > intermittent_share)
    plan.warnings.push_back(fmt::format(
        "the step is {:.3g} times the critical time step with this penalty: contact that opens and closes may gain "
        "energy above {}; step_s = {:.3g} or enforcement = \"multiplier\" is safe",
        ratio, intermittent_share, intermittent_share * plan.penalty_critical_s));
}

/// Relative normal velocity with which the bodies approach at the start [m/s].
double approach_speed(const Problem& problem, const ContactGeometry& contact) {
  double speed = 0.0;
  for (int c = 0; c < problem.scene.components(); ++c) {
    speed += contact.normal[c] * problem.scene.bodies[at(contact.body_a)].initial_velocity_m_s[at(c)];
    if (contact.body_b >= 0)
      speed -= contact.normal[c] * problem.scene.bodies[at(contact.body_b)].initial_velocity_m_s[at(c)];
  }
  return std::max(speed, 0.0);
}

}  // namespace

void check_penalty(const Problem& problem, Plan& plan) {
  if (problem.contacts.empty()) return;
  const Contact& law = problem.scene.contact_law();
  if (law.enforcement != Enforcement::penalty) return;
  for (const ContactGeometry& contact : problem.contacts) {
    const std::vector<double> mass = pair_masses(problem, contact);
    for (std::size_t i = 0; i < mass.size(); ++i) {
      const double stiffness = law.penalty_pa_m * contact.pairs[i].area_m2;
      plan.penalty_step_ratio =
          std::max(plan.penalty_step_ratio, std::sqrt(2.0 * stiffness / mass[i]) * contact_step_s(problem));
    }
    plan.penalty_stiffness_ratio = std::max(plan.penalty_stiffness_ratio, stiffness_ratio(problem, contact));
    if (problem.scene.model == Model::bar)
      plan.penalty_delay_s = std::max(plan.penalty_delay_s, release_delay(problem, contact));
  }
  if (problem.scene.coupling.protocol.layout == Layout::all_explicit) {
    check_explicit_penalty(problem, plan);
  } else if (law.impact_update == ImpactUpdate::none && plan.penalty_step_ratio > 1.0) {
    plan.warnings.push_back(fmt::format(
        "penalty with the trapezoidal rule and impact_update = \"none\": sqrt(2 alpha_n/m) dt = {:.4g}, above 1, "
        "creates energy at every impact; use impact_update = \"mass\", enforcement = \"multiplier\" or penalty_pa_m = "
        "{:.3g}",
        plan.penalty_step_ratio, law.penalty_pa_m / std::pow(plan.penalty_step_ratio, 2)));
  }
}

namespace {

/// Such a pair's forces along n, t and b move each other, which laws by pairs of nodes do not know.
void refuse_askew_supports(const Problem& problem, std::size_t index) {
  const ContactGeometry& contact = problem.contacts[index];
  const Sides sides(problem, contact);
  for (const ContactPair& pair : contact.pairs) {
    const Eigen::Vector3d t = tangent_of(pair.normal), b = pair.normal.cross(t);
    for (std::size_t side = 0; side < sides.body.size(); ++side) {
      const BodyProblem& body = *sides.body[side];
      const int node = Sides::node(pair, side);
      for (int c = 0; c < 3; ++c) {
        const auto along = [c](const Eigen::Vector3d& direction) { return std::abs(direction[c]) > 1e-9; };
        if (!body.fixed_dof[at(3 * node + c)] || along(pair.normal) + along(t) + along(b) < 2) continue;
        throw ConfigError(fmt::format(
            "{}: the contact node {} of body '{}' at {} is held along a coordinate that is neither along the normal "
            "nor along the tangent or the binormal of the contact; allowed with this law: 0, or supports along those "
            "alone; multiplier_update = \"trapezoidal_reset\" knows friction with any supports",
            problem.scene.where(problem.scene.contacts[index].key() + ".friction_coefficient"), node, body.name,
            fem::place_text(body.mesh.model, body.mesh.position[at(node)])));
      }
    }
  }
}

}  // namespace

void check_supports(const Problem& problem) {
  if (problem.scene.model != Model::solid || problem.contacts.empty() || !needs_pairs(problem.scene)) return;
  for (std::size_t c = 0; c < problem.contacts.size(); ++c)
    if (problem.scene.contacts[c].friction_coefficient > 0.0) refuse_askew_supports(problem, c);
}

/// Regularised friction is a damper as stiff as mu N xi: the trapezoidal rule follows it without damping its own
/// ringing, where no law of impulses solves for the velocity that friction leaves.
void check_friction(const Problem& problem, Plan& plan) {
  if (problem.contacts.empty()) return;
  const Contact& law = problem.scene.contact_law();
  if (law.friction_law != FrictionLaw::regularised) return;
  plan.warnings.push_back(fmt::format(
      "regularised friction, mu p tanh(xi v): below a relative velocity of 1/xi = {:.3g} m/s it is less than mu p, "
      "so nothing sticks "
      "and a pair held by friction creeps; friction_law = \"return_mapping\" sticks",
      1.0 / law.friction_regularisation_s_m));
  if (law.enforcement != Enforcement::penalty || law.impact_update != ImpactUpdate::none) return;
  if (problem.scene.coupling.protocol.layout == Layout::all_explicit) return;
  double needed = 0.0;
  for (std::size_t c = 0; c < problem.contacts.size(); ++c) {
    const ContactGeometry& contact = problem.contacts[c];
    double compliance = 0.0;
    for (const fem::Material* material : Sides(problem, contact).material)
      compliance += 1.0 / impedance(problem.scene.model, *material);
    const double pressure = approach_speed(problem, contact) / compliance;
    const std::vector<double> mass = pair_masses(problem, contact);
    for (std::size_t i = 0; i < mass.size(); ++i)
      needed = std::max(needed, problem.scene.contacts[c].friction_coefficient * pressure * contact.pairs[i].area_m2 *
                                    contact_step_s(problem) / (2.0 * mass[i]));
  }
  const double scale = 1.0 / law.friction_regularisation_s_m;
  if (ringing_ratio * scale < needed)
    plan.warnings.push_back(
        fmt::format("regularised friction: its velocity scale 1/xi = {:.3g} m/s is less than a tenth of mu N dt/(2 m) "
                    "= {:.3g} m/s, so "
                    "the friction force rings after an impact; use friction_law = \"return_mapping\" or "
                    "friction_regularisation_s_m = "
                    "{:.3g}",
                    scale, needed, ringing_ratio / needed));
}

namespace {

void check_impact(const Problem& problem, const ContactGeometry& contact, Plan& plan) {
  const double speed = approach_speed(problem, contact), moved_m = speed * contact_step_s(problem);
  const Sides sides(problem, contact);
  double compliance = 0.0;
  for (const fem::Material* material : sides.material) compliance += 1.0 / impedance(problem.scene.model, *material);
  for (std::size_t side = 0; side < sides.body.size(); ++side) {
    const BodyProblem& body = *sides.body[side];
    const double strain = speed / compliance / modulus(problem.scene.model, *sides.material[side]);
    if (strain > small_strain)
      plan.warnings.push_back(
          fmt::format("an impact at {:.4g} m/s strains body \"{}\" by about {:.2g} %: strain is "
                      "small no more, expect "
                      "errors of stresses and forces of that size",
                      speed, body.name, 100.0 * strain));
    const double depth_m = element_depth(body, Sides::node(contact.pairs.front(), side), contact.normal);
    const std::string found = fmt::format(
        "a step of {:.6g} s, in which the bodies move {:.3g} m towards each "
        "other, {:.3g} of the depth of an "
        "element of body \"{}\" at the contact",
        contact_step_s(problem), moved_m, moved_m / depth_m, body.name);
    if (moved_m > thickness(body, contact.normal))
      throw ConfigError(
          fmt::format("{}: found {}: more than its thickness, they would pass through it; allowed: {:.3g} s or less",
                      problem.scene.where("time"), found, 0.5 * depth_m / speed));
    if (moved_m > 0.5 * depth_m)
      plan.warnings.push_back(
          fmt::format("{}: the impact turns that element nearly inside out; {:.3g} s or less "
                      "leaves room",
                      found, 0.5 * depth_m / speed));
  }
}

/// A pair that opens in a window gains the work of the force that its acceleration remembers over the gap's increment:
/// a large one where one side is stiff enough to throw the other off within the window.
void check_reset_law(const Problem& problem, const ContactGeometry& contact) {
  const Sides sides(problem, contact);
  if (sides.body.size() < 2) return;
  std::array<double, 2> windows{};  // of a wave through the element
  for (std::size_t side = 0; side < 2; ++side) {
    const BodyProblem& body = *sides.body[side];
    if (body.mesh.rigid_nodes > 0) return;  // its strain is as fast as the finest element of the other body
    const double depth_m = element_depth(body, Sides::node(contact.pairs.front(), side), contact.normal);
    windows[side] =
        contact_step_s(problem) * fem::longitudinal_wave_speed(body.section.model, *sides.material[side]) / depth_m;
  }
  const std::size_t stiff = windows[0] > windows[1] ? 0 : 1;
  const double most = windows[stiff], ratio = most / windows[1 - stiff];
  if (most <= longest_reset_window || ratio <= most_unequal_windows) return;
  const auto [low, high] = std::minmax(
      {impedance(problem.scene.model, *sides.material[0]), impedance(problem.scene.model, *sides.material[1])});
  if (high <= most_unequal_impedances * low) return;
  throw ConfigError(fmt::format(
      "{}: found a step of {:.3g} s, {:.3g} times as long as a wave takes through the contact elements of body \"{}\", "
      "but {:.3g} times through those of body \"{}\": the law \"trapezoidal_reset\" gains energy where these differ by "
      "more than {:.0f} times and the larger is above {:.0f}; allowed: time.step_s = {:.3g} or less, or "
      "{}.multiplier_update = \"massless\" (surfaces whose nodes face each other in pairs) or \"fully_implicit\"",
      problem.scene.where("time"), contact_step_s(problem), most, sides.body[stiff]->name, most / ratio,
      sides.body[1 - stiff]->name, most_unequal_windows, longest_reset_window,
      contact_step_s(problem) * longest_reset_window / most, problem.scene.contact_law().key()));
}

}  // namespace

void check_impact(const Problem& problem, Plan& plan) {
  if (problem.contacts.empty()) return;
  const Contact& law = problem.scene.contact_law();
  const bool resets = law.enforcement == Enforcement::multiplier &&
                      law.multiplier_update == MultiplierUpdate::trapezoidal_reset &&
                      problem.scene.coupling.protocol.layout != Layout::all_explicit;
  for (const ContactGeometry& contact : problem.contacts) {
    check_impact(problem, contact, plan);
    if (resets) check_reset_law(problem, contact);
  }
}

}  // namespace ricochet::scene

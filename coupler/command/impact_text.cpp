#include "coupler/command/impact_text.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include "common/problem/facet_sagitta.hpp"
#include "coupler/results/theory.hpp"

namespace ricochet::coupler {
namespace {

struct Impact {
  double force_n = 0.0, duration_s = 0.0;
  double pressure_pa = 0.0;  ///< of Hertz: in the middle of the patch, the largest
  double approach_m = 0.0;   ///< of Hertz: by how much the bodies come nearer while they touch
};

std::string line(const scene::ContactGeometry& contact, const scene::Problem& problem, double speed_m_s,
                 const Impact& impact, const std::string& by) {
  int first = contact.body_a, second = contact.body_b;
  if (contact.second_named_first) std::swap(first, second);
  const auto& a = problem.bodies[static_cast<std::size_t>(first)].name;
  const std::string b = second < 0 ? "what is rigid" : problem.bodies[static_cast<std::size_t>(second)].name;
  return fmt::format("impact of \"{}\" on {}{}{} at {:.4g} m/s: about {:.4g} N for {:.4g} s, by {}\n", a,
                     contact.body_b < 0 ? "" : "\"", b, contact.body_b < 0 ? "" : "\"", speed_m_s, impact.force_n,
                     impact.duration_s, by);
}

/// With which the bodies of a contact approach at the start [m/s].
double closing_speed(const scene::Problem& problem, const scene::ContactGeometry& contact) {
  double speed = 0.0;
  for (const auto& [body, sign] : {std::pair{contact.body_a, 1.0}, std::pair{contact.body_b, -1.0}}) {
    if (body < 0) continue;
    const auto& velocity = problem.scene.bodies[static_cast<std::size_t>(body)].initial_velocity_m_s;
    for (std::size_t c = 0; c < velocity.size(); ++c)
      speed += sign * contact.normal[static_cast<Eigen::Index>(c)] * velocity[c];
  }
  return speed;
}

bool held(const scene::Body& body, const Eigen::Vector3d& normal) {
  return std::any_of(body.supports.begin(), body.supports.end(), [&](const scene::Support& support) {
    return std::any_of(support.components.begin(), support.components.end(), [&](int c) { return normal[c] != 0.0; });
  });
}

/// The gap g0 + r^2/(2R) near the first place of contact, and which share of the round patch there is: in a solid
/// that is cut along its planes of symmetry a half or a quarter.
struct Curvature {
  double radius_m = 0.0, share = 1.0;
};

std::optional<Curvature> curvature(const scene::Problem& problem, const scene::ContactGeometry& contact) {
  const auto& mesh = problem.bodies[static_cast<std::size_t>(contact.body_a)].mesh;
  const auto first = std::min_element(contact.pairs.begin(), contact.pairs.end(),
                                      [](const auto& p, const auto& q) { return p.gap0_m < q.gap0_m; });
  const auto& apex = mesh.position[static_cast<std::size_t>(first->node_a)];
  const Eigen::Vector3d tangent = scene::tangent_of(contact.normal), binormal = contact.normal.cross(tangent);
  double farthest_m = 0.0;
  Eigen::Vector4d reach = Eigen::Vector4d::Zero();  // along +-t, +-b
  const auto lateral = [&](const auto& pair) {
    const Eigen::Vector3d x = mesh.position[static_cast<std::size_t>(pair.node_a)] - apex;
    return Eigen::Vector2d(x.dot(tangent), x.dot(binormal));
  };
  for (const auto& pair : contact.pairs) {
    const Eigen::Vector2d x = lateral(pair);
    farthest_m = std::max(farthest_m, x.norm());
    reach = reach.cwiseMax(Eigen::Vector4d(x[0], -x[0], x[1], -x[1]));
  }
  double squares = 0.0, products = 0.0;  // of r^2 and g - g0, near the apex
  for (const auto& pair : contact.pairs) {
    const double r2 = lateral(pair).squaredNorm(), near = 0.35 * farthest_m;
    if (r2 > near * near) continue;
    squares += r2 * r2;
    products += r2 * (pair.gap0_m - first->gap0_m);
  }
  if (!(products > 1e-9 * squares / farthest_m)) return std::nullopt;  // flat
  Curvature found{0.5 * squares / products, 1.0};
  for (int direction = 0; problem.scene.components() == 3 && direction < 2; ++direction) {
    const double low = reach[2 * direction], high = reach[2 * direction + 1];
    if (std::min(low, high) < 1e-6 * std::max(low, high)) found.share *= 0.5;
  }
  return found;
}

/// Hertz' law knows no waves: they must have gone to and fro in either body, but where it absorbs them, before the end.
bool is_slow(const scene::Problem& problem, const scene::Plan& plan, const scene::ContactGeometry& contact,
             double duration_s) {
  constexpr double times = 2.0;
  for (const int body : {contact.body_a, contact.body_b}) {
    if (body < 0 || !problem.scene.bodies[static_cast<std::size_t>(body)].absorbing.empty()) continue;
    const auto& material = scene::contact_material(problem, contact, body);
    const double length_m = plan.bodies[static_cast<std::size_t>(body)].extent_m.dot(contact.normal.cwiseAbs());
    const double transit_s = 2.0 * length_m / std::sqrt(material.youngs_modulus_pa / material.density_kg_m3);
    if (duration_s < times * transit_s) return false;
  }
  return true;
}

std::optional<Impact> hertz(const scene::Problem& problem, const scene::Plan& plan,
                            const scene::ContactGeometry& contact, double speed_m_s) {
  const bool round = problem.scene.model == scene::Model::axisymmetric || problem.scene.components() == 3;
  const auto shape = round ? curvature(problem, contact) : std::nullopt;
  if (!shape) return std::nullopt;
  double compliance = 0.0, inverse_mass = 0.0;
  for (const int body : {contact.body_a, contact.body_b}) {
    if (body < 0) continue;
    const auto& material = scene::contact_material(problem, contact, body);
    compliance += (1.0 - material.poisson_ratio * material.poisson_ratio) / material.youngs_modulus_pa;
    if (!held(problem.scene.bodies[static_cast<std::size_t>(body)], contact.normal))
      inverse_mass += 1.0 / plan.bodies[static_cast<std::size_t>(body)].mass_kg;
  }
  if (inverse_mass == 0.0) return std::nullopt;
  const double k = shape->share * 4.0 / 3.0 / compliance * std::sqrt(shape->radius_m);
  const double approach_m = std::pow(1.25 * speed_m_s * speed_m_s / (inverse_mass * k), 0.4);
  const double force_n = k * std::pow(approach_m, 1.5), patch_m2 = std::numbers::pi * shape->radius_m * approach_m;
  const Impact impact{force_n, 2.9432 * approach_m / speed_m_s, 1.5 * force_n / (shape->share * patch_m2), approach_m};
  return is_slow(problem, plan, contact, impact.duration_s) ? std::optional(impact) : std::nullopt;
}

/// A stress of an impact at `speed_m_s` that is above a limit of a body's material; it grows like speed^power.
struct Excess {
  std::string what, limit;
  double stress_pa, limit_pa, speed_m_s, power;
};

void warn(const Excess& e, const std::string& body, std::vector<std::string>& warnings) {
  if (!(e.stress_pa > e.limit_pa)) return;
  warnings.push_back(
      fmt::format("an impact at {:.4g} m/s {} of {:.4g} MPa in body \"{}\", {:.4g} times its {} of {:.4g} MPa: linear "
                  "elastic elements "
                  "are right up to {:.3g} m/s",
                  e.speed_m_s, e.what, 1e-6 * e.stress_pa, body, e.stress_pa / e.limit_pa, e.limit, 1e-6 * e.limit_pa,
                  e.speed_m_s * std::pow(e.limit_pa / e.stress_pa, 1.0 / e.power)));
}

/// Flat surfaces: force F = v / sum 1/(rho c A): the stress F/A runs along the body, and comes back from a
/// free end with the other sign.
void warn_of_flat(const scene::Problem& problem, const scene::ContactGeometry& contact, double speed_m_s,
                  std::vector<std::string>& warnings) {
  const bool bar = problem.scene.model == scene::Model::bar;
  double compliance = 0.0;
  for (const int body : {contact.body_a, contact.body_b}) {
    if (body >= 0) compliance += 1.0 / axial_impedance(problem, static_cast<std::size_t>(body));
  }
  for (const int index : {contact.body_a, contact.body_b}) {
    if (index < 0 || problem.scene.bodies[static_cast<std::size_t>(index)].rigid) continue;
    const auto& body = problem.bodies[static_cast<std::size_t>(index)];
    const auto& material = scene::contact_material(problem, contact, index);
    const double stress_pa = speed_m_s / compliance / (bar ? body.section.measure : 1.0);
    warn({"makes, by impedance theory, a von Mises stress", "yield stress",
          von_mises_share(problem, static_cast<std::size_t>(index)) * stress_pa, material.yield_stress_pa, speed_m_s,
          1.0},
         body.name, warnings);
    warn({"sends, by impedance theory, a wave that a free end turns into a tension", "strength", stress_pa,
          material.strength_pa, speed_m_s, 1.0},
         body.name, warnings);
  }
}

/// Round surfaces: a metal yields first, below the surface, where p_max is 1.6 times its yield stress; the
/// rim of the patch has a tension of (1 - 2 nu)/3 p_max. Johnson, Contact Mechanics, 3.4 and 6.1.
void warn_of_round(const scene::Problem& problem, const scene::ContactGeometry& contact, const Impact& impact,
                   double speed_m_s, std::vector<std::string>& warnings) {
  constexpr double first_yield = 1.6, power = 0.4;  // p_max ~ v^(2/5)
  for (const int index : {contact.body_a, contact.body_b}) {
    if (index < 0 || problem.scene.bodies[static_cast<std::size_t>(index)].rigid) continue;
    const auto& body = problem.bodies[static_cast<std::size_t>(index)];
    const auto& m = scene::contact_material(problem, contact, index);
    warn({"makes, by Hertz' theory, a von Mises stress", "yield stress", impact.pressure_pa / first_yield,
          m.yield_stress_pa, speed_m_s, power},
         body.name, warnings);
    warn({"makes, by Hertz' theory, a tension", "strength", (1.0 - 2.0 * m.poisson_ratio) / 3.0 * impact.pressure_pa,
          m.strength_pa, speed_m_s, power},
         body.name, warnings);
  }
}

/// Where Hertz' law does not hold, a body is in contact for as long as waves run to and fro in it, the largest time of
/// either; with a force like a half sine the bodies come nearer by v/pi times that.
double approach_by_waves(const scene::Problem& problem, const scene::Plan& plan, const scene::ContactGeometry& contact,
                         double speed_m_s) {
  double longest_s = 0.0;
  for (const int body : {contact.body_a, contact.body_b}) {
    if (body < 0) continue;
    const auto& material = scene::contact_material(problem, contact, body);
    const double length_m = plan.bodies[static_cast<std::size_t>(body)].extent_m.dot(contact.normal.cwiseAbs());
    longest_s = std::max(longest_s, 2.0 * length_m / std::sqrt(material.youngs_modulus_pa / material.density_kg_m3));
  }
  return speed_m_s * longest_s / std::numbers::pi;
}

/// Facets of a curved surface that stand off it by a share of the approach hold few nodes in the patch of contact:
/// forces then depend on where these lie.
void warn_of_facets(const scene::Problem& problem, std::size_t contact, double approach_m, const std::string& by,
                    std::vector<std::string>& warnings) {
  constexpr double most = 0.1;
  for (const auto& facets : scene::curved_facets(problem, contact)) {
    if (!(facets.sagitta_m > most * approach_m)) continue;
    warnings.push_back(
        fmt::format("surface \"{}\": its facets, {:.3g} m long where the bodies meet, stand off the round surface by "
                    "{:.3g} m, and the bodies approach by about {:.3g} m in the impact, by {}: forces depend on where "
                    "the nodes lie; with facets of {:.2g} m, {:.3g} times finer, it is a tenth",
                    facets.surface, facets.edge_m, facets.sagitta_m, approach_m, by,
                    facets.edge_m * std::sqrt(most * approach_m / facets.sagitta_m),
                    std::sqrt(facets.sagitta_m / (most * approach_m))));
  }
}

}  // namespace

std::vector<std::string> limit_warnings(const scene::Problem& problem, const scene::Plan& plan) {
  std::vector<std::string> warnings;
  for (std::size_t i = 0; i < problem.contacts.size(); ++i) {
    const auto& contact = problem.contacts[i];
    const double speed_m_s = closing_speed(problem, contact);
    if (speed_m_s <= 0.0 || contact.pairs.empty()) continue;
    if (!curvature(problem, contact)) {
      warn_of_flat(problem, contact, speed_m_s, warnings);
    } else if (const auto impact = hertz(problem, plan, contact, speed_m_s)) {
      warn_of_round(problem, contact, *impact, speed_m_s, warnings);
      warn_of_facets(problem, i, impact->approach_m, "Hertz' theory", warnings);
    } else {
      warn_of_facets(problem, i, approach_by_waves(problem, plan, contact, speed_m_s), "the time of waves", warnings);
    }
  }
  return warnings;
}

std::vector<double> contact_durations_s(const scene::Problem& problem, const scene::Plan& plan) {
  const auto loaded = [](const scene::Body& body) {
    return !body.gravity_m_s2.empty() || !body.tractions.empty() || !body.prescribed.empty();
  };
  const auto& bodies = problem.scene.bodies;
  const auto theory = impact_theory(problem);
  std::vector<double> durations(problem.contacts.size(), std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < durations.size(); ++i) {
    const auto& contact = problem.contacts[i];
    const double speed_m_s = closing_speed(problem, contact);
    if (!(speed_m_s > 0.0) || contact.pairs.empty() || std::any_of(bodies.begin(), bodies.end(), loaded)) continue;
    if (theory)
      durations[i] = theory->contact_duration_s;
    else if (const auto impact = hertz(problem, plan, contact, speed_m_s))
      durations[i] = impact->duration_s;
  }
  return durations;
}

std::string impact_text(const scene::Problem& problem, const scene::Plan& plan) {
  std::string text;
  const auto theory = impact_theory(problem);
  for (const auto& contact : problem.contacts) {
    const double speed_m_s = closing_speed(problem, contact);
    if (speed_m_s <= 0.0 || contact.pairs.empty()) continue;
    if (theory) {
      double area_m2 = 0.0;
      for (const auto& pair : contact.pairs) area_m2 += pair.area_m2;
      text += line(contact, problem, speed_m_s, {theory->stress_pa * area_m2, theory->contact_duration_s},
                   "impedance theory");
    } else if (const auto impact = hertz(problem, plan, contact, speed_m_s)) {
      text += line(contact, problem, speed_m_s, *impact, "Hertz' theory");
    }
  }
  return text;
}

}  // namespace ricochet::coupler

#include "coupler/results/theory.hpp"

#include <algorithm>
#include <cmath>
#include <variant>

namespace ricochet::coupler {
namespace {

bool periodic(const scene::Body& body) {
  const auto* mesh = body.structured();
  return mesh && mesh->periodic_across;
}

/// That of a body of several where its first contact is.
const fem::Material& material_of_contact(const scene::Problem& problem, std::size_t body) {
  const auto index = static_cast<int>(body);
  for (const auto& contact : problem.contacts)
    if (contact.body_a == index || contact.body_b == index) return scene::contact_material(problem, contact, index);
  return problem.bodies[body].material;
}

double wave_speed(const scene::Problem& problem, std::size_t body) {
  const auto& m = material_of_contact(problem, body);
  const double nu = m.poisson_ratio;
  const double bar = m.youngs_modulus_pa / m.density_kg_m3;
  const bool confined = periodic(problem.scene.bodies[body]);
  if (problem.scene.model != scene::Model::plane_strain && !confined) return std::sqrt(bar);
  return std::sqrt(bar * (confined ? (1 - nu) / ((1 + nu) * (1 - 2 * nu)) : 1 / (1 - nu * nu)));
}

double length_along(const scene::BodyProblem& body, const Eigen::Vector3d& normal) {
  double low = HUGE_VAL, high = -HUGE_VAL;
  for (const auto& x : body.mesh.position) {
    low = std::min(low, x.dot(normal));
    high = std::max(high, x.dot(normal));
  }
  return high - low;
}

/// Until the wave of the impact is back at the contact [s]; it is not where an absorbing surface takes it up.
double transit(const scene::Problem& problem, std::size_t body) {
  if (!problem.scene.bodies[body].absorbing.empty()) return HUGE_VAL;
  return 2 * length_along(problem.bodies[body], problem.contacts.front().normal) / wave_speed(problem, body);
}

double velocity_along(const scene::Body& body, const Eigen::Vector3d& normal) {
  double velocity = 0.0;
  for (std::size_t c = 0; c < body.initial_velocity_m_s.size(); ++c) {
    velocity += normal[static_cast<Eigen::Index>(c)] * body.initial_velocity_m_s[c];
  }
  return velocity;
}

/// Nothing but the other body acts on it along the normal, and it only flies.
bool flies_freely(const scene::Body& body, const Eigen::Vector3d& normal) {
  const auto along = [&](int component) { return normal[component] != 0.0; };
  const auto zero = [](double x) { return x == 0.0; };
  const auto held = [&](const scene::Support& s) {
    return std::any_of(s.components.begin(), s.components.end(), along);
  };
  const auto driven = [&](const scene::PrescribedMotion& p) { return p.turn || along(p.component); };
  return std::none_of(body.supports.begin(), body.supports.end(), held) &&
         std::none_of(body.prescribed.begin(), body.prescribed.end(), driven) && body.tractions.empty() &&
         std::all_of(body.gravity_m_s2.begin(), body.gravity_m_s2.end(), zero) &&
         body.initial_displacement_start_m == body.initial_displacement_end_m;
}

/// The surfaces lie parallel, so that all of them touch at once: of balls and of noses no plane wave comes.
bool touches_all_at_once(const scene::ContactGeometry& contact, double length_m) {
  constexpr double of_length = 1e-9;
  const auto by_gap = [](const auto& x, const auto& y) { return x.gap0_m < y.gap0_m; };
  const auto [least, most] = std::minmax_element(contact.pairs.begin(), contact.pairs.end(), by_gap);
  return most->gap0_m - least->gap0_m <= of_length * length_m;
}

}  // namespace

double axial_impedance(const scene::Problem& problem, std::size_t body) {
  const bool bar = problem.scene.model == scene::Model::bar;
  return material_of_contact(problem, body).density_kg_m3 * wave_speed(problem, body) *
         (bar ? problem.scene.bodies[body].area_m2 : 1.0);
}

double von_mises_share(const scene::Problem& problem, std::size_t body) {
  const double nu = material_of_contact(problem, body).poisson_ratio;
  if (periodic(problem.scene.bodies[body])) return (1.0 - 2.0 * nu) / (1.0 - nu);
  return problem.scene.model == scene::Model::plane_strain ? std::sqrt(1.0 - nu + nu * nu) : 1.0;
}

std::optional<ImpactTheory> impact_theory(const scene::Problem& problem) {
  if (problem.contacts.size() != 1 || !problem.joints.empty()) return std::nullopt;
  const auto& contact = problem.contacts.front();
  if (contact.body_b < 0) return std::nullopt;
  const auto a = static_cast<std::size_t>(contact.body_a);
  const auto b = static_cast<std::size_t>(contact.body_b);
  for (const auto body : {a, b}) {
    if (!flies_freely(problem.scene.bodies[body], contact.normal)) return std::nullopt;
    if (fem::materials_of(problem.bodies[body]).size() > 1)
      return std::nullopt;  // waves come back from where they meet
    if (problem.scene.bodies[body].rigid) return std::nullopt;
  }
  if (problem.scene.contact_law().nose_radius_m > 0) return std::nullopt;
  if (!touches_all_at_once(contact, length_along(problem.bodies[a], contact.normal))) return std::nullopt;
  const double closing =
      velocity_along(problem.scene.bodies[a], contact.normal) - velocity_along(problem.scene.bodies[b], contact.normal);
  if (closing <= 0) return std::nullopt;
  const double transit_a = transit(problem, a), transit_b = transit(problem, b);
  const double z_a = axial_impedance(problem, a), z_b = axial_impedance(problem, b);
  const bool equal = std::abs(z_a - z_b) <= 1e-9 * z_a;
  const bool a_decides = equal ? transit_a <= transit_b : z_a < z_b;
  const bool bar = problem.scene.model == scene::Model::bar;
  ImpactTheory theory;
  theory.contact_duration_s = a_decides ? transit_a : transit_b;
  if (!std::isfinite(theory.contact_duration_s)) return std::nullopt;
  theory.other_body_returns_later = theory.contact_duration_s <= (1 + 1e-9) * (a_decides ? transit_b : transit_a);
  theory.first_step_s = std::min(transit_a, transit_b);
  theory.closing_velocity_m_s = closing;
  theory.body = problem.bodies[a_decides ? a : b].name;
  theory.stress_pa = z_a * z_b / (z_a + z_b) * closing / (bar ? contact.pairs.front().area_m2 : 1.0);
  return theory;
}

}  // namespace ricochet::coupler

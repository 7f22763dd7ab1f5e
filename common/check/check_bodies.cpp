#include "common/check/check_bodies.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "common/fem/element.hpp"
#include "common/fem/hanging_nodes.hpp"
#include "common/fem/inp_file.hpp"
#include "common/problem/build.hpp"
#include "common/problem/critical_step.hpp"
#include "common/problem/mass_scaling.hpp"

namespace ricochet::scene {
namespace {

/// From foams to osmium, and to diamond [kg/m^3, m/s].
constexpr double least_density = 0.5, largest_density = 3e4, largest_speed = 3e4;
/// A body with a solid's density is not so soft; model problems have neither [kg/m^3, m/s].
constexpr double solid_density = 100.0, least_speed = 10.0;
/// A body of this size that no wave crosses so far of in the run, and what a mesh of tens of tonnes is [m, kg].
constexpr double large_m = 0.5, least_crossing = 0.05, huge_m = 5.0, huge_kg = 2e4;

Eigen::Vector3d extent_of(const fem::Mesh& mesh) {
  Eigen::Vector3d low = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (const Eigen::Vector3d& x : mesh.position) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  return high - low;
}

double volume_of(const BodyProblem& body, double mass_kg) {
  if (body.mesh.material.empty()) return mass_kg / body.material.density_kg_m3;
  double volume_m3 = 0.0;
  for (int e = 0; e < static_cast<int>(body.mesh.elements.size()); ++e) {
    const fem::Material& material = fem::material_of(body, e);
    volume_m3 += fem::element_lumped_mass(body.section, material, fem::element_geometry(body.mesh, e)).sum() /
                 material.density_kg_m3;
  }
  return volume_m3;
}

}  // namespace

std::vector<BodyPlan> plan_bodies(const Problem& problem) {
  std::vector<BodyPlan> plans;
  for (std::size_t b = 0; b < problem.bodies.size(); ++b) {
    const BodyProblem& body = problem.bodies[b];
    BodyPlan plan;
    plan.name = body.name;
    plan.extent_m = extent_of(body.mesh);
    plan.mass_kg = body_lumped_mass(body).sum();
    plan.volume_m3 = volume_of(body, plan.mass_kg - added_mass(problem, static_cast<int>(b)).kg);
    for (const double v : problem.scene.bodies[b].initial_velocity_m_s) plan.speed_m_s = std::hypot(plan.speed_m_s, v);
    plan.rigid = problem.scene.bodies[b].rigid;
    plan.energy_j = 0.5 * plan.mass_kg * plan.speed_m_s * plan.speed_m_s;
    plans.push_back(std::move(plan));
  }
  return plans;
}

void check_units(const Problem& problem, Plan& plan) {
  for (std::size_t b = 0; b < problem.bodies.size(); ++b) {
    const BodyProblem& body = problem.bodies[b];
    const BodyPlan& of = plan.bodies[b];
    for (const fem::Material* material : fem::materials_of(body)) {
      const double density = material->density_kg_m3;
      const double speed =
          problem.scene.bodies[b].rigid ? least_speed : fem::longitudinal_wave_speed(body.section.model, *material);
      const bool too_soft = density > solid_density && speed < least_speed;
      if (density < least_density || density > largest_density || too_soft || speed > largest_speed)
        plan.warnings.push_back(fmt::format(
            "body \"{}\": a density of {:.4g} kg/m^3 and a wave speed of {:.4g} m/s are those of no material; "
            "is it in another unit than youngs_modulus_pa [Pa] and density_kg_m3 [kg/m^3]?",
            of.name, density, speed));
    }
    const double speed = fastest_wave_m_s(body);
    const double largest_m = of.extent_m.maxCoeff(), crossed_m = speed * problem.scene.time.end_s;
    const bool gmsh = !problem.scene.bodies[b].files().empty();
    const bool uncrossed = largest_m > large_m && crossed_m < least_crossing * largest_m;
    if (uncrossed || (gmsh && largest_m > huge_m && of.mass_kg > huge_kg))
      plan.warnings.push_back(fmt::format(
          "body \"{}\" is {:.4g} m large and has {:.4g} kg; a wave runs {:.3g} m until {:.3g} s: is it in millimetres? "
          "Lengths are metres{}",
          of.name, largest_m, of.mass_kg, crossed_m, problem.scene.time.end_s,
          gmsh ? ", in a mesh file too, unless mesh.length_unit says otherwise" : ""));
  }
}

void note_ignored_cards(const Scene& scene, Plan& plan) {
  std::set<std::string> seen;
  for (const Body& body : scene.bodies) {
    for (const GmshMesh* file : body.files()) {
      if (!fem::is_inp_file(file->path) || !seen.insert(file->path).second) continue;
      const std::vector<std::string> cards = fem::ignored_inp_cards(file->path);
      if (!cards.empty())
        plan.notes.push_back(fmt::format(
            "{} is read for its mesh alone; {} left out: materials, supports, loads and steps are those of the scene",
            file->path, fmt::join(cards, ", ")));
    }
  }
}

/// A piece that was put beside the other by mistake would hold on by what is left.
void note_partial_ties(const Problem& problem, Plan& plan) {
  for (std::size_t b = 0; b < problem.bodies.size(); ++b) {
    const fem::Mesh& mesh = problem.bodies[b].mesh;
    for (const auto& tie : problem.scene.bodies[b].ties) {
      std::array<std::ptrdiff_t, 2> nodes{}, hanging{};
      for (std::size_t side = 0; side < 2; ++side) {
        const std::vector<int> all = fem::surface_nodes(mesh, tie[side]);
        nodes[side] = std::ssize(all);
        hanging[side] =
            std::count_if(all.begin(), all.end(), [&](int node) { return fem::hanging_at(mesh, node) != nullptr; });
      }
      const std::size_t fine = hanging[0] >= hanging[1] ? 0 : 1;
      if (hanging[fine] < nodes[fine])
        plan.notes.push_back(
            fmt::format("body \"{}\": {} of the {} nodes of \"{}\" lie beside \"{}\", to which it is "
                        "tied, and stay free",
                        problem.bodies[b].name, nodes[fine] - hanging[fine], nodes[fine], tie[fine], tie[1 - fine]));
    }
  }
}

}  // namespace ricochet::scene

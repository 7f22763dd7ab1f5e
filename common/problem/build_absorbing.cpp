#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/base/error.hpp"
#include "common/fem/element.hpp"
#include "common/problem/build.hpp"

namespace ricochet::scene {
namespace {

constexpr double perpendicular_tolerance = 1e-6;

/// Speed of the wave that meets the surface head on [m/s].
double normal_speed(const BodyProblem& body, Wave wave) {
  if (wave == Wave::dilatational) return fem::longitudinal_wave_speed(body.section.model, body.material);
  const double bar = fem::longitudinal_wave_speed(Model::bar, body.material), nu = body.material.poisson_ratio;
  return body.section.model == Model::plane_strain ? bar / std::sqrt(1.0 - nu * nu) : bar;
}

class Absorber {
 public:
  Absorber(const Scene& scene, std::string key, BodyProblem& body)
      : scene_(&scene), key_(std::move(key)), body_(&body) {}

  /// Adds the impedance rho c times the tributary area of every node of the surface [kg/s].
  void add(const AbsorbingSurface& absorbing) {
    require_surface(*scene_, key_, body_->mesh, absorbing.surface);
    const double density = body_->material.density_kg_m3;
    double whole_area = 0.0;
    for (const auto& edge : body_->mesh.surfaces.at(absorbing.surface)) {
      const Eigen::Vector2d& a = body_->mesh.position[at(edge[0])];
      const Eigen::Vector2d b = fem::nearest_image(body_->mesh, body_->mesh.position[at(edge[1])], a);
      const Eigen::Vector2d area = fem::edge_area(body_->section, a, b);
      const int normal = normal_component(edge, b - a);
      whole_area += area.sum();
      for (int c = 0; c < scene_->components(); ++c) {
        const double speed =
            c == normal ? normal_speed(*body_, absorbing.wave) : fem::shear_wave_speed(body_->material);
        for (std::size_t end = 0; end < 2; ++end)
          add(edge[end], c, density * speed * area[static_cast<Eigen::Index>(end)]);
      }
      for (const int node : edge) refuse_held(node, normal);
    }
    if (!(whole_area > 0.0)) refuse("a surface without area", "a surface with area");
  }

 private:
  /// A force on a dof that is held would do nothing.
  void add(int node, int c, double coefficient) {
    const int dof = node * scene_->components() + c;
    if (!body_->fixed_dof[at(dof)]) body_->damping_kg_s[dof] += coefficient;
  }
  [[noreturn]] void refuse(const std::string& found, const std::string& allowed) const {
    throw ConfigError(fmt::format("{}: found {}; allowed: {}", scene_->where(key_), found, allowed));
  }
  [[nodiscard]] std::string place(int node) const {
    const Eigen::Vector2d& x = body_->mesh.position[at(node)];
    return fmt::format("({:.6g}, {:.6g}) m", x[0], x[1]);
  }
  /// The coordinate that an edge is perpendicular to: dashpots act on components one by one.
  [[nodiscard]] int normal_component(const std::array<int, 2>& edge, const Eigen::Vector2d& along) const {
    if (scene_->model == Model::bar) return 0;
    for (int c = 0; c < 2; ++c)
      if (std::abs(along[c]) <= perpendicular_tolerance * along.norm()) return c;
    refuse("an edge at " + place(edge[0]) + " that is perpendicular to neither coordinate",
           "edges along one coordinate");
  }
  void refuse_held(int node, int normal) const {
    if (body_->fixed_dof[at(node * scene_->components() + normal)])
      refuse("the node at " + place(node) + ", which is held along the surface's normal",
             "a surface that is free to move");
  }

  const Scene* scene_;
  std::string key_;
  BodyProblem* body_;
};

std::string key_of(const Body& spec, std::size_t i) {
  return fmt::format("body.{}.absorbing[{}].surface", spec.name, i);
}

}  // namespace

void set_absorbing(const Scene& scene, const Body& spec, BodyProblem& body) {
  body.damping_kg_s = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(body.fixed_dof.size()));
  for (std::size_t i = 0; i < spec.absorbing.size(); ++i) Absorber(scene, key_of(spec, i), body).add(spec.absorbing[i]);
}

void refuse_absorbing_contact(const Problem& problem) {
  for (std::size_t b = 0; b < problem.bodies.size(); ++b) {
    const Body& spec = problem.scene.bodies[b];
    const std::vector<int> contact = contact_nodes(problem.contact, static_cast<int>(b));
    for (std::size_t i = 0; i < spec.absorbing.size(); ++i)
      for (const int node : fem::surface_nodes(problem.bodies[b].mesh, spec.absorbing[i].surface)) {
        if (!std::binary_search(contact.begin(), contact.end(), node)) continue;
        const Eigen::Vector2d& x = problem.bodies[b].mesh.position[at(node)];
        throw ConfigError(
            fmt::format("{}: found the contact node at ({:.6g}, {:.6g}) m on it; allowed: a surface that "
                        "shares no node with the contact surface",
                        problem.scene.where(key_of(spec, i)), x[0], x[1]));
      }
  }
}

}  // namespace ricochet::scene

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "common/base/error.hpp"
#include "common/fem/element.hpp"
#include "common/fem/hanging_nodes.hpp"
#include "common/problem/build.hpp"

namespace ricochet::scene {
namespace {

constexpr double perpendicular_tolerance = 1e-6;

/// Speed of the wave that meets the surface head on [m/s].
double normal_speed(Model model, const fem::Material& material, Wave wave) {
  if (wave == Wave::dilatational) return fem::longitudinal_wave_speed(model, material);
  const double bar = fem::longitudinal_wave_speed(Model::bar, material), nu = material.poisson_ratio;
  return model == Model::plane_strain ? bar / std::sqrt(1.0 - nu * nu) : bar;
}

class Absorber {
 public:
  Absorber(const Scene& scene, std::string key, BodyProblem& body)
      : scene_(&scene), key_(std::move(key)), body_(&body) {}

  /// Adds the impedance rho c times the tributary area of every node of the surface [kg/s].
  void add(const AbsorbingSurface& absorbing) {
    require_surface(*scene_, key_, body_->mesh, absorbing.surface);
    const fem::Material& material = material_at(*body_, body_->mesh.surfaces.at(absorbing.surface).front());
    double whole_area = 0.0;
    for (const fem::Face& face : body_->mesh.surfaces.at(absorbing.surface)) {
      const fem::FaceArea area = fem::face_area(body_->section, body_->mesh, face);
      const int normal = normal_component(face);
      whole_area += std::accumulate(area.begin(), area.end(), 0.0);
      for (int c = 0; c < scene_->components(); ++c) {
        const double speed =
            c == normal ? normal_speed(scene_->model, material, absorbing.wave) : fem::shear_wave_speed(material);
        for (std::size_t i = 0; i < face.size(); ++i) add(face[i], c, material.density_kg_m3 * speed * area[i]);
      }
      for (const int node : face) refuse_held(node, normal);
    }
    if (!(whole_area > 0.0)) refuse("a surface without area", "a surface with area");
  }

 private:
  /// A force on a dof that is held would do nothing.
  void add(int node, int c, double coefficient) {
    const fem::HangingNode* hanging = fem::hanging_at(body_->mesh, node);
    for (const auto& [carrier, share] : hanging ? hanging->bearers() : std::vector<WeightedNode>{{node, 1.0}}) {
      const int dof = carrier * scene_->components() + c;
      if (!body_->fixed_dof[at(dof)]) body_->damping_kg_s[dof] += share * coefficient;
    }
  }
  [[noreturn]] void refuse(const std::string& found, const std::string& allowed) const {
    throw ConfigError(fmt::format("{}: found {}; allowed: {}", scene_->where(key_), found, allowed));
  }
  [[nodiscard]] std::string place(int node) const {
    return fem::place_text(body_->mesh.model, body_->mesh.position[at(node)]);
  }
  /// The coordinate that a face is perpendicular to: dashpots act on components one by one.
  [[nodiscard]] int normal_component(const fem::Face& face) const {
    if (scene_->model == Model::bar) return 0;
    const Eigen::Vector3d normal = fem::face_normal(body_->mesh, face);
    for (int c = 0; c < scene_->components(); ++c) {
      Eigen::Vector3d along = normal;
      along[c] = 0.0;
      if (along.norm() <= perpendicular_tolerance) return c;
    }
    const bool edge = face.size() == 2;
    refuse(fmt::format("{} at {} that is perpendicular to {} coordinate", edge ? "an edge" : "a face", place(face[0]),
                       edge ? "neither" : "no"),
           edge ? "edges along one coordinate" : "faces across one coordinate");
  }
  void refuse_held(int node, int normal) const {
    if (body_->fixed_dof[at(node * scene_->components() + normal)] && fem::hanging_at(body_->mesh, node) == nullptr)
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
    const std::vector<int> contact = contact_nodes(problem.contacts, static_cast<int>(b));
    for (std::size_t i = 0; i < spec.absorbing.size(); ++i)
      for (const int node : fem::surface_nodes(problem.bodies[b].mesh, spec.absorbing[i].surface)) {
        if (!std::binary_search(contact.begin(), contact.end(), node)) continue;
        throw ConfigError(fmt::format(
            "{}: found the contact node at {} on it; allowed: a surface that shares no node with the contact surface",
            problem.scene.where(key_of(spec, i)),
            fem::place_text(problem.scene.model, problem.bodies[b].mesh.position[at(node)])));
      }
  }
}

}  // namespace ricochet::scene

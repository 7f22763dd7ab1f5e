#pragma once

#include <string>

#include "common/body/body_state.hpp"
#include "tests/support/scene_file.hpp"

namespace ricochet::test {

/// Two plates of 2 x 2 elements that touch, lower (part 0) on [0, 0.2] x [-0.2, 0] and upper (part 1) on
/// [0, 0.2] x [0, 0.4] m, as the only participant of a scene has them.
struct Plates {
  scene::Problem problem;
  std::vector<solver::BodyState> states;

  explicit Plates(const std::string& protocol, const std::string& contact_keys = "")
      : problem(build(protocol, contact_keys)),
        states(solver::initial_states(problem, problem.scene.participants.front(), true)) {}

  [[nodiscard]] int node_at(std::size_t part, const Eigen::Vector2d& x) const {
    const auto& position = states[part].part.mesh.position;
    int node = 0;
    while ((position[static_cast<std::size_t>(node)].head<2>() - x).norm() > 1e-9) ++node;
    return node;
  }
  void set_velocity(std::size_t part, const Eigen::Vector2d& velocity) {
    for (int node = 0; node < states[part].part.nodes(); ++node) states[part].v.segment<2>(2 * node) = velocity;
  }
  /// Sum over both plates of M times a vector per part [kg times its unit].
  template <class OfPart>
  [[nodiscard]] Eigen::Vector2d mass_times(const OfPart& of_part) const {
    Eigen::Vector2d sum(0.0, 0.0);
    for (int part = 0; part < 2; ++part) {
      const auto& state = states[static_cast<std::size_t>(part)];
      for (int dof = 0; dof < state.part.dofs(); ++dof) sum[dof % 2] += state.mass[dof] * of_part(part)[dof];
    }
    return sum;
  }

 private:
  static scene::Problem build(const std::string& protocol, const std::string& contact_keys) {
    std::string text = "model = \"plane_strain\"\n";
    for (const std::string name : {"lower", "upper"}) {
      text += "[[body]]\nname = \"" + name +
              "\"\nmaterial = { youngs_modulus_pa = 1e9, poisson_ratio = 0.25, density_kg_m3 = 1000.0 }\nmesh = { " +
              (name == "lower" ? "start_m = -0.2, length_m = 0.2" : "length_m = 0.4") +
              ", height_m = 0.2, elements = [2, 2] }\n";
    }
    text += "[contact]\nsurfaces = [\"lower.end\", \"upper.start\"]\n" + contact_keys +
            "[time]\nstep_s = 1e-6\nend_s = 1e-3\n[coupling]\nprotocol = \"" + protocol + "\"\n";
    const TemporaryFolder folder;
    return scene::build_problem(scene::load_scene(folder.write(text)));
  }
};

}  // namespace ricochet::test

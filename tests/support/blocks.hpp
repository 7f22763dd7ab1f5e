#pragma once

#include <fmt/format.h>

#include <string>
#include <utility>

#include "common/body/body_state.hpp"
#include "tests/support/scene_file.hpp"

namespace ricochet::test {

/// Two blocks of 2 x 2 x 2 hexahedra that touch, lower (part 0) under upper (part 1), as the only participant of a
/// scene has them.
struct Blocks {
  scene::Problem problem;
  std::vector<solver::BodyState> states;

  /// `body_keys`: of both, such as supports.
  explicit Blocks(const std::string& protocol, const std::string& contact_keys = "", const std::string& body_keys = "")
      : problem(build(protocol, contact_keys, body_keys)),
        states(solver::initial_states(problem, problem.scene.participants.front(), true)) {}

  /// The lower block moves with `of_lower`, the upper one is at rest; each node by so much more per metre of x and y
  /// that no two pairs do the same.
  void set_velocity(const Eigen::Vector3d& of_lower, const Eigen::Vector3d& more_per_m) {
    auto& state = states[0];
    for (int node = 0; node < state.part.nodes(); ++node) {
      const auto& x = state.part.mesh.position[static_cast<std::size_t>(node)];
      state.v.segment<3>(3 * node) = of_lower + (x[0] - 2.0 * x[1]) * more_per_m;
    }
  }

 private:
  static scene::Problem build(const std::string& protocol, const std::string& contact_keys,
                              const std::string& body_keys) {
    std::string text = "model = \"solid\"\n";
    for (const auto& [name, start] : {std::pair{"lower", "start_m = -0.2, "}, std::pair{"upper", ""}}) {
      text += fmt::format(
          "[[body]]\nname = \"{}\"\nmaterial = {{ youngs_modulus_pa = 1e9, poisson_ratio = 0.25, density_kg_m3 = "
          "1000.0 "
          "}}\nmesh = {{ {}length_m = 0.2, height_m = 0.2, width_m = 0.2, elements = [2, 2, 2] }}\n{}",
          name, start, body_keys);
    }
    text += "[contact]\nsurfaces = [\"lower.end\", \"upper.start\"]\n" + contact_keys +
            "[time]\nstep_s = 1e-6\nend_s = 1e-3\n[coupling]\nprotocol = \"" + protocol + "\"\n";
    const TemporaryFolder folder;
    return scene::build_problem(scene::load_scene(folder.write(text)));
  }
};

}  // namespace ricochet::test

#pragma once

#include <fmt/format.h>

#include <string>
#include <utility>

#include "common/contact/contact_surface.hpp"
#include "tests/support/scene_file.hpp"

namespace ricochet::test {

/// Two blocks of 2 x 2 x 2 hexahedra that touch, lower (part 0) under upper (part 1), as the only participant of a
/// scene has them: nine pairs of nodes, n = +z, t = x, n x t = y.
struct ContactBlocks {
  scene::Problem problem;
  std::vector<solver::BodyState> states;
  solver::ContactSurface surface;

  /// `body_keys`: of both, such as supports.
  explicit ContactBlocks(const std::string& protocol, const std::string& contact_keys = "",
                         const std::string& body_keys = "")
      : problem(build(protocol, contact_keys, body_keys)),
        states(solver::initial_states(problem, problem.scene.participants.front(), true)),
        surface(problem, states) {}

  /// The lower block moves with `of_lower`, the upper one is at rest; each node by so much more per metre of x and y
  /// that no two pairs do the same.
  void set_velocity(const Eigen::Vector3d& of_lower, const Eigen::Vector3d& more_per_m) {
    auto& state = states[0];
    for (int node = 0; node < state.part.nodes(); ++node) {
      const auto& x = state.part.mesh.position[static_cast<std::size_t>(node)];
      state.v.segment<3>(3 * node) = of_lower + (x[0] - 2.0 * x[1]) * more_per_m;
    }
  }
  /// Every pair takes a share of its neighbour's row, so that they share nodes.
  void share_nodes() {
    const auto pairs = surface.pairs;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const auto& other = pairs[(i + 1) % pairs.size()];
      for (const auto row : {&solver::Pair::normal, &solver::Pair::tangent, &solver::Pair::binormal}) {
        auto& entries = (surface.pairs[i].*row).entries;
        for (auto& e : entries) e.coefficient *= 0.75;
        for (auto e : (other.*row).entries) {
          e.coefficient *= 0.25;
          entries.push_back(e);
        }
      }
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

#pragma once

#include <string>

#include "common/contact/contact_surface.hpp"
#include "tests/support/scene_file.hpp"

namespace ricochet::test {

/// Two plates of 2 x 2 elements that touch, lower (part 0) on [0, 0.2] x [-0.2, 0] and upper (part 1) on
/// [0, 0.2] x [0, 0.4] m, as the only participant of a scene has them; and their contact as one row: the middle node of
/// the lower surface against the middle of the first edge of the upper one, which no pair of nodes is. Masses of its
/// nodes: 5, and 5 and 10 kg.
struct ContactPlates {
  scene::Problem problem;
  std::vector<solver::BodyState> states;
  solver::ContactSurface surface;

  explicit ContactPlates(const std::string& protocol, const std::string& contact_keys = "")
      : problem(build(protocol, contact_keys)),
        states(solver::initial_states(problem, problem.scene.participants.front(), true)),
        surface(problem, states) {}

  /// Entries of the row along `direction`; the weights of each side sum to one, so that forces are in balance.
  [[nodiscard]] solver::ContactRow row(const Eigen::Vector2d& direction) const {
    const int lower = node_at(0, {0.1, 0.0}), left = node_at(1, {0.0, 0.0}), middle = node_at(1, {0.1, 0.0});
    solver::ContactRow row;
    for (int c = 0; c < 2; ++c) {
      if (direction[c] == 0.0) continue;
      row.entries.push_back({0, 2 * lower + c, -direction[c], solver::Side::a});
      row.entries.push_back({1, 2 * left + c, 0.5 * direction[c], solver::Side::b});
      row.entries.push_back({1, 2 * middle + c, 0.5 * direction[c], solver::Side::b});
    }
    return row;
  }
  void use_one_row() {
    surface.pairs = {{.normal = row({0.0, 1.0}),
                      .tangent = row({-1.0, 0.0}),
                      .gap0_m = 0.0,
                      .area_m2 = 0.1,
                      .friction_coefficient = problem.scene.contact_law().friction_coefficient}};
  }
  /// Every node of the lower surface against the whole upper one: three rows that share its nodes.
  void use_three_rows() {
    constexpr double weights[3][3] = {{0.75, 0.25, 0.0}, {0.25, 0.5, 0.25}, {0.0, 0.25, 0.75}};
    surface.pairs.clear();
    for (int i = 0; i < 3; ++i) {
      const auto entries = [&](int component, double sign) {
        solver::ContactRow row;
        row.entries.push_back({0, 2 * node_at(0, {0.1 * i, 0.0}) + component, -sign, solver::Side::a});
        for (int k = 0; k < 3; ++k) {
          if (weights[i][k] == 0.0) continue;
          const int dof = 2 * node_at(1, {0.1 * k, 0.0}) + component;
          row.entries.push_back({1, dof, sign * weights[i][k], solver::Side::b});
        }
        return row;
      };
      surface.pairs.push_back({.normal = entries(1, 1.0),
                               .tangent = entries(0, -1.0),
                               .gap0_m = 0.0,
                               .area_m2 = i == 1 ? 0.1 : 0.05,
                               .friction_coefficient = problem.scene.contact_law().friction_coefficient});
    }
  }
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

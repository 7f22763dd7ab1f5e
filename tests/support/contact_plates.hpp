#pragma once

#include <string>

#include "common/contact/contact_surface.hpp"
#include "tests/support/plates.hpp"

namespace ricochet::test {

/// Plates and their contact as one row: the middle node of the lower surface against the middle of the first edge of
/// the upper one, which no pair of nodes is. Masses of its nodes: 5, and 5 and 10 kg.
struct ContactPlates : Plates {
  solver::ContactSurface surface;

  explicit ContactPlates(const std::string& protocol, const std::string& contact_keys = "")
      : Plates(protocol, contact_keys), surface(problem, states) {}

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
};

}  // namespace ricochet::test

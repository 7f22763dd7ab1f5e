#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/body/body_state.hpp"
#include "common/body/internal_force.hpp"

namespace ricochet::test {

constexpr double stiffening = 1e5;  ///< b of N = E A (strain + b strain^3)

/// P of bars whose normal force is N(strain) as above. They store E A h (strain^2/2 + b strain^4/4).
class CubicBars final : public solver::InternalForce {
 public:
  explicit CubicBars(const solver::BodyState& state) : state_(state), rows_{{0, state.part.dofs()}} {}

  void evaluate(double, Eigen::VectorXd& u, Eigen::VectorXd& force) override {
    force.setZero();
    for_each_bar(u, [&](int left, int right, double, double strain) {
      const double normal_force = stiffness() * (strain + stiffening * strain * strain * strain);
      force[left] -= normal_force;
      force[right] += normal_force;
    });
  }
  [[nodiscard]] const std::vector<solver::Rows>& rows() const override { return rows_; }
  [[nodiscard]] bool linear() const override { return false; }
  [[nodiscard]] double stored(const Eigen::VectorXd& u, const Eigen::VectorXd&, double) const override {
    double energy_j = 0.0;
    for_each_bar(u, [&](int, int, double length_m, double strain) {
      const double square = strain * strain;
      energy_j += stiffness() * length_m * (0.5 * square + 0.25 * stiffening * square * square);
    });
    return energy_j;
  }
  [[nodiscard]] const fem::SparseMatrix& tangent(const Eigen::VectorXd& u) override {
    std::vector<Eigen::Triplet<double>> entries;
    for_each_bar(u, [&](int left, int right, double length_m, double strain) {
      const double k = stiffness() / length_m * (1.0 + 3.0 * stiffening * strain * strain);
      entries.insert(entries.end(), {{left, left, k}, {right, right, k}, {left, right, -k}, {right, left, -k}});
    });
    tangent_.resize(u.size(), u.size());
    tangent_.setFromTriplets(entries.begin(), entries.end());
    ++tangents;
    return tangent_;
  }

  int tangents = 0;  ///< how often one was asked for

 private:
  [[nodiscard]] double stiffness() const {  ///< E A [N]
    return state_.part.material.youngs_modulus_pa * state_.part.section.measure;
  }
  template <class Visit>
  void for_each_bar(const Eigen::VectorXd& u, const Visit& visit) const {
    const auto& mesh = state_.part.mesh;
    for (const auto& bar : mesh.elements) {
      const int left = bar[0], right = bar[1];
      const double length_m = mesh.position[fem::at(right)][0] - mesh.position[fem::at(left)][0];
      visit(left, right, length_m, (u[right] - u[left]) / length_m);
    }
  }
  const solver::BodyState& state_;
  std::vector<solver::Rows> rows_;
  fem::SparseMatrix tangent_;
};

}  // namespace ricochet::test

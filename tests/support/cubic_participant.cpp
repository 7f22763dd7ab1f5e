// cubic_participant --scene SCENE --name NAME --connect ENDPOINT: the explicit solver with bars that grow stiffer as
// they are strained, so that its internal force is not linear in the displacement. Tests have it started in the place
// of that solver.
#include <memory>
#include <utility>

#include "common/solver/main.hpp"
#include "explicit_solver/explicit_solver.hpp"

namespace ricochet {
namespace {

constexpr double stiffening = 1e5;  ///< b of N = E A (strain + b strain^3); the tests have it, too

/// P of bars whose normal force is N(strain) as above. They store E A h (strain^2/2 + b strain^4/4).
class CubicBars final : public solver::InternalForce {
 public:
  explicit CubicBars(const solver::BodyState& state) : state_(state), rows_{{0, state.part.dofs()}} {}

  void evaluate(Eigen::VectorXd& u, Eigen::VectorXd& force) override {
    force.setZero();
    for_each_bar(u, [&](int left, int right, double, double strain) {
      const double normal_force = stiffness() * (strain + stiffening * strain * strain * strain);
      force[left] -= normal_force;
      force[right] += normal_force;
    });
  }
  [[nodiscard]] const std::vector<solver::Rows>& rows() const override { return rows_; }
  [[nodiscard]] bool linear() const override { return false; }
  [[nodiscard]] double stored(const Eigen::VectorXd& u, double) const override {
    double energy_j = 0.0;
    for_each_bar(u, [&](int, int, double length_m, double strain) {
      const double square = strain * strain;
      energy_j += stiffness() * length_m * (0.5 * square + 0.25 * stiffening * square * square);
    });
    return energy_j;
  }

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
};

class CubicSolver final : public explicit_solver::ExplicitSolver {
 public:
  CubicSolver(scene::Problem problem, const std::string& name, std::optional<double> told_critical_step_s)
      : ExplicitSolver(std::move(problem), name, told_critical_step_s, nullptr,
                       [](const solver::BodyState& state, const std::vector<int>&) {
                         return std::make_unique<CubicBars>(state);
                       }) {}
};

}  // namespace
}  // namespace ricochet

int main(int argc, char** argv) { return ricochet::solver::solver_main<ricochet::CubicSolver>(argc, argv); }

#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <type_traits>
#include <vector>

#include "common/body/body_state.hpp"
#include "common/body/internal_force.hpp"

namespace ricochet::solver {

/// P of elements that yield: P = K u - integral of B^T m p dV with p the plastic strain at the quadrature points and m
/// its modulus (PlasticState). With s = m (deviator of B u - p), of a bar its axial strain in place of the deviator,
/// and q = c |s| the von Mises stress, c^2 = 3/2, of a bar 1, a point yields where q is above its yield stress y
/// (fem::Plasticity). A step goes straight from the strain of the step before to the new one, so that the return to
/// the yield stress is one equation of one unknown, for linear hardening in closed form (Simo, Hughes: Computational
/// Inelasticity, 1998, boxes 1.4 and 3.1):
///   q - m c^2 g = y,   equivalent += g,   p += c^2 g s/q.
/// The temperature in y is that before the step, which keeps P the gradient of a convex potential. Plastic work in a
/// step is V (s before + s after)/2 : dp. With the elastic energy it makes up (P_n + P_{n+1})/2 . du, the work that
/// both integrators book, exactly. A step that holds what flows at another place (`hold`) takes s after where it ends.
///
/// A point whose q was q_0 cannot yield before u has changed by so much that q could have grown by y - q_0, with y at
/// rest. Elements are looked at when that is due and no earlier; what comes out is the same as if all were.
///
/// It reads and keeps BodyState::plastic, which is of the accepted window.
class PlasticElements final : public InternalForce {
 public:
  /// `state` must outlive this object unmoved.
  explicit PlasticElements(const BodyState& state);

  void evaluate(double step_s, Eigen::VectorXd& u, Eigen::VectorXd& force) override;
  void hold(double step_s, Eigen::VectorXd& u, Eigen::VectorXd& change) override;
  void let_go() override { held_ = false; }
  [[nodiscard]] bool hold_enough(Eigen::VectorXd& u) override;
  void evaluate_at_rest(Eigen::VectorXd& u, Eigen::VectorXd& force) override;
  void follow(const Eigen::VectorXd&) override;
  void settle() override;
  void go_back() override;
  [[nodiscard]] const std::vector<Rows>& rows() const override { return all_; }
  [[nodiscard]] bool linear() const override { return false; }
  [[nodiscard]] double stored(const Eigen::VectorXd& u, const Eigen::VectorXd&, double half_work_j) const override;
  /// K: where points flow the tangent is smaller. P has a convex potential, and no step that K finds goes too far.
  [[nodiscard]] const fem::SparseMatrix& tangent(const Eigen::VectorXd&) override { return state_->part.stiffness; }
  [[nodiscard]] bool keeps_tangent() const override { return true; }
  void archive(Archive& a) override;

 private:
  static constexpr int most_components = 6;
  static constexpr std::size_t elements_of_block = 32;
  using Strain = Eigen::Matrix<double, most_components, 1>;  ///< 0 beyond those of the model
  /// A point that yields in a step.
  struct Flow {
    int element = 0, point = 0;      ///< the point counted within the part
    double equivalent = 0.0;         ///< by which it grows
    double strain_per_stress = 0.0;  ///< c^2 g/q
    Strain stress;                   ///< s, before the return

    [[nodiscard]] Strain strain() const { return strain_per_stress * stress; }
  };
  /// Copies of an element share it.
  struct Shape {
    std::vector<double> volume_m3;  ///< per point
    std::vector<double> gradients;  ///< fem::ElementPoint's, per node and number of its row: one of each point
    double pa_per_m = 0.0;          ///< q of a point changes at most by this times the change of u, up to a translation
  };
  /// Elements that are near each other, if the mesh numbers them so.
  struct Block {
    int first = 0, end = 0;   ///< elements
    std::vector<int> nodes;   ///< of them
    double path_m = 0.0;      ///< how far its nodes have moved against each other at most, over all steps
    double tried_m = 0.0;     ///< the same from the last step to the last evaluation
    double due_m = 0.0;       ///< the path at which the first of its elements has to be looked at
    std::vector<Flow> flows;  ///< of the last evaluation
  };
  void set_shapes();
  void set_blocks();
  /// Elements that may yield are bars, quadrilaterals and hexahedra: as many points, and components of a stress.
  template <int dimension>
  static constexpr int points_of = 1 << (dimension == 1 ? 0 : dimension);
  template <int dimension>
  static constexpr int components_of = dimension == 1 ? 1 : 2 * dimension;
  template <int dimension>
  using Stresses = Eigen::Array<double, components_of<dimension>, points_of<dimension>>;
  /// visit(dimension of the elements, as a constant).
  template <class Visit>
  decltype(auto) by_dimension(const Visit& visit) const {
    switch (fem::components(state_->part.section.model)) {
      case 1: return visit(std::integral_constant<int, 1>());
      case 2: return visit(std::integral_constant<int, 2>());
      default: return visit(std::integral_constant<int, 3>());
    }
  }
  template <int dimension>
  [[nodiscard]] Stresses<dimension> stresses(int element, const Eigen::VectorXd& u) const;
  [[nodiscard]] const fem::Plasticity& law(int element) const {
    return laws_[fem::at(1 + fem::material_index(state_->part.mesh, element))];
  }
  [[nodiscard]] double softening(const fem::Plasticity& law, int point) const;
  template <int dimension>
  [[nodiscard]] double margin(int element, const Eigen::VectorXd& u, std::vector<Flow>& flows) const;
  template <int dimension>
  [[nodiscard]] bool holds_enough(const Block& block, const Eigen::VectorXd& u, double path_m) const;
  [[nodiscard]] double moved(const Block& block, const Eigen::VectorXd& from, const Eigen::VectorXd& to) const;
  void look(Block& block, const Eigen::VectorXd& u);
  void look(const Eigen::VectorXd& u);
  /// visit(block) of all, by threads where that pays.
  template <class Visit>
  void for_blocks(const Visit& visit);
  void return_at(double step_s, const Eigen::VectorXd& u);
  void heat(const fem::Plasticity& law, int point, double work_j_m3);
  template <int dimension>
  void keep(const std::vector<Flow>& flows);
  template <int dimension>
  void add_force(const Flow& flow, Eigen::VectorXd& force) const;

  const BodyState* state_;
  std::vector<fem::Plasticity> laws_;  ///< by 1 + fem::material_index; of an elastic one the yield stress is infinite
  double factor_squared_;              ///< c^2
  bool round_;                         ///< the model is axisymmetric
  std::vector<Rows> all_;
  std::vector<Shape> shapes_;
  std::vector<int> shape_of_;              ///< per element
  std::shared_ptr<PlasticState> settled_;  ///< of the accepted window
  PlasticState step_;                      ///< of the last step
  std::vector<int> changed_;               ///< points that have yielded since the accepted window
  Eigen::VectorXd u_settled_;              ///< of the accepted window
  Eigen::VectorXd u_step_;                 ///< of the last step
  Eigen::VectorXd u_tried_;                ///< of the last evaluation
  double tried_s_ = 0.0;                   ///< its step
  bool held_ = false;                      ///< what flows stays that of the last `hold`
  Eigen::VectorXd tried_force_n_;          ///< PlasticState::force_n of it
  std::vector<Block> blocks_;
  std::size_t flowing_ = 0;    ///< points in the last evaluation
  std::vector<double> due_m_;  ///< per element: the path of its block at which it has to be looked at
};

}  // namespace ricochet::solver

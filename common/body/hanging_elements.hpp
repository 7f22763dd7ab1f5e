#pragma once

#include <Eigen/Core>
#include <memory>
#include <utility>

#include "common/body/body_state.hpp"
#include "common/body/internal_force.hpp"
#include "common/fem/hanging_nodes.hpp"

namespace ricochet::solver {

/// P of elements that are not linear, some of whose nodes hang: P = T^T P_of_elements(T u) (fem/hanging_nodes.hpp). K
/// of a part has T in it already, and linear elements need nothing of this kind.
class HangingElements final : public InternalForce {
 public:
  /// `state` must outlive this object unmoved; the elements evaluate all rows.
  HangingElements(const BodyState& state, std::unique_ptr<InternalForce> elements)
      : hanging_(state.part.mesh.hanging),
        components_(fem::components(state.part.mesh.model)),
        others_(state.frame ? nullptr : state.others),
        elements_(std::move(elements)) {}

  void evaluate(double step_s, Eigen::VectorXd& u, Eigen::VectorXd& force) override {
    if (others_ != nullptr) others_->exchange(u);
    fem::follow(hanging_, components_, u);
    elements_->evaluate(step_s, u, force);
    fem::pass_on(hanging_, components_, force);
  }
  void hold(double step_s, Eigen::VectorXd& u, Eigen::VectorXd& change) override {
    fem::follow(hanging_, components_, u);
    elements_->hold(step_s, u, change);
    fem::pass_on(hanging_, components_, change);
  }
  void let_go() override { elements_->let_go(); }
  [[nodiscard]] bool hold_enough(Eigen::VectorXd& u) override {
    fem::follow(hanging_, components_, u);
    return elements_->hold_enough(u);
  }
  void evaluate_at_rest(Eigen::VectorXd& u, Eigen::VectorXd& force) override {
    fem::follow(hanging_, components_, u);
    elements_->evaluate_at_rest(u, force);
    fem::pass_on(hanging_, components_, force);
  }
  void follow(const Eigen::VectorXd& force) override { elements_->follow(force); }
  [[nodiscard]] bool remembers() const override { return elements_->remembers(); }
  void settle() override { elements_->settle(); }
  void go_back() override { elements_->go_back(); }
  [[nodiscard]] const std::vector<Rows>& rows() const override { return elements_->rows(); }
  [[nodiscard]] bool linear() const override { return elements_->linear(); }
  [[nodiscard]] double stored(const Eigen::VectorXd& u, const Eigen::VectorXd& force,
                              double half_work_j) const override {
    return elements_->stored(u, force, half_work_j);
  }
  [[nodiscard]] const fem::SparseMatrix& tangent(const Eigen::VectorXd& u) override { return elements_->tangent(u); }
  [[nodiscard]] bool keeps_tangent() const override { return elements_->keeps_tangent(); }
  void archive(Archive& a) override { elements_->archive(a); }

 private:
  const std::vector<fem::HangingNode>& hanging_;
  int components_;
  OtherRanks* others_;  ///< null where u comes with what others know
  std::unique_ptr<InternalForce> elements_;
};

}  // namespace ricochet::solver

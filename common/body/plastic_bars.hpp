#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "common/body/body_state.hpp"
#include "common/body/internal_force.hpp"

namespace ricochet::solver {

/// P of bars that yield: N = A E (strain - plastic strain), |N|/A <= yield_stress_pa + hardening_pa * equivalent
/// plastic strain. A step goes straight from the strain of the step before to the new one, so that the return to the
/// yield stress has a closed form (Simo, Hughes: Computational Inelasticity, 1998, box 1.4):
///   trial = E (strain - plastic strain),  excess = |trial| - (yield stress + hardening * equivalent)
///   where excess > 0:  plastic strain += sign(trial) excess/(E + H),  equivalent += excess/(E + H),
///   and the consistent tangent is E H/(E + H) in place of E.
/// Plastic work in a step is A h (stress before + stress after)/2 times the change of the plastic strain. With the
/// elastic energy A h stress^2/(2 E) it makes up (P_n + P_{n+1})/2 . du, the work that both integrators book, exactly.
///
/// It reads and keeps BodyState::plastic, which is of the accepted window.
class PlasticBars final : public InternalForce {
 public:
  /// `state` must outlive this object unmoved.
  explicit PlasticBars(const BodyState& state);

  void evaluate(Eigen::VectorXd& u, Eigen::VectorXd& force) override;
  void follow(const Eigen::VectorXd&) override { step_ = tried_; }
  void settle() override;
  void go_back() override { step_ = *settled_; }
  [[nodiscard]] const std::vector<Rows>& rows() const override { return all_; }
  [[nodiscard]] bool linear() const override { return false; }
  [[nodiscard]] double stored(const Eigen::VectorXd& u, double half_work_j) const override;
  /// Of the step that led to u. Where `u` is that of the last call before `settle`, it is that tangent: an operator
  /// that outlives the window which made it can be made again, after a trial or from a checkpoint.
  [[nodiscard]] const fem::SparseMatrix& tangent(const Eigen::VectorXd& u) override;
  void archive(Archive& a) override;

 private:
  /// Where a tangent was asked for, and which elements flowed there.
  struct Tangent {
    Eigen::VectorXd u;
    std::vector<bool> flows;

    void archive(Archive& a) { a.same_size(u, flows); }
  };
  [[nodiscard]] double strain(std::size_t element, const Eigen::VectorXd& u) const;
  [[nodiscard]] double excess(Eigen::Index element, double trial_pa) const;
  void find_flowing(const Eigen::VectorXd& u);

  const BodyState* state_;
  double young_pa_, area_m2_;
  fem::Plasticity law_;
  std::vector<double> length_m_;
  std::vector<Rows> all_;
  std::shared_ptr<PlasticState> settled_;  ///< of the accepted window
  PlasticState step_, tried_;              ///< of the last step, and as it was evaluated last
  Tangent asked_, settled_tangent_;
  fem::SparseMatrix tangent_;
};

[[nodiscard]] bool any_yields(const std::vector<BodyState>& states);
/// P of a part by its material, for the implicit solver: linear or PlasticBars.
[[nodiscard]] std::unique_ptr<InternalForce> material_elements(const BodyState& state);

}  // namespace ricochet::solver

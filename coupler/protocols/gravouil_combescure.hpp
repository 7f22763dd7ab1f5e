#pragma once

#include <Eigen/LU>

#include "coupler/protocols/dual_interface.hpp"
#include "coupler/protocols/protocol.hpp"

namespace ricochet::coupler {

/// Dual coupling with m explicit steps in a window, velocities equal at each of them (Gravouil, Combescure:
/// Multi-time-step explicit-implicit method for non-linear structural dynamics, Int. J. Numer. Meth. Engng 50, 2001).
/// Between the ends of the window the implicit side's *free* velocity, without multipliers, is linear in time:
///   v_free(0) = v_n + H_i lambda_n,   v_free(T) = v + H_i lambda of a trial window
///   v_j = v_free(t_j) - H_i lambda_j,   H_i the implicit side's operator
/// H_i is measured with the contact open: while it is closed the free velocity is off by what the contact answers, and
/// with m > 1 the window then grows slowly (`ricochet stability`: 5e-5 a window at m = 2, Courant 0.5). Dissipates
/// O(dT) for m > 1: a protocol to be studied. 1 + 2 m exchanges with the explicit side, two with the implicit one.
class GravouilCombescure final : public Protocol {
 public:
  explicit GravouilCombescure(const ProtocolSettings& settings) : substeps_(settings.substeps) {}
  void start(Coupling& coupling, const wire::Initialize& request) override;
  void reconfigure(Coupling& coupling) override;
  void archive(Archive& a) override;
  void step(Coupling& coupling, const Step& step) override;

 private:
  void measure_implicit(Coupling& coupling);
  void factorise();
  /// Velocity that the implicit side would have at the end of the window without multipliers.
  Eigen::VectorXd free_velocity(Coupling& coupling, const Step& step);

  int substeps_;
  DualInterface interface_;
  Eigen::MatrixXd implicit_operator_;                      ///< H_i, shared numbering [m/s/N]
  Eigen::PartialPivLU<Eigen::MatrixXd> velocity_problem_;  ///< of I + H_i Z
};

}  // namespace ricochet::coupler

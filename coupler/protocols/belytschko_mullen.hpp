#pragma once

#include <Eigen/Core>
#include <vector>

#include "coupler/protocols/protocol.hpp"

namespace ricochet::coupler {

/// Implicit-explicit partition by nodes (Belytschko, Mullen: Stability of explicit-implicit mesh partitions in time
/// integration, Int. J. Numer. Meth. Engng 12, 1978). The implicit operator also holds the explicit elements' stiffness
/// at the shared nodes, so that their force there is that of the new displacement:
///   P_Gamma = K_Gamma,E u~_E + K_Gamma,Gamma u_Gamma,  u~_E = u + dt v + dt^2/2 a
/// The explicit nodes move first; then the shared ones, implicitly; the explicit elements' force follows from both.
/// K_Gamma,Gamma comes from unit responses at the start. Two evaluations a window, the first with u_Gamma of the window
/// before. Momentum is conserved to round-off. Stable for dt <= 2/omega_max of the explicit nodes with the shared ones
/// held, which is not below that of `hughes_liu`.
///
/// The two answers P of a window differ by K times the motion between them in linear bodies. One whose answers differ
/// by something else, above 1e-3 of its largest so far, ends the run by a ConfigError with its name: the
/// shared nodes were moved by a force that it does not have. Each window tries one sum of them with fixed weights.
class BelytschkoMullen final : public Protocol {
 public:
  void start(Coupling& coupling, const wire::Initialize& request) override;
  /// K is asked for again where the answer to a motion depends on the size of the window, as that of modes does.
  void reconfigure(Coupling& coupling) override;
  void step(Coupling& coupling, const Step& step) override;
  void archive(Archive& a) override;

 private:
  /// A weighted sum of what an explicit participant answers, and of its linear answer.
  struct WeightedSum {
    Eigen::VectorXd weights, row;            ///< w, K w
    double of_input = 0.0, of_output = 0.0;  ///< of the first answer: (K w).u, w.P
    double largest = 0.0;                    ///< |w|.|P| so far
  };
  [[nodiscard]] Eigen::MatrixXd measure(Coupling& coupling, const Step& step);
  [[nodiscard]] bool answer_as_before(Coupling& coupling, const Step& step);
  void note_first_answers(const Coupling& coupling);
  void require_linear(const Coupling& coupling, const Step& step);

  double probe_m_ = 0.0;
  std::vector<double> force_;      ///< P_Gamma - K u_Gamma [N]
  std::vector<double> motion_;     ///< scratch: u_Gamma in rows of a link [m]
  std::vector<WeightedSum> sums_;  ///< per link; empty vectors: it is implicit
};

}  // namespace ricochet::coupler

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "coupler/protocols/protocol.hpp"

namespace ricochet::coupler {

/// Strong coupling by iteration, for participants that can only repeat a window: the explicit side answers a
/// displacement u of the shared nodes with a force, the implicit side that force with a displacement u~(u), until the
/// residual
///   r = u~(u) - u,   |r| <= tolerance times the largest |u~ - u_n| of a window so far, or the round-off of u~
/// vanishes. Its solution is that of `belytschko_mullen`. The next u is
///   constant  u + omega r
///   aitken    the same with omega_k = -omega_{k-1} r_{k-1} . dr / |dr|^2,  dr = r_k - r_{k-1}  (Irons, Tuck 1969)
///   iqn_ils   u + r minus what a least-squares fit of all residuals of this window and the one before explains
///             (Degroote, Bathe, Vierendeels, Computers and Structures 87, 2009)
/// Throws SolverError if `max_iterations` do not suffice.
class FixedPoint final : public Protocol {
 public:
  /// Throws std::invalid_argument for an acceleration that is none of these.
  explicit FixedPoint(const ProtocolSettings& settings);
  void step(Coupling& coupling, const Step& step) override;
  [[nodiscard]] std::string note() const override;
  void archive(Archive& a) override {
    a(relaxation_, scale_, last_residual_, last_answer_, residual_differences_, answer_differences_, of_this_window_,
      windows_, iterations_, most_);
  }

 private:
  using Vector = Eigen::VectorXd;
  // Each moves u given its residual; `first`: of this window.
  void relax(const Vector& residual, const Vector& answer, bool first, Vector& u);
  void relax_aitken(const Vector& residual, const Vector& answer, bool first, Vector& u);
  void quasi_newton(const Vector& residual, const Vector& answer, bool first, Vector& u);

  ProtocolSettings settings_;
  void (FixedPoint::*accelerate_)(const Vector& residual, const Vector& answer, bool first, Vector& u);
  double relaxation_ = 1.0, scale_ = 0.0;
  Vector last_residual_, last_answer_;
  /// Differences of residuals and answers, newest last, and how many belong to the present window.
  std::vector<Vector> residual_differences_, answer_differences_;
  std::size_t of_this_window_ = 0;
  std::int64_t windows_ = 0, iterations_ = 0, most_ = 0;
};

}  // namespace ricochet::coupler

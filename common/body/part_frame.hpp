#pragma once

#include <Eigen/Core>

#include "common/base/parallel.hpp"
#include "common/fem/part.hpp"
#include "common/fem/rigid_motion.hpp"

namespace ricochet::solver {

/// R of H = R S with S symmetric, in a plane or in space (polar decomposition).
[[nodiscard]] Eigen::Matrix3d rotation_of(const Eigen::Matrix2d& h);
[[nodiscard]] Eigen::Matrix3d rotation_of(const Eigen::Matrix3d& h);

/// The vector of each node, turned in place.
void turn_nodes(const Eigen::Matrix3d& by, int components, Eigen::VectorXd& of_nodes);

/// The frame of a part that turns by any angle. It has the rigid motion that leaves least of the part's motion, in the
/// measure of the masses: with m_i the lumped mass of node i, X_i its place, x_i = X_i + u_i, and Y_i,
/// y_i the same from the centre of mass,
///   R maximises sum m_i y_i . R Y_i,   that is   sum m_i y_i Y_i^T = R S   with S symmetric (rotation_of).
/// The part is strained by
///   d_i = R^T y_i - Y_i.
class PartFrame {
 public:
  /// Of plane strain or a solid. Throws std::invalid_argument otherwise.
  explicit PartFrame(const fem::Part& part);

  /// Where a displacement u [m] of the part puts the frame.
  struct Fit {
    fem::RigidMotion motion;
    Eigen::Matrix3d stretch;  ///< S [kg m^2]
  };
  /// Any number of threads makes the same bits. `parallel` may be null.
  [[nodiscard]] Fit fit(const Eigen::VectorXd& u, Parallel* parallel = nullptr) const;
  /// d of it.
  void straining(const Eigen::VectorXd& u, const fem::RigidMotion& motion, Eigen::VectorXd& d,
                 Parallel* parallel = nullptr) const;
  [[nodiscard]] Eigen::VectorXd straining(const Eigen::VectorXd& u) const;
  /// P_i = R (g_i - m_i c x Y_i), c = (tr(S) - S)^-1 sum_i (Y_i + d_i) x g_i: with g the gradient of an energy of d, P
  /// is that of the same energy as a function of u. It has neither a resultant nor a moment.
  void force(const Fit& fit, const Eigen::VectorXd& d, const Eigen::VectorXd& g, Eigen::VectorXd& p,
             Parallel* parallel = nullptr) const;

 private:
  template <int components>
  [[nodiscard]] Fit fit_of(const Eigen::VectorXd& u, Parallel* parallel) const;
  template <int components>
  void straining_of(const Eigen::VectorXd& u, const fem::RigidMotion& motion, Eigen::VectorXd& d,
                    Parallel* parallel) const;
  template <int components>
  void force_of(const Fit& fit, const Eigen::VectorXd& d, const Eigen::VectorXd& g, Eigen::VectorXd& p,
                Parallel* parallel) const;

  int components_;
  double mass_kg_;
  Eigen::Vector3d centre_m_;  ///< of mass
  Eigen::VectorXd mass_;      ///< m, per node [kg]
  Eigen::VectorXd arm_;       ///< Y, per degree of freedom [m]
  Eigen::Matrix3d inertia_;   ///< sum m Y Y^T [kg m^2]
};

}  // namespace ricochet::solver

#pragma once

#include <Eigen/Core>

#include "common/base/archive.hpp"
#include "common/base/parallel.hpp"
#include "common/fem/part.hpp"
#include "common/fem/rigid_motion.hpp"

namespace ricochet::solver {

/// R of H = R S with S symmetric, in a plane or in space (polar decomposition).
[[nodiscard]] Eigen::Matrix3d rotation_of(const Eigen::Matrix2d& h);
[[nodiscard]] Eigen::Matrix3d rotation_of(const Eigen::Matrix3d& h);

class OtherRanks;

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
  /// The frame of a part in plane strain or of a solid. Throws std::invalid_argument otherwise.
  explicit PartFrame(const fem::Part& part);

  /// Where a displacement u [m] of the part puts the frame.
  struct Fit {
    fem::RigidMotion motion;
    Eigen::Matrix3d stretch;  ///< S [kg m^2]
  };
  /// Mass, its centre and sum m Y Y^T.
  struct Whole {
    double mass_kg = 0.0;
    Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
    Eigen::Matrix3d inertia_kg_m2 = Eigen::Matrix3d::Zero();

    void archive(Archive& a) {
      a(mass_kg);
      for (double& value : centre_m) a(value);
      for (double& value : inertia_kg_m2.reshaped()) a(value);
    }
  };
  /// A rank's share has the frame of the whole part. Each fit and each force then asks the others, which must outlive
  /// this object.
  PartFrame(const fem::Part& share, const Whole& whole, OtherRanks& others);
  [[nodiscard]] const Whole& whole() const { return whole_; }
  /// That of a share, for who must not ask the others.
  [[nodiscard]] const Fit& last_fit() const { return last_; }

  /// Any number of threads and ranks makes the same bits. `parallel` may be null.
  [[nodiscard]] Fit fit(const Eigen::VectorXd& u, Parallel* parallel = nullptr) const;
  /// d of it.
  void straining(const Eigen::VectorXd& u, const fem::RigidMotion& motion, Eigen::VectorXd& d,
                 Parallel* parallel = nullptr) const;
  [[nodiscard]] Eigen::VectorXd straining(const Eigen::VectorXd& u) const;
  /// P_i = R (g_i - m_i c x Y_i), c = (tr(S) - S)^-1 sum_i (Y_i + d_i) x g_i: with g the gradient of an energy of d, P
  /// is that of the same energy as a function of u. It has neither a resultant nor a moment.
  void force(const Fit& fit, const Eigen::VectorXd& d, const Eigen::VectorXd& g, Eigen::VectorXd& p,
             Parallel* parallel = nullptr) const;
  /// sum (R d_i) . P_i over the nodes of a block: of all blocks d . g, since sum m_i Y_i x d_i = 0.
  [[nodiscard]] double work_of(const Eigen::Matrix3d& rotation, const Eigen::VectorXd& d, const Eigen::VectorXd& p,
                               int block) const;

 private:
  void set_arms(const fem::Part& part);
  template <class Sum, class SumOf>
  [[nodiscard]] Sum sum_of_blocks(Parallel* parallel, const SumOf& sum_of) const;
  template <int components>
  [[nodiscard]] Fit fit_of(const Eigen::VectorXd& u, Parallel* parallel) const;
  template <int components>
  void straining_of(const Eigen::VectorXd& u, const fem::RigidMotion& motion, Eigen::VectorXd& d,
                    Parallel* parallel) const;
  template <int components>
  void force_of(const Fit& fit, const Eigen::VectorXd& d, const Eigen::VectorXd& g, Eigen::VectorXd& p,
                Parallel* parallel) const;

  int components_;
  Whole whole_;
  OtherRanks* others_ = nullptr;
  mutable Fit last_{{}, Eigen::Matrix3d::Zero()};
  Eigen::VectorXd mass_;  ///< m, per node [kg]
  Eigen::VectorXd arm_;   ///< Y, per degree of freedom [m]
};

}  // namespace ricochet::solver
